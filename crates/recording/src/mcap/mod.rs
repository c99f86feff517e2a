//! MCAP, the recordings of ROS 2: joint states of one topic in, and out.
//!
//! Only `sensor_msgs/JointState` is read (ROS 2, and ROS 1 as `mcap convert` leaves it); other topics
//! are listed in a note.

mod joint_state;

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use ::mcap::records::Record;
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, WriteOptions, parse_record};

use crate::error::{Fault, RecordingError};
use crate::raw::{RawColumn, RawColumns};
use crate::recording::{Quantity, Recording};
use joint_state::{BadMessage, JointState};

/// Topic that is taken where several have joint states, and that is written.
const JOINT_STATES: &str = "/joint_states";
/// Names of the message in ROS 2 and ROS 1.
const SCHEMA_NAMES: [&str; 2] = ["sensor_msgs/msg/JointState", "sensor_msgs/JointState"];
/// Longest record that is believed \[bytes\].
const LONGEST_RECORD: usize = 1 << 30;
/// Stamps after this are those of a clock \[ns\]: they are counted from the whole second of the first.
const CLOCK_NS: i64 = 100_000_000_000_000_000;
/// Quantities that a joint state holds.
const HELD: [Quantity; 3] = [Quantity::Position, Quantity::Velocity, Quantity::Effort];

/// Definition of the message, as ROS 2 writes it.
const SCHEMA: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// How columns are named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Names {
    /// `t`, `<joint>/<quantity>`
    Plain,
    /// `__time`, `<topic>/<joint>/<quantity>`
    WithTopic,
}

/// Joint states of one topic as columns, time in seconds.
pub(crate) fn read_columns(
    reader: impl Read,
    source: &str,
    topic: Option<&str>,
    names: Names,
) -> Result<RawColumns, RecordingError> {
    let mut file = Contents { wanted: topic.map(str::to_owned), ..Contents::default() };
    let ended_early = file.read(reader, source)?;
    let fault = |fault| RecordingError::new(fault, source);
    let (topics, others) = file.topics();
    let chosen = match topic {
        Some(topic) if topics.iter().any(|t| t == topic) => topic.to_owned(),
        Some(topic) => {
            return Err(fault(Fault::UnknownTopic { topic: topic.to_owned(), found: topics }));
        }
        None => match &topics[..] {
            [] => return Err(fault(Fault::NoJointStates { topics: others })),
            [only] => only.clone(),
            several if several.iter().any(|t| t == JOINT_STATES) => JOINT_STATES.to_owned(),
            _ => return Err(fault(Fault::SeveralJointStates { topics })),
        },
    };
    let mut raw = file.columns(&chosen, source, names)?;
    raw.notes.insert(0, format!("joint states of the topic {chosen}"));
    let others: Vec<String> = topics.into_iter().filter(|t| *t != chosen).chain(others).collect();
    if !others.is_empty() {
        raw.notes.push(format!("topics not read: {}", others.join(", ")));
    }
    if let Some(why) = ended_early {
        raw.notes.push(format!("the file is not complete ({why}); read up to there"));
    }
    Ok(raw)
}

/// What a file holds, of joint states alone.
#[derive(Default)]
struct Contents {
    /// the only topic to read
    wanted: Option<String>,
    /// schema id to name
    schemas: BTreeMap<u16, String>,
    /// channel id to topic, schema and encoding
    channels: BTreeMap<u16, (String, u16, String)>,
    topics: BTreeMap<String, Topic>,
}

/// The messages of a topic with joint states.
#[derive(Default)]
struct Topic {
    /// names of the joints as messages list them: few lists, many messages
    names: Vec<Vec<String>>,
    /// index of the names, and the message without them
    states: Vec<(usize, JointState)>,
    /// messages whose header has no stamp: that of the recorder stands in its place
    without_stamp: usize,
}

