//! Channels of a file whose columns have standard names: `<joint>/<quantity>`, or those of
//! PlotJuggler.

use crate::error::{Fault, RecordingError};
use crate::import::Import;
use crate::quantity::Quantity;
use crate::raw::RawColumns;

/// The columns of a file by their names.
pub(crate) struct Header {
    /// Index of the column with the time stamps.
    pub(crate) time: usize,
    /// The joints in order of first appearance.
    pub(crate) joints: Vec<String>,
    /// The columns that are read.
    pub(crate) channels: Vec<Channel>,
    /// Names of all columns, trimmed.
    pub(crate) columns: Vec<String>,
    /// Names of the columns that are not read.
    pub(crate) ignored: Vec<String>,
    /// Notes.
    pub(crate) notes: Vec<String>,
}

/// One column of a joint.
pub(crate) struct Channel {
    /// Index of the column.
    pub(crate) column: usize,
    /// Index into [`Header::joints`].
    pub(crate) joint: usize,
    pub(crate) quantity: Quantity,
}

/// Usual names of quantities, lower case, without punctuation.
const SYNONYMS: [(Quantity, &[&str]); 6] = [
    (
        Quantity::Position,
        &["position", "positions", "pos", "angle", "angles", "q", "qpos", "theta"],
    ),
    (
        Quantity::Velocity,
        &["velocity", "velocities", "vel", "qvel", "speed", "qd", "dq", "qdot", "omega", "rate"],
    ),
    (
        Quantity::Acceleration,
        &["acceleration", "accelerations", "acc", "accel", "qdd", "ddq", "qddot", "alpha"],
    ),
    (
        Quantity::Effort,
        &["effort", "efforts", "torque", "torques", "trq", "tau", "force", "eff", "moment"],
    ),
    (Quantity::Current, &["current", "currents", "cur", "amps", "i"]),
    (Quantity::Voltage, &["voltage", "voltages", "volt", "volts", "u"]),
];

/// Usual names of time stamps, lower case, without punctuation.
const TIME_NAMES: [&str; 14] = [
    "t",
    "time",
    "ts",
    "times",
    "timestamp",
    "timestamps",
    "stamp",
    "ros time",
    "header stamp",
    "seconds",
    "sec",
    "secs",
    "clock",
    "elapsed",
];

/// Time columns of PlotJuggler, the preferred first.
const PLOTJUGGLER_TIME: [&str; 2] = ["__time", "time"];
/// Preferred topic if several have joints.
const JOINT_STATES: &str = "/joint_states";

impl Header {
    /// Reads the trimmed column names.
    ///
    /// # Errors
    /// No column with time stamps, no joint column, or a column that occurs twice.
    pub(crate) fn new(
        columns: Vec<String>,
        source: &str,
        line: u64,
    ) -> Result<Self, RecordingError> {
        let Some(time) = columns.iter().position(|name| name == "t") else {
            if let Some((time, topic)) = plotjuggler(&columns, source, line)? {
                return Self::of_topic(columns, time, &topic, source, line);
            }
            let similar = columns.iter().find(|name| looks_like_time(name)).cloned();
            let fault = Fault::NoTimeColumn { similar, columns };
            return Err(RecordingError::new(fault, source).on_line(line));
        };
        let (mut joints, mut channels) = (Vec::<String>::new(), Vec::new());
        let (mut ignored, mut notes, mut unexplained) = (Vec::new(), Vec::new(), Vec::new());
        for (column, name) in columns.iter().enumerate() {
            let channel = joint_channel(name);
            if name != "t" && channel.is_none() {
                let label = if name.is_empty() {
                    format!("(column {} has no name)", column + 1)
                } else {
                    name.clone()
                };
                match renamed(name) {
                    Some(better) => notes.push(format!(
                        "ignored column `{name}`; rename it to `{better}` if it is a channel"
                    )),
                    None => unexplained.push(label.clone()),
                }
                ignored.push(label);
                continue;
            }
            refuse_duplicate(&columns, column, source, line)?;
            if let Some((joint, quantity)) = channel {
                let joint = index_of(&mut joints, joint);
                channels.push(Channel { column, joint, quantity });
            }
        }
        if channels.is_empty() {
            let rename =
                columns.iter().find_map(|name| renamed(name).map(|better| (name.clone(), better)));
            let fault = Fault::NoJointColumns { rename, columns };
            return Err(RecordingError::new(fault, source).on_line(line));
        }
        if !unexplained.is_empty() {
            notes.push(format!("ignored columns: {}", unexplained.join(", ")));
        }
        Ok(Self { time, joints, channels, columns, ignored, notes })
    }

