//! Mapping files: what the columns of a foreign file mean.

mod coupling;
mod plan;
mod reader;
mod rules;

use std::fs;
use std::path::Path;

use crate::draft::Draft;
use crate::error::{Fault, RecordingError, listed};
use crate::raw::RawColumns;
use crate::recording::{Quantity, Recording};
use crate::units::{Base, Unit, units_of};

use plan::{Claim, Plan};
use reader::Reader;
use rules::{PerJoint, Rules};

/// What the columns of a file mean, from a small TOML file.
///
/// # Format
///
/// ```toml
/// [time]                      # may be left out: then `t`, `__time` or `time`, in s
/// column = "stamp_ms"
/// unit = "ms"                 # s, ms, us, ns
/// sort = true                 # put rows into the order of time; otherwise that is a fault
///
/// [[channel]]
/// column = "q1_deg"           # name in the file
/// joint = "joint_1"           # name in the URDF
/// quantity = "position"       # of Quantity; may be left out where the column ends with it: a/position
/// unit = "deg"                # may be left out: SI
/// sign = -1                   # 1 or -1
/// offset = 1.5707963          # in SI, after unit and sign
///
/// [[coupling]]                # motors that move several joints
/// joints = ["joint_5", "joint_6"]
/// motors = ["m5", "m6"]       # names that channels above have as `joint`
/// matrix = [[45, 0], [32, 32]]
/// offset = [0, 0]             # may be left out
/// ```
///
/// | quantity | units | other keys |
/// |---|---|---|
/// | position, motor_position | `rad` `deg` `turn` `m` `mm` `counts` | `gear_ratio` divides; `counts_per_turn`, or `gain` per count |
/// | velocity | the same per second: `rad/s` `deg/s` `turn/s` `rpm` `m/s` `mm/s` `counts/s` | as above |
/// | acceleration | `rad/s^2` `deg/s^2` `turn/s^2` `m/s^2` `mm/s^2` `counts/s^2` | as above |
/// | effort | `N m` `N mm` `mN m` `N` | `gear_ratio` multiplies: a torque of the motor |
/// | effort | `A` `mA` | `gain` in N m/A, or `torque_constant` in N m/A times `gear_ratio` |
/// | effort | `V` `mV` | `torque_constant`, `resistance_ohm`, `gear_ratio`, `back_emf` |
/// | current | `A` `mA` `counts` | `gain` in A per count |
/// | voltage | `V` `mV` `counts` | `gain` in V per count |
/// | temperature | `degC` `K` | |
///
/// `gain` is a factor everywhere: SI unit of the quantity per unit of the column. `gear_ratio` is
/// motor turns per joint turn. Other columns are ignored and noted.
///
/// **Whole arms.** `{joint}` in a column stands for any joint's name, `{quantity}` for any
/// quantity, and `joint = "arm_{joint}"` makes the joint's name from the part found. Numbers may be
/// one per joint: `gain = { shoulder = 13.6, elbow = -8.7 }`; then the channel is of these joints
/// only (`sign` and `offset` of the others are 1 and 0). A channel that names its column comes
/// before channels with placeholders, these come in the order of the file, and a column is taken
/// once by them.
///
/// **Voltage.** A drive voltage u gives `effort = sign · gear · kt / R · u - (gear · kt)² / R · velocity`.
/// The second term, the back-EMF, is viscous friction in all but name. It is left to the viscous
/// friction that is identified, since recorded velocities are noisy or late; that coefficient then
/// contains (gear · kt)² / R, and a note says how much. With `back_emf = true` the term is formed
/// from the recorded velocity. Either holds only while the bridge drives the motor: with the bridge
/// off there is no back-EMF.
///
/// **Coupling.** `q_motor = R q_joint + const` with one row of R per motor, so velocities and
/// accelerations alike, and by the principle of virtual work `tau_joint = Rᵀ tau_motor`. Quantities
/// that are recorded for all motors of a coupling become those of its joints.
///
/// # Examples
///
/// A whole arm whose currents are multiplied by a gain per joint:
///
/// ```
/// use armident_recording::{Mapping, read_csv_mapped_from};
///
/// let mapping = Mapping::parse(r#"
/// [[channel]]
/// column = "{joint}/current"
/// quantity = "effort"
/// unit = "A"
/// gain = { arm_1_joint = 13.6, arm_2_joint = 13.6, arm_3_joint = -8.7, arm_4_joint = -8.7 }
/// [[channel]]
/// column = "{joint}/{quantity}"
/// "#, "tiago.toml")?;
///
/// let mut text = "t,arm_1_joint/position,arm_1_joint/current,arm_2_joint/position,\
///                 arm_2_joint/current,arm_3_joint/position,arm_3_joint/current,\
///                 arm_4_joint/position,arm_4_joint/current\n".to_owned();
/// for k in 0..10 {
///     text += &format!("{},0.07,0.5,0.04,1.0,-0.03,0.0,0.005,2.0\n", 0.01 * f64::from(k));
/// }
/// let recording = read_csv_mapped_from(text.as_bytes(), "run.csv", &mapping)?;
/// let effort = |joint| recording.joint(joint).unwrap().effort.as_ref().unwrap()[0];
/// assert_eq!((effort("arm_1_joint"), effort("arm_4_joint")), (6.8, -17.4));
/// # Ok::<(), armident_recording::RecordingError>(())
/// ```
///
/// A servo of which only the drive voltage is known:
///
/// ```
/// # use armident_recording::{Mapping, read_csv_mapped_from};
/// let mapping = Mapping::parse(r#"
/// [[channel]]
/// column = "servo/voltage"
/// joint = "servo"
/// quantity = "effort"
/// unit = "V"
/// torque_constant = 0.366
/// resistance_ohm = 2.81
/// [[channel]]
/// column = "{joint}/position"
/// "#, "xl330.toml")?;
/// # let rows: String = (0..9).map(|k| format!("{},0.1,2.81\n", 0.005 * f64::from(k))).collect();
/// # let text = format!("t,servo/position,servo/voltage\n{rows}");
/// let recording = read_csv_mapped_from(text.as_bytes(), "sine.csv", &mapping)?;
/// assert!((recording.joints[0].effort.as_ref().unwrap()[0] - 0.366).abs() < 1e-12);
/// # Ok::<(), armident_recording::RecordingError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Mapping {
    source: String,
    rules: Rules,
}

