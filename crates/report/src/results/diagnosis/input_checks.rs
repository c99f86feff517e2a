//! What the recordings show about their own columns.

use armident_diagnose::InferredDriveGain;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::results::check::CheckRow;

/// Gain of a joint whose effort is recorded as a current or voltage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct DriveGainOfMasses {
    /// Joint.
    pub joint: String,
    /// `current` or `voltage`.
    pub quantity: String,
    /// Effort per unit \[N m or N, per A or V\], inferred from the URDF masses.
    pub gain: f64,
    /// Its 95 % interval.
    pub interval_95: [Option<f64>; 2],
    /// Whether the recordings identify it (an interval of less than a factor of ten); if not, the joint is excluded.
    pub determined: bool,
    /// Whether it comes from the given model, identified with a known load; else from the URDF masses.
    pub of_model: bool,
}

impl DriveGainOfMasses {
    fn of(found: &InferredDriveGain) -> Self {
        Self {
            joint: found.joint.clone(),
            quantity: found.quantity.to_owned(),
            gain: found.gain,
            interval_95: found.interval_95.map(Some),
            determined: found.determined,
            of_model: found.of_model,
        }
    }
}

/// Outcome of the input checks.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct InputCheckRows {
    /// Checks that failed; their joints are excluded from the diagnosis.
    pub faults: Vec<CheckRow>,
    /// Gains of joints with a current or voltage only.
    pub drive_gains: Vec<DriveGainOfMasses>,
    /// Why the columns were not checked; `null` where they were.
    pub unchecked: Option<String>,
}

impl InputCheckRows {
    /// Of the checks of a diagnosis.
    pub(crate) fn of(found: &armident_diagnose::InputChecks) -> Self {
        Self {
            faults: found.faults.iter().map(CheckRow::of).collect(),
            drive_gains: found.drive_gains.iter().map(DriveGainOfMasses::of).collect(),
            unchecked: found.unchecked.clone(),
        }
    }

    /// Whether a joint was excluded from the diagnosis.
    pub fn excludes(&self, joint: &str) -> bool {
        self.faults.iter().any(|fault| fault.joint.as_deref() == Some(joint))
            || self.drive_gains.iter().any(|gain| !gain.determined && gain.joint == joint)
    }
}
