//! Meaning of columns by their names, as a mapping file to confirm.
//!
//! The name of a column holds a quantity (one of its usual names), a joint (the other words), and words of measured or
//! commanded values. Names with two meanings are marked as unsure, with the reason.

use std::fmt::Write as _;

use super::header::{looks_like_time, of_topic_or_joint, synonym};
use crate::import::not_seconds;
use crate::quantity::Quantity;
use crate::raw::RawColumns;
use crate::timing::Timing;
use crate::units::{TIME, Unit, find, units_of};

/// A mapping guessed from the names of columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MappingGuess {
    /// The column of the time stamps.
    pub time: Option<GuessedTime>,
    /// Channels of joints, in the order of the columns.
    pub channels: Vec<GuessedChannel>,
    /// Columns that are not used.
    pub unused: Vec<String>,
    /// What the names leave open, one line each; empty if the guess is sure.
    pub unsure: Vec<String>,
}

/// The column of the time stamps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GuessedTime {
    /// Its name in the file.
    pub column: String,
    /// Its unit: `s`, `ms`, `us` or `ns`.
    pub unit: &'static str,
}

/// The meaning of one column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GuessedChannel {
    /// Its name in the file.
    pub column: String,
    /// Name of the joint.
    pub joint: String,
    /// What is recorded.
    pub quantity: Quantity,
    /// Its unit, if it is not the SI unit.
    pub unit: Option<&'static str>,
}

/// Words of measured values; they are not part of a joint's name.
const MEASURED: [&str; 18] = [
    "actual",
    "act",
    "measured",
    "meas",
    "feedback",
    "fb",
    "observation",
    "observed",
    "obs",
    "state",
    "states",
    "real",
    "present",
    "robot",
    "sensor",
    "joint",
    "joints",
    "motor",
];
/// Words of what a controller is given.
const GIVEN: [&str; 12] = [
    "target",
    "desired",
    "des",
    "cmd",
    "command",
    "commanded",
    "commands",
    "ref",
    "reference",
    "setpoint",
    "goal",
    "action",
];
/// Other words of values that are not measured: computed, estimated, limits.
const COMPUTED: [&str; 12] = [
    "error",
    "err",
    "ext",
    "external",
    "limit",
    "max",
    "min",
    "output",
    "predicted",
    "pred",
    "filtered",
    "d",
];
/// Words of columns that are of no joint.
const NO_JOINT: [&str; 18] = [
    "tcp",
    "ee",
    "cartesian",
    "wrench",
    "imu",
    "tool",
    "quat",
    "quaternion",
    "pose",
    "accelerometer",
    "gyro",
    "camera",
    "image",
    "episode",
    "frame",
    "task",
    "mode",
    "status",
];
/// Words that only stand before the number of a joint.
const NUMBERED: [&str; 9] = ["j", "joint", "axis", "motor", "m", "link", "jnt", "dof", "servo"];
/// Positions beyond this are degrees: two turns \[rad\].
const DEGREES_FROM: f64 = 4.0 * std::f64::consts::PI;

/// A column read by its name.
struct Reading {
    column: usize,
    quantity: Quantity,
    joint: Joint,
    unit: Option<Unit>,
    is_commanded: bool,
    is_measured: bool,
    /// place among the usual names of the quantity: the usual ones first
    rank: usize,
}

#[derive(Debug, Clone, PartialEq)]
enum Joint {
    Named(String),
    Numbered(usize),
}

