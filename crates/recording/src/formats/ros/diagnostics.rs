//! `diagnostic_msgs/DiagnosticArray`, written.
//!
//! ```text
//! header  { stamp { sec, nanosec }, frame_id }
//! status  { level byte, name, message, hardware_id, values { key, value }[] }[]
//! ```

use super::serialised::Writer;
use crate::formats::mcap::Status;

/// Name of the message in ROS 2.
pub(in crate::formats) const NAME: &str = "diagnostic_msgs/msg/DiagnosticArray";
/// Definition of the message, as ROS 2 writes it; that of its header follows.
pub(in crate::formats) const DEFINITION: &str = "\
std_msgs/Header header
diagnostic_msgs/DiagnosticStatus[] status
================================================================================
MSG: diagnostic_msgs/DiagnosticStatus
byte OK=0
byte WARN=1
byte ERROR=2
byte STALE=3
byte level
string name
string message
string hardware_id
diagnostic_msgs/KeyValue[] values
================================================================================
MSG: diagnostic_msgs/KeyValue
string key
string value
";

/// The message for ROS 2.
pub(in crate::formats) fn to_cdr(stamp_ns: i64, statuses: &[Status]) -> Vec<u8> {
    let mut writer = Writer::with_header(stamp_ns);
    writer.u32(statuses.len() as u32);
    for status in statuses {
        writer.byte(status.level as u8);
        for text in [&status.name, &status.message, &status.subject] {
            writer.string(text);
        }
        writer.u32(status.values.len() as u32);
        for (key, value) in &status.values {
            writer.string(key);
            writer.string(value);
        }
    }
    writer.into_bytes()
}
