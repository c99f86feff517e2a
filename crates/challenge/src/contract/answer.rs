//! What a diagnosis writes: `out.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::contract::truth::{Named, PerJoint};

/// A diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// `armident.diagnosis/2`.
    pub schema: String,
    /// Whether model and recordings agree.
    pub verdict: AnswerVerdict,
    /// What is missing.
    #[serde(default)]
    pub findings: Vec<AnswerFinding>,
    /// How well the result fits.
    #[serde(default)]
    pub fit: Fit,
}

/// Whether model and recordings agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AnswerVerdict {
    /// They agree.
    Match,
    /// They do not.
    Mismatch,
}

/// A named effect.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AnswerFinding {
    /// Slug of the effect, or `unmodelled`.
    pub effect: String,
    /// Joints blamed.
    #[serde(default)]
    pub joints: Vec<String>,
    /// Link blamed.
    #[serde(default)]
    pub link: Option<String>,
    /// Time window \[s\].
    #[serde(default)]
    pub window: Option<[f64; 2]>,
    /// Recording of the window.
    #[serde(default)]
    pub recording: Option<String>,
    /// Parameters by name.
    #[serde(default)]
    pub parameters: BTreeMap<String, AnswerEstimate>,
    /// Probability that it is right.
    pub confidence: f64,
    /// Its evidence.
    #[serde(default)]
    pub evidence: Evidence,
    /// Effects that the recordings cannot distinguish from it.
    #[serde(default)]
    pub alternatives: Vec<Named>,
}

/// A number with its standard error.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AnswerEstimate {
    /// The number.
    pub value: Option<f64>,
    /// Its standard error.
    #[serde(default)]
    pub stderr: Option<f64>,
    /// Its unit.
    #[serde(default)]
    pub unit: Option<String>,
}

/// The part of the evidence that is scored.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Evidence {
    /// Columns on which an unmodelled torque depends.
    #[serde(default)]
    pub variables: Vec<String>,
}

/// How well a result fits.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Fit {
    /// On the hold-out.
    #[serde(default)]
    pub holdout: HoldoutRmse,
}

/// Root mean square errors on the recorded efforts of the hold-out \[N m or N\].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HoldoutRmse {
    /// The given URDF.
    #[serde(default)]
    pub before: PerJoint,
    /// After identifying the rigid body only.
    #[serde(default)]
    pub rigid: PerJoint,
    /// The full model.
    #[serde(default)]
    pub after: PerJoint,
}
