//! Why an identification failed.

use armident_numeric::NumericError;
use armident_recording::RecordingError;

use crate::consistency::ConsistencyError;
use crate::estimators::EstimatorError;
use crate::experiment::Algorithm2Error;

/// Why an identification failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A recording cannot become a motion.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording lacks efforts.
    #[error("no effort column for {}", joints.join(", "))]
    NoEffort {
        /// Source of the recording.
        source_name: String,
        /// Joints without an effort.
        joints: Vec<String>,
    },
    /// A joint has efforts in some recordings and currents in others.
    #[error("joint `{joint}` has an effort here but only a current in another recording")]
    MixedChannels {
        /// Source of the recording that has efforts.
        source_name: String,
        /// The joint.
        joint: String,
    },
    /// The recordings do not determine the gains of drives whose current is recorded.
    #[error(
        "drive gains of {} are not identifiable from the currents (95 % interval over a factor of ten)",
        joints.iter().map(|joint| format!("`{joint}`")).collect::<Vec<_>>().join(", ")
    )]
    GainsNotDetermined {
        /// Sources of the training recordings.
        sources: Vec<String>,
        /// Joints of these drives.
        joints: Vec<String>,
    },
    /// The estimator.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// The projection to consistent links.
    #[error(transparent)]
    Consistency(#[from] ConsistencyError),
    /// Planned experiments that do not match their plan.
    #[error(transparent)]
    Planned(#[from] Algorithm2Error),
    /// A number is not finite.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}