impl MappingGuess {
    /// The guess from the names alone, with numbered joints named by `joints`, in their order, as far as there are any.
    pub fn of(names: &[String], joints: &[String]) -> Self {
        let time = time_column(names);
        let mut readings: Vec<Reading> = (names.iter().enumerate())
            .filter(|(column, _)| Some(*column) != time)
            .filter_map(|(column, name)| Reading::of(column, name))
            .collect();
        let mut guess = Self::default();
        guess.choose_measured(&mut readings, names);
        drop_without_position(&mut readings);
        let first = readings.iter().filter_map(|r| r.joint.number()).min().unwrap_or(0);
        // numbers from 0 or from 1; a log may lack the first joint
        let first = first.min(1);
        for reading in &readings {
            let joint = guess.name_of(&reading.joint, first, joints);
            guess.channels.push(GuessedChannel {
                column: names[reading.column].clone(),
                joint,
                quantity: reading.quantity,
                unit: reading.unit.filter(|u| *u != units_of(reading.quantity)[0]).map(|u| u.name),
            });
        }
        if joints.is_empty() && readings.iter().any(|r| r.joint.number().is_some()) {
            guess.question(
                "joints are numbered: name them as in the URDF, or pass the URDF".to_owned(),
            );
        }
        guess.check_counts();
        guess.time = time.map(|column| GuessedTime {
            column: names[column].clone(),
            unit: unit_in_name(&names[column], TIME).map_or("s", |unit| unit.name),
        });
        match guess.time {
            None => guess.question("no column looks like time stamps".to_owned()),
            Some(_) if guess.channels.is_empty() => {
                guess.question("no column looks like a channel of a joint".to_owned());
            }
            Some(_) => {}
        }
        guess.unused = (names.iter().enumerate())
            .filter(|(k, _)| Some(*k) != time && readings.iter().all(|r| r.column != *k))
            .map(|(_, name)| name.clone())
            .collect();
        guess
    }

    /// Which of the columns it uses.
    pub(crate) fn reads(&self, names: &[String]) -> Vec<bool> {
        let is_used = |name: &String| {
            self.time.as_ref().is_some_and(|time| time.column == *name)
                || self.channels.iter().any(|channel| channel.column == *name)
        };
        names.iter().map(is_used).collect()
    }

    /// Units that only the values show: of stamps by their step, of positions by their size.
    #[must_use]
    pub(crate) fn with_values(mut self, raw: &RawColumns) -> Self {
        let values = |name: &str| {
            raw.columns.iter().find(|c| c.name == name).and_then(|c| c.values.as_deref())
        };
        if let Some(time) = &mut self.time
            && unit_in_name(&time.column, TIME).is_none()
            && let Some(stamps) = values(&time.column)
        {
            let step = Timing::of(stamps).median_step_s;
            let unit = match not_seconds(step) {
                Some(("nanoseconds", _)) => "ns",
                Some(("microseconds", _)) => "us",
                Some(("milliseconds" | "sample numbers or milliseconds", _)) => "ms",
                _ => "s",
            };
            time.unit = unit;
            if unit != "s" {
                let line =
                    format!("stamps of `{}` in {unit}, by their step of {step:?}", time.column);
                self.question(line);
            }
        }
        let is_far = |channel: &GuessedChannel| {
            channel.quantity == Quantity::Position
                && channel.unit.is_none()
                && values(&channel.column)
                    .is_some_and(|values| values.iter().any(|x| x.abs() > DEGREES_FROM))
        };
        if let Some(far) = self.channels.iter().find(|channel| is_far(channel)) {
            let line =
                format!("positions in degrees, as `{}` leaves two turns of radians", far.column);
            for channel in self.channels.iter_mut().filter(|channel| channel.unit.is_none()) {
                channel.unit = match channel.quantity {
                    Quantity::Position | Quantity::MotorPosition | Quantity::Command => Some("deg"),
                    Quantity::Velocity => Some("deg/s"),
                    _ => None,
                };
            }
            self.question(line);
        }
        self
    }

    /// The mapping file; unsure lines stand in it as comments.
    pub fn to_toml(&self) -> String {
        let mut text = String::from(
            "# guessed from the names of the columns; check joints, quantities and units\n",
        );
        for line in &self.unsure {
            let _ = writeln!(text, "# unsure: {line}");
        }
        if let Some(time) = &self.time {
            let unit = time.unit;
            let _ =
                write!(text, "\n[time]\ncolumn = {}\nunit = \"{unit}\"\n", quoted(&time.column));
        }
        for channel in &self.channels {
            let (column, joint) = (quoted(&channel.column), quoted(&channel.joint));
            let quantity = channel.quantity;
            let _ = write!(
                text,
                "\n[[channel]]\ncolumn = {column}\njoint = {joint}\nquantity = \"{quantity}\"\n"
            );
            if let Some(unit) = channel.unit {
                let _ = writeln!(text, "unit = \"{unit}\"");
            }
        }
        text
    }

