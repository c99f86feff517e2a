//! Designs the motions of an identification: a suite inside the arm's limits, and the standard errors it will give.
//!
//! [`excite`] is the door. Limits hold between samples: those of position, velocity, acceleration and jerk by bounds of the
//! series, those of the effort by a bound of its derivative. The objective is the determinant of the Fisher information of
//! the minimal inertia set and of the friction of each joint; the same information gives the standard errors before the arm
//! has moved.
//!
//! Contacts of the links' primitives with each other and with regions are bounded between samples as well. Not handled: meshes.

mod clearance;
mod designer;
mod effort_bound;
mod error;
mod fourier;
mod imitation;
mod information;
mod keep_out;
mod law_columns;
mod limits;
mod moves;
mod part;
mod predicted;
mod search;
mod separation;
mod suite;
mod sweep;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod test_arms;
mod visibility;

pub use designer::SuiteMotion;
pub use error::ExcitationError;
pub use fourier::{Bounds, FourierJoint};
pub use information::Information;
pub use keep_out::KeepOut;
pub use limits::{GivenLimits, MotionLimits};
pub use part::{Part, Split};
pub use predicted::PredictedError;
pub use search::FourierMotion;
pub use separation::{RivalEffects, RivalModels, Separation};
pub use suite::{ExciteRequest, Suite, SuiteSettings, excite};
pub use visibility::{STANDARD_ERRORS, Sight, Visibility};
