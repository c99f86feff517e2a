//! Estimated parameters of a result in one list.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::constants::ConstantRow;
use super::diagnosis::DiagnoseReport;
use super::identify::IdentifyReport;
use crate::words::{effect_label, parameter_label};

/// An estimated parameter of an arm.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ParameterRow {
    /// Label of a constant of the minimal set, or law and parameter: `Coulomb friction, level`.
    pub parameter: String,
    /// Joint or link.
    pub location: String,
    /// Unit; `1` of a pure number.
    pub unit: String,
    /// Estimate.
    pub value: f64,
    /// Standard error; `null` where it is not known.
    pub standard_error: Option<f64>,
    /// Value of the robot description; `null` where it has none.
    pub given: Option<f64>,
    /// Share that the recordings do not identify, 0 to 1.
    pub undetermined: f64,
}

impl IdentifyReport {
    /// Constants, parameters of effects and drive gains.
    pub(crate) fn parameter_rows(&self) -> Vec<ParameterRow> {
        let constants = self.constants.iter().filter_map(|constant| {
            Some(ParameterRow {
                parameter: constant.label.clone(),
                location: constant.joint.clone(),
                unit: constant.unit.clone(),
                value: constant.value?,
                standard_error: constant.standard_error,
                given: Some(constant.urdf),
                undetermined: constant.undetermined,
            })
        });
        let effects = self.effects.iter().map(|effect| {
            let other = effect.other_joint.iter();
            let joints: Vec<&str> =
                std::iter::once(&effect.joint).chain(other).map(String::as_str).collect();
            ParameterRow {
                parameter: of_effect(&effect.effect, &effect.parameter),
                location: joints.join(", "),
                unit: effect.unit.clone(),
                value: effect.value,
                standard_error: effect.standard_error,
                given: None,
                undetermined: effect.undetermined,
            }
        });
        let gains = self.drive_gains.iter().map(|gain| ParameterRow {
            parameter: "drive gain".to_owned(),
            location: gain.joint.clone(),
            unit: gain.unit.clone(),
            value: gain.value,
            standard_error: gain.standard_error,
            ..ParameterRow::default()
        });
        constants.chain(effects).chain(gains).collect()
    }
}

impl DiagnoseReport {
    /// Constants that were estimated with the findings; those of findings are with these.
    pub(crate) fn parameter_rows(&self) -> Vec<ParameterRow> {
        let constants: Vec<ConstantRow> = self.more.read("constants").unwrap_or_default();
        let row = |constant: ConstantRow| {
            Some(ParameterRow {
                parameter: constant.label,
                location: constant.joint,
                unit: constant.unit,
                value: constant.value?,
                standard_error: constant.standard_error,
                given: Some(constant.urdf),
                undetermined: constant.undetermined,
            })
        };
        constants.into_iter().filter_map(row).collect()
    }
}

/// `Coulomb friction, level`.
pub(super) fn of_effect(effect: &str, parameter: &str) -> String {
    format!("{}, {}", effect_label(effect), parameter_label(parameter))
}
