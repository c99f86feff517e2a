//! Data of `armident identify` on recordings of commands.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Result of `armident identify` where commands are recorded and efforts are not.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ServosReport {
    /// `armident.identify_commands/1`.
    pub schema: String,
    /// Robot name.
    pub robot: String,
    /// Training recordings.
    pub recordings: Vec<String>,
    /// Hold-out recordings.
    pub holdout_recordings: Vec<String>,
    /// Joints from base to tip.
    pub joints: Vec<ServoRow>,
    /// Joints whose recorded current is a magnitude.
    pub currents_without_sign: Vec<String>,
    /// Warnings, each with its code in brackets.
    pub warnings: Vec<String>,
    /// Notes: automatic choices and repairs.
    pub notes: Vec<String>,
}

/// Controller and friction of one joint. What is over the stiffness is known also where the stiffness is not.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ServoRow {
    /// Joint.
    pub joint: String,
    /// Whether it translates.
    pub translates: bool,
    /// Effort by position error at gain 1 \[N m/rad or N/m\]; `null` where no motion determines it.
    pub stiffness: Option<ServoNumber>,
    /// Delay of the command \[s\].
    pub delay_s: ServoNumber,
    /// Viscous friction, back-EMF and derivative gain over the stiffness \[s\].
    pub damping_s: ServoNumber,
    /// Inertia of the rotor over the stiffness \[s²\].
    pub inertia_s2: ServoNumber,
    /// Constant effort over the stiffness \[rad or m\].
    pub offset: ServoNumber,
    /// Coulomb friction over the stiffness \[rad or m\].
    pub dry_friction: ServoNumber,
    /// Static friction beyond Coulomb friction over the stiffness \[rad or m\]; `null` where it is not significant.
    pub static_excess: Option<ServoNumber>,
    /// Stribeck velocity \[rad/s or m/s\]; likewise.
    pub stribeck_velocity: Option<ServoNumber>,
    /// Dry friction by the load \[1\]; `null` where it is not significant or no load is felt.
    pub load_friction: Option<ServoNumber>,
    /// Largest position error that the weight of the links causes \[rad or m\]; `null` where it is not determined.
    pub sag: Option<f64>,
    /// Median lag of the position behind the command, dry friction included \[s\]; `null` where the command hardly moves.
    pub lag_s: Option<f64>,
    /// 95 % interval of the median lag \[s\].
    pub lag_interval_95_s: Option<[f64; 2]>,
    /// RMS position error in simulation of each training recording \[rad or m\].
    pub train_rms: Vec<f64>,
    /// RMS position error in simulation of each hold-out recording \[rad or m\].
    pub holdout_rms: Vec<f64>,
    /// RMS position error of the command with the gain, offset and lag that suit each hold-out recording best, or each
    /// training recording where there is no hold-out \[rad or m\].
    pub command_rms: Vec<f64>,
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ServoNumber {
    /// The estimate.
    pub value: f64,
    /// Its standard error; `null` from too few recordings.
    pub standard_error: Option<f64>,
}

impl ServosReport {
    /// Current schema.
    pub const SCHEMA: &str = "armident.identify_commands/1";
}
