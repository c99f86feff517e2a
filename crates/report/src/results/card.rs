//! Data of the model card of an identified arm.

use armident_model::ArmModel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::by_joint::ByJoint;
use super::identify::IdentifyReport;
use super::parameters::ParameterRow;

/// An identified arm in short: of which unit, from what, how large and how certain.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ModelCard {
    /// `armident.card/1`.
    pub schema: String,
    /// Robot name.
    pub robot: String,
    /// Serial number of the unit; `null` where it was not given.
    pub serial: Option<String>,
    /// Date of the recordings; `null` where it was not given and the stamps have none.
    pub date: Option<String>,
    /// Version of the program.
    pub version: String,
    /// Method or estimator in words.
    pub method: String,
    /// Cut-off frequency of the low-pass \[Hz\]; `null` where recorded accelerations were used.
    pub cutoff_hz: Option<f64>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Files that the model was made of, with their digests.
    pub inputs: Vec<CardInput>,
    /// Constants of the minimal set, parameters of effects and drive gains.
    pub parameters: Vec<ParameterRow>,
    /// Links of the model, which are among those that the recordings do not distinguish.
    pub links: Vec<CardLink>,
    /// Effort errors and noise by joint.
    pub effort: Vec<CardEffort>,
    /// Warnings, each with its code in brackets.
    pub warnings: Vec<String>,
}

/// A file that a model was made of.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CardInput {
    /// The file.
    pub file: String,
    /// `robot`, `training`, `hold-out`, `mapping` or `plan`.
    pub used_as: String,
    /// Size \[bytes\].
    pub bytes: u64,
    /// SHA-256; empty where the file could not be read again.
    pub sha256: String,
}

/// A link of a model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CardLink {
    /// The joint that moves it.
    pub joint: String,
    /// Its name.
    pub link: String,
    /// Mass \[kg\].
    pub mass_kg: f64,
    /// Mass in the robot description \[kg\].
    pub given_mass_kg: f64,
    /// Centre of mass in its driving-axis frame \[m\].
    pub centre_of_mass_m: [f64; 3],
}

/// How well the efforts of a joint are predicted.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CardEffort {
    /// Joint name.
    pub joint: String,
    /// Root mean square error on the training recordings \[N m or N\].
    pub training: Option<f64>,
    /// On the hold-out; `null` without one.
    pub holdout: Option<f64>,
    /// Of the robot description, on the hold-out or else on training.
    pub given: Option<f64>,
    /// Residual level of the fit.
    pub noise: Option<f64>,
}

impl ModelCard {
    /// Current schema.
    pub const SCHEMA: &str = "armident.card/1";

    /// Of an identification and its model. `date`, where it is not known, is none.
    pub fn of(
        report: &IdentifyReport,
        model: &ArmModel,
        inputs: Vec<CardInput>,
        serial: Option<String>,
        date: Option<String>,
    ) -> Self {
        let of = |numbers: &ByJoint, joint: &String| numbers.get(joint).copied();
        let holdout = report.fit.holdout.as_ref();
        let effort = report.joints.iter().map(|joint| CardEffort {
            training: of(&report.fit.train.rmse, joint),
            holdout: holdout.and_then(|fit| of(&fit.rmse, joint)),
            given: of(&report.fit.urdf.rmse, joint),
            noise: of(&report.effort_noise, joint),
            joint: joint.clone(),
        });
        let before = model.before();
        let links =
            model.chain.joints.iter().zip(&before.chain.joints).map(|(joint, given)| CardLink {
                joint: joint.name.clone(),
                link: joint.child_link.clone(),
                mass_kg: joint.link.mass_kg,
                given_mass_kg: given.link.mass_kg,
                centre_of_mass_m: joint.link.com_m().into(),
            });
        Self {
            schema: Self::SCHEMA.to_owned(),
            robot: report.robot.clone(),
            serial,
            date,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            method: report.method_in_words().to_owned(),
            cutoff_hz: report.cutoff_hz,
            joints: report.joints.clone(),
            inputs,
            parameters: report.parameter_rows(),
            links: links.collect(),
            effort: effort.collect(),
            warnings: report.warnings.clone(),
        }
    }
}