    /// The columns `<topic>/<joint>/<quantity>` of a file by PlotJuggler.
    fn of_topic(
        columns: Vec<String>,
        time: usize,
        topic: &str,
        source: &str,
        line: u64,
    ) -> Result<Self, RecordingError> {
        let (mut joints, mut channels, mut ignored) = (Vec::new(), Vec::new(), Vec::new());
        for (column, name) in columns.iter().enumerate() {
            let known = topic_channel(name).filter(|(of, _, _)| *of == topic);
            if known.is_none() && column != time {
                ignored.push(name.clone());
                continue;
            }
            refuse_duplicate(&columns, column, source, line)?;
            if let Some((_, joint, quantity)) = known {
                let joint = index_of(&mut joints, joint);
                channels.push(Channel { column, joint, quantity });
            }
        }
        let mut notes = vec![format!(
            "PlotJuggler export: time from `{}`, joints from topic {topic}",
            columns[time]
        )];
        if !ignored.is_empty() {
            notes.push(format!("ignored columns: {}", ignored.join(", ")));
        }
        Ok(Self { time, joints, channels, columns, ignored, notes })
    }

    /// Which of the columns are read.
    pub(crate) fn is_read(&self) -> Vec<bool> {
        let mut read = vec![false; self.columns.len()];
        read[self.time] = true;
        for channel in &self.channels {
            read[channel.column] = true;
        }
        read
    }

    /// Sorts the columns into time stamps and channels.
    pub(crate) fn import(self, mut raw: RawColumns) -> Import {
        let mut take = |column: usize| raw.columns[column].values.take().unwrap_or_default();
        let time_s = take(self.time);
        let channels: Vec<(usize, Quantity, Vec<f64>)> = self
            .channels
            .iter()
            .map(|channel| (channel.joint, channel.quantity, take(channel.column)))
            .collect();
        let mut import = Import::new(raw, self.time, time_s);
        import.notes = self.notes;
        import.ignored = self.ignored;
        for (channel, (joint, quantity, values)) in self.channels.iter().zip(channels) {
            import.push(&self.joints[joint], quantity, Some(channel.column), values);
        }
        import
    }
}

/// Refuses a duplicate name.
fn refuse_duplicate(
    columns: &[String],
    column: usize,
    source: &str,
    line: u64,
) -> Result<(), RecordingError> {
    let name = &columns[column];
    let Some(first) = columns[..column].iter().position(|earlier| earlier == name) else {
        return Ok(());
    };
    let fault = Fault::DuplicateColumn { name: name.clone(), first: first + 1, second: column + 1 };
    Err(RecordingError::new(fault, source).on_line(line))
}

fn index_of(joints: &mut Vec<String>, joint: &str) -> usize {
    joints.iter().position(|known| known == joint).unwrap_or_else(|| {
        joints.push(joint.to_owned());
        joints.len() - 1
    })
}

/// Column of the time stamps and topic of the joints, if the names are those of PlotJuggler.
///
/// # Errors
/// Several topics have joints and none is `/joint_states`.
fn plotjuggler(
    columns: &[String],
    source: &str,
    line: u64,
) -> Result<Option<(usize, String)>, RecordingError> {
    let stamps = |name: &&str| columns.iter().position(|column| column == name);
    let Some(time) = PLOTJUGGLER_TIME.iter().find_map(stamps) else { return Ok(None) };
    let mut topics: Vec<&str> = Vec::new();
    for (topic, _, _) in columns.iter().filter_map(|name| topic_channel(name)) {
        if !topics.contains(&topic) {
            topics.push(topic);
        }
    }
    match topics[..] {
        [] => Ok(None),
        [only] => Ok(Some((time, only.to_owned()))),
        _ if topics.contains(&JOINT_STATES) => Ok(Some((time, JOINT_STATES.to_owned()))),
        _ => {
            let topics = topics.into_iter().map(str::to_owned).collect();
            Err(RecordingError::new(Fault::SeveralTopics { topics }, source).on_line(line))
        }
    }
}

