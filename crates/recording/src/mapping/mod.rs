//! Mapping files: the meaning of the columns of other loggers' files.

mod coupling;
mod guess;
mod header;
mod plan;
mod reader;
mod rules;

use std::fs;
use std::path::Path;

use crate::error::{Fault, RecordingError, listed};
use crate::import::Import;
use crate::quantity::Quantity;
use crate::raw::{RawColumn, RawColumns};
use crate::recording::Recording;
use crate::units::{Base, Unit, units_of};

pub use guess::{GuessedChannel, GuessedTime, MappingGuess};
pub(crate) use header::{Header, looks_like_time, synonym};
use plan::{Claim, Plan};
use reader::Reader;
use rules::{PerJoint, Rules};

/// Meaning of the columns of a file, from a TOML file.
///
/// # Format
///
/// ```toml
/// [time]                      # optional: `t`, `__time` or `time`, in s
/// column = "stamp_ms"
/// unit = "ms"                 # s, ms, us, ns
/// sort = true                 # sort rows by time; otherwise decreasing stamps are an error
///
/// [[channel]]
/// column = "q1_deg"           # name in the file
/// joint = "joint_1"           # name in the URDF
/// quantity = "position"       # a Quantity; optional if the column ends with it: a/position
/// unit = "deg"                # optional: SI
/// sign = -1                   # 1 or -1
/// offset = 1.5707963          # in SI, after unit and sign
///
/// [[coupling]]                # motors that move several joints
/// joints = ["joint_5", "joint_6"]
/// motors = ["m5", "m6"]       # `joint` names of channels above
/// matrix = [[45, 0], [32, 32]]
/// offset = [0, 0]             # optional
/// ```
///
/// | quantity | units | other keys |
/// |---|---|---|
/// | position, motor_position, command | `rad` `deg` `turn` `m` `mm` `counts` | `gear_ratio` divides; `counts_per_turn`, or `gain` per count |
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
/// motor turns per joint turn. Other columns are ignored, with a note.
///
/// **Whole arms.** `{joint}` in a column matches any joint name, `{quantity}` any quantity, and
/// `joint = "arm_{joint}"` builds the joint name from the matched part. Numbers may be given per
/// joint: `gain = { shoulder = 13.6, elbow = -8.7 }`; the channel is then restricted to these joints
/// (`sign` and `offset` default to 1 and 0). Channels that name a column take precedence over
/// channels with placeholders, which apply in file order; each column matches once.
///
/// **Voltage.** A drive voltage u gives `effort = sign · gear · kt / R · u - (gear · kt)² / R · velocity`.
/// The second term, the back-EMF, is equivalent to viscous friction. By default it is part of the
/// identified viscous friction, since recorded velocities are noisy or delayed; that coefficient then
/// contains (gear · kt)² / R, which a note reports. With `back_emf = true` the term is computed from
/// the recorded velocity. Both hold only while the bridge drives the motor: with the bridge off there
/// is no back-EMF.
///
/// **Coupling.** `q_motor = R q_joint + const` with one row of R per motor, so velocities and
/// accelerations likewise, and by the principle of virtual work `tau_joint = Rᵀ tau_motor`.
/// Quantities that are recorded for all motors of a coupling become those of its joints.
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
/// A servo with a drive voltage only:
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
    /// Invalid TOML; unknown keys, quantities or units; invalid or contradictory numbers.
    pub fn parse(text: &str, source: &str) -> Result<Self, RecordingError> {
        Ok(Self { source: source.to_owned(), rules: Reader::rules(text, source)? })
    }

    /// Origin: a path, or a description.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Which of the named columns of a file are needed.
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
    /// Missing columns, two columns for one channel, incomplete coupled motors, or signals with
    /// defects that are not repaired on reading.
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
                .map(|name| RawColumn { name: name.clone(), values: None })
                .collect(),
            lines: raw.lines.clone(),
            notes: Vec::new(),
            not_finite: raw.not_finite.clone(),
        };
        let mut import = Import::new(header, plan.time, time_s);
        import.by_mapping = true;
        import.time_unit_is_stated = self.rules.time.unit.is_some();
        import.sort = self.rules.time.sort;
        import.notes = self.notes(&plan);
        import.notes.extend(back_emf_notes);
        import.ignored = plan.ignored.iter().map(|index| shown(&names, *index)).collect();
        if !import.ignored.is_empty() {
            import.notes.push(format!("ignored columns: {}", import.ignored.join(", ")));
        }
        self.fill(&mut import, &plan, values)?;
        import.finish()
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

    /// Shift, factor and offset: `(value + shift) * factor + offset`.
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

    /// Subtracts the back-EMF if requested; otherwise notes its size.
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
                    "effort of {} computed from voltage; back-EMF appears as viscous friction of \
                     {damping:.4} N m s/rad",
                    claim.joint
                ));
                continue;
            }
            let of_joint =
                |other: &&Claim| other.quantity == Quantity::Velocity && other.joint == claim.joint;
            let Some(velocity) = plan.claims.iter().position(|other| of_joint(&other)) else {
                let what = format!("`back_emf` needs a velocity of `{}`", claim.joint);
                let advice = "map its velocity too, or remove back_emf: viscous friction then \
                              includes it";
                return Err(self.fault(rule.line, what, advice).in_column(&names[claim.column]));
            };
            let velocity = values[velocity].clone();
            for (effort, velocity) in values[index].iter_mut().zip(velocity) {
                *effort -= damping * velocity;
            }
        }
        Ok(notes)
    }

    /// A note on joints whose effort is computed from a current.
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
            _ => vec![format!("effort computed from current: {}", of_current.join(", "))],
        }
    }

    /// Converts coupled motors to their joints and adds all channels to the import.
    fn fill(
        &self,
        import: &mut Import,
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
                    let what = format!("missing {quantity} of {}", listed(&lacking));
                    let advice = "map each quantity for all motors of a coupling, or for none";
                    return Err(self.fault(coupling.line, what, advice));
                }
                let Some(joints) = coupling.to_joints(quantity, &columns) else { continue };
                for k in present {
                    is_done[k] = true;
                }
                for (joint, column) in coupling.joints.iter().zip(joints) {
                    if plan.claims.iter().any(|c| c.is(joint, quantity)) {
                        let what =
                            format!("{joint}/{quantity} is both a column and computed from motors");
                        let advice = "map the motors' encoders as quantity = \"motor_position\"";
                        return Err(self.fault(coupling.line, what, advice));
                    }
                    coupled.push((joint.clone(), quantity, column));
                }
            }
        }
        for (k, claim) in plan.claims.iter().enumerate().filter(|(k, _)| !is_done[*k]) {
            let values = std::mem::take(&mut values[k]);
            import.push(&claim.joint, claim.quantity, Some(claim.column), values);
        }
        for (joint, quantity, values) in coupled {
            import.push(&joint, quantity, None, values);
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