impl Mapping {
    /// Reads a mapping file.
    ///
    /// # Errors
    /// The file cannot be read, or the faults of [`parse`](Self::parse).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, RecordingError> {
        let path = path.as_ref();
        let source = path.display().to_string();
        let text = fs::read_to_string(path).map_err(|error| {
            let fault = match error.kind() {
                std::io::ErrorKind::NotFound => Fault::NotFound,
                _ => Fault::Io { doing: "read", error },
            };
            RecordingError::new(fault, &source)
        })?;
        Self::parse(&text, &source)
    }

    /// Reads the text of a mapping file; `source` names it in messages.
    ///
    /// # Errors
    /// No TOML; unknown keys, quantities or units; numbers that make no sense.
    pub fn parse(text: &str, source: &str) -> Result<Self, RecordingError> {
        Ok(Self { source: source.to_owned(), rules: Reader::rules(text, source)? })
    }

    /// Where it comes from.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Which of the named columns of a file are read.
    pub(crate) fn reads(
        &self,
        names: &[String],
        of_file: &str,
    ) -> Result<Vec<bool>, RecordingError> {
        let plan = Plan::new(&self.rules, names, &self.source, of_file)?;
        let mut read = vec![false; names.len()];
        read[plan.time] = true;
        for claim in &plan.claims {
            read[claim.column] = true;
        }
        Ok(read)
    }

    /// The recording that the columns hold.
    ///
    /// # Errors
    /// Columns that the mapping names are not there, two columns for one channel, coupled motors of
    /// which some are missing; or the signals are faulty in a way that is not repaired on reading.
    pub fn apply(&self, raw: &RawColumns) -> Result<Recording, RecordingError> {
        let names = raw.names();
        let plan = Plan::new(&self.rules, &names, &self.source, &raw.source)?;
        let column = |index: usize| -> Result<&[f64], RecordingError> {
            raw.columns[index].values.as_deref().ok_or_else(|| {
                let (expected, found) = (raw.rows(), 0);
                RecordingError::new(Fault::LengthMismatch { expected, found }, &raw.source)
                    .in_column(&names[index])
            })
        };
        let stamps = column(plan.time)?;
        let per_s = self.rules.time.unit.map_or(1.0, |unit| 1.0 / unit.factor);
        // divided by a whole number of units per second, as the decimal text would be
        let time_s: Vec<f64> = stamps.iter().map(|t| t / per_s.round()).collect();

        let mut values = Vec::new();
        for claim in &plan.claims {
            let raw_values = column(claim.column)?;
            if raw_values.len() != stamps.len() {
                let fault =
                    Fault::LengthMismatch { expected: stamps.len(), found: raw_values.len() };
                return Err(RecordingError::new(fault, &raw.source).in_column(&names[claim.column]));
            }
            values.push(self.converted(claim, raw_values));
        }
        let back_emf_notes = self.subtract_back_emf(&plan, &names, &mut values)?;

        let header = RawColumns {
            source: raw.source.clone(),
            columns: names
                .iter()
                .map(|name| crate::raw::RawColumn { name: name.clone(), values: None })
                .collect(),
            lines: raw.lines.clone(),
            notes: Vec::new(),
            first_not_finite: raw.first_not_finite.clone(),
        };
        let mut draft = Draft::new(header, plan.time, time_s);
        draft.by_mapping = true;
        draft.time_unit_is_stated = self.rules.time.unit.is_some();
        draft.sort = self.rules.time.sort;
        draft.notes = self.notes(&plan);
        draft.notes.extend(back_emf_notes);
        draft.ignored = plan.ignored.iter().map(|index| shown(&names, *index)).collect();
        if !draft.ignored.is_empty() {
            draft.notes.push(format!("columns not read: {}", draft.ignored.join(", ")));
        }
        self.fill(&mut draft, &plan, values)?;
        draft.finish()
    }

    fn fault(&self, line: u64, what: String, advice: impl Into<String>) -> RecordingError {
        let fault = Fault::Mapping { what, advice: advice.into() };
        RecordingError::new(fault, &self.source).on_line(line)
    }

    /// Unit, gain, gear, sign and offset.
    fn converted(&self, claim: &Claim, values: &[f64]) -> Vec<f64> {
        let (factor, shift, offset) = self.scale(claim);
        values.iter().map(|value| (value + shift) * factor + offset).collect()
    }

    /// What is added, what is multiplied by then, and what is added last.
    fn scale(&self, claim: &Claim) -> (f64, f64, f64) {
        let rule = &self.rules.channels[claim.rule];
        let number = |values: &Option<PerJoint>, otherwise: f64| {
            values.as_ref().and_then(|values| values.of(&claim.joint)).unwrap_or(otherwise)
        };
        let gear = number(&rule.gear_ratio, 1.0);
        let torque_constant = number(&rule.torque_constant, 1.0);
        let unit = unit_of(rule.unit, claim.quantity);
        let physics = match (claim.quantity, unit.base) {
            (Quantity::Effort, Base::Volt) => {
                gear * torque_constant / number(&rule.resistance_ohm, 1.0)
            }
            (Quantity::Effort, _) => gear * torque_constant,
            _ => 1.0 / gear,
        };
        let count = match &rule.counts_per_turn {
            Some(turn) => std::f64::consts::TAU / turn.of(&claim.joint).unwrap_or(1.0),
            None => 1.0,
        };
        let factor =
            number(&rule.sign, 1.0) * unit.factor * count * number(&rule.gain, 1.0) * physics;
        (factor, unit.shift / unit.factor, number(&rule.offset, 0.0))
    }

    /// Forms the back-EMF where asked for; otherwise notes how large it is.
    fn subtract_back_emf(
        &self,
        plan: &Plan,
        names: &[String],
        values: &mut [Vec<f64>],
    ) -> Result<Vec<String>, RecordingError> {
        let mut notes = Vec::new();
        for (index, claim) in plan.claims.iter().enumerate() {
            let rule = &self.rules.channels[claim.rule];
            let is_voltage = rule.unit.is_some_and(|unit| unit.base == Base::Volt);
            if claim.quantity != Quantity::Effort || !is_voltage {
                continue;
            }
            let number = |values: &Option<PerJoint>| {
                values.as_ref().and_then(|values| values.of(&claim.joint)).unwrap_or(1.0)
            };
            let (gear, torque_constant) = (number(&rule.gear_ratio), number(&rule.torque_constant));
            let damping = (gear * torque_constant).powi(2) / number(&rule.resistance_ohm);
            if !rule.back_emf {
                notes.push(format!(
                    "effort of {} formed from a voltage without its back-EMF, which acts as viscous \
                     friction of {damping:.4} N m s/rad",
                    claim.joint
                ));
                continue;
            }
            let of_joint =
                |other: &&Claim| other.quantity == Quantity::Velocity && other.joint == claim.joint;
            let Some(velocity) = plan.claims.iter().position(|other| of_joint(&other)) else {
                let what = format!("`back_emf` needs a velocity of `{}`", claim.joint);
                let advice = "map its velocity too, or leave back_emf out: viscous friction \
                              contains it then";
                return Err(self.fault(rule.line, what, advice).in_column(&names[claim.column]));
            };
            let velocity = values[velocity].clone();
            for (effort, velocity) in values[index].iter_mut().zip(velocity) {
                *effort -= damping * velocity;
            }
        }
        Ok(notes)
    }

    /// Which joints have efforts that are not recorded as such.
    fn notes(&self, plan: &Plan) -> Vec<String> {
        let of_current: Vec<String> = plan
            .claims
            .iter()
            .filter(|claim| {
                let unit = self.rules.channels[claim.rule].unit;
                claim.quantity == Quantity::Effort && unit.is_some_and(|u| u.base == Base::Ampere)
            })
            .map(|claim| claim.joint.clone())
            .collect();
        match of_current[..] {
            [] => Vec::new(),
            _ => vec![format!("effort formed from the current: {}", of_current.join(", "))],
        }
    }

    /// Brings coupled motors to their joints, and everything into the draft.
    fn fill(
        &self,
        draft: &mut Draft,
        plan: &Plan,
        mut values: Vec<Vec<f64>>,
    ) -> Result<(), RecordingError> {
        let mut is_done = vec![false; plan.claims.len()];
        let mut coupled: Vec<(String, Quantity, Vec<f64>)> = Vec::new();
        for coupling in &self.rules.couplings {
            for quantity in Quantity::ALL {
                let found: Vec<Option<usize>> = coupling
                    .motors
                    .iter()
                    .map(|motor| plan.claims.iter().position(|c| c.is(motor, quantity)))
                    .collect();
                let present: Vec<usize> = found.iter().flatten().copied().collect();
                if present.is_empty() {
                    continue;
                }
                let columns: Vec<&[f64]> = present.iter().map(|k| values[*k].as_slice()).collect();
                if columns.len() < coupling.motors.len() {
                    let lacking = coupling.motors.iter().zip(&found).filter(|(_, k)| k.is_none());
                    let lacking: Vec<String> = lacking.map(|(motor, _)| motor.clone()).collect();
                    let what = format!("the {quantity} of {} is missing", listed(&lacking));
                    let advice = "a coupling needs each quantity of all its motors or of none";
                    return Err(self.fault(coupling.line, what, advice));
                }
                let Some(joints) = coupling.to_joints(quantity, &columns) else { continue };
                for k in present {
                    is_done[k] = true;
                }
                for (joint, column) in coupling.joints.iter().zip(joints) {
                    if plan.claims.iter().any(|c| c.is(joint, quantity)) {
                        let what =
                            format!("{joint}/{quantity} is both a column and made of motors");
                        let advice = "map the motors' encoders as quantity = \"motor_position\"";
                        return Err(self.fault(coupling.line, what, advice));
                    }
                    coupled.push((joint.clone(), quantity, column));
                }
            }
        }
        for (k, claim) in plan.claims.iter().enumerate().filter(|(k, _)| !is_done[*k]) {
            let values = std::mem::take(&mut values[k]);
            draft.push(&claim.joint, claim.quantity, Some(claim.column), values);
        }
        for (joint, quantity, values) in coupled {
            draft.push(&joint, quantity, None, values);
        }
        Ok(())
    }
}

fn unit_of(stated: Option<Unit>, quantity: Quantity) -> Unit {
    stated.unwrap_or(units_of(quantity)[0])
}

fn shown(names: &[String], index: usize) -> String {
    match names[index].as_str() {
        "" => format!("(column {} has no name)", index + 1),
        name => name.to_owned(),
    }
}