/// Topic, joint and quantity of a column `/<topic>/<joint>/<quantity>`.
fn topic_channel(column: &str) -> Option<(&str, &str, Quantity)> {
    let (path, quantity) = joint_channel(column)?;
    let (topic, joint) = path.rsplit_once('/')?;
    (topic.starts_with('/') && topic.len() > 1 && !joint.is_empty() && joint.trim() == joint)
        .then_some((topic, joint, quantity))
}

/// Joint and quantity of a column `<joint>/<quantity>`; the joint may contain slashes.
fn joint_channel(column: &str) -> Option<(&str, Quantity)> {
    let (joint, suffix) = column.rsplit_once('/')?;
    let joint_is_clean =
        !joint.is_empty() && joint.trim() == joint && !joint.contains(['\r', '\n']);
    Quantity::from_suffix(suffix).filter(|_| joint_is_clean).map(|quantity| (joint, quantity))
}

/// Joint and quantity of a column `<joint>/<quantity>` or `/<topic>/<joint>/<quantity>`.
pub(super) fn of_topic_or_joint(column: &str) -> Option<(&str, Quantity)> {
    let of_topic = topic_channel(column).map(|(_, joint, quantity)| (joint, quantity));
    of_topic.or_else(|| joint_channel(column))
}

/// The quantity that a word in lower case names, and the place of the word among the usual ones.
pub(crate) fn synonym(word: &str) -> Option<(Quantity, usize)> {
    SYNONYMS.iter().find_map(|(quantity, names)| {
        names.iter().position(|name| *name == word).map(|rank| (*quantity, rank))
    })
}

/// The standard name of a column whose last part is a usual word for a quantity:
/// `elbow/torque` -> `elbow/effort`, `elbow_pos` -> `elbow/position`.
fn renamed(column: &str) -> Option<String> {
    let (joint, word) = column.rsplit_once('/').or_else(|| column.rsplit_once(['_', '.', ' ']))?;
    let joint = joint.trim();
    if joint.is_empty() {
        return None;
    }
    let word = plain(word);
    let word = word.split(' ').next()?;
    let (quantity, _) = SYNONYMS.iter().find(|(_, names)| names.contains(&word))?;
    Some(format!("{joint}/{quantity}"))
}

/// Whether a column has a usual name of time stamps.
pub(crate) fn looks_like_time(column: &str) -> bool {
    let name = plain(column);
    TIME_NAMES.contains(&name.as_str())
        || name.split(' ').next().is_some_and(|first| TIME_NAMES.contains(&first))
}

/// Lower case, every run of other characters than letters and digits one space: `Time \[s\]` ->
/// `time s`.
fn plain(name: &str) -> String {
    let spaced: String = name
        .chars()
        .map(|c| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { ' ' })
        .collect();
    spaced.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_segment_is_the_quantity() {
        assert_eq!(
            joint_channel("left/arm/elbow/effort"),
            Some(("left/arm/elbow", Quantity::Effort))
        );
        assert_eq!(joint_channel("/effort"), None);
        assert_eq!(joint_channel("elbow/Effort"), None);
        assert_eq!(joint_channel("effort"), None);
    }

    #[test]
    fn usual_names_get_suggestions() {
        for (found, better) in [
            ("elbow/torque", "elbow/effort"),
            ("elbow/pos", "elbow/position"),
            ("elbow/angle [rad]", "elbow/position"),
            ("elbow/Position", "elbow/position"),
            ("elbow_vel", "elbow/velocity"),
            ("arm.elbow.ddq", "arm.elbow/acceleration"),
        ] {
            assert_eq!(renamed(found).as_deref(), Some(better));
        }
        for name in ["supply_temperature", "/torque", "", "position"] {
            assert_eq!(renamed(name), None, "{name}");
        }
        for name in ["time", "Time [s]", "# t", "%time", "header.stamp", "t_s", "timestamp_ns"] {
            assert!(looks_like_time(name), "{name}");
        }
        for name in ["torque", "elbow/position", ""] {
            assert!(!looks_like_time(name), "{name}");
        }
    }
}
