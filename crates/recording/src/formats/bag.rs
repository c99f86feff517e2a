//! ROS 1 bags: joints of one topic (cargo feature `all-formats`).
//!
//! Records are a header of fields `name=value` and data; messages lie in chunks, which may be compressed. Read here rather than
//! by the crate `rosbag` 0.6, which panics on a bag without its index: a killed recorder leaves one. Source: ROS wiki, Bags,
//! format 2.0.

use super::format::{FileStart, Format, Support};
#[cfg(feature = "all-formats")]
use {
    super::format::{ColumnRequest, Input},
    super::ros::Topics,
    crate::error::{Fault, RecordingError},
    crate::raw::RawColumns,
    std::collections::BTreeMap,
    std::io::{BufReader, Read},
};

/// ROS 1 bags.
#[derive(Debug, Clone, Copy)]
pub struct Bag;

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

impl Format for Bag {
    fn name(&self) -> &'static str {
        "ROS 1 bag"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["bag"]
    }

    fn support(&self) -> Support {
        if cfg!(feature = "all-formats") { Support::Read } else { Support::Feature("all-formats") }
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(MAGIC)
    }

    #[cfg(feature = "all-formats")]
    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let mut reader = BufReader::new(input.into_reader());
        let mut magic = [0; MAGIC.len()];
        let mut contents = Contents {
            topics: Topics::new(request),
            connections: BTreeMap::new(),
            chunks: 0,
            expected: 0,
        };
        let read = reader.read_exact(&mut magic).map_err(|error| error.to_string());
        let read = read.and_then(|()| contents.read(&mut reader, 0));
        let ended = match read {
            Err(what) if contents.topics.is_empty() => {
                let fault = Fault::Broken { format: "ROS 1 bag", what };
                return Err(RecordingError::new(fault, request.source()));
            }
            Err(what) => Some(what),
            Ok(()) => None,
        };
        let ended = ended.map(|what| match contents.expected {
            0 => format!("{what} in chunk {}", contents.chunks),
            all => format!("{what} in chunk {} of {all}", contents.chunks),
        });
        contents.topics.columns(request, ended)
    }
}

/// Kinds of records.
#[cfg(feature = "all-formats")]
mod operation {
    pub(super) const MESSAGE: u8 = 2;
    pub(super) const FILE: u8 = 3;
    pub(super) const CHUNK: u8 = 5;
    pub(super) const CONNECTION: u8 = 7;
}

/// Messages of a bag.
#[cfg(feature = "all-formats")]
struct Contents {
    topics: Topics,
    /// number of a connection to its topic
    connections: BTreeMap<u32, String>,
    /// chunks so far
    chunks: usize,
    /// chunks by the header of the file; 0 if it was never closed
    expected: u32,
}

#[cfg(feature = "all-formats")]
impl Contents {
    /// Reads records to the end, those of chunks at `depth` 1; the reason if the file is truncated.
    fn read(&mut self, reader: &mut dyn Read, depth: usize) -> Result<(), String> {
        while let Some((header, is_whole)) = block(reader)? {
            if !is_whole {
                return Err("it ends".to_owned());
            }
            let header = fields(&header)?;
            let (data, is_whole) = block(reader)?.ok_or("it ends")?;
            let is_chunk = header.get("op").is_some_and(|op| op[..] == [operation::CHUNK]);
            if !is_whole && !is_chunk {
                return Err("it ends".to_owned());
            }
            match header.get("op").and_then(|op| op.first()) {
                Some(&operation::FILE) => {
                    self.expected = number(&header, "chunk_count").unwrap_or(0);
                }
                Some(&operation::CONNECTION) => self.connect(&header, &data)?,
                Some(&operation::MESSAGE) => self.message(&header, &data),
                Some(&operation::CHUNK) if depth == 0 => {
                    self.chunks += 1;
                    let size = u64::from(number(&header, "size").unwrap_or(0));
                    match header.get("compression").map(Vec::as_slice) {
                        Some(b"none") | None => self.read(&mut data.as_slice(), 1)?,
                        Some(b"bz2") => {
                            let inside = bzip2::read::BzDecoder::new(data.as_slice());
                            self.read(&mut inside.take(size), 1)?;
                        }
                        Some(b"lz4") => {
                            let inside = lz4::Decoder::new(data.as_slice())
                                .map_err(|error| error.to_string())?;
                            self.read(&mut inside.take(size), 1)?;
                        }
                        Some(other) => {
                            let name = String::from_utf8_lossy(other);
                            return Err(format!("compression `{name}` is not known"));
                        }
                    }
                }
                _ => {}
            }
            if !is_whole {
                return Err("it ends".to_owned());
            }
        }
        Ok(())
    }

    fn connect(&mut self, header: &Fields, data: &[u8]) -> Result<(), String> {
        let text = |fields: &Fields, name: &str| {
            fields.get(name).map(|value| String::from_utf8_lossy(value).into_owned())
        };
        let (Some(number), Some(topic)) = (number(header, "conn"), text(header, "topic")) else {
            return Err("a connection has no topic".to_owned());
        };
        let schema = text(&fields(data)?, "type").unwrap_or_default();
        self.topics.declare(&topic, &schema);
        self.connections.insert(number, topic);
        Ok(())
    }

    fn message(&mut self, header: &Fields, data: &[u8]) {
        let topic = number(header, "conn").and_then(|number| self.connections.get(&number));
        let Some(topic) = topic else { return };
        let time = header.get("time").filter(|time| time.len() == 8);
        let log_ns = time.map_or(0, |time| {
            let part = |at: usize| {
                u64::from(u32::from_le_bytes([time[at], time[at + 1], time[at + 2], time[at + 3]]))
            };
            part(0) * 1_000_000_000 + part(4)
        });
        self.topics.take(topic, "ros1", data, log_ns);
    }
}

/// Fields of a header.
#[cfg(feature = "all-formats")]
type Fields = BTreeMap<String, Vec<u8>>;

/// A length and so many bytes, and whether all of them are there; none at the end.
#[cfg(feature = "all-formats")]
fn block(reader: &mut dyn Read) -> Result<Option<(Vec<u8>, bool)>, String> {
    let read = |reader: &mut dyn Read, length: u64| -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        reader.take(length).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
        Ok(bytes)
    };
    let length = read(reader, 4)?;
    let length = match length[..] {
        [] => return Ok(None),
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        _ => return Err("it ends".to_owned()),
    };
    let bytes = read(reader, u64::from(length))?;
    let is_whole = bytes.len() == length as usize;
    Ok(Some((bytes, is_whole)))
}

#[cfg(feature = "all-formats")]
fn fields(mut header: &[u8]) -> Result<Fields, String> {
    let mut fields = Fields::new();
    while let Some((field, _)) = block(&mut header)? {
        let Some(equals) = field.iter().position(|byte| *byte == b'=') else {
            return Err("a field has no value".to_owned());
        };
        let name = String::from_utf8_lossy(&field[..equals]).into_owned();
        fields.insert(name, field[equals + 1..].to_vec());
    }
    Ok(fields)
}

#[cfg(feature = "all-formats")]
fn number(fields: &Fields, name: &str) -> Option<u32> {
    let bytes = fields.get(name)?;
    <[u8; 4]>::try_from(bytes.as_slice()).ok().map(u32::from_le_bytes)
}
