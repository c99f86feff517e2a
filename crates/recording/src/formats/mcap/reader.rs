//! Reads the joint states of one topic from MCAP.

use std::collections::BTreeMap;
use std::io::{BufReader, Read};

use ::mcap::records::Record;
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, parse_record};

use super::joint_state::{BadMessage, HELD, JOINT_STATES, JointState, SCHEMA_NAMES};
use crate::error::{Fault, RecordingError, plural};
use crate::formats::format::ColumnRequest;
use crate::quantity::Quantity;
use crate::raw::{RawColumn, RawColumns};

/// Bytes read at a time.
const BUFFER_BYTES: usize = 1 << 18;
/// Longest record accepted \[bytes\].
const LONGEST_RECORD: usize = 1 << 30;
/// Stamps above this are clock times \[ns\]; their origin becomes the whole second of the first.
const CLOCK_NS: i64 = 100_000_000_000_000_000;

/// Joint states of one topic as columns, time in seconds: `t` and `<joint>/<quantity>`, or, for a
/// mapping, `__time` and `<topic>/<joint>/<quantity>`.
pub(super) fn read_columns(
    reader: impl Read,
    request: &ColumnRequest<'_>,
) -> Result<RawColumns, RecordingError> {
    let reader = BufReader::with_capacity(BUFFER_BYTES, reader);
    let (source, topic) = (request.source(), request.topic());
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
    let mut raw = file.columns(&chosen, source, request.is_mapped())?;
    raw.notes.insert(0, format!("joint states of the topic {chosen}"));
    let others: Vec<String> = topics.into_iter().filter(|t| *t != chosen).chain(others).collect();
    if !others.is_empty() {
        raw.notes.push(format!("ignored topics: {}", others.join(", ")));
    }
    if let Some(why) = ended_early {
        raw.notes.push(format!("truncated file ({why}); read up to that point"));
    }
    Ok(raw)
}

/// Joint states of a file.
#[derive(Default)]
struct Contents {
    /// topic to read; all if none
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
    /// messages without header stamp, which have the log time instead
    without_stamp: usize,
}

impl Contents {
    /// Reads all records; the reason if the file is truncated.
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

    /// A killed recorder leaves a truncated file: the messages before the end are kept.
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

    /// Topics with joint states, and the others with the names of their messages.
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
        with_topic: bool,
    ) -> Result<RawColumns, RecordingError> {
        let read = self.topics.remove(topic).unwrap_or_default();
        let Some(Publishers { sets, skipped }) = read.publishers() else {
            return Err(RecordingError::new(Fault::HeaderOnly, source));
        };
        let joints: Vec<String> = sets.concat();
        let mut raw = RawColumns::new(source);
        if sets.len() > 1 {
            let lists: Vec<String> = sets.iter().map(|set| set.join(", ")).collect();
            raw.notes.push(format!(
                "{} publishers of joints ({}); messages merged on their stamps",
                sets.len(),
                lists.join("; ")
            ));
        }
        if !skipped.is_empty() {
            raw.notes.push(format!("ignored messages with other joints: {skipped}"));
        }
        if read.without_stamp > 0 {
            raw.notes.push(format!(
                "{} message{} without header stamp; using log time",
                read.without_stamp,
                plural(read.without_stamp)
            ));
        }
        // place of every joint in each list of names; none for lists of other joints
        let places: Vec<Option<Vec<Option<usize>>>> = (read.names.iter())
            .map(|list| {
                let is_whole = |set: &&Vec<String>| {
                    set.len() == list.len() && set.iter().all(|joint| list.contains(joint))
                };
                sets.iter().find(is_whole)?;
                let place = |joint: &String| list.iter().position(|n| n == joint);
                Some(joints.iter().map(place).collect())
            })
            .collect();
        let mut taken: Vec<(&JointState, &[Option<usize>])> = (read.states.iter())
            .filter_map(|(names, state)| Some((state, places[*names].as_deref()?)))
            .collect();
        if sets.len() > 1 {
            taken.sort_by_key(|(state, _)| state.stamp_ns);
        }
        let first = taken.first().map_or(0, |(state, _)| state.stamp_ns);
        let zero = if first > CLOCK_NS { first - first % 1_000_000_000 } else { 0 };
        if zero != 0 {
            raw.notes.push(format!("time origin: {} s", zero / 1_000_000_000));
        }
        let stamps = taken.iter().map(|(s, _)| (s.stamp_ns - zero) as f64 / 1e9).collect();
        let time = if with_topic { "__time" } else { "t" };
        raw.columns.push(RawColumn { name: time.to_owned(), values: Some(stamps) });
        for (joint, name) in joints.iter().enumerate() {
            for quantity in HELD {
                let value = |(state, places): &(&JointState, &[Option<usize>])| {
                    let of_joint = places[joint].and_then(|place| list(state, quantity).get(place));
                    of_joint.copied().unwrap_or(f64::NAN)
                };
                let values: Vec<f64> = taken.iter().map(value).collect();
                if values.iter().all(|v| v.is_nan()) {
                    continue;
                }
                let column = if with_topic {
                    format!("{topic}/{name}/{quantity}")
                } else {
                    format!("{name}/{quantity}")
                };
                raw = raw.with(column, values);
            }
        }
        Ok(raw)
    }
}

