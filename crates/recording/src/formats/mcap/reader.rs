//! Reads the messages of joints from MCAP.

use std::collections::BTreeMap;
use std::io::{BufReader, Read};

use ::mcap::records::Record;
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, parse_record};

use crate::error::{Fault, RecordingError};
use crate::formats::ros::Topics;

/// Bytes read at a time.
const BUFFER_BYTES: usize = 1 << 18;
/// Longest record accepted \[bytes\].
const LONGEST_RECORD: usize = 1 << 30;

/// Reads the messages of a file; the reason if it ends early.
///
/// # Errors
/// The file cannot be read, or none of its messages.
pub(in crate::formats) fn read_messages(
    reader: impl Read,
    topics: &mut Topics,
    source: &str,
) -> Result<Option<String>, RecordingError> {
    let reader = BufReader::with_capacity(BUFFER_BYTES, reader);
    Contents { topics, schemas: BTreeMap::new(), channels: BTreeMap::new() }.read(reader, source)
}

/// Messages of a file.
struct Contents<'a> {
    topics: &'a mut Topics,
    /// schema id to name
    schemas: BTreeMap<u16, String>,
    /// channel id to topic and encoding
    channels: BTreeMap<u16, (String, String)>,
}

impl Contents<'_> {
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
                    Ok(record) => self.take(record),
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

    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).map_or("", String::as_str);
                self.topics.declare(&channel.topic, schema);
                self.channels.insert(channel.id, (channel.topic, channel.message_encoding));
            }
            Record::Message { header, data } => {
                if let Some((topic, encoding)) = self.channels.get(&header.channel_id) {
                    self.topics.take(topic, encoding, &data, header.log_time);
                }
            }
            _ => {}
        }
    }
}
