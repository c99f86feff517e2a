//! `sensor_msgs/JointState` in the two encodings of ROS.
//!
//! ```text
//! header  { stamp { sec, nanosec }, frame_id }        ROS 1: header { seq, stamp, frame_id }
//! name      string[]
//! position, velocity, effort   float64[]
//! ```
//!
//! * ROS 2, encoding `cdr`: a header of four bytes with the byte order, then numbers aligned to their
//!   size (counted from the end of the header; at most to four bytes in XCDR2), strings and lists
//!   after their length, strings with a terminating zero. Source: OMG, DDS-XTypes 1.3, 7.4.
//! * ROS 1, encoding `ros1`: little endian without alignment or zeros.
//!
//! Decoded here rather than by a crate: `re_cdr` 0.1 aligns 8-byte numbers to 8 bytes always, so
//! that it reads the position 2.5 of the XCDR2 message in the tests below as 5e-315, and its serde
//! reader reports no offset of an error.

use crate::quantity::Quantity;

/// Preferred topic if several have joint states, and the topic that is written.
pub(super) const JOINT_STATES: &str = "/joint_states";
/// Names of the message in ROS 2 and ROS 1.
pub(super) const SCHEMA_NAMES: [&str; 2] = ["sensor_msgs/msg/JointState", "sensor_msgs/JointState"];
/// Quantities of a joint state.
pub(super) const HELD: [Quantity; 3] = [Quantity::Position, Quantity::Velocity, Quantity::Effort];

/// One message.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct JointState {
    /// Stamp of the header \[ns\].
    pub(super) stamp_ns: i64,
    pub(super) name: Vec<String>,
    pub(super) position: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(super) effort: Vec<f64>,
}

/// Where and why a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BadMessage {
    pub(super) offset: usize,
    pub(super) what: String,
}

const NS_PER_S: i64 = 1_000_000_000;
/// ROS 2 in little endian, as this module writes it.
const CDR_LITTLE: [u8; 4] = [0, 1, 0, 0];

impl JointState {
    /// Reads a message of ROS 2.
    pub(super) fn from_cdr(bytes: &[u8]) -> Result<Self, BadMessage> {
        let bad = |what: String| BadMessage { offset: 0, what };
        let head = bytes.get(..4).ok_or_else(|| bad("it is shorter than its header".to_owned()))?;
        let (little, widest) = match head[..2] {
            [0, 0] => (false, 8),
            [0, 1] => (true, 8),
            [0, 6] => (false, 4),
            [0, 7] => (true, 4),
            [a, b, ..] => return Err(bad(format!("its encoding {a:02x} {b:02x} is not known"))),
            _ => return Err(bad("it has no encoding".to_owned())),
        };
        let mut reader =
            Reader { bytes: &bytes[4..], at: 0, before: 4, little, widest, ros2: true };
        let (sec, nanosec) = (reader.u32()? as i32, reader.u32()?);
        reader.rest(i64::from(sec) * NS_PER_S + i64::from(nanosec))
    }

    /// Reads a message of ROS 1.
    pub(super) fn from_ros1(bytes: &[u8]) -> Result<Self, BadMessage> {
        let mut reader = Reader { bytes, at: 0, before: 0, little: true, widest: 1, ros2: false };
        reader.u32()?;
        let (sec, nanosec) = (reader.u32()?, reader.u32()?);
        reader.rest(i64::from(sec) * NS_PER_S + i64::from(nanosec))
    }

    /// The message for ROS 2.
    pub(super) fn to_cdr(&self) -> Vec<u8> {
        let mut writer = Writer { bytes: CDR_LITTLE.to_vec() };
        let sec = self.stamp_ns.div_euclid(NS_PER_S) as i32;
        writer.bytes.extend(sec.to_le_bytes());
        writer.u32(self.stamp_ns.rem_euclid(NS_PER_S) as u32);
        writer.string("");
        writer.u32(self.name.len() as u32);
        for name in &self.name {
            writer.string(name);
        }
        for list in [&self.position, &self.velocity, &self.effort] {
            writer.list(list);
        }
        writer.bytes
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    /// bytes before the first one counted
    before: usize,
    little: bool,
    /// widest alignment
    widest: usize,
    /// strings end with a zero that their length counts
    ros2: bool,
}

impl Reader<'_> {
    /// All after the stamp.
    fn rest(&mut self, stamp_ns: i64) -> Result<JointState, BadMessage> {
        self.string("the frame")?;
        let count = self.count("the names", 4)?;
        let mut name = Vec::with_capacity(count);
        for _ in 0..count {
            name.push(self.string("a name")?);
        }
        let position = self.list("the positions")?;
        let velocity = self.list("the velocities")?;
        let effort = self.list("the efforts")?;
        for (list, of) in
            [(&position, "positions"), (&velocity, "velocities"), (&effort, "efforts")]
        {
            if !list.is_empty() && list.len() != name.len() {
                let what = format!("it has {} names, but {} {of}", name.len(), list.len());
                return Err(self.bad(what));
            }
        }
        Ok(JointState { stamp_ns, name, position, velocity, effort })
    }