    fn question(&mut self, line: String) {
        if !self.unsure.contains(&line) {
            self.unsure.push(line);
        }
    }

    /// Keeps one column of each channel: the measured one, else the one with the more usual name.
    fn choose_measured(&mut self, readings: &mut Vec<Reading>, names: &[String]) {
        let mut kept: Vec<Reading> = Vec::new();
        let is_channel = |r: &Reading| !r.is_commanded || r.quantity == Quantity::Command;
        for reading in readings.drain(..).filter(is_channel) {
            let same = |other: &Reading| {
                (&other.joint, other.quantity) == (&reading.joint, reading.quantity)
            };
            let Some(place) = kept.iter().position(same) else {
                kept.push(reading);
                continue;
            };
            let merit = |r: &Reading| (r.is_measured, std::cmp::Reverse(r.rank));
            let other = &kept[place];
            if reading.is_measured == other.is_measured {
                let (a, b) = (&names[other.column], &names[reading.column]);
                self.question(format!(
                    "`{a}` and `{b}` are both {} of one joint",
                    reading.quantity
                ));
            }
            if merit(&reading) > merit(other) {
                kept[place] = reading;
            }
        }
        kept.sort_by_key(|reading| reading.column);
        *readings = kept;
    }

    fn name_of(&mut self, joint: &Joint, first: usize, joints: &[String]) -> String {
        match joint {
            Joint::Numbered(number) => match joints.get(number - first) {
                Some(name) => name.clone(),
                None => {
                    if !joints.is_empty() {
                        self.question(format!(
                            "there is no joint {number} among {}",
                            joints.join(", ")
                        ));
                    }
                    format!("joint_{}", number - first + 1)
                }
            },
            Joint::Named(name) => {
                if joints.is_empty() || joints.contains(name) {
                    return name.clone();
                }
                let inside: Vec<&String> =
                    (joints.iter()).filter(|joint| plain(joint).contains(&plain(name))).collect();
                match inside[..] {
                    [only] => only.clone(),
                    _ => {
                        self.question(format!("no joint is named `{name}`"));
                        name.clone()
                    }
                }
            }
        }
    }

    /// Quantities that some joints lack.
    fn check_counts(&mut self) {
        let count = |quantity| self.channels.iter().filter(|c| c.quantity == quantity).count();
        let positions = count(Quantity::Position);
        let drives: usize = [Quantity::Effort, Quantity::Current, Quantity::Voltage]
            .map(count)
            .into_iter()
            .max()
            .unwrap_or(0);
        if !self.channels.is_empty() && positions == 0 {
            self.question("no column looks like a position".to_owned());
        } else if drives > 0 && drives != positions {
            self.question(format!("{positions} positions, but {drives} efforts or currents"));
        }
    }
}

impl Joint {
    fn number(&self) -> Option<usize> {
        match self {
            Self::Numbered(number) => Some(*number),
            Self::Named(_) => None,
        }
    }
}