impl Contents {
    /// Reads all; says why when the file ends before its end.
    fn read(
        &mut self,
        mut reader: impl Read,
        source: &str,
    ) -> Result<Option<String>, RecordingError> {
        let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
        let mut records = LinearReader::new_with_options(options);
        let io_fault = |error| RecordingError::new(Fault::Io { doing: "read", error }, source);
        while let Some(event) = records.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(wanted)) => {
                    let read = reader.read(records.insert(wanted)).map_err(io_fault)?;
                    records.notify_read(read);
                }
                Ok(LinearReadEvent::Record { data, opcode }) => match parse_record(opcode, data) {
                    Ok(record) => self.take(record, source)?,
                    Err(error) => return self.ended(&error, source),
                },
                Err(error) => return self.ended(&error, source),
            }
        }
        Ok(None)
    }

    /// A recorder that was killed leaves a file without its end: what is before counts.
    fn ended(&self, error: &McapError, source: &str) -> Result<Option<String>, RecordingError> {
        if self.topics.is_empty() {
            let what = error.to_string();
            return Err(RecordingError::new(Fault::Broken { format: "MCAP", what }, source));
        }
        Ok(Some(error.to_string()))
    }

    fn take(&mut self, record: Record<'_>, source: &str) -> Result<(), RecordingError> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let entry = (channel.topic, channel.schema_id, channel.message_encoding);
                self.channels.insert(channel.id, entry);
            }
            Record::Message { header, data } => {
                let Some((topic, schema, encoding)) = self.channels.get(&header.channel_id) else {
                    return Ok(());
                };
                let unwanted = self.wanted.as_ref().is_some_and(|wanted| wanted != topic);
                if unwanted || !is_joint_state(self.schemas.get(schema)) {
                    return Ok(());
                }
                let read = match encoding.as_str() {
                    "cdr" => JointState::from_cdr(&data),
                    "ros1" => JointState::from_ros1(&data),
                    other => Err(BadMessage {
                        offset: 0,
                        what: format!("its encoding `{other}` is neither cdr nor ros1"),
                    }),
                };
                let of_topic = self.topics.entry(topic.clone()).or_default();
                let mut state = read.map_err(|BadMessage { offset, what }| {
                    let number = of_topic.states.len() + 1;
                    let fault = Fault::BadMessage { topic: topic.clone(), number, offset, what };
                    RecordingError::new(fault, source)
                })?;
                if state.stamp_ns == 0 {
                    of_topic.without_stamp += 1;
                    state.stamp_ns = i64::try_from(header.log_time).unwrap_or(i64::MAX);
                }
                let names = std::mem::take(&mut state.name);
                let known = of_topic.names.iter().position(|n| *n == names);
                let known = known.unwrap_or_else(|| {
                    of_topic.names.push(names);
                    of_topic.names.len() - 1
                });
                of_topic.states.push((known, state));
            }
            _ => {}
        }
        Ok(())
    }

    /// Topics with joint states, and the others with their messages' names.
    fn topics(&self) -> (Vec<String>, Vec<String>) {
        let (mut joints, mut others) = (Vec::new(), Vec::new());
        for (topic, schema, _) in self.channels.values() {
            let name = self.schemas.get(schema);
            if is_joint_state(name) {
                joints.push(topic.clone());
            } else {
                others.push(format!("{topic} ({})", name.map_or("no schema", String::as_str)));
            }
        }
        for list in [&mut joints, &mut others] {
            list.sort();
            list.dedup();
        }
        (joints, others)
    }

    fn columns(
        &mut self,
        topic: &str,
        source: &str,
        names: Names,
    ) -> Result<RawColumns, RecordingError> {
        let read = self.topics.remove(topic).unwrap_or_default();
        let Some((joints, skipped)) = read.joints() else {
            return Err(RecordingError::new(Fault::HeaderOnly, source));
        };
        let mut raw = RawColumns::new(source);
        if !skipped.is_empty() {
            raw.notes.push(format!("messages with other joints are not read: {skipped}"));
        }
        if read.without_stamp > 0 {
            raw.notes.push(format!(
                "{} messages have no stamp in their header: the time of the recorder is used",
                read.without_stamp
            ));
        }
        // place of every joint in each list of names; none for lists of other joints
        let places: Vec<Option<Vec<usize>>> = (read.names.iter())
            .map(|list| {
                let place = |joint: &String| list.iter().position(|n| n == joint);
                let all: Option<Vec<usize>> = joints.iter().map(place).collect();
                all.filter(|places| places.len() == list.len())
            })
            .collect();
        let taken: Vec<(&JointState, &[usize])> = (read.states.iter())
            .filter_map(|(names, state)| Some((state, places[*names].as_deref()?)))
            .collect();
        let first = taken.first().map_or(0, |(state, _)| state.stamp_ns);
        let zero = if first > CLOCK_NS { first - first % 1_000_000_000 } else { 0 };
        if zero != 0 {
            raw.notes.push(format!("time is counted from {} s of the clock", zero / 1_000_000_000));
        }
        let stamps = taken.iter().map(|(s, _)| (s.stamp_ns - zero) as f64 / 1e9).collect();
        let time = if names == Names::Plain { "t" } else { "__time" };
        raw.columns.push(RawColumn { name: time.to_owned(), values: Some(stamps) });
        for (joint, name) in joints.iter().enumerate() {
            for quantity in HELD {
                let value = |(state, places): &(&JointState, &[usize])| {
                    list(state, quantity).get(places[joint]).copied().unwrap_or(f64::NAN)
                };
                let values: Vec<f64> = taken.iter().map(value).collect();
                if values.iter().all(|v| v.is_nan()) {
                    continue;
                }
                let column = match names {
                    Names::Plain => format!("{name}/{quantity}"),
                    Names::WithTopic => format!("{topic}/{name}/{quantity}"),
                };
                raw = raw.with(column, values);
            }
        }
        Ok(raw)
    }
}

