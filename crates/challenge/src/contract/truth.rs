//! The truth of a case: `truth.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::contract::kind::CaseKind;

/// Start and end of the exam that are not judged \[s\].
pub const EDGE_S: f64 = 0.3;

/// Names a number per joint.
pub(crate) type PerJoint = BTreeMap<String, f64>;

/// What a case hides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// `armident.challenge/1`.
    pub schema: String,
    /// `field`, `hard` or `change`, nothing for a clean case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// Name of the case.
    pub case: String,
    /// Name of the robot.
    pub robot: String,
    /// The link on which a contact acts.
    pub tip_link: String,
    /// The hidden effects.
    pub effects: Vec<TrueEffect>,
    /// Baseline friction of a field case; of a change, its differences.
    #[serde(rename = "everyday", default, skip_serializing_if = "Vec::is_empty")]
    pub baseline: Vec<BaselineFriction>,
    /// Standard scale of the relative errors of every inertial; 0: the URDF is exact.
    #[serde(default)]
    pub background_inertial_error: f64,
    /// Joints whose effort the effects change.
    #[serde(default)]
    pub affected_joints: Vec<String>,
    /// Joint -> links that move rigidly with it.
    #[serde(default)]
    pub bodies: BTreeMap<String, Vec<String>>,
    /// Sensors.
    pub noise: NoiseTruth,
    /// Samples per second.
    pub sample_rate: SampleRate,
    /// Recording faults of a hard case.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub difficulties: Vec<String>,
    /// Recording dirt of a field case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dirt: Option<serde_json::Value>,
    /// What is reachable on `holdout.csv`.
    #[serde(flatten)]
    pub holdout: Floors,
    /// What is reachable on `exam.csv`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exam: Option<Floors>,
    /// Largest observability of the effects.
    #[serde(default)]
    pub observability: f64,
    /// How far the simulation is from its own laws.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checks: Option<serde_json::Value>,
}

impl Truth {
    /// What kind of case this is.
    pub fn kind(&self) -> CaseKind {
        match self.kind.as_deref() {
            Some("field") => CaseKind::Field,
            Some("hard") => CaseKind::Hard,
            Some("change") => CaseKind::Change,
            _ => CaseKind::Clean,
        }
    }

    /// Whether baseline friction of a joint may be reported beside what is hidden.
    pub(crate) fn has_baseline(&self, effect: &str, joint: &str) -> bool {
        let here = |term: &BaselineFriction| term.effect == effect && term.joints == [joint];
        match self.kind() {
            CaseKind::Clean => false,
            CaseKind::Field | CaseKind::Hard => true,
            CaseKind::Change => self.baseline.iter().any(here),
        }
    }

    /// Whether the efforts come through a filter, or by a clock of their own.
    pub(crate) fn delays_efforts(&self) -> bool {
        let size = |key: &str| self.dirt.as_ref().and_then(|dirt| dirt.get(key)?.as_f64());
        ["effort_clock_drift", "effort_low_pass_hz"]
            .into_iter()
            .any(|key| size(key).is_some_and(|size| size != 0.0))
    }

    /// The joint that moves a link.
    pub fn joint_of_link(&self, link: &str) -> Option<&str> {
        let moved = |links: &Vec<String>| links.iter().any(|name| name == link);
        self.bodies.iter().find(|(_, links)| moved(links)).map(|(joint, _)| joint.as_str())
    }
}

/// A hidden effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrueEffect {
    /// Slug of the effect, or `unlisted`.
    pub effect: String,
    /// Its joints.
    #[serde(default)]
    pub joints: Vec<String>,
    /// Its link.
    #[serde(default)]
    pub link: Option<String>,
    /// Its time window \[s\].
    #[serde(default)]
    pub window: Option<[f64; 2]>,
    /// The recording of the window.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// Its parameters in the units of the law.
    #[serde(default)]
    pub parameters: PerJoint,
    /// Columns on which an unlisted law depends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variables: Vec<String>,
    /// Formula of an unlisted or perturbed law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// The parameters whose error is scored.
    #[serde(default)]
    pub main_parameters: Vec<String>,
    /// Sets of findings that are the same torque.
    #[serde(default)]
    pub accept: Vec<Vec<Named>>,
    /// Findings that are tolerated beside the right one.
    #[serde(default)]
    pub tolerate: Vec<Named>,
    /// RMS of the torque over noise after projections.
    #[serde(default)]
    pub observability: Option<f64>,
    /// The same with the baseline friction of its joint projected out too.
    #[serde(default)]
    pub naming_margin: Option<f64>,
    /// The same without projections.
    #[serde(default)]
    pub raw_ratio: Option<f64>,
}

/// An effect with its place.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Named {
    /// Slug of the effect.
    pub effect: String,
    /// Its joints; none means any.
    #[serde(default)]
    pub joints: Vec<String>,
    /// Its link.
    #[serde(default)]
    pub link: Option<String>,
}

/// Viscous or Coulomb friction of a field case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BaselineFriction {
    /// `viscous_friction` or `coulomb_friction`.
    pub effect: String,
    /// Its joint.
    pub joints: Vec<String>,
    /// Its level or coefficient.
    pub parameters: PerJoint,
    /// The special law that contains it.
    pub covered_by: Option<String>,
    /// RMS of its torque over noise after projections.
    pub observability: Option<f64>,
    /// Whether it is above the noise at all.
    pub counted: bool,
}

/// Sensors of a case.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct NoiseTruth {
    /// Standard deviation of the effort noise per sample \[N m or N\].
    #[serde(default)]
    pub effort_sigma: PerJoint,
    /// What noise and stick phases leave to a careful user \[N m or N\].
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub effective_sigma: PerJoint,
    /// Noise over the torque range.
    #[serde(default)]
    pub effort_fraction: f64,
    /// `c` of the kernel `[c, 1 - 2c, c]`.
    #[serde(default)]
    pub effort_colour: f64,
    /// Encoder counts \[rad or m\].
    #[serde(default)]
    pub encoder_resolution: PerJoint,
    /// How the velocity channel came about, where there is one.
    #[serde(default)]
    pub velocity: Option<VelocityTruth>,
}

/// The velocity channel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct VelocityTruth {
    /// `causal_low_pass_of_encoder_difference` or `white`.
    #[serde(default)]
    pub kind: String,
    /// Cut-off of the former \[Hz\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cutoff_hz: Option<f64>,
    /// Noise of the latter over the RMS speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fraction_of_rms: Option<f64>,
}

/// Samples per second, of all files or of each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SampleRate {
    /// All files \[Hz\].
    All(f64),
    /// By name of the file without extension \[Hz\].
    PerFile(BTreeMap<String, f64>),
}

/// Root mean square errors per joint that bound what a diagnosis can reach \[N m or N\].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Floors {
    /// True model on the true motion: the noise.
    #[serde(default)]
    pub oracle_rmse: PerJoint,
    /// True rigid body on the filtered recorded position.
    #[serde(default)]
    pub practical_rmse: PerJoint,
    /// True laws on the filtered recorded position, best cut-off.
    #[serde(default)]
    pub attainable_rmse: PerJoint,
    /// Given URDF on the true motion.
    #[serde(default)]
    pub urdf_rmse: PerJoint,
    /// Given URDF on the filtered recorded position.
    #[serde(default)]
    pub urdf_rmse_practical: PerJoint,
}
