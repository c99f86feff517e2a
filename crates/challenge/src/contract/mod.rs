//! The files of a case and of a result: what generator, diagnosis and score agree on.

pub(crate) mod answer;
pub(crate) mod case;
pub(crate) mod files;
pub(crate) mod kind;
pub(crate) mod truth;
