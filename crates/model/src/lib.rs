//! The one arm model: what it holds, predicts and simulates, and its file.
//!
//! An [`ArmModel`] is a chain with its links, and what was found beyond: effects on joints, transmissions, smooth terms, the
//! tilt of the base, and what each channel does (encoder zero, delay, gain, dead zone). Recordings are put
//! at its [`OperatingPoint`] ([`PosedRecording`]), and [`ArmModel::predict`] gives their efforts.

mod arm_model;
mod dead_zone;
mod effect_columns;
mod file;
mod link_load;
mod link_prior;
mod link_side_motion;
mod merge;
mod operating_point;
mod posed_recording;
mod predict;
mod prepared;
mod reversal;
mod servo;
mod simulated;
mod smooth_term;
#[cfg(test)]
mod test_arms;
mod transmission;

pub use arm_model::{ArmModel, BandPrediction, DriveGainsKnown, is_sublinear};
pub use dead_zone::DeadZone;
pub use effect_columns::{DEFAULT_SPEED_RESOLUTION, effect_columns, joint_motion, pair_columns};
pub use file::{MODEL_SCHEMA, ModelError};
pub use link_load::Load;
pub use link_prior::{LEAST_SHARE, LinkError, MeanLink, link_errors, radius_of_gyration_m};
pub use link_side_motion::MOST_TURNS;
pub use operating_point::OperatingPoint;
pub use posed_recording::{PosedRecording, changed};
pub use predict::{PredictError, Prediction};
pub use prepared::PreparedRecording;
pub use reversal::{SHARP, regularised_sign};
pub use servo::ServoTerm;
pub use smooth_term::{AxisQuantity, FactorForm, SmoothAxis, SmoothBasis, SmoothTerm, SpeedFactor};
pub use transmission::{FittedTransmission, Spring, TransmissionTerm};
