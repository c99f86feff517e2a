//! Designs the motions of an identification: a suite inside the arm's limits, and the standard errors it will give.
//!
//! [`excite`] is the door. Limits hold between samples: those of position, velocity, acceleration and jerk by bounds of the
//! series, those of the effort by a bound of its derivative. The objective is the determinant of the Fisher information of
//! the minimal inertia set and of the friction of each joint; the same information gives the standard errors before the arm
//! has moved.
//!
//! Not handled: collisions.

mod effort_bound;
mod error;
mod fourier;
mod information;
mod limits;
mod search;
mod suite;
mod sweep;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod test_arms;

pub use error::ExcitationError;
pub use fourier::{Bounds, FourierJoint};
pub use information::Information;
pub use limits::{GivenLimits, MotionLimits};
pub use search::FourierMotion;
pub use suite::{
    ExciteRequest, Part, PredictedError, Split, Suite, SuiteMotion, SuiteSettings, excite,
};