impl Reading {
    fn of(column: usize, name: &str) -> Option<Self> {
        if let Some((joint, quantity)) = of_topic_or_joint(name) {
            let (joint, is_measured) = (Joint::Named(joint.to_owned()), true);
            return Some(Self {
                column,
                quantity,
                joint,
                unit: None,
                is_commanded: false,
                is_measured,
                rank: 0,
            });
        }
        let bare = without_unit(name);
        let words = words(bare);
        let texts: Vec<String> =
            words.iter().map(|(from, to)| bare[*from..*to].to_lowercase()).collect();
        let has = |list: &[&str]| texts.iter().any(|word| list.contains(&word.as_str()));
        if has(&NO_JOINT) {
            return None;
        }
        let (place, quantity, rank) = quantity_in(&texts)?;
        let unit = unit_in_name(name, units_of(quantity));
        let is_unit = |k: usize| {
            k > place && unit.is_some() && unit_in_words(&texts[k..], units_of(quantity)).is_some()
        };
        let end = (0..texts.len()).find(|k| is_unit(*k)).unwrap_or(texts.len());
        let rest: Vec<usize> = (0..end).filter(|k| *k != place).collect();
        let is_commanded = rest.iter().any(|k| is_not_measured(&texts[*k]));
        let is_measured = rest.iter().any(|k| MEASURED.contains(&texts[*k].as_str()));
        let own: Vec<usize> = (rest.iter().copied())
            .filter(|k| {
                let word = texts[*k].as_str();
                // the quantity may stand twice: `observation.effort.elbow.effort`
                let is_again = word.len() > 1 && synonym(word).is_some_and(|s| s.0 == quantity);
                !is_again && !MEASURED.contains(&word) && !is_not_measured(word)
            })
            .collect();
        let numbers: Vec<usize> = own.iter().filter_map(|k| texts[*k].parse().ok()).collect();
        let is_numbered = own
            .iter()
            .all(|k| texts[*k].parse::<usize>().is_ok() || NUMBERED.contains(&texts[*k].as_str()));
        let joint = match numbers[..] {
            [number] if is_numbered => Joint::Numbered(number),
            // a quantity of a whole arm is no channel, and letters need a number
            _ if own.is_empty() || texts[place].len() == 1 => return None,
            _ => Joint::Named(joint_name(bare, &words, &own, place)),
        };
        // a position that a controller is given, and nothing that is computed from it
        let commanded = || rest.iter().filter(|k| is_not_measured(&texts[**k]));
        let is_given = is_commanded && commanded().all(|k| GIVEN.contains(&texts[*k].as_str()));
        let quantity = match quantity {
            Quantity::Position if is_given => Quantity::Command,
            other => other,
        };
        Some(Self { column, quantity, joint, unit, is_commanded, is_measured, rank })
    }
}

/// Name of a joint: the text around the quantity, without the words that are not its own.
fn joint_name(name: &str, words: &[(usize, usize)], own: &[usize], quantity: usize) -> String {
    // `joint` and `motor` are words of names too: `elbow_joint.pos`
    let last_own = own.last().copied().unwrap_or(0);
    let mut last = last_own;
    while last + 1 < words.len() && last + 1 != quantity {
        let (from, to) = words[last + 1];
        if !["joint", "motor"].contains(&name[from..to].to_lowercase().as_str()) {
            break;
        }
        last += 1;
    }
    let first = own.first().copied().unwrap_or(0);
    if (first..=last).contains(&quantity) {
        let part = |k: &usize| &name[words[*k].0..words[*k].1];
        return own.iter().map(part).collect::<Vec<_>>().join("_");
    }
    name[words[first].0..words[last].1].to_owned()
}

/// The word that names a quantity, the last one if there are several: `motor_position_current` is a current.
fn quantity_in(words: &[String]) -> Option<(usize, Quantity, usize)> {
    let found = words.iter().enumerate().rev();
    let quantity = |word: &str| match word {
        "temperature" | "temperatures" | "temp" => Some((Quantity::Temperature, 0)),
        _ => synonym(word),
    };
    let mut found = found.filter_map(|(k, word)| quantity(word).map(|(q, rank)| (k, q, rank)));
    let last = found.clone().find(|(k, _, _)| words[*k].len() > 1);
    // a single letter counts where no word does
    last.or_else(|| found.next()).or_else(|| {
        // `observation.state` of robots that list their joints there
        let state = words.iter().position(|word| word == "state")?;
        words[..state].iter().any(|word| word == "observation").then_some((
            state,
            Quantity::Position,
            0,
        ))
    })
}

/// Drops joints without a position where others have one: `speed_scaling` is no joint.
fn drop_without_position(readings: &mut Vec<Reading>) {
    let of_positions: Vec<Joint> = (readings.iter())
        .filter(|reading| reading.quantity == Quantity::Position)
        .map(|reading| reading.joint.clone())
        .collect();
    // what a controller is given is no motion
    readings.retain(|reading| match reading.quantity {
        Quantity::Command => of_positions.contains(&reading.joint),
        _ => of_positions.is_empty() || of_positions.contains(&reading.joint),
    });
}

fn time_column(names: &[String]) -> Option<usize> {
    let exact = ["t", "__time", "time", "timestamp"];
    let find = |wanted: &&str| names.iter().position(|name| name == wanted);
    exact.iter().find_map(find).or_else(|| names.iter().position(|name| looks_like_time(name)))
}

