//! Sections of a validation.

mod effort_error;
mod position_error;
mod replay;

pub(super) use effort_error::EffortError;
pub(super) use position_error::PositionError;
pub(super) use replay::Replay;
