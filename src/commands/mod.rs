//! One file a command: read, call, write.

pub(crate) mod challenge;
pub(crate) mod check;
pub(crate) mod diagnose;
pub(crate) mod export;
pub(crate) mod identify;
pub(crate) mod params;
pub(crate) mod plan;
pub(crate) mod predict;
pub(crate) mod recordings;
pub(crate) mod simulate;
pub(crate) mod validate;
