//! MATLAB files of versions 5 to 7: numeric variables, and those in structures of one element.
//!
//! Elements are a type, a length and data, in eight-byte steps; variables of version 7 are compressed by zlib. Read here
//! rather than by a crate: `matrw` 0.1 refuses files of SciPy and panics on compressed data that end early.
//! Source: MathWorks, MAT-File Format, level 5.

use std::io::Read as _;

use flate2::read::ZlibDecoder;

use super::arrays::{Array, Content, by_rows, columns, with_short_names};
use super::format::{ColumnRequest, FileStart, Format, Input, Support};
use crate::error::{Fault, RecordingError};
use crate::raw::RawColumns;

/// MATLAB files of versions 5 to 7.
#[derive(Debug, Clone, Copy)]
pub struct Matlab;

/// Bytes before the first element.
const HEADER_BYTES: usize = 128;
/// Types of elements.
const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;
/// Longest variable after decompression \[bytes\].
const LONGEST: u64 = 1 << 32;
/// Deepest structure in a structure that is read.
const DEEPEST: usize = 4;

impl Format for Matlab {
    fn name(&self) -> &'static str {
        "MATLAB"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["mat"]
    }

    fn support(&self) -> Support {
        Support::Read
    }

    /// Text of its own, then version and byte order; version 7.3 has the text as well, and is HDF5.
    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(b"MATLAB 5.0 MAT-file")
            && start.bytes.get(126..128).is_some_and(|order| order == b"IM" || order == b"MI")
    }

    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let fault = |fault| RecordingError::new(fault, request.source());
        let mut bytes = Vec::new();
        input
            .into_reader()
            .read_to_end(&mut bytes)
            .map_err(|error| fault(Fault::Io { doing: "read", error }))?;
        let (arrays, ended) = variables(&bytes);
        let read = columns(with_short_names(arrays), request);
        let mut raw = match (read, &ended) {
            // the variables that are missing may be those that the file lacks
            (Err(_), Some(what)) => {
                return Err(fault(Fault::Broken { format: "MATLAB", what: what.clone() }));
            }
            (read, _) => read?,
        };
        raw.notes.extend(
            ended.map(|why| format!("truncated file ({why}); variables up to that point are read")),
        );
        Ok(raw)
    }
}

/// The variables of a file, and why reading ended before its end.
fn variables(bytes: &[u8]) -> (Vec<Array>, Option<String>) {
    let mut arrays = Vec::new();
    let is_big = bytes.get(126..128) == Some(b"MI");
    let mut elements = Elements { bytes: bytes.get(HEADER_BYTES..).unwrap_or_default(), is_big };
    while !elements.bytes.is_empty() {
        let at = bytes.len() - elements.bytes.len();
        let read =
            elements.next().and_then(|(kind, data)| variable(kind, data, is_big, &mut arrays));
        if let Err(what) = read {
            return (arrays, Some(format!("at byte {at}, {what}")));
        }
    }
    (arrays, None)
}

/// Adds the arrays of one variable.
fn variable(kind: u32, data: &[u8], is_big: bool, arrays: &mut Vec<Array>) -> Result<(), String> {
    match kind {
        MATRIX => matrix(data, is_big, "", 0, arrays),
        COMPRESSED => {
            let mut inside = Vec::new();
            let decoder = ZlibDecoder::new(data).take(LONGEST);
            { decoder }.read_to_end(&mut inside).map_err(|error| error.to_string())?;
            let (kind, data) = Elements { bytes: &inside, is_big }.next()?;
            match kind {
                MATRIX => matrix(data, is_big, "", 0, arrays),
                other => Err(format!("element of type {other} in a compressed variable")),
            }
        }
        other => Err(format!("element of type {other}, expected a variable")),
    }
}

/// Elements one after the other.
struct Elements<'a> {
    bytes: &'a [u8],
    is_big: bool,
}

