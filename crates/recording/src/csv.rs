//! Reads comma-separated text: our own column names, those of PlotJuggler, or any with a mapping.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Terminator};
use rayon::prelude::*;

use crate::error::{Fault, RecordingError};
use crate::header::Header;
use crate::mapping::Mapping;
use crate::raw::{RawColumn, RawColumns};
use crate::recording::Recording;

/// Bytes read at a time,
const BLOCK_BYTES: u64 = 8 << 20;
/// bytes looked at together for the end of the last line,
const LINE_BYTES: u64 = 1 << 12;
/// and bytes of the pieces that processors share.
const PIECE_BYTES: usize = 1 << 18;
/// Bytes looked at to tell other formats.
pub(crate) const START_BYTES: u64 = 4096;

/// Reads a CSV file. `source` of the recording is the path.
///
/// # Errors
/// The file cannot be read, or any of the faults of [`read_csv_from`].
pub fn read_csv(path: impl AsRef<Path>) -> Result<Recording, RecordingError> {
    let (file, source) = open(path.as_ref())?;
    read_csv_from(file, &source)
}

/// Reads a CSV file whose columns a mapping explains.
///
/// # Errors
/// The file cannot be read, or any of the faults of [`read_csv_mapped_from`].
pub fn read_csv_mapped(
    path: impl AsRef<Path>,
    mapping: &Mapping,
) -> Result<Recording, RecordingError> {
    let (file, source) = open(path.as_ref())?;
    read_csv_mapped_from(file, &source, mapping)
}

pub(crate) fn open(path: &Path) -> Result<(File, String), RecordingError> {
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
    Ok((file, source))
}

/// Reads CSV text; `source` names it in messages.
///
/// The first line names the columns: `t` in seconds, then `<joint>/<quantity>` where the quantity
/// is the part after the last slash and a name of a [`Quantity`](crate::Quantity). Without a column
/// `t`, the names that PlotJuggler writes are understood: `__time` or `time`, then
/// `/joint_states/<joint>/<quantity>` or another topic. Other columns are listed in
/// [`Recording::ignored_columns`] and noted. Byte order marks, CRLF, blank lines and spaces around
/// fields are accepted. What is repaired on reading is listed in [`Recording::findings`].
///
/// # Errors
/// A file of another kind; a header without time stamps or without a joint column, or with a column
/// twice; rows with another number of fields; fields that are not numbers; infinite values, and NaN
/// beyond what is filled in; stamps that go backwards, are not in seconds or repeat in more than
/// 1 % of the samples; fewer than 8 samples; positions that their velocities show to be in degrees
/// or millimetres.
pub fn read_csv_from(reader: impl Read, source: &str) -> Result<Recording, RecordingError> {
    let mut header = None;
    let raw = read_columns(reader, source, |columns, line| {
        let known = header.insert(Header::new(columns.to_vec(), source, line)?);
        Ok(known.is_read())
    })?;
    match header {
        Some(header) => header.draft(raw).finish(),
        None => Err(RecordingError::new(Fault::Empty, source)),
    }
}

/// Reads CSV text whose columns a mapping explains; `source` names it in messages. Columns that the
/// mapping does not mention may hold anything.
///
/// # Errors
/// A mapping that does not fit the columns, or any of the faults of [`read_csv_from`].
pub fn read_csv_mapped_from(
    reader: impl Read,
    source: &str,
    mapping: &Mapping,
) -> Result<Recording, RecordingError> {
    let raw = read_columns(reader, source, |columns, _| mapping.reads(columns, source))?;
    mapping.apply(&raw)
}

