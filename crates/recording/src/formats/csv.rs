//! Comma-separated text: a column `t` \[s\], then `<joint>/<quantity>`. Other separators are recognised.

use std::io::{self, BufWriter, Read, Write};

use ::csv::{ByteRecord, ReaderBuilder, Terminator};
use rayon::prelude::*;

use super::format::{ColumnRequest, EXPORT_CSV, Encoded, FileStart, Format, Input, Support};
use super::separator::Separator;
use crate::error::{Fault, RecordingError};
use crate::raw::{RawColumn, RawColumns};
use crate::recording::Recording;

/// Bytes of a block that is read at a time.
const BLOCK_BYTES: u64 = 8 << 20;
/// Bytes read at a time to complete the last line of a block.
const LINE_BYTES: u64 = 1 << 12;
/// Bytes that hold the header and the first row.
const FIRST_BYTES: u64 = 1 << 16;
/// What UTF-8 text may start with.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// Bytes of a piece of a block; pieces are parsed in parallel.
const PIECE_BYTES: usize = 1 << 18;

/// Comma-separated text.
#[derive(Debug, Clone, Copy)]
pub struct Csv;

impl Format for Csv {
    fn name(&self) -> &'static str {
        "CSV"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["csv"]
    }

    fn support(&self) -> Support {
        Support::ReadWrite
    }

    /// Never: text has no magic bytes, CSV is what no other format recognises.
    fn is_it(&self, _start: &FileStart<'_>) -> bool {
        false
    }

    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        read_columns(input.into_reader(), request)
    }

    fn write(&self, recording: &Recording) -> Result<Encoded, RecordingError> {
        let mut bytes = Vec::new();
        write_csv_to(&mut bytes, recording)?;
        Ok(Encoded { bytes, omitted: Vec::new() })
    }
}

/// Reads the wanted columns of CSV text; the others may hold anything.
pub(crate) fn read_columns(
    mut reader: impl Read,
    request: &ColumnRequest<'_>,
) -> Result<RawColumns, RecordingError> {
    let io_fault =
        |error| RecordingError::new(Fault::Io { doing: "read", error }, request.source());
    let mut first = read_block(&mut reader, BLOCK_BYTES).map_err(io_fault)?;
    let start = first.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&first);
    let Some(separator) = Separator::of(start) else {
        return read_comma_separated(first.as_slice().chain(reader), request);
    };
    reader.read_to_end(&mut first).map_err(io_fault)?;
    let all = first.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&first);
    let (text, decimal_commas) = separator.to_commas(all);
    let mut raw = read_comma_separated(text.as_slice(), request)?;
    raw.notes.push(separator.note(decimal_commas));
    Ok(raw)
}

/// Text of the first row of a column; none where there is no such column.
pub(crate) fn first_text(mut reader: impl Read, column: &str) -> io::Result<Option<String>> {
    let first = read_block(&mut reader, FIRST_BYTES)?;
    let start = first.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&first);
    let text = Separator::of(start).map_or_else(|| start.to_vec(), |of| of.to_commas(start).0);
    let mut rows = rows_of(text.as_slice())
        .into_byte_records()
        .filter(|row| !matches!(row, Ok(row) if is_blank(row)));
    let (header, row) = (rows.next().transpose()?, rows.next().transpose()?);
    let place = header
        .and_then(|row| header_names(&row))
        .and_then(|names| names.iter().position(|name| name == column));
    let field = place.zip(row).and_then(|(place, row)| row.get(place).map(<[u8]>::to_vec));
    Ok(field.and_then(|field| Some(String::from_utf8(field).ok()?.trim().to_owned())))
}

fn read_comma_separated(
    mut reader: impl Read,
    request: &ColumnRequest<'_>,
) -> Result<RawColumns, RecordingError> {
    let source = request.source();
    let fault = |fault| RecordingError::new(fault, source);
    let io_fault = |error| fault(Fault::Io { doing: "read", error });
    let first = read_block(&mut reader, BLOCK_BYTES).map_err(io_fault)?;
    let start = first.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&first);
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
        let found = "text with CR line ends";
        return Err(fault(Fault::NotCsv { found, advice: EXPORT_CSV }));
    }
    let wanted = request.wanted(&columns, line)?;
    let mut table = Table::new(columns, &wanted, source);
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
fn rows_of<'a>(text: impl Read + 'a) -> ::csv::Reader<impl Read + 'a> {
    // a line always ends with LF here, CR is trimmed off the last field: then the reader's line
    // count after a record is exactly one more than the record's line
    ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .terminator(Terminator::Any(b'\n'))
        .buffer_capacity(1 << 16)
        .from_reader(text.chain(b"\n".as_slice()))
}

fn csv_fault(error: ::csv::Error, source: &str) -> RecordingError {
    let error = match error.into_kind() {
        ::csv::ErrorKind::Io(error) => error,
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
    fn new(names: Vec<String>, wanted: &[bool], source: &'a str) -> Self {
        let columns = names
            .into_iter()
            .zip(wanted)
            .map(|(name, wanted)| RawColumn { name, values: wanted.then(Vec::new) })
            .collect();
        Self { source, raw: RawColumns { columns, ..RawColumns::new(source) } }
    }

    /// Adds all rows, of which so many lines stand before the first.
    fn push_all<R: Read>(
        &mut self,
        rows: &mut ::csv::Reader<R>,
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
    /// Lines that hold anything but numbers are left to [`Self::push_all`], which knows what to
    /// say.
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
            let value = match field {
                // missing
                [] => Some(f64::NAN),
                _ => std::str::from_utf8(field).ok().and_then(|text| text.parse::<f64>().ok()),
            };
            let shown = || String::from_utf8_lossy(field).chars().take(40).collect::<String>();
            let Some(value) = value else {
                return Err(fault(Fault::NotANumber { text: shown() }).in_column(&column.name));
            };
            if !value.is_finite() && !self.raw.not_finite.iter().any(|first| first.1 == number) {
                self.raw.not_finite.push((index, number, shown()));
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

/// Writes CSV text: `t` \[s\] and a column `<joint>/<quantity>` per channel, numbers with as many
/// digits as restore the same value. Notes and ignored columns are not written.
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
    let mut names = ::csv::Writer::from_writer(Vec::new());
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
