//! Fields of messages in the two encodings of ROS.
//!
//! * ROS 2, encoding `cdr`: a header of four bytes with the byte order, then numbers aligned to their
//!   size (counted from the end of the header; at most to four bytes in XCDR2), strings and lists
//!   after their length, strings with a terminating zero. Source: OMG, DDS-XTypes 1.3, 7.4.
//! * ROS 1, encoding `ros1`: little endian without alignment or zeros.
//!
//! Decoded here rather than by a crate: `re_cdr` 0.1 aligns 8-byte numbers to 8 bytes always, so
//! that it reads the position 2.5 of the XCDR2 message in the tests of `joint_state` as 5e-315, and its serde
//! reader reports no offset of an error.

/// Nanoseconds per second.
pub(super) const NS_PER_S: i64 = 1_000_000_000;

/// Encoding of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) enum Encoding {
    /// Of ROS 2.
    Cdr,
    /// Of ROS 1.
    Ros1,
}

/// Where and why a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BadMessage {
    pub(super) offset: usize,
    pub(super) what: String,
}

/// Reads the fields of a message, one after the other.
pub(super) struct Reader<'a> {
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

impl<'a> Reader<'a> {
    /// At the first byte of a message.
    pub(super) fn new(bytes: &'a [u8], encoding: Encoding) -> Result<Self, BadMessage> {
        if encoding == Encoding::Ros1 {
            return Ok(Self { bytes, at: 0, before: 0, little: true, widest: 1, ros2: false });
        }
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
        Ok(Self { bytes: &bytes[4..], at: 0, before: 4, little, widest, ros2: true })
    }

    /// `std_msgs/Header`: its stamp \[ns\].
    pub(super) fn header(&mut self) -> Result<i64, BadMessage> {
        let (sec, nanosec) = if self.ros2 {
            (i64::from(self.u32()? as i32), self.u32()?)
        } else {
            self.u32()?;
            (i64::from(self.u32()?), self.u32()?)
        };
        self.string("the frame")?;
        Ok(sec * NS_PER_S + i64::from(nanosec))
    }

    /// A list of names.
    pub(super) fn names(&mut self) -> Result<Vec<String>, BadMessage> {
        let count = self.count("the names", 4)?;
        (0..count).map(|_| self.string("a name")).collect()
    }

    pub(super) fn bad(&self, what: impl Into<String>) -> BadMessage {
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

    pub(super) fn u32(&mut self) -> Result<u32, BadMessage> {
        let bytes = self.take::<4>()?;
        Ok(if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    /// A length of entries of at least so many bytes each.
    pub(super) fn count(&mut self, of: &str, bytes_each: usize) -> Result<usize, BadMessage> {
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

    /// A list of numbers.
    pub(super) fn list(&mut self, of: &str) -> Result<Vec<f64>, BadMessage> {
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

/// ROS 2 in little endian, as it is written here.
const CDR_LITTLE: [u8; 4] = [0, 1, 0, 0];

/// Definition of the header that messages begin with.
pub(in crate::formats) const HEADER_DEFINITION: &str = "\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Writes the fields of a message for ROS 2, one after the other.
pub(super) struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    /// A message that begins with a header without a frame.
    pub(super) fn with_header(stamp_ns: i64) -> Self {
        let mut writer = Self { bytes: CDR_LITTLE.to_vec() };
        writer.bytes.extend((stamp_ns.div_euclid(NS_PER_S) as i32).to_le_bytes());
        writer.u32(stamp_ns.rem_euclid(NS_PER_S) as u32);
        writer.string("");
        writer
    }

    fn align(&mut self, to: usize) {
        let length = (self.bytes.len() - CDR_LITTLE.len()).next_multiple_of(to);
        self.bytes.resize(length + CDR_LITTLE.len(), 0);
    }

    pub(super) fn byte(&mut self, x: u8) {
        self.bytes.push(x);
    }

    pub(super) fn u32(&mut self, x: u32) {
        self.align(4);
        self.bytes.extend(x.to_le_bytes());
    }

    pub(super) fn string(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    pub(super) fn list(&mut self, list: &[f64]) {
        self.u32(list.len() as u32);
        for x in list {
            self.align(8);
            self.bytes.extend(x.to_le_bytes());
        }
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}
