//! Sections of two results side by side.

mod effort_error;
mod findings;
mod parameters;

pub(super) use effort_error::EffortError;
pub(super) use findings::Findings;
pub(super) use parameters::Parameters;
