//! Writes joint states to MCAP.

use std::collections::BTreeMap;
use std::io::Cursor;

use ::mcap::{McapError, WriteOptions};

use crate::error::{Fault, RecordingError};
use crate::formats::format::Encoded;
use crate::formats::ros::{HELD, JOINT_STATES, JointState, SCHEMA_NAME};
use crate::recording::Recording;

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

/// The recording as MCAP: a message `sensor_msgs/msg/JointState` per sample under `/joint_states`,
/// stamped to the nanosecond. Channels that a joint state cannot hold are omitted.
///
/// Stamps before 0, which ROS does not have, are shifted by whole seconds.
///
/// # Errors
/// The recording is inconsistent, or too long for the stamps of ROS.
pub(super) fn write(recording: &Recording) -> Result<Encoded, RecordingError> {
    recording.check()?;
    let source = recording.source.as_str();
    let fault = |error: McapError| {
        let error = std::io::Error::other(error.to_string());
        RecordingError::new(Fault::Io { doing: "written", error }, source)
    };
    let shift = recording.time_s.first().map_or(0.0, |t| t.min(0.0).floor());
    let options = WriteOptions::new().profile("ros2").library("armident");
    let mut out = options.create(Cursor::new(Vec::new())).map_err(fault)?;
    let schema = out.add_schema(SCHEMA_NAME, "ros2msg", SCHEMA.as_bytes()).map_err(fault)?;
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
    let bytes = out.into_inner().into_inner();
    let omitted = recording.joints.iter().flat_map(|joint| {
        let other = joint.channels().filter(|(quantity, _)| !HELD.contains(quantity));
        other.map(|(quantity, _)| format!("{}/{quantity}", joint.name))
    });
    Ok(Encoded { bytes, omitted: omitted.collect() })
}
