//! Elastic transmissions and backlash.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::detail;
use crate::layout::{Block, significant};
use crate::results::DiagnoseReport;
use crate::section::{SectionData, Source};

/// A transmission between motor and link.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct TransmissionRow {
    /// Joint.
    pub joint: String,
    /// Gap \[rad or m\]; 0 without backlash.
    pub gap: f64,
    /// Stiffness, of the flanks where there is a gap \[N m/rad or N/m\].
    pub stiffness: f64,
    /// Damping \[N m s/rad or N s/m\].
    pub damping: f64,
    /// Motor inertia beyond that of the given model \[kg m2 or kg\].
    pub motor_inertia: f64,
    /// Fitted share of the difference to a rigid transmission; 1 where the law holds.
    pub share: f64,
}

/// Transmissions of the model that are not rigid.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct Transmissions(pub Vec<TransmissionRow>);

impl SectionData for Transmissions {
    const KEY: &'static str = "transmissions";

    fn of(source: &Source<'_>) -> Option<Self> {
        let found = &source.diagnosis.model.transmissions;
        let rows = found.iter().map(|term| TransmissionRow {
            joint: term.joint.clone(),
            gap: term.transmission.gap,
            stiffness: term.transmission.stiffness,
            damping: term.transmission.damping,
            motor_inertia: term.motor_inertia,
            share: term.share,
        });
        (!found.is_empty()).then(|| Self(rows.collect()))
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let row = |row: &TransmissionRow| {
            let (position, effort) =
                (result.position_unit(&row.joint), result.effort_unit(&row.joint));
            let number = |x: f64| significant(x, 3, 0.0);
            let inertia = if effort == "N" { "kg" } else { "kg m2" };
            let gap = match row.gap {
                gap if gap > 0.0 => format!("gap {} {position}, ", number(row.share * gap)),
                _ => String::new(),
            };
            detail(format!(
                "Transmission of {}: {gap}stiffness {} {effort}/{position}, damping {} {effort} s/{position}, motor \
                 inertia {} {inertia} beyond the given model",
                row.joint,
                number(row.stiffness),
                number(row.damping),
                number(row.motor_inertia)
            ))
        };
        self.0.iter().flat_map(row).collect()
    }
}
