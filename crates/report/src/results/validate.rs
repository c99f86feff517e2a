//! Data of `armident validate`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::by_joint::{ByJoint, or_nan};
use super::units::{all_translate, position_unit};

/// Result of `armident validate`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ValidateReport {
    /// `armident.validate/1`.
    pub schema: String,
    /// Robot name.
    pub robot: String,
    /// Model file or URDF.
    pub model: String,
    /// Hold-out recordings.
    pub recordings: Vec<String>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Joints that translate: their positions are in m and their efforts in N, all others in rad and N m. `null` where
    /// that is not known.
    pub prismatic_joints: Option<Vec<String>>,
    /// Cut-off frequency of the low-pass \[Hz\].
    pub cutoff_hz: Option<f64>,
    /// Effort error of the URDF's links without effects, by joint.
    pub before: BTreeMap<String, EffortErrorRow>,
    /// Effort error of the model, by joint.
    pub after: BTreeMap<String, EffortErrorRow>,
    /// Position errors under commands; `null` where efforts are recorded.
    pub positions: Option<PositionsUnderCommands>,
    /// Forward replay of the URDF; `null` where it cannot be simulated, and with `--no-replay`.
    pub replay_before: Option<ReplayReport>,
    /// Forward replay of the model, likewise.
    pub replay_after: Option<ReplayReport>,
    /// Warnings, each with its code in brackets.
    pub warnings: Vec<String>,
    /// Notes: automatic choices and repairs.
    pub notes: Vec<String>,
}

/// Effort error of one joint; `null` where a number could not be determined.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct EffortErrorRow {
    /// Root mean square, low-passed \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub rmse: f64,
    /// Relative to the standard deviation of the effort.
    #[serde(deserialize_with = "or_nan")]
    pub relative: f64,
    /// Root mean square, unfiltered \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub rmse_raw: f64,
    /// Share of samples in the 95 % band: 1.96 noise levels of the fit.
    pub band_coverage: Option<f64>,
    /// Lag-1 autocorrelation of the residual.
    pub lag1_correlation: Option<f64>,
    /// p-value of the Ljung-Box test over 10 lags, residual thinned to twice the cut-off frequency.
    pub whiteness_p: Option<f64>,
}

/// RMS position errors of an arm behind its controllers \[rad or m\].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PositionsUnderCommands {
    /// Of the command itself.
    pub command: ByJoint,
    /// Of the model, from the first sample of each recording on.
    pub whole: ByJoint,
    /// Of the model, from the recorded state at the start of each window on.
    pub in_windows: ByJoint,
    /// Length of a window \[s\].
    pub window_s: f64,
    /// Windows simulated to their end.
    pub windows: usize,
    /// Windows that diverged.
    pub diverged: usize,
}

/// Forward replay of all joints.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ReplayReport {
    /// Length of a window \[s\].
    pub window_s: f64,
    /// Windows simulated to their end.
    pub windows: usize,
    /// Windows that diverged.
    pub diverged: usize,
    /// Root mean square position error \[rad or m\].
    pub position_rms: ByJoint,
    /// Root mean square velocity error \[rad/s or m/s\].
    pub velocity_rms: ByJoint,
}

impl ValidateReport {
    /// Current schema.
    pub const SCHEMA: &str = "armident.validate/1";

    /// Unit of the positions of all joints.
    pub fn position_units(&self) -> &'static str {
        position_unit(all_translate(&self.joints, self.prismatic_joints.as_ref()))
    }
}