    fn bad(&self, what: impl Into<String>) -> BadMessage {
        BadMessage { offset: self.before + self.at, what: what.into() }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], BadMessage> {
        self.at = self.at.next_multiple_of(N.min(self.widest));
        let end = self.at + N;
        let Some(Ok(found)) = self.bytes.get(self.at..end).map(<[u8; N]>::try_from) else {
            return Err(self.bad("it ends here"));
        };
        self.at = end;
        Ok(found)
    }

    fn u32(&mut self) -> Result<u32, BadMessage> {
        let bytes = self.take::<4>()?;
        Ok(if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    /// A length of entries of at least so many bytes each.
    fn count(&mut self, of: &str, bytes_each: usize) -> Result<usize, BadMessage> {
        let count = self.u32()? as usize;
        if count > (self.bytes.len() - self.at) / bytes_each {
            return Err(self.bad(format!("{of} cannot be {count}: the message is shorter")));
        }
        Ok(count)
    }

    fn string(&mut self, of: &str) -> Result<String, BadMessage> {
        let length = self.count(of, 1)?;
        let bytes = &self.bytes[self.at..self.at + length];
        let text = if self.ros2 { bytes.strip_suffix(&[0]).unwrap_or(bytes) } else { bytes };
        let text = std::str::from_utf8(text).map_err(|_| self.bad(format!("{of} is not UTF-8")))?;
        self.at += length;
        Ok(text.to_owned())
    }

    fn list(&mut self, of: &str) -> Result<Vec<f64>, BadMessage> {
        let count = self.count(of, 8)?;
        let mut list = Vec::with_capacity(count);
        for _ in 0..count {
            let bytes = self.take::<8>()?;
            list.push(if self.little {
                f64::from_le_bytes(bytes)
            } else {
                f64::from_be_bytes(bytes)
            });
        }
        Ok(list)
    }
}

struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    fn align(&mut self, to: usize) {
        let length = (self.bytes.len() - CDR_LITTLE.len()).next_multiple_of(to);
        self.bytes.resize(length + CDR_LITTLE.len(), 0);
    }

    fn u32(&mut self, x: u32) {
        self.align(4);
        self.bytes.extend(x.to_le_bytes());
    }

    fn string(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    fn list(&mut self, list: &[f64]) {
        self.u32(list.len() as u32);
        for x in list {
            self.align(8);
            self.bytes.extend(x.to_le_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(JointState::from_cdr(&expected).unwrap(), one);
    }

    #[test]
    fn what_is_written_is_read() {
        assert_eq!(JointState::from_cdr(&message().to_cdr()).unwrap(), message());
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
        let found = JointState::from_cdr(&big).unwrap();
        assert_eq!((found.stamp_ns, found.position), (5_000_000_007, vec![2.5]));

        let mut second = vec![0, 7, 0, 0];
        second.extend([5, 0, 0, 0, 7, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
        second.extend([1, 0, 0, 0, 5, 0, 0, 0, b'w', b'r', b's', b't', 0, 0, 0, 0]);
        second.extend([1, 0, 0, 0]); // at 32 + 4: no padding before the number
        second.extend(2.5_f64.to_le_bytes());
        second.extend([0; 8]);
        let found = JointState::from_cdr(&second).unwrap();
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
        let found = JointState::from_ros1(&bytes).unwrap();
        assert_eq!((found.stamp_ns, found.name), (5_000_000_007, vec!["q".to_owned()]));
        assert_eq!((found.position, found.effort), (vec![2.5], vec![-1.0]));
    }

    /// No prefix of a message and no flipped byte makes the reader panic.
    #[test]
    fn broken_messages_are_refused_in_words() {
        let whole = message().to_cdr();
        for length in 0..whole.len() {
            let bad = JointState::from_cdr(&whole[..length]).unwrap_err();
            assert!(bad.offset <= whole.len() && !bad.what.is_empty());
            let _ = JointState::from_ros1(&whole[..length]);
        }
        for at in 0..whole.len() {
            for bit in 0..8 {
                let mut broken = whole.clone();
                broken[at] ^= 1 << bit;
                let _ = JointState::from_cdr(&broken);
                let _ = JointState::from_ros1(&broken);
            }
        }
        let mut uneven = message();
        uneven.position.pop();
        let bad = JointState::from_cdr(&uneven.to_cdr()).unwrap_err();
        assert_eq!(bad.what, "it has 2 names, but 1 positions");
    }
}