/// Least messages of a publisher, as a share of those of the first, that are merged with them: between slower ones a motion
/// is not seen.
const LEAST_SHARE: f64 = 0.25;
/// Share of the time of the first publisher in which another publishes as well.
const OVERLAP: f64 = 0.9;

/// Who publishes on a topic.
struct Publishers {
    /// joints of the messages that are read, in their order: those of most messages first
    sets: Vec<Vec<String>>,
    /// the other messages, in words
    skipped: String,
}

impl Topic {
    /// The joints of most messages, those of other publishers of other joints, and a list of the messages of neither: a
    /// gripper may publish now and then, and a second node all joints once more.
    fn publishers(&self) -> Option<Publishers> {
        let sorted = |list: &[String]| {
            let mut list = list.to_vec();
            list.sort();
            list
        };
        let sets: Vec<Vec<String>> = self.names.iter().map(|list| sorted(list)).collect();
        let mut of_set: BTreeMap<&[String], (usize, i64, i64)> = BTreeMap::new();
        for (names, state) in &self.states {
            let (count, first, last) =
                of_set.entry(&sets[*names]).or_insert((0, i64::MAX, i64::MIN));
            *count += 1;
            *first = state.stamp_ns.min(*first);
            *last = state.stamp_ns.max(*last);
        }
        let most = of_set.values().map(|(count, _, _)| *count).max()?;
        let main =
            sets.iter().find(|set| of_set.get(set.as_slice()).is_some_and(|c| c.0 == most))?;
        let (_, first, last) = *of_set.get(main.as_slice())?;
        let mut read: Vec<&[String]> = vec![main];
        for set in &sets {
            let Some((count, from, to)) = of_set.get(set.as_slice()) else { continue };
            let is_other = !set.is_empty()
                && read.iter().all(|known| known.iter().all(|joint| !set.contains(joint)));
            let together = (last.min(*to) - first.max(*from)) as f64;
            if is_other
                && *count as f64 >= LEAST_SHARE * most as f64
                && together >= OVERLAP * (last - first) as f64
            {
                read.push(set);
            }
        }
        let skipped: Vec<String> = (of_set.iter())
            .filter(|(set, _)| !read.contains(*set))
            .map(|(set, (count, _, _))| format!("{count} with {}", set.join(", ")))
            .collect();
        let in_order = |set: &&[String]| {
            self.names
                .iter()
                .zip(&sets)
                .find(|(_, sorted)| sorted == set)
                .map(|(list, _)| list.clone())
        };
        let sets = read.iter().filter_map(in_order).collect();
        Some(Publishers { sets, skipped: skipped.join("; ") })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Messages of these joints at so many per second for 10 s.
    fn published(topic: &mut Topic, joints: &[&str], hz: i64) {
        topic.names.push(joints.iter().map(ToString::to_string).collect());
        for k in 0..10 * hz {
            let state = JointState { stamp_ns: k * 1_000_000_000 / hz, ..JointState::default() };
            topic.states.push((topic.names.len() - 1, state));
        }
    }

    #[test]
    fn publishers_of_other_joints_are_merged() {
        let mut topic = Topic::default();
        published(&mut topic, &["b", "a"], 50);
        published(&mut topic, &["c"], 100);
        published(&mut topic, &["finger"], 2);
        published(&mut topic, &["a", "b", "c"], 20);
        let Publishers { sets, skipped } = topic.publishers().unwrap();
        assert_eq!(sets, [vec!["c".to_owned()], vec!["b".to_owned(), "a".to_owned()]]);
        assert_eq!(skipped, "200 with a, b, c; 20 with finger");
    }
}
