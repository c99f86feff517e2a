//! Recordings as comma-separated text: a column `t` \[s\], then `<joint>/<quantity>`.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Terminator};

use crate::error::{Fault, RecordingError};
use crate::header::Header;
use crate::recording::{JointChannels, MIN_SAMPLES, Recording};
use crate::timing::Timing;

/// Median steps at and above this cannot be seconds \[s\].
const LONGEST_STEP_S: f64 = 0.5;
/// Median steps at and below this cannot be seconds \[s\].
const SHORTEST_STEP_S: f64 = 1e-6;
/// Share of samples that may repeat the stamp before them.
const REPEATED_SHARE: f64 = 0.01;
/// Bytes looked at to tell other formats.
const START_BYTES: u64 = 4096;

/// Reads a CSV file. `source` of the recording is the path.
///
/// # Errors
/// The file cannot be read, or any of the faults of [`read_csv_from`].
pub fn read_csv(path: impl AsRef<Path>) -> Result<Recording, RecordingError> {
    let path = path.as_ref();
    let source = path.display().to_string();
    if path.is_dir() {
        return Err(RecordingError::new(Fault::IsDirectory, &source));
    }
    let file = File::open(path).map_err(|error| {
        let fault = match error.kind() {
            io::ErrorKind::NotFound => Fault::NotFound,
            _ => Fault::Io { doing: "opened", error },
        };
        RecordingError::new(fault, &source)
    })?;
    read_csv_from(file, &source)
}

/// Reads CSV text; `source` names it in messages.
///
/// The first line names the columns: `t` in seconds, then `<joint>/<quantity>` where the quantity
/// is the part after the last slash and one of position, velocity, acceleration, effort, current,
/// voltage. Other columns are listed in [`Recording::ignored_columns`] and noted. Byte order marks,
/// CRLF, blank lines and spaces around fields are accepted. Samples that repeat the stamp before
/// them are dropped and noted.
///
/// # Errors
/// A file of another kind; a header without `t` or without a joint column, or with a column twice;
/// rows with another number of fields; fields that are not finite numbers; stamps that go
/// backwards, are not in seconds or repeat in more than 1 % of the samples; fewer than 8 samples.
pub fn read_csv_from(mut reader: impl Read, source: &str) -> Result<Recording, RecordingError> {
    let fault = |fault| RecordingError::new(fault, source);
    let io_fault = |error| fault(Fault::Io { doing: "read", error });
    let mut start = Vec::new();
    reader.by_ref().take(START_BYTES).read_to_end(&mut start).map_err(io_fault)?;
    if let Some(format) = other_format(&start) {
        return Err(fault(Fault::NotCsv { format }));
    }
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&start);
    // a line always ends with LF here, CR is trimmed off the last field: then the reader's line
    // count after a record is exactly one more than the record's line
    let mut rows = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .terminator(Terminator::Any(b'\n'))
        .buffer_capacity(1 << 16)
        .from_reader(start.chain(reader).chain(b"\n".as_slice()));
    let csv_fault = |error: csv::Error| match error.into_kind() {
        csv::ErrorKind::Io(error) => io_fault(error),
        other => io_fault(io::Error::other(format!("{other:?}"))),
    };

    let mut row = ByteRecord::new();
    loop {
        if !rows.read_byte_record(&mut row).map_err(csv_fault)? {
            return Err(fault(Fault::Empty));
        }
        if !is_blank(&row) {
            break;
        }
    }
    let line = rows.position().line() - 1;
    let columns = header_names(&row).ok_or_else(|| fault(Fault::HeaderNotUtf8).on_line(line))?;
    if columns.iter().any(|name| name.contains('\r')) {
        return Err(fault(Fault::NotCsv { format: "text whose lines end with CR alone" }));
    }
    if let Some(separator) = wrong_separator(&columns) {
        let below = rows.read_byte_record(&mut row).map_err(csv_fault)?;
        let decimal_commas = below && row.len() > 1;
        return Err(fault(Fault::WrongSeparator { separator, decimal_commas }).on_line(line));
    }
    let header = Header::new(columns, source, line)?;

    let mut table = Table::new(&header, source);
    while rows.read_byte_record(&mut row).map_err(csv_fault)? {
        if is_blank(&row) && header.columns.len() > 1 {
            continue;
        }
        let line = rows.position().line() - 1;
        if let Err(error) = table.push(&row, line) {
            // the first fault of the file is the one to tell
            let unclosed =
                || Some(fault(Fault::UnclosedQuote).on_line(unclosed_quote(&row, line)?));
            return Err(table.not_finite().or_else(unclosed).unwrap_or(error));
        }
    }
    table.finish()
}

/// The samples read so far.
struct Table<'a> {
    header: &'a Header,
    source: &'a str,
    time_s: Vec<f64>,
    /// One column per [`Header::channels`].
    values: Vec<Vec<f64>>,
    rows: usize,
    repeated: usize,
    first_repeated_s: f64,
    /// Line, column and text of the first value that is NaN or infinite.
    first_not_finite: Option<(u64, usize, String)>,
    not_finite: usize,
}