impl Topic {
    /// The joints of most messages, in the order of the first, and what the other messages hold:
    /// grippers and arms may publish under one topic.
    fn joints(&self) -> Option<(Vec<String>, String)> {
        let sorted = |list: &[String]| {
            let mut list = list.to_vec();
            list.sort();
            list
        };
        let sets: Vec<Vec<String>> = self.names.iter().map(|list| sorted(list)).collect();
        let mut counts: BTreeMap<&[String], usize> = BTreeMap::new();
        for (names, _) in &self.states {
            *counts.entry(&sets[*names]).or_default() += 1;
        }
        let most = *counts.values().max()?;
        let wanted = sets.iter().find(|set| counts.get(set.as_slice()) == Some(&most))?;
        let first = self.names.iter().zip(&sets).find(|(_, set)| *set == wanted)?.0;
        let skipped: Vec<String> = (counts.iter())
            .filter(|(set, _)| **set != wanted.as_slice())
            .map(|(set, count)| format!("{count} with {}", set.join(", ")))
            .collect();
        Some((first.clone(), skipped.join("; ")))
    }
}

fn is_joint_state(schema: Option<&String>) -> bool {
    schema.is_some_and(|name| SCHEMA_NAMES.contains(&name.as_str()))
}

fn list(state: &JointState, quantity: Quantity) -> &[f64] {
    match quantity {
        Quantity::Position => &state.position,
        Quantity::Velocity => &state.velocity,
        Quantity::Effort => &state.effort,
        _ => &[],
    }
}

/// The recording as MCAP: a message `sensor_msgs/msg/JointState` per sample under `/joint_states`,
/// stamped to the nanosecond. Returns the names of the channels that a joint state has no place for.
///
/// Stamps before 0, which ROS does not have, are moved by whole seconds.
///
/// # Errors
/// The recording is inconsistent, or too long for the stamps of ROS.
pub fn write_mcap_to(
    bytes: &mut Vec<u8>,
    recording: &Recording,
) -> Result<Vec<String>, RecordingError> {
    recording.check()?;
    let source = recording.source.as_str();
    let fault = |error: McapError| {
        let error = std::io::Error::other(error.to_string());
        RecordingError::new(Fault::Io { doing: "written", error }, source)
    };
    let shift = recording.time_s.first().map_or(0.0, |t| t.min(0.0).floor());
    let options = WriteOptions::new().profile("ros2").library("armident");
    let mut out = options.create(Cursor::new(Vec::new())).map_err(fault)?;
    let schema = out.add_schema(SCHEMA_NAMES[0], "ros2msg", SCHEMA.as_bytes()).map_err(fault)?;
    let channel = out.add_channel(schema, JOINT_STATES, "cdr", &BTreeMap::new()).map_err(fault)?;
    let names: Vec<String> = recording.joints.iter().map(|j| j.name.clone()).collect();
    let columns = |quantity| -> Vec<Option<&[f64]>> {
        recording.joints.iter().map(|joint| joint.channel(quantity)).collect()
    };
    let [position, velocity, effort] = HELD.map(columns);
    let row = |columns: &[Option<&[f64]>], row: usize| -> Vec<f64> {
        if columns.iter().all(Option::is_none) {
            return Vec::new();
        }
        columns.iter().map(|c| c.map_or(f64::NAN, |values| values[row])).collect()
    };
    for (k, t) in recording.time_s.iter().enumerate() {
        let stamp_ns = ((t - shift) * 1e9).round() as i64;
        let state = JointState {
            stamp_ns,
            name: names.clone(),
            position: row(&position, k),
            velocity: row(&velocity, k),
            effort: row(&effort, k),
        };
        let time = stamp_ns.max(0).unsigned_abs();
        let header = ::mcap::records::MessageHeader {
            channel_id: channel,
            sequence: k as u32,
            log_time: time,
            publish_time: time,
        };
        out.write_to_known_channel(&header, &state.to_cdr()).map_err(fault)?;
    }
    out.finish().map_err(fault)?;
    *bytes = out.into_inner().into_inner();
    let lost = recording.joints.iter().flat_map(|joint| {
        let other = joint.channels().filter(|(quantity, _)| !HELD.contains(quantity));
        other.map(|(quantity, _)| format!("{}/{quantity}", joint.name))
    });
    Ok(lost.collect())
}
