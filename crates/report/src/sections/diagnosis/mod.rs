//! Sections of a diagnosis.

mod drive_gains;
mod effort_error;
mod faults;
mod findings;
mod inconclusive_changes;
mod minimal_set;
mod next_motion;
mod placebo;
mod position_error;
mod reference_speed;
mod replay;
mod residual_map;

pub(super) use drive_gains::DriveGains;
pub(super) use effort_error::EffortError;
pub(super) use faults::Faults;
pub(super) use findings::Findings;
pub use inconclusive_changes::{InconclusiveChange, InconclusiveChanges};
pub use minimal_set::MinimalSetEstimate;
pub use next_motion::NextMotionResult;
pub use placebo::PlaceboTest;
pub use position_error::{ErrorWithoutLaw, PositionErrors, PositionFit};
pub use reference_speed::ReferenceSpeed;
pub use replay::ReplayPair;
pub(super) use residual_map::ResidualMap;