impl<'a> Table<'a> {
    fn new(header: &'a Header, source: &'a str) -> Self {
        Self {
            header,
            source,
            time_s: Vec::new(),
            values: vec![Vec::new(); header.channels.len()],
            rows: 0,
            repeated: 0,
            first_repeated_s: 0.0,
            first_not_finite: None,
            not_finite: 0,
        }
    }

    fn push(&mut self, row: &ByteRecord, line: u64) -> Result<(), RecordingError> {
        let fault = |fault| RecordingError::new(fault, self.source).on_line(line);
        let (expected, found) = (self.header.columns.len(), row.len());
        if found != expected {
            return Err(fault(Fault::RaggedRow { expected, found }));
        }
        self.rows += 1;
        let time_s = self.number(row, self.header.time, line)?;
        let fault = |fault| RecordingError::new(fault, self.source).on_line(line);
        let previous_s = self.time_s.last().copied();
        if let Some(previous_s) = previous_s.filter(|previous_s| time_s < *previous_s) {
            let fault = fault(Fault::TimeBackwards { previous_s, found_s: time_s });
            return Err(fault.in_column("t"));
        }
        let keep = previous_s != Some(time_s);
        if keep {
            // a stamp that is NaN would hide a step back; the file is refused at its end
            if time_s.is_finite() {
                self.time_s.push(time_s);
            }
        } else {
            if self.repeated == 0 {
                self.first_repeated_s = time_s;
            }
            self.repeated += 1;
        }
        for index in 0..self.header.channels.len() {
            let value = self.number(row, self.header.channels[index].column, line)?;
            if keep {
                self.values[index].push(value);
            }
        }
        Ok(())
    }

    /// The number in a field; NaN and infinities are counted.
    fn number(
        &mut self,
        row: &ByteRecord,
        column: usize,
        line: u64,
    ) -> Result<f64, RecordingError> {
        let field = row.get(column).unwrap_or_default().trim_ascii();
        let value = std::str::from_utf8(field).ok().and_then(|text| text.parse::<f64>().ok());
        let shown = || String::from_utf8_lossy(field).chars().take(40).collect::<String>();
        let Some(value) = value else {
            let fault = match field {
                [] => Fault::EmptyField,
                _ => Fault::NotANumber { text: shown() },
            };
            return Err(RecordingError::new(fault, self.source)
                .on_line(line)
                .in_column(&self.header.columns[column]));
        };
        if !value.is_finite() {
            self.not_finite += 1;
            self.first_not_finite.get_or_insert_with(|| (line, column, shown()));
        }
        Ok(value)
    }

    fn not_finite(&self) -> Option<RecordingError> {
        let (line, column, text) = self.first_not_finite.as_ref()?;
        let fault = Fault::NotFinite { text: text.clone(), count: self.not_finite };
        Some(
            RecordingError::new(fault, self.source)
                .on_line(*line)
                .in_column(&self.header.columns[*column]),
        )
    }

    fn finish(self) -> Result<Recording, RecordingError> {
        let fault = |fault| RecordingError::new(fault, self.source);
        if self.rows == 0 {
            return Err(fault(Fault::HeaderOnly));
        }
        if let Some(error) = self.not_finite() {
            return Err(error);
        }
        let (found, required) = (self.time_s.len(), MIN_SAMPLES);
        if self.rows < required {
            return Err(fault(Fault::TooFewSamples { found: self.rows, required }));
        }
        if self.repeated as f64 > REPEATED_SHARE * self.rows as f64 {
            let fault = fault(Fault::RepeatedStamps { count: self.repeated, total: self.rows });
            return Err(fault.in_column("t"));
        }
        if found < required {
            return Err(fault(Fault::TooFewSamples { found, required }));
        }
        let median_step_s = Timing::of(&self.time_s).median_step_s;
        if let Some((unit, factor)) = not_seconds(median_step_s) {
            let median_step = format!("{median_step_s:.3e}").parse().unwrap_or(median_step_s);
            let fault = fault(Fault::NotSeconds { median_step, unit, factor });
            return Err(fault.in_column("t"));
        }

        let mut notes = self.header.notes.clone();
        if self.repeated > 0 {
            notes.push(format!(
                "{} of {} samples repeated the time stamp before them and were dropped, the first \
                 at t = {} s",
                self.repeated, self.rows, self.first_repeated_s
            ));
        }
        let mut joints: Vec<JointChannels> =
            self.header.joints.iter().map(JointChannels::new).collect();
        for (channel, values) in self.header.channels.iter().zip(self.values) {
            *joints[channel.joint].channel_mut(channel.quantity) = Some(values);
        }
        let mut recording = Recording::new(self.source, self.time_s, joints)?;
        recording.notes = notes;
        recording.ignored_columns.clone_from(&self.header.ignored);
        Ok(recording)
    }
}

