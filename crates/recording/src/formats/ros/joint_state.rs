//! `sensor_msgs/JointState`, read and written.
//!
//! ```text
//! header  { stamp { sec, nanosec }, frame_id }        ROS 1: header { seq, stamp, frame_id }
//! name      string[]
//! position, velocity, effort   float64[]
//! ```

use super::serialised::{BadMessage, Encoding, Reader, Writer};
use crate::quantity::Quantity;

/// Name of the message in ROS 2.
pub(in crate::formats) const SCHEMA_NAME: &str = "sensor_msgs/msg/JointState";
/// Definition of the message, as ROS 2 writes it; that of its header follows.
pub(in crate::formats) const DEFINITION: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
";
/// Quantities of a joint state.
pub(in crate::formats) const HELD: [Quantity; 3] =
    [Quantity::Position, Quantity::Velocity, Quantity::Effort];

/// One message.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::formats) struct JointState {
    /// Stamp of the header \[ns\].
    pub(in crate::formats) stamp_ns: i64,
    pub(in crate::formats) name: Vec<String>,
    pub(in crate::formats) position: Vec<f64>,
    pub(in crate::formats) velocity: Vec<f64>,
    pub(in crate::formats) effort: Vec<f64>,
}

impl JointState {
    /// Reads a message.
    pub(super) fn decode(bytes: &[u8], encoding: Encoding) -> Result<Self, BadMessage> {
        let mut reader = Reader::new(bytes, encoding)?;
        let stamp_ns = reader.header()?;
        let name = reader.names()?;
        let position = reader.list("the positions")?;
        let velocity = reader.list("the velocities")?;
        let effort = reader.list("the efforts")?;
        for (list, of) in
            [(&position, "positions"), (&velocity, "velocities"), (&effort, "efforts")]
        {
            if !list.is_empty() && list.len() != name.len() {
                let what = format!("it has {} names, but {} {of}", name.len(), list.len());
                return Err(reader.bad(what));
            }
        }
        Ok(Self { stamp_ns, name, position, velocity, effort })
    }

    /// The message for ROS 2.
    pub(in crate::formats) fn to_cdr(&self) -> Vec<u8> {
        let mut writer = Writer::with_header(self.stamp_ns);
        writer.u32(self.name.len() as u32);
        for name in &self.name {
            writer.string(name);
        }
        for list in [&self.position, &self.velocity, &self.effort] {
            writer.list(list);
        }
        writer.into_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_cdr(bytes: &[u8]) -> Result<JointState, BadMessage> {
        JointState::decode(bytes, Encoding::Cdr)
    }

    fn from_ros1(bytes: &[u8]) -> Result<JointState, BadMessage> {
        JointState::decode(bytes, Encoding::Ros1)
    }

    fn message() -> JointState {
        JointState {
            stamp_ns: 1_700_000_000_123_456_789,
            name: vec!["a".to_owned(), "elbow".to_owned()],
            position: vec![0.25, -1.5],
            velocity: Vec::new(),
            effort: vec![1e-300, f64::MAX],
        }
    }

    /// The bytes of a message with one joint, written out by hand from the standard.
    #[test]
    fn bytes_are_those_of_the_standard() {
        let one = JointState {
            stamp_ns: 1_000_000_002,
            name: vec!["q".to_owned()],
            position: vec![1.0],
            velocity: Vec::new(),
            effort: Vec::new(),
        };
        let mut expected = vec![0, 1, 0, 0];
        expected.extend([1, 0, 0, 0, 2, 0, 0, 0]); // stamp
        expected.extend([1, 0, 0, 0, 0, 0, 0, 0]); // empty frame with its zero, and padding
        expected.extend([1, 0, 0, 0, 2, 0, 0, 0, b'q', 0, 0, 0]); // one name, and padding
        expected.extend([1, 0, 0, 0]); // one position, at 32: aligned
        expected.extend([0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
        expected.extend([0, 0, 0, 0, 0, 0, 0, 0]); // no velocity, no effort
        assert_eq!(one.to_cdr(), expected);
        assert_eq!(from_cdr(&expected).unwrap(), one);
    }

    #[test]
    fn what_is_written_is_read() {
        assert_eq!(from_cdr(&message().to_cdr()).unwrap(), message());
    }

    /// Big endian, and the second version with its alignment to four bytes.
    #[test]
    fn other_byte_orders_and_alignments() {
        let big = {
            let mut bytes = vec![0, 0, 0, 0];
            bytes.extend(5_i32.to_be_bytes());
            bytes.extend(7_u32.to_be_bytes());
            bytes.extend(1_u32.to_be_bytes());
            bytes.extend([0, 0, 0, 0]);
            bytes.extend(1_u32.to_be_bytes());
            bytes.extend(2_u32.to_be_bytes());
            bytes.extend([b'q', 0, 0, 0]);
            bytes.extend(1_u32.to_be_bytes());
            bytes.extend(2.5_f64.to_be_bytes());
            bytes.extend([0; 8]);
            bytes
        };
        let found = from_cdr(&big).unwrap();
        assert_eq!((found.stamp_ns, found.position), (5_000_000_007, vec![2.5]));

        let mut second = vec![0, 7, 0, 0];
        second.extend([5, 0, 0, 0, 7, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
        second.extend([1, 0, 0, 0, 5, 0, 0, 0, b'w', b'r', b's', b't', 0, 0, 0, 0]);
        second.extend([1, 0, 0, 0]); // at 32 + 4: no padding before the number
        second.extend(2.5_f64.to_le_bytes());
        second.extend([0; 8]);
        let found = from_cdr(&second).unwrap();
        assert_eq!((found.name, found.position), (vec!["wrst".to_owned()], vec![2.5]));
    }

    #[test]
    fn ros_1() {
        let mut bytes = vec![9, 0, 0, 0, 5, 0, 0, 0, 7, 0, 0, 0];
        bytes.extend([4, 0, 0, 0, b'b', b'a', b's', b'e']);
        bytes.extend([1, 0, 0, 0, 1, 0, 0, 0, b'q', 1, 0, 0, 0]);
        bytes.extend(2.5_f64.to_le_bytes());
        bytes.extend([0, 0, 0, 0, 1, 0, 0, 0]);
        bytes.extend((-1.0_f64).to_le_bytes());
        let found = from_ros1(&bytes).unwrap();
        assert_eq!((found.stamp_ns, found.name), (5_000_000_007, vec!["q".to_owned()]));
        assert_eq!((found.position, found.effort), (vec![2.5], vec![-1.0]));
    }

    /// No prefix of a message and no flipped byte makes the reader panic.
    #[test]
    fn broken_messages_are_refused_in_words() {
        let whole = message().to_cdr();
        for length in 0..whole.len() {
            let bad = from_cdr(&whole[..length]).unwrap_err();
            assert!(bad.offset <= whole.len() && !bad.what.is_empty());
            let _ = from_ros1(&whole[..length]);
        }
        for at in 0..whole.len() {
            for bit in 0..8 {
                let mut broken = whole.clone();
                broken[at] ^= 1 << bit;
                let _ = from_cdr(&broken);
                let _ = from_ros1(&broken);
            }
        }
        let mut uneven = message();
        uneven.position.pop();
        let bad = from_cdr(&uneven.to_cdr()).unwrap_err();
        assert_eq!(bad.what, "it has 2 names, but 1 positions");
    }
}
