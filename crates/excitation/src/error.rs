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
    /// A region to keep out of is none.
    #[error("keep-out `{name}`, {key}: expected {expected}, found {found}")]
    KeepOut {
        /// Name of the region.
        name: String,
        /// Which key.
        key: &'static str,
        /// What is there.
        found: String,
        /// What it must be.
        expected: &'static str,
    },
    /// Regions are given for an arm without shapes.
    #[error("keep-outs are given, but no link has a `<collision>` of a box, cylinder or sphere")]
    NoShapes,
    /// No pose inside the limits is free.
    #[error(
        "no pose inside the limits keeps clear: {} and {} are {missing_m:.3} m too near in the best of {tried} poses",
        names[0], names[1]
    )]
    NoFreePose {
        /// What touches.
        names: [String; 2],
        /// By how much the margin is missed \[m\].
        missing_m: f64,
        /// Poses that were tried.
        tried: usize,
    },
    /// Findings and alternatives that no motion can be designed for.
    #[error("no motion can be designed for the diagnosis: {found}")]
    Rival {
        /// What is wrong.
        found: String,
    },
    /// Linear algebra failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// A planned motion is no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}
