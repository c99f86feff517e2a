//! A law with its parameters and its place.

use serde::{Deserialize, Serialize};

/// An effect with its parameters and its joint, as simulations take it and model files hold it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct EffectOnJoint {
    /// Slug of the effect.
    pub effect: String,
    /// Joint name; of a link, the joint that moves it; of two neighbours, the first. Effects of the
    /// whole arm need none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub joint: String,
    /// The second of two neighbours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_joint: Option<String>,
    /// Start and end of a contact in the time of its recording \[s\]; nothing: all the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window_s: Option<[f64; 2]>,
    /// Parameters in the order of the law.
    pub parameters: Vec<f64>,
}

impl EffectOnJoint {
    /// An effect on one joint.
    pub fn new(
        effect: impl Into<String>,
        joint: impl Into<String>,
        parameters: impl Into<Vec<f64>>,
    ) -> Self {
        Self {
            effect: effect.into(),
            joint: joint.into(),
            parameters: parameters.into(),
            ..Self::default()
        }
    }
}

/// An [`EffectOnJoint`] that the library cannot serve.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnknownEffect {
    /// No effect of this name.
    #[error("there is no effect `{found}`; known are {known}")]
    Slug {
        /// What was asked for.
        found: String,
        /// Slugs of the library.
        known: String,
    },
    /// Too few or too many numbers.
    #[error("effect `{effect}` takes the parameters ({expected}), found {found} numbers")]
    Parameters {
        /// The effect.
        effect: &'static str,
        /// Names of its parameters.
        expected: String,
        /// How many were given.
        found: usize,
    },
}
