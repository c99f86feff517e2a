//! What the residual of each joint depends on.

use armident_diagnose::JointAtlas;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::results::by_joint::or_nan;

/// Multiple of the in-band noise below which a residual counts as explained.
const EXPLAINED: f64 = 3.0;

/// Samples of one bin of a variable.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct RegressorBin {
    /// Lower end of the variable.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Samples.
    pub rows: usize,
    /// Mean residual of the given model \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub mean_before: f64,
    /// Root mean square residual of the given model \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub rms_before: f64,
    /// Mean residual of the diagnosed model \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub mean_after: f64,
    /// Root mean square residual of the diagnosed model \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub rms_after: f64,
}

/// A variable and the share of the residual variance that the means of its bins explain.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct VariableShare {
    /// `speed`, `direction`, `load`, `position`, `acceleration`, `time_since_reversal`, `travel_since_reversal` or
    /// `time`.
    pub variable: String,
    /// Share explained with the given model, beyond that of random bins.
    #[serde(deserialize_with = "or_nan")]
    pub share_before: f64,
    /// Share explained with the diagnosed model.
    #[serde(deserialize_with = "or_nan")]
    pub share_after: f64,
    /// Bins of about as many samples each; of `time`, of equal length.
    pub bins: Vec<RegressorBin>,
}

/// A function of the motion and the share of the residual variance that it explains alone.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Regressor {
    /// The function.
    pub function: String,
    /// Share explained with the given model.
    #[serde(deserialize_with = "or_nan")]
    pub share_before: f64,
    /// Share explained with the diagnosed model.
    #[serde(deserialize_with = "or_nan")]
    pub share_after: f64,
    /// Effects that a large share indicates.
    #[serde(alias = "points_to")]
    pub indicates: String,
}

/// Residuals of one joint on the training recordings, below the comparison bandwidth.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct JointResiduals {
    /// Joint.
    pub joint: String,
    /// Root mean square residual of the given model \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub before: f64,
    /// Root mean square residual of the links-only fit \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub rigid: f64,
    /// Root mean square residual of the diagnosed model \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub after: f64,
    /// Noise \[N m or N\].
    #[serde(deserialize_with = "or_nan")]
    pub noise: f64,
    /// p-value of the Ljung-Box test of the diagnosed model's residual; `null` where it could not be determined.
    #[serde(deserialize_with = "or_nan")]
    pub whiteness_p: f64,
    /// Functions of the motion, strongest first.
    #[serde(alias = "symmetries")]
    pub regressors: Vec<Regressor>,
    /// Variables, strongest first.
    #[serde(alias = "regimes")]
    pub variables: Vec<VariableShare>,
}

impl JointResiduals {
    /// Of one joint of the diagnosis.
    pub(crate) fn of(found: &JointAtlas) -> Self {
        let bin = |bin: &armident_diagnose::Bin| RegressorBin {
            from: bin.from,
            to: bin.to,
            rows: bin.rows,
            mean_before: bin.mean_before,
            rms_before: bin.rms_before,
            mean_after: bin.mean_after,
            rms_after: bin.rms_after,
        };
        let regressors = found.symmetries.iter().map(|test| Regressor {
            function: test.function.to_owned(),
            share_before: test.share_before,
            share_after: test.share_after,
            indicates: test.points_to.to_owned(),
        });
        let variables = found.regimes.iter().map(|regime| VariableShare {
            variable: regime.variable.to_owned(),
            share_before: regime.share_before,
            share_after: regime.share_after,
            bins: regime.bins.iter().map(bin).collect(),
        });
        Self {
            joint: found.joint.clone(),
            before: found.before,
            rigid: found.rigid,
            after: found.after,
            noise: found.noise,
            whiteness_p: found.whiteness_p,
            regressors: regressors.collect(),
            variables: variables.collect(),
        }
    }

    /// Residual of the diagnosed model, in noise levels.
    pub fn residual_over_noise(&self) -> f64 {
        self.after / self.noise.max(f64::MIN_POSITIVE)
    }

    /// Whether the residual of the diagnosed model is little more than noise.
    pub fn is_explained(&self) -> bool {
        self.residual_over_noise() < EXPLAINED
    }
}
