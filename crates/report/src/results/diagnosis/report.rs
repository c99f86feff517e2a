//! The result as data.

use std::collections::BTreeMap;

use armident_diagnose::Errors;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use super::finding::FindingRow;
use super::input_checks::InputCheckRows;
use super::residual_map::JointResiduals;
use crate::results::by_joint::{ByJoint, or_nan};
use crate::results::units::{all_translate, effort_unit, position_unit};

/// What was diagnosed.
#[derive(Debug, Clone, Default)]
pub struct DiagnoseInputs {
    /// Training recordings.
    pub recordings: Vec<String>,
    /// Hold-out recordings.
    pub holdout_recordings: Vec<String>,
    /// Recordings from before a change.
    pub reference_recordings: Vec<String>,
    /// Whether the robot was given as a model with effects of its own, which are no findings.
    pub beyond_a_model: bool,
    /// Warnings from reading the robot.
    pub warnings: Vec<String>,
}

/// Root mean square effort errors, unfiltered, by joint \[N m or N\].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct EffortErrors {
    /// Given model, without effects.
    pub before: ByJoint,
    /// Links-only fit.
    pub rigid: ByJoint,
    /// Diagnosed model.
    pub after: ByJoint,
}

impl From<Errors> for EffortErrors {
    fn from(errors: Errors) -> Self {
        Self {
            before: errors.before.into(),
            rigid: errors.rigid.into(),
            after: errors.after.into(),
        }
    }
}

/// Effort errors of training and hold-out.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Fits {
    /// Of the training recordings.
    pub train: Option<EffortErrors>,
    /// Of the hold-out; `null` without `--holdout`.
    pub holdout: Option<EffortErrors>,
}

impl Fits {
    /// Errors of the hold-out, or else of training, and whether they are of the hold-out.
    pub fn judged(&self) -> Option<(&EffortErrors, bool)> {
        let holdout = self.holdout.as_ref().map(|errors| (errors, true));
        holdout.or_else(|| self.train.as_ref().map(|errors| (errors, false)))
    }
}

/// Data of single sections, by key, in the order of the sections.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MoreData(Vec<(String, Value)>);

impl MoreData {
    /// The data of a key; none where there is none.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.0.iter().find(|(known, _)| known == key).map(|(_, data)| data)
    }

    /// Sets the data of a key.
    pub fn set(&mut self, key: &str, data: Value) {
        match self.0.iter_mut().find(|(known, _)| known == key) {
            Some((_, old)) => *old = data,
            None => self.0.push((key.to_owned(), data)),
        }
    }

    /// The data of a key as a type; none where it is absent or of another form.
    pub fn read<T: DeserializeOwned>(&self, key: &str) -> Option<T> {
        T::deserialize(self.get(key)?).ok()
    }
}

impl Serialize for MoreData {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.0.iter().map(|(key, data)| (key, data)))
    }
}

impl<'de> Deserialize<'de> for MoreData {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let map = BTreeMap::<String, Value>::deserialize(from)?;
        Ok(Self(map.into_iter().collect()))
    }
}

impl JsonSchema for MoreData {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "MoreData".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object" })
    }
}

/// Result of `armident diagnose`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct DiagnoseReport {
    /// `armident.diagnosis/2`.
    pub schema: String,
    /// `match`, or `mismatch`: findings, failed input checks, or joints in `unexplained` or `link_errors_material_on`.
    pub verdict: String,
    /// First line of the text.
    pub sentence: String,
    /// Robot name.
    pub robot: String,
    /// Training recordings.
    pub recordings: Vec<String>,
    /// Hold-out recordings.
    pub holdout_recordings: Vec<String>,
    /// Recordings of the reference; absent without `--reference`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reference_recordings: Vec<String>,
    /// Chain joints in order.
    pub joints: Vec<String>,
    /// Joints that translate: their positions are in m and their efforts in N, all others in rad and N m. `null` where
    /// that is not known.
    pub prismatic_joints: Option<Vec<String>>,
    /// Outcome of the input checks.
    #[serde(alias = "books")]
    pub input_checks: InputCheckRows,
    /// Missing effects, most material first.
    pub findings: Vec<FindingRow>,
    /// Effort errors.
    pub fit: Fits,
    /// Standard deviation of one recorded effort sample, by joint \[N m or N\].
    pub effort_noise: ByJoint,
    /// Relative standard deviation of the given model's inertias that makes the recordings most likely.
    #[serde(alias = "inertial_error", deserialize_with = "or_nan")]
    pub prior_scale: f64,
    /// Joints on which the errors of all link inertias together are material.
    #[serde(alias = "inertias_matter_on")]
    pub link_errors_material_on: Vec<String>,
    /// Residuals by joint, and what they depend on.
    #[serde(alias = "atlas")]
    pub residual_map: Vec<JointResiduals>,
    /// Joints whose residual, with all findings, is over three times the in-band noise.
    pub unexplained: Vec<String>,
    /// Joints whose hold-out error is over 10 % larger than with the given model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub worse_on_holdout: Vec<String>,
    /// p-value of the Ljung-Box test of the hold-out residual, by joint; `null` where it is too short.
    #[serde(skip_serializing_if = "is_empty")]
    pub whiteness_p: ByJoint,
    /// Warnings, each with its code in brackets.
    pub warnings: Vec<String>,
    /// Data of single sections.
    #[serde(flatten)]
    pub more: MoreData,
}

fn is_empty(numbers: &ByJoint) -> bool {
    numbers.is_empty()
}

impl DiagnoseReport {
    /// Current schema.
    pub const SCHEMA: &str = "armident.diagnosis/2";

    /// Whether a change against a reference was diagnosed.
    pub fn is_change(&self) -> bool {
        !self.reference_recordings.is_empty()
    }

    /// Whether a joint translates; none where that is not known.
    fn translates(&self, joint: &str) -> Option<bool> {
        Some(self.prismatic_joints.as_ref()?.iter().any(|name| name == joint))
    }

    /// Unit of a joint's position: `rad` or `m`.
    pub fn position_unit(&self, joint: &str) -> &'static str {
        position_unit(self.translates(joint))
    }

    /// Unit of the positions of all joints.
    pub fn position_units(&self) -> &'static str {
        position_unit(all_translate(&self.joints, self.prismatic_joints.as_ref()))
    }

    /// Unit of a joint's effort: `N m` or `N`.
    pub fn effort_unit(&self, joint: &str) -> &'static str {
        effort_unit(self.translates(joint))
    }

    /// Unit of the efforts of all joints.
    pub fn effort_units(&self) -> &'static str {
        effort_unit(all_translate(&self.joints, self.prismatic_joints.as_ref()))
    }
}
