//! How a case is made: scene, hidden effects, simulation, truth.

pub(crate) mod accept;
pub(crate) mod draw_effects;
pub(crate) mod exact_motion;
pub(crate) mod floors;
pub(crate) mod generate;
pub(crate) mod observer;
pub(crate) mod recording_faults;
pub(crate) mod request;
pub(crate) mod scene;
pub(crate) mod sensors;
pub(crate) mod simulate;
pub(crate) mod sizes;
pub(crate) mod truth_of;