/// Reads the columns that `choose` marks, given the names of all and the line of the header.
fn read_columns(
    mut reader: impl Read,
    source: &str,
    choose: impl FnOnce(&[String], u64) -> Result<Vec<bool>, RecordingError>,
) -> Result<RawColumns, RecordingError> {
    let fault = |fault| RecordingError::new(fault, source);
    let io_fault = |error| fault(Fault::Io { doing: "read", error });
    let first = read_block(&mut reader, BLOCK_BYTES).map_err(io_fault)?;
    if let Some(format) = other_format(&first[..first.len().min(START_BYTES as usize)]) {
        return Err(fault(Fault::NotCsv { format }));
    }
    let start = first.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&first);
    let mut rows = rows_of(start.chain(&mut reader));
    let mut row = ByteRecord::new();
    loop {
        if !rows.read_byte_record(&mut row).map_err(|e| csv_fault(e, source))? {
            return Err(fault(Fault::Empty));
        }
        if !is_blank(&row) {
            break;
        }
    }
    let (line, body) = (rows.position().line() - 1, rows.position().byte() as usize);
    let columns = header_names(&row).ok_or_else(|| fault(Fault::HeaderNotUtf8).on_line(line))?;
    if columns.iter().any(|name| name.contains('\r')) {
        return Err(fault(Fault::NotCsv { format: "text whose lines end with CR alone" }));
    }
    if let Some(separator) = wrong_separator(&columns) {
        let below = rows.read_byte_record(&mut row).map_err(|e| csv_fault(e, source))?;
        let decimal_commas = below && row.len() > 1;
        return Err(fault(Fault::WrongSeparator { separator, decimal_commas }).on_line(line));
    }
    let chosen = choose(&columns, line)?;
    let mut table = Table::new(columns, &chosen, source);
    if start.contains(&b'"') {
        // quotes may hold line ends: one row after the other
        table.push_all(&mut rows, 0)?;
    } else {
        drop(rows);
        let mut block = start[body.min(start.len())..].to_vec();
        let mut lines = line;
        while !block.is_empty() {
            if block.contains(&b'"') {
                table.push_all(&mut rows_of(block.chain(&mut reader)), lines)?;
                break;
            }
            lines += table.push_block(&block, lines)?;
            block = read_block(&mut reader, BLOCK_BYTES).map_err(io_fault)?;
        }
    }
    if table.raw.lines.is_empty() {
        return Err(fault(Fault::HeaderOnly));
    }
    Ok(table.raw)
}

/// So many bytes and what is left of their last line; less at the end, nothing behind it.
fn read_block(reader: &mut impl Read, bytes: u64) -> io::Result<Vec<u8>> {
    let mut block = Vec::with_capacity(bytes as usize + 1);
    reader.by_ref().take(bytes).read_to_end(&mut block)?;
    while (block.len() as u64) >= bytes && block.last() != Some(&b'\n') {
        if reader.by_ref().take(LINE_BYTES).read_to_end(&mut block)? == 0 {
            break;
        }
    }
    Ok(block)
}

/// Rows of text that is at the beginning of a line.
fn rows_of<'a>(text: impl Read + 'a) -> csv::Reader<impl Read + 'a> {
    // a line always ends with LF here, CR is trimmed off the last field: then the reader's line
    // count after a record is exactly one more than the record's line
    ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .terminator(Terminator::Any(b'\n'))
        .buffer_capacity(1 << 16)
        .from_reader(text.chain(b"\n".as_slice()))
}

fn csv_fault(error: csv::Error, source: &str) -> RecordingError {
    let error = match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    };
    RecordingError::new(Fault::Io { doing: "read", error }, source)
}

/// The rows read so far.
struct Table<'a> {
    source: &'a str,
    raw: RawColumns,
}

impl<'a> Table<'a> {
    fn new(names: Vec<String>, chosen: &[bool], source: &'a str) -> Self {
        let columns = names
            .into_iter()
            .zip(chosen)
            .map(|(name, chosen)| RawColumn { name, values: chosen.then(Vec::new) })
            .collect();
        Self { source, raw: RawColumns { columns, ..RawColumns::new(source) } }
    }

    /// Adds all rows, of which so many lines stand before the first.
    fn push_all<R: Read>(
        &mut self,
        rows: &mut csv::Reader<R>,
        lines_before: u64,
    ) -> Result<(), RecordingError> {
        let mut row = ByteRecord::new();
        while rows.read_byte_record(&mut row).map_err(|e| csv_fault(e, self.source))? {
            if is_blank(&row) && self.raw.columns.len() > 1 {
                continue;
            }
            let line = lines_before + rows.position().line() - 1;
            if let Err(error) = self.push(&row, line) {
                let unclosed = unclosed_quote(&row, line).map(|line| {
                    RecordingError::new(Fault::UnclosedQuote, self.source).on_line(line)
                });
                return Err(unclosed.unwrap_or(error));
            }
        }
        Ok(())
    }

    /// Adds the rows of whole lines without quotes, on all processors; gives the number of lines.
    ///
    /// Lines that hold anything but numbers are left to [`Self::push_all`], which knows what to say.
    fn push_block(&mut self, block: &[u8], lines_before: u64) -> Result<u64, RecordingError> {
        let pieces = pieces_of(block);
        let read: Vec<(u64, Option<Piece>)> = pieces
            .par_iter()
            .map(|piece| {
                let lines = piece.iter().filter(|byte| **byte == b'\n').count() as u64;
                (lines, Piece::of(piece, &self.raw.columns))
            })
            .collect();
        let mut lines = 0;
        for (text, (count, piece)) in pieces.iter().zip(read) {
            match piece {
                Some(piece) => {
                    let columns = self.raw.columns.iter_mut().filter_map(|c| c.values.as_mut());
                    for (values, new) in columns.zip(piece.columns) {
                        values.extend(new);
                    }
                    let first = lines_before + lines + 1;
                    self.raw.lines.extend(piece.lines.iter().map(|line| first + u64::from(*line)));
                }
                None => self.push_all(&mut rows_of(*text), lines_before + lines)?,
            }
            lines += count;
        }
        Ok(lines)
    }