/// Words of a name as byte ranges: runs of letters or of digits, also `camelCase`.
fn words(name: &str) -> Vec<(usize, usize)> {
    let mut words: Vec<(usize, usize)> = Vec::new();
    let mut before = ' ';
    for (at, c) in name.char_indices() {
        let continues = (c.is_alphabetic()
            && before.is_alphabetic()
            && !(before.is_lowercase() && c.is_uppercase()))
            || (c.is_numeric() && before.is_numeric());
        let end = at + c.len_utf8();
        match words.last_mut() {
            Some(word) if continues => word.1 = end,
            _ if c.is_alphanumeric() => words.push((at, end)),
            _ => {}
        }
        before = c;
    }
    words
}

/// A name without a unit in brackets at its end.
fn without_unit(name: &str) -> &str {
    let end = name.trim_end();
    let opens = [("[", ']'), ("(", ')')]
        .into_iter()
        .find_map(|(open, close)| end.ends_with(close).then(|| end.rfind(open)).flatten());
    // an index is no unit: `position[0]`
    let is_index = |at: usize| end[at + 1..end.len() - 1].trim().parse::<usize>().is_ok();
    match opens {
        Some(at) if at > 0 && !is_index(at) => end[..at].trim_end(),
        _ => end,
    }
}

/// The unit that a name ends with: in brackets, or as its last words.
fn unit_in_name(name: &str, units: &'static [Unit]) -> Option<Unit> {
    let bare = without_unit(name);
    if bare.len() < name.trim_end().len() {
        let inside = name.trim_end()[bare.len()..].trim();
        return find(units, inside[1..inside.len() - 1].trim());
    }
    let texts: Vec<String> =
        words(bare).into_iter().map(|(from, to)| bare[from..to].to_lowercase()).collect();
    (1..texts.len()).find_map(|k| unit_in_words(&texts[k..], units))
}

/// A unit of one or two words: `deg`, `rad s`.
fn unit_in_words(words: &[String], units: &'static [Unit]) -> Option<Unit> {
    let text = match words {
        // single letters are numbers of something
        [unit] if unit.len() > 1 => unit.clone(),
        [unit, per] => format!("{unit}/{per}"),
        _ => return None,
    };
    let known = |unit: &&Unit| unit.name.to_lowercase().replace(' ', "") == text;
    units.iter().find(known).copied().or_else(|| find(units, &text))
}

