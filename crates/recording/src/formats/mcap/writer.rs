//! Writes joint states and statuses to MCAP.

use std::collections::BTreeMap;
use std::io::{Cursor, Seek, Write};

use ::mcap::records::MessageHeader;
use ::mcap::{McapError, WriteOptions};

use super::{JointTopic, StatusTopic};
use crate::error::{Fault, RecordingError};
use crate::formats::format::Encoded;
use crate::formats::ros::{
    DIAGNOSTICS, DIAGNOSTICS_DEFINITION, HEADER_DEFINITION, HELD, JOINT_STATE,
    JOINT_STATE_DEFINITION, JOINT_STATES, JointState, to_cdr,
};
use crate::recording::Recording;

/// The recording as MCAP: a message `sensor_msgs/msg/JointState` per sample under `/joint_states`,
/// stamped to the nanosecond. Channels that a joint state cannot hold are omitted.
///
/// Stamps before 0, which ROS does not have, are shifted by whole seconds.
///
/// # Errors
/// The recording is inconsistent, or too long for the stamps of ROS.
pub(super) fn write(recording: &Recording) -> Result<Encoded, RecordingError> {
    let topic = JointTopic { name: JOINT_STATES.to_owned(), states: recording };
    write_topics(&[topic], &[])
}

/// Messages of all topics in the order of their stamps, with a schema a type of message.
///
/// # Errors
/// A recording is inconsistent, or too long for the stamps of ROS.
pub(super) fn write_topics(
    joints: &[JointTopic<'_>],
    statuses: &[StatusTopic],
) -> Result<Encoded, RecordingError> {
    for topic in joints {
        topic.states.check()?;
    }
    let source = joints.first().map_or("", |topic| topic.states.source.as_str());
    written(joints, statuses).map_err(|error| {
        let error = std::io::Error::other(error.to_string());
        RecordingError::new(Fault::Io { doing: "written", error }, source)
    })
}

fn written(joints: &[JointTopic<'_>], statuses: &[StatusTopic]) -> Result<Encoded, McapError> {
    let first = joints.iter().filter_map(|topic| topic.states.time_s.first().copied());
    let shift_s = first.fold(0.0, f64::min).floor();
    let stamp_ns = |t: f64| ((t - shift_s) * 1e9).round() as i64;
    let options = WriteOptions::new().profile("ros2").library("armident");
    let mut out = options.create(Cursor::new(Vec::new()))?;

    let mut messages: Vec<Message<'_>> = Vec::new();
    let states = schema(&mut out, JOINT_STATE, JOINT_STATE_DEFINITION)?;
    for topic in joints {
        let channel = out.add_channel(states, &topic.name, "cdr", &BTreeMap::new())?;
        let stamps = topic.states.time_s.iter().enumerate();
        messages.extend(stamps.map(|(row, t)| Message {
            stamp_ns: stamp_ns(*t),
            channel,
            sequence: row as u32,
            content: Content::Row(topic.states, row),
        }));
    }
    if !statuses.is_empty() {
        let diagnostics = schema(&mut out, DIAGNOSTICS, DIAGNOSTICS_DEFINITION)?;
        for topic in statuses {
            let channel = out.add_channel(diagnostics, &topic.name, "cdr", &BTreeMap::new())?;
            messages.extend(topic.at.iter().enumerate().map(|(k, (t, statuses))| Message {
                stamp_ns: stamp_ns(*t),
                channel,
                sequence: k as u32,
                content: Content::Statuses(statuses),
            }));
        }
    }
    // players read a file from its beginning: topics of one stamp lie beside each other
    messages.sort_by_key(|message| message.stamp_ns);
    for Message { stamp_ns, channel, sequence, content } in messages {
        let time = stamp_ns.max(0).unsigned_abs();
        let header =
            MessageHeader { channel_id: channel, sequence, log_time: time, publish_time: time };
        let bytes = match content {
            Content::Row(states, row) => joint_state(states, row, stamp_ns).to_cdr(),
            Content::Statuses(statuses) => to_cdr(stamp_ns, statuses),
        };
        out.write_to_known_channel(&header, &bytes)?;
    }
    out.finish()?;
    let omitted = joints.iter().flat_map(|topic| &topic.states.joints).flat_map(|joint| {
        let other = joint.channels().filter(|(quantity, _)| !HELD.contains(quantity));
        other.map(|(quantity, _)| format!("{}/{quantity}", joint.name))
    });
    let omitted = omitted.collect();
    Ok(Encoded { bytes: out.into_inner().into_inner(), omitted })
}

/// A message to be written.
struct Message<'a> {
    stamp_ns: i64,
    channel: u16,
    sequence: u32,
    content: Content<'a>,
}

enum Content<'a> {
    Row(&'a Recording, usize),
    Statuses(&'a [super::Status]),
}

/// Registers a type of message that begins with a header.
fn schema<W: Write + Seek>(
    out: &mut ::mcap::Writer<W>,
    name: &str,
    definition: &str,
) -> Result<u16, McapError> {
    out.add_schema(name, "ros2msg", format!("{definition}{HEADER_DEFINITION}").as_bytes())
}

fn joint_state(states: &Recording, row: usize, stamp_ns: i64) -> JointState {
    let [position, velocity, effort] = HELD.map(|quantity| {
        let columns: Vec<Option<&[f64]>> =
            states.joints.iter().map(|joint| joint.channel(quantity)).collect();
        if columns.iter().all(Option::is_none) {
            return Vec::new();
        }
        columns.iter().map(|column| column.map_or(f64::NAN, |values| values[row])).collect()
    });
    let name = states.joints.iter().map(|joint| joint.name.clone()).collect();
    JointState { stamp_ns, name, position, velocity, effort }
}
