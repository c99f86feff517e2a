//! Sections of a validation.

mod effort_error;
mod replay;

pub(super) use effort_error::EffortError;
pub(super) use replay::Replay;