impl<'a> Elements<'a> {
    fn u32(&self, at: usize) -> Result<u32, String> {
        let bytes = self.bytes.get(at..at + 4).ok_or("the file ends")?;
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        Ok(if self.is_big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// Type and data of the next element.
    fn next(&mut self) -> Result<(u32, &'a [u8]), String> {
        let first = self.u32(0)?;
        let (kind, from, length): (u32, usize, usize) = match first >> 16 {
            0 => (first, 8, self.u32(4)? as usize),
            // small elements have both in four bytes, and at most four of data
            length => (first & 0xffff, 4, length as usize),
        };
        let data = self.bytes.get(from..from.saturating_add(length)).ok_or("the file ends")?;
        let whole = match (from, kind) {
            (4, _) => 8,
            // compressed data are not padded
            (_, COMPRESSED) => from + length,
            _ => (from + length).next_multiple_of(8),
        };
        self.bytes = self.bytes.get(whole..).unwrap_or_default();
        Ok((kind, data))
    }

    /// Numbers of the next element.
    fn numbers(&mut self) -> Result<Vec<f64>, String> {
        let (kind, data) = self.next()?;
        numbers(kind, data, self.is_big)
    }

    /// Text of the next element, which has a byte per letter.
    fn text(&mut self) -> Result<String, String> {
        let (_, data) = self.next()?;
        Ok(String::from_utf8_lossy(data).trim_end_matches('\0').to_owned())
    }
}

fn numbers(kind: u32, data: &[u8], is_big: bool) -> Result<Vec<f64>, String> {
    macro_rules! of {
        ($type:ty) => {{
            let items = data.chunks_exact(size_of::<$type>());
            let read = |item: &[u8]| {
                let mut bytes = [0; size_of::<$type>()];
                bytes.copy_from_slice(item);
                let value = if is_big {
                    <$type>::from_be_bytes(bytes)
                } else {
                    <$type>::from_le_bytes(bytes)
                };
                value as f64
            };
            items.map(read).collect()
        }};
    }
    Ok(match kind {
        1 => of!(i8),
        2 => of!(u8),
        3 => of!(i16),
        // 17 is UTF-16
        4 | 17 => of!(u16),
        5 => of!(i32),
        6 => of!(u32),
        7 => of!(f32),
        9 => of!(f64),
        12 => of!(i64),
        13 => of!(u64),
        // 16 is UTF-8
        16 => of!(u8),
        other => return Err(format!("numbers of type {other}")),
    })
}

/// Classes of variables.
const CELL: u32 = 1;
const STRUCTURE: u32 = 2;
const TEXT: u32 = 4;
const FIRST_NUMERIC: u32 = 6;

/// Adds the arrays of a variable; those of fields are named `<structure>.<field>`.
fn matrix(
    data: &[u8],
    is_big: bool,
    within: &str,
    depth: usize,
    arrays: &mut Vec<Array>,
) -> Result<(), String> {
    if data.is_empty() {
        return Ok(());
    }
    let mut parts = Elements { bytes: data, is_big };
    let flags = parts.numbers()?;
    let flags = flags.first().copied().unwrap_or(0.0) as u32;
    let (class, is_complex) = (flags & 0xff, flags & 0x0800 != 0);
    let shape: Vec<usize> = parts.numbers()?.iter().map(|length| *length as usize).collect();
    let own = parts.text()?;
    let name = match (within, own.as_str()) {
        ("", own) => own.to_owned(),
        (within, "") => within.to_owned(),
        (within, own) => format!("{within}.{own}"),
    };
    let count = shape
        .iter()
        .try_fold(1_usize, |all, n| all.checked_mul(*n))
        .ok_or("its shape is too large")?;
    let mut add = |content| arrays.push(Array { name: name.clone(), content });
    match class {
        STRUCTURE if count == 1 && depth < DEEPEST => {
            let length = parts.numbers()?.first().copied().unwrap_or(0.0) as usize;
            let (_, names) = parts.next()?;
            if length == 0 {
                return Err("names of fields without length".to_owned());
            }
            for field in names.chunks(length) {
                let field = String::from_utf8_lossy(field);
                let field = field.split('\0').next().unwrap_or_default().to_owned();
                let (kind, data) = parts.next()?;
                if kind != MATRIX {
                    return Err(format!("field `{field}` of type {kind}"));
                }
                let path = if name.is_empty() { field } else { format!("{name}.{field}") };
                matrix(data, is_big, &path, depth + 1, arrays)?;
            }
        }
        CELL => {
            let mut inside = Vec::new();
            for _ in 0..count {
                if parts.bytes.is_empty() {
                    break;
                }
                let (_, data) = parts.next()?;
                if depth < DEEPEST {
                    matrix(data, is_big, "", depth + 1, &mut inside)?;
                }
            }
            let texts: Option<Vec<String>> = inside
                .into_iter()
                .map(|cell| match cell.content {
                    Content::Texts(texts) => texts.into_iter().next(),
                    _ => None,
                })
                .collect();
            add(texts.map_or_else(|| Content::Other("cells".to_owned()), Content::Texts));
        }
        TEXT => {
            let letters = parts.numbers()?;
            // rows of equal length, the first letters of all rows first
            let rows = shape.first().copied().unwrap_or(1).clamp(1, letters.len().max(1));
            let text = |row: usize| -> String {
                letters
                    .iter()
                    .skip(row)
                    .step_by(rows)
                    .filter_map(|letter| char::from_u32(*letter as u32))
                    .collect()
            };
            add(Content::Texts((0..rows).map(text).collect()));
        }
        FIRST_NUMERIC..=15 if is_complex => add(Content::Other("complex numbers".to_owned())),
        FIRST_NUMERIC..=15 => {
            let values = parts.numbers()?;
            if values.len() != count {
                return Err(format!("`{name}` has {} values, expected {count}", values.len()));
            }
            let values = by_rows(&values, &shape);
            add(Content::Numbers(shape, values));
        }
        _ => add(Content::Other(format!("a variable of class {class}"))),
    }
    Ok(())
}
