//! The one arm model: what it holds, predicts and simulates, and its file.
//!
//! An [`ArmModel`] is a chain with its links, effects on joints and the filter they were found with. Recordings are put
//! at an [`OperatingPoint`] ([`PosedRecording`]), where laws that turn the configuration itself are assumed to be.

mod arm_model;
mod dead_zone;
mod diagnosed_model;
mod effect_columns;
mod learned;
mod link_load;
mod link_side_motion;
mod operating_point;
mod posed_recording;
mod prepared;
mod reversal;
mod smooth_term;
#[cfg(test)]
mod test_arms;
mod transmission;

pub use arm_model::{ArmModel, MODEL_SCHEMA, ModelError};
pub use dead_zone::Shown;
pub use diagnosed_model::{DiagnosedModel, is_bend};
pub use effect_columns::{DEFAULT_SPEED_RESOLUTION, effect_columns, joint_motion, pair_columns};
pub use learned::{Learned, LearnedError};
pub use link_load::Load;
pub use link_side_motion::MOST_TURNS;
pub use operating_point::OperatingPoint;
pub use posed_recording::{PosedRecording, changed};
pub use prepared::PreparedRecording;
pub use reversal::{SHARP, regularised_sign};
pub use smooth_term::{AxisQuantity, FactorForm, SmoothAxis, SmoothBasis, SmoothTerm, SpeedFactor};
pub use transmission::{Spring, Transmission, TransmissionTerm, of_shape};
