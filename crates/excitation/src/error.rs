//! Why no motion can be designed.

use armident_numeric::NumericError;
use armident_recording::RecordingError;

/// Why no motion can be designed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExcitationError {
    /// Limits are given for a joint that the chain does not have.
    #[error("limits are given for joint `{joint}`, which is not on the chain")]
    UnknownJoint {
        /// The joint.
        joint: String,
        /// Joints of the chain.
        known: Vec<String>,
    },
    /// A limit is not possible.
    #[error("limit `{limit}` of joint `{joint}`: expected {expected}, found {value}")]
    Limit {
        /// Joint.
        joint: String,
        /// Which limit.
        limit: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// A setting is not possible.
    #[error("{setting}: expected {expected}, found {value}")]
    Setting {
        /// Which setting.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// No motion keeps to the effort limits.
    #[error(
        "no motion keeps to the effort limits: joint `{joint}` needs {effort:.3} where {limit:.3} may be used, \
         on the best of {tried} motions"
    )]
    Effort {
        /// Joint whose limit is exceeded most.
        joint: String,
        /// Its effort \[N m or N\].
        effort: f64,
        /// What may be used of its limit.
        limit: f64,
        /// Motions that were tried.
        tried: usize,
    },
    /// Linear algebra failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// A planned motion is no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}