/// Unit of stamps with this median step, and the factor that makes them seconds.
fn not_seconds(median_step: f64) -> Option<(&'static str, f64)> {
    match median_step {
        step if step >= 5e5 => Some(("nanoseconds", 1e-9)),
        step if step >= 5e2 => Some(("microseconds", 1e-6)),
        1.0 => Some(("sample numbers or milliseconds", 1e-3)),
        step if step >= LONGEST_STEP_S => Some(("milliseconds", 1e-3)),
        step if step <= SHORTEST_STEP_S => Some(("days", 86_400.0)),
        _ => None,
    }
}

/// A line of white space only.
fn is_blank(row: &ByteRecord) -> bool {
    row.len() <= 1 && row.get(0).unwrap_or_default().trim_ascii().is_empty()
}

/// Line on which a row begins that contains line ends and ends on `line`.
fn unclosed_quote(row: &ByteRecord, line: u64) -> Option<u64> {
    let text = row.as_slice();
    let breaks = text.iter().filter(|byte| **byte == b'\n').count() as u64;
    // a quote that is never closed swallows the last line end too
    let swallowed = u64::from(text.last() == Some(&b'\n'));
    (breaks > 0).then(|| (line + swallowed).saturating_sub(breaks))
}

fn header_names(row: &ByteRecord) -> Option<Vec<String>> {
    row.iter()
        .map(|field| std::str::from_utf8(field).ok().map(|name| name.trim().to_owned()))
        .collect()
}

/// The separator of a header that is one field only because its separator is no comma.
fn wrong_separator(columns: &[String]) -> Option<&'static str> {
    let [only] = columns else { return None };
    [(';', "semicolons"), ('\t', "tabs"), ('|', "vertical bars"), (' ', "spaces")]
        .into_iter()
        .find_map(|(sign, name)| only.contains(sign).then_some(name))
}

/// Formats that are told apart by their first bytes.
fn other_format(start: &[u8]) -> Option<&'static str> {
    const FORMATS: [(&[u8], &str); 9] = [
        (b"\xff\xfe", "UTF-16 text"),
        (b"\xfe\xff", "UTF-16 text"),
        (b"\x89MCAP", "an MCAP file"),
        (b"#ROSBAG", "a ROS 1 bag"),
        (b"SQLite format 3", "an SQLite file (a ROS 2 bag?)"),
        (b"PAR1", "a Parquet file"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"PK\x03\x04", "a ZIP archive or a spreadsheet"),
        (b"\x89HDF", "an HDF5 file"),
    ];
    let known = FORMATS.into_iter().find(|(magic, _)| start.starts_with(magic));
    let binary = || start.contains(&0).then_some("binary data");
    known.map(|(_, format)| format).or_else(binary)
}

/// Writes a CSV file: `t` and the channels. Numbers have as many digits as bring back the same
/// value; notes and ignored columns are not written.
///
/// # Errors
/// The recording is inconsistent, or the file cannot be written.
pub fn write_csv(path: impl AsRef<Path>, recording: &Recording) -> Result<(), RecordingError> {
    let path = path.as_ref();
    recording.check()?;
    let fault = |doing| {
        move |error| RecordingError::new(Fault::Io { doing, error }, &path.display().to_string())
    };
    let file = File::create(path).map_err(fault("opened"))?;
    let mut writer = BufWriter::new(file);
    write_csv_to(&mut writer, recording)?;
    let written = writer.into_inner().map_err(io::IntoInnerError::into_error);
    if let Err(error) = written {
        // half a recording would be read as a whole one
        let _ = fs::remove_file(path);
        return Err(fault("written")(error));
    }
    Ok(())
}

/// Writes CSV text, as [`write_csv`].
///
/// # Errors
/// The recording is inconsistent, or the writer fails.
pub fn write_csv_to(writer: impl Write, recording: &Recording) -> Result<(), RecordingError> {
    recording.check()?;
    let channels: Vec<(String, &[f64])> = recording
        .joints
        .iter()
        .flat_map(|joint| {
            let named = |(quantity, values)| (format!("{}/{quantity}", joint.name), values);
            joint.channels().map(named)
        })
        .collect();
    let columns: Vec<&[f64]> = [recording.time_s.as_slice()]
        .into_iter()
        .chain(channels.iter().map(|(_, values)| *values))
        .collect();
    let fault =
        |error| RecordingError::new(Fault::Io { doing: "written", error }, &recording.source);

    let mut out = BufWriter::with_capacity(1 << 16, writer);
    let mut names = csv::Writer::from_writer(Vec::new());
    let header = std::iter::once("t").chain(channels.iter().map(|(name, _)| name.as_str()));
    names.write_record(header).map_err(|error| fault(error.into()))?;
    let names = names.into_inner().map_err(|error| fault(error.into_error()))?;
    let mut write_all = || -> io::Result<()> {
        out.write_all(&names)?;
        for row in 0..recording.len() {
            for (index, column) in columns.iter().enumerate() {
                let separator = if index == 0 { "" } else { "," };
                write!(out, "{separator}{}", column[row])?;
            }
            out.write_all(b"\n")?;
        }
        out.flush()
    };
    write_all().map_err(fault)
}
