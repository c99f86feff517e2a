//! Data of `armident identify`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::by_joint::{ByJoint, or_nan};
use super::consistency::ConsistencyReport;
use super::constants::ConstantRow;

/// Result of `armident identify`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct IdentifyReport {
    /// `armident.identify/2`.
    pub schema: String,
    /// `algorithm2` or `batch`.
    pub method: String,
    /// Estimator: `ols`, `wls`, `irls` or `iv`; `null` with Algorithm 2.
    pub estimator: Option<String>,
    /// Robot name.
    pub robot: String,
    /// Training recordings.
    pub recordings: Vec<String>,
    /// Hold-out recordings.
    pub holdout_recordings: Vec<String>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Cut-off frequency of the low-pass \[Hz\]; `null` where recorded accelerations were used.
    pub cutoff_hz: Option<f64>,
    /// Source of the velocities: `position` or `recorded`.
    pub velocities: String,
    /// Prior scale: relative standard deviation of the URDF inertias; `null` without a prior.
    #[serde(alias = "link_prior")]
    pub prior_scale: Option<f64>,
    /// Physically consistent links of the model; `null` with `--raw-estimate`.
    pub consistency: Option<ConsistencyReport>,
    /// Constants of the minimal set.
    pub constants: Vec<ConstantRow>,
    /// Parameters of effects on joints.
    pub effects: Vec<EffectRow>,
    /// Parameters that are not separately identifiable on this arm.
    pub merged: Vec<MergedRow>,
    /// Gains of drives whose current was recorded instead of an effort; absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drive_gains: Vec<DriveGainRow>,
    /// What lies between motor and torque sensor, of joints with a current and an effort; absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensed_gears: Vec<SensedGearRow>,
    /// Known payloads of recordings; absent without `--payload`.
    #[serde(alias = "loads", skip_serializing_if = "Vec::is_empty")]
    pub payloads: Vec<PayloadRow>,
    /// Steps of Algorithm 2; empty for `batch`.
    pub steps: Vec<StepRow>,
    /// Numerical rank.
    pub rank: usize,
    /// Number of parameters.
    #[serde(alias = "unknowns")]
    pub parameters: usize,
    /// Condition number of the normalised columns (of the worst step of Algorithm 2).
    #[serde(deserialize_with = "or_nan")]
    pub condition: f64,
    /// Rows of the least-squares problem.
    pub rows: usize,
    /// Effective sample size over samples after filtering.
    #[serde(alias = "independent_share", deserialize_with = "or_nan")]
    pub effective_sample_share: f64,
    /// Residual level of the low-passed effort, by joint \[N m or N\].
    pub effort_noise: ByJoint,
    /// Parameters whose 95 % interval includes 0.
    #[serde(alias = "not_essential")]
    pub not_significant: Vec<String>,
    /// Durbin-Wu-Hausman test, with `iv`.
    pub endogeneity: Option<EndogeneityRow>,
    /// Errors on each recording of a fit to the others, with `--cross-validate` and several recordings.
    pub cross_validation: Option<FitRows>,
    /// Effort errors of the model (with `--raw-estimate` of the estimate) and of the URDF. One and a half periods of
    /// the cut-off frequency are left out at both ends of a recording.
    pub fit: FitReport,
    /// Warnings, each with its code in brackets.
    pub warnings: Vec<String>,
    /// Notes: automatic choices and repairs.
    pub notes: Vec<String>,
}

/// Durbin-Wu-Hausman test of endogeneity.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct EndogeneityRow {
    /// Parameter with the largest shift.
    pub term: String,
    /// Shift between least squares and instrumental variables, in standard errors.
    #[serde(deserialize_with = "or_nan")]
    pub t: f64,
    /// p-value over all parameters.
    #[serde(deserialize_with = "or_nan")]
    pub p: f64,
}

/// One parameter of an effect on a joint.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct EffectRow {
    /// Slug of the effect.
    pub effect: String,
    /// Joint name.
    pub joint: String,
    /// Second of two joints that share a transmission; else absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_joint: Option<String>,
    /// Parameter of the law.
    pub parameter: String,
    /// Unit.
    pub unit: String,
    /// Estimate.
    pub value: f64,
    /// Standard error; `null` at the bound.
    pub standard_error: Option<f64>,
    /// Whether the law admits the sign.
    pub admissible: bool,
    /// Whether the estimate is at its bound, 0.
    pub at_bound: bool,
    /// Share that the recordings do not identify, 0 to 1.
    pub undetermined: f64,
}