/// Lower case, letters and digits only.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// A TOML string.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// Whether a word is of a value that was commanded, computed or estimated.
fn is_not_measured(word: &str) -> bool {
    GIVEN.contains(&word) || COMPUTED.contains(&word)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guess(names: &[&str], joints: &[&str]) -> MappingGuess {
        let owned = |list: &[&str]| list.iter().map(ToString::to_string).collect::<Vec<_>>();
        MappingGuess::of(&owned(names), &owned(joints))
    }

    fn channels(guess: &MappingGuess) -> Vec<String> {
        let unit =
            |c: &GuessedChannel| c.unit.map_or_else(String::new, |unit| format!(" [{unit}]"));
        let one =
            |c: &GuessedChannel| format!("{}: {}/{}{}", c.column, c.joint, c.quantity, unit(c));
        guess.channels.iter().map(one).collect()
    }

    #[test]
    fn usual_names_are_channels() {
        for (name, channel) in [
            ("actual_q_0", "joint_1/position"),
            ("q1", "joint_1/position"),
            ("q_1", "joint_1/position"),
            ("dq[0]", "joint_1/velocity"),
            ("tau_J1", "joint_1/effort"),
            ("actual_current_0", "joint_1/current"),
            ("joint1.pos", "joint_1/position"),
            ("qpos_0", "joint_1/position"),
            ("shoulder_pan.pos", "shoulder_pan/position"),
            ("elbow_joint.vel", "elbow_joint/velocity"),
            ("elbow_joint/torque", "elbow_joint/effort"),
            ("position.elbow", "elbow/position"),
            ("elbow torque [Nm]", "elbow/effort"),
            ("observation.state.elbow_flex.pos", "elbow_flex/position"),
            ("observation.effort.elbow_flex.effort", "elbow_flex/effort"),
            ("observation.state.elbow_flex", "elbow_flex/position"),
            ("jointVelocity3", "joint_3/velocity"),
            ("q1_deg", "joint_1/position [deg]"),
            ("q1 [deg]", "joint_1/position [deg]"),
            ("dq1 (deg/s)", "joint_1/velocity [deg/s]"),
            ("motor_temperature_1", "joint_1/temperature"),
            ("fr3_joint1/position", "fr3_joint1/position"),
            ("/joint_states/elbow/effort", "elbow/effort"),
        ] {
            assert_eq!(channels(&guess(&["t", name], &[])), [format!("{name}: {channel}")]);
        }
    }

    #[test]
    fn other_columns_are_no_channels() {
        for name in [
            "actual_TCP_force_0",
            "target_q_0",
            "robot_mode",
            "q",
            "remark",
            "i",
            "action.elbow.pos",
            "tau_ext_1",
            "imu_acc_1",
            "speed_scaling_d",
        ] {
            assert_eq!(channels(&guess(&["t", name], &[])), [""; 0], "{name}");
        }
    }

    #[test]
    fn measured_columns_win() {
        let found = guess(&["timestamp", "target_q_0", "q_0", "actual_q_0"], &["pan"]);
        assert_eq!(channels(&found), ["target_q_0: pan/command", "actual_q_0: pan/position"]);
        assert_eq!(found.unsure, [""; 0]);
        let found = guess(&["t", "q_1", "theta_1"], &["pan"]);
        assert_eq!(channels(&found), ["q_1: pan/position"]);
        assert_eq!(found.unsure, ["`q_1` and `theta_1` are both position of one joint"]);
    }

    #[test]
    fn joints_of_the_arm_give_names() {
        let arm = ["shoulder_pan_joint", "elbow_joint"];
        let found = guess(&["time_ms", "q_0", "q_1", "tau_0", "tau_1"], &arm);
        assert_eq!(
            channels(&found),
            [
                "q_0: shoulder_pan_joint/position",
                "q_1: elbow_joint/position",
                "tau_0: shoulder_pan_joint/effort",
                "tau_1: elbow_joint/effort"
            ]
        );
        assert_eq!(found.time.unwrap().unit, "ms");
        assert_eq!(found.unsure, [""; 0]);
        let found = guess(&["t", "shoulder_pan.pos", "wrist.pos"], &arm);
        assert_eq!(channels(&found)[0], "shoulder_pan.pos: shoulder_pan_joint/position");
        assert_eq!(found.unsure, ["no joint is named `wrist`"]);
    }

    #[test]
    fn open_questions_are_listed() {
        let found = guess(&["q_1", "q_2", "tau_1"], &[]);
        assert_eq!(
            found.unsure,
            [
                "joints are numbered: name them as in the URDF, or pass the URDF",
                "2 positions, but 1 efforts or currents",
                "no column looks like time stamps",
            ]
        );
        assert_eq!(guess(&["t", "x"], &[]).unsure, ["no column looks like a channel of a joint"]);
    }

    #[test]
    fn values_show_units() {
        let stamps = (0..20).map(|k| 1e6 + 8000.0 * f64::from(k)).collect();
        let angles = (0..20).map(|k| 90.0 + f64::from(k)).collect();
        let raw = RawColumns::new("log").with("timestamp", stamps).with("elbow.pos", angles);
        let found = MappingGuess::of(&raw.names(), &[]).with_values(&raw);
        assert_eq!(channels(&found), ["elbow.pos: elbow/position [deg]"]);
        assert_eq!(found.time.as_ref().unwrap().unit, "us");
        assert_eq!(found.unsure.len(), 2);
        assert!(found.to_toml().contains("# unsure: positions in degrees"), "{}", found.to_toml());
    }

    #[test]
    fn written_mappings_are_read_again() {
        let found = guess(&["t \"x\"", "a\\b/position", "b_pos [deg]"], &[]);
        let mapping = crate::Mapping::parse(&found.to_toml(), "guess.toml").unwrap();
        let reads =
            mapping.reads(&["t \"x\"", "a\\b/position", "b_pos [deg]"].map(str::to_owned), "x");
        assert_eq!(reads.unwrap(), [true; 3]);
    }
}