    fn push(&mut self, row: &ByteRecord, line: u64) -> Result<(), RecordingError> {
        let fault = |fault| RecordingError::new(fault, self.source).on_line(line);
        let (expected, found) = (self.raw.columns.len(), row.len());
        if found != expected {
            return Err(fault(Fault::RaggedRow { expected, found }));
        }
        let index = self.raw.lines.len();
        for (number, column) in self.raw.columns.iter_mut().enumerate() {
            let Some(values) = &mut column.values else { continue };
            let field = row.get(number).unwrap_or_default().trim_ascii();
            let value = std::str::from_utf8(field).ok().and_then(|text| text.parse::<f64>().ok());
            let shown = || String::from_utf8_lossy(field).chars().take(40).collect::<String>();
            let Some(value) = value else {
                let kind = match field {
                    [] => Fault::EmptyField,
                    _ => Fault::NotANumber { text: shown() },
                };
                return Err(fault(kind).in_column(&column.name));
            };
            if !value.is_finite() {
                self.raw.first_not_finite.get_or_insert_with(|| (index, number, shown()));
            }
            values.push(value);
        }
        self.raw.lines.push(line);
        Ok(())
    }
}

/// Lines cut into pieces for the processors.
fn pieces_of(block: &[u8]) -> Vec<&[u8]> {
    let mut pieces = Vec::new();
    let mut rest = block;
    while !rest.is_empty() {
        let from = PIECE_BYTES.min(rest.len());
        let end = rest[from..].iter().position(|byte| *byte == b'\n');
        let (piece, others) = rest.split_at(end.map_or(rest.len(), |end| from + end + 1));
        pieces.push(piece);
        rest = others;
    }
    pieces
}

/// Rows of some lines, each with as many finite numbers as there are columns.
struct Piece {
    /// of the columns that are read
    columns: Vec<Vec<f64>>,
    /// counted from the first of the piece
    lines: Vec<u32>,
}

impl Piece {
    /// None if there is anything else in the lines.
    fn of(text: &[u8], columns: &[RawColumn]) -> Option<Self> {
        let text = std::str::from_utf8(text).ok()?;
        let wanted: Vec<bool> = columns.iter().map(|column| column.values.is_some()).collect();
        let count = wanted.iter().filter(|wanted| **wanted).count();
        let mut piece = Self { columns: vec![Vec::new(); count], lines: Vec::new() };
        for (number, line) in text.split_terminator('\n').enumerate() {
            if line.trim_ascii().is_empty() {
                // of one column it is an empty field
                if wanted.len() > 1 {
                    continue;
                }
                return None;
            }
            let mut fields = line.split(',');
            let mut values = piece.columns.iter_mut();
            for wanted in &wanted {
                let field = fields.next()?;
                if *wanted {
                    let value = field.trim_ascii().parse::<f64>().ok()?;
                    if !value.is_finite() {
                        return None;
                    }
                    values.next()?.push(value);
                }
            }
            if fields.next().is_some() {
                return None;
            }
            piece.lines.push(u32::try_from(number).ok()?);
        }
        Some(piece)
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
pub(crate) fn other_format(start: &[u8]) -> Option<&'static str> {
    const FORMATS: [(&[u8], &str); 11] = [
        (b"\xff\xfe", "UTF-16 text"),
        (b"\xfe\xff", "UTF-16 text"),
        (b"\x89MCAP", "an MCAP file"),
        (b"#ROSBAG", "a ROS 1 bag"),
        (b"SQLite format 3", "an SQLite file (a ROS 2 bag?)"),
        (b"PAR1", "a Parquet file"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"MATLAB 5.0 MAT-file", "a MATLAB file"),
        (b"\x93NUMPY", "a NumPy file"),
        (b"PK\x03\x04", "a ZIP archive or a spreadsheet"),
        (b"\x89HDF", "an HDF5 file"),
    ];
    let known = FORMATS.into_iter().find(|(magic, _)| start.starts_with(magic));
    let binary = || start.contains(&0).then_some("binary data");
    known.map(|(_, format)| format).or_else(binary)
}