/// Between the motor of a joint and its torque sensor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct SensedGearRow {
    /// Joint name.
    pub joint: String,
    /// Whether the effort of the sensor determines the gain; if not, the numbers mean nothing.
    pub determined: bool,
    /// Torque constant times gear ratio \[N m/A or N/A\].
    pub gain: SensedNumber,
    /// Viscous friction \[N m s/rad or N s/m\].
    pub viscous: SensedNumber,
    /// Coulomb friction \[N m or N\].
    pub coulomb: SensedNumber,
    /// Inertia of motor and gear \[kg m2 or kg\].
    pub inertia: SensedNumber,
    /// Effort of the sensor at a current of 0, with the other sign \[N m or N\].
    pub offset: SensedNumber,
    /// RMS residual in terms of effort \[N m or N\].
    pub rms: f64,
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct SensedNumber {
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Gain of a drive: effort per unit current.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct DriveGainRow {
    /// Joint name.
    pub joint: String,
    /// Estimate; relative to one drive where only ratios are identifiable.
    pub value: f64,
    /// Standard error; `null` for the drive that the others are relative to.
    pub standard_error: Option<f64>,
    /// 95 % interval; `null` where the gain is not identifiable.
    pub interval_95: Option<[f64; 2]>,
    /// `N m/A`, `N/A` or `relative`.
    pub unit: String,
    /// Gain used in the fit.
    pub used: f64,
}

/// A payload of known mass on the last link.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PayloadRow {
    /// Recordings that have it.
    pub recordings: Vec<String>,
    /// Its mass \[kg\].
    pub mass_kg: f64,
    /// Its centre of mass in the frame of the last moving link \[m\].
    #[serde(alias = "centre_m")]
    pub centre_of_mass_m: [f64; 3],
    /// Whether the centre of mass was estimated.
    #[serde(alias = "found")]
    pub is_estimated: bool,
}

/// A parameter that is not separately identifiable on this arm.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct MergedRow {
    /// The parameter.
    pub term: String,
    /// Parameters that include it, with factors.
    pub into: BTreeMap<String, f64>,
}

/// One step of Algorithm 2.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct StepRow {
    /// Number in the paper.
    pub step: String,
    /// Equation of the paper.
    pub equation: String,
    /// Observed joint.
    pub observed: String,
    /// Constants estimated.
    pub unknowns: Vec<String>,
    /// Rows.
    pub rows: usize,
    /// Rank over columns.
    pub rank: usize,
    /// Columns.
    pub columns: usize,
    /// Condition number.
    #[serde(deserialize_with = "or_nan")]
    pub condition: f64,
    /// Residual RMS.
    #[serde(deserialize_with = "or_nan")]
    pub rmse: f64,
}

/// Effort errors of training, hold-out and URDF.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct FitReport {
    /// On the training recordings.
    pub train: FitRows,
    /// On the hold-out; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holdout: Option<FitRows>,
    /// Of the URDF, without friction, on the hold-out (or else on training).
    pub urdf: FitRows,
}

/// Effort errors by joint, low-passed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct FitRows {
    /// Root mean square residual \[N m or N\].
    pub rmse: ByJoint,
    /// Relative to the standard deviation of the effort.
    pub relative: ByJoint,
}

impl IdentifyReport {
    /// Current schema.
    pub const SCHEMA: &str = "armident.identify/2";

    /// Errors of the hold-out, or else of training, and whether they are of the hold-out.
    pub fn judged(&self) -> (&FitRows, bool) {
        let holdout = self.fit.holdout.as_ref().map(|fit| (fit, true));
        holdout.unwrap_or((&self.fit.train, false))
    }

    /// Method or estimator in words.
    pub fn method_in_words(&self) -> &str {
        match self.estimator.as_deref() {
            // an estimator that is not in the library goes by its name
            Some(name) => armident_ident::estimators::by_name(name).map_or(name, |e| e.title()),
            None if self.method == "algorithm2" => "Algorithm 2",
            None => &self.method,
        }
    }
}
