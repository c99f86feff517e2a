//! NumPy archives: arrays by name.
//!
//! The header of an array is one line of Python, read here: the crate `npyz` 0.9 brings a generator of parsers for it.
//! Source: NumPy Enhancement Proposal 1.

use std::io::{Cursor, Read as _, Write as _};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::arrays::{Array, Content, by_rows, columns};
use super::format::{ColumnRequest, Encoded, FileStart, Format, Input, Support};
use crate::error::{Fault, RecordingError};
use crate::raw::RawColumns;
use crate::recording::Recording;

/// NumPy archives with the columns of CSV, or with arrays of samples by joints.
#[derive(Debug, Clone, Copy)]
pub struct Npz;

const MAGIC: &[u8] = b"\x93NUMPY";

impl Format for Npz {
    fn name(&self) -> &'static str {
        "NumPy"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["npz"]
    }

    fn support(&self) -> Support {
        Support::ReadWrite
    }

    /// A ZIP archive, which its first file or the extension distinguishes from others.
    fn is_it(&self, start: &FileStart<'_>) -> bool {
        let first =
            start.bytes.get(26..28).map_or(0, |b| usize::from(u16::from_le_bytes([b[0], b[1]])));
        start.bytes.starts_with(b"PK\x03\x04")
            && (start.has_extension(self.extensions())
                || start.bytes.get(30..30 + first).is_some_and(|name| name.ends_with(b".npy")))
    }

    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let source = request.source();
        let broken =
            |what: String| RecordingError::new(Fault::Broken { format: "NumPy", what }, source);
        let file = input
            .into_file()
            .map_err(|error| RecordingError::new(Fault::Io { doing: "read", error }, source))?;
        let mut archive = ZipArchive::new(file).map_err(|error| broken(error.to_string()))?;
        let mut arrays = Vec::new();
        for index in 0..archive.len() {
            let mut entry = archive.by_index(index).map_err(|error| broken(error.to_string()))?;
            let name = entry.name().map_err(|error| broken(error.to_string()))?.into_owned();
            let Some(name) = name.strip_suffix(".npy") else { continue };
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).map_err(|error| broken(format!("`{name}`: {error}")))?;
            let content = array(&bytes).map_err(|what| broken(format!("`{name}`: {what}")))?;
            arrays.push(Array { name: name.to_owned(), content });
        }
        columns(arrays, request)
    }

    /// Columns as in CSV, one array each.
    fn write(&self, recording: &Recording) -> Result<Encoded, RecordingError> {
        recording.check()?;
        let fault = |error: std::io::Error| {
            RecordingError::new(Fault::Io { doing: "written", error }, &recording.source)
        };
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        let mut add = |name: &str, values: &[f64]| -> std::io::Result<()> {
            archive.start_file(format!("{name}.npy"), options)?;
            archive.write_all(&npy(values))
        };
        add("t", &recording.time_s).map_err(fault)?;
        for joint in &recording.joints {
            for (quantity, values) in joint.channels() {
                add(&format!("{}/{quantity}", joint.name), values).map_err(fault)?;
            }
        }
        let bytes = archive.finish().map_err(|error| fault(error.into()))?.into_inner();
        Ok(Encoded { bytes, omitted: Vec::new() })
    }
}

/// A column as the bytes of an array.
fn npy(values: &[f64]) -> Vec<u8> {
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", values.len());
    // magic, version and length are 10 bytes; all of it is a multiple of 64
    let length = (header.len() + 11).next_multiple_of(64) - 10;
    header.push_str(&" ".repeat(length - 1 - header.len()));
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Reads the bytes of an array.
fn array(bytes: &[u8]) -> Result<Content, String> {
    let version =
        bytes.strip_prefix(MAGIC).and_then(|rest| rest.first()).ok_or("it is no array")?;
    let (from, length) = match version {
        1 => (10, bytes.get(8..10).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])))),
        _ => {
            let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            (12, length.map(|length| length as usize))
        }
    };
    let length = length.ok_or("it is truncated")?;
    let header = bytes.get(from..from + length).ok_or("it is truncated")?;
    let header = String::from_utf8_lossy(header);
    let after = |key: &str| {
        let (_, rest) = header.split_once(&format!("'{key}'"))?;
        Some(rest.trim_start().strip_prefix(':')?.trim_start().to_owned())
    };
    let kind = after("descr").ok_or("its header has no type")?;
    let Some(kind) = kind.strip_prefix('\'').and_then(|kind| kind.split('\'').next()) else {
        return Ok(Content::Other("records".to_owned()));
    };
    let shape = after("shape").ok_or("its header has no shape")?;
    let shape = shape.trim_start_matches('(').split(')').next().unwrap_or_default();
    let shape: Vec<usize> = shape
        .split(',')
        .map(str::trim)
        .filter(|length| !length.is_empty())
        .map(|length| length.trim_end_matches('L').parse().map_err(|_| "its shape is not known"))
        .collect::<Result<_, _>>()?;
    let by_columns = after("fortran_order").is_some_and(|order| order.starts_with("True"));
    let data = &bytes[from + length..];
    let count = shape
        .iter()
        .try_fold(1_usize, |all, n| all.checked_mul(*n))
        .ok_or("its shape is too large")?;
    let (order, letter, size) =
        parts(kind).ok_or_else(|| format!("its type `{kind}` is not known"))?;
    let is_big = order == '>';
    let width = if letter == 'U' { 4 * size } else { size };
    if letter == 'O' {
        return Ok(Content::Other("objects".to_owned()));
    }
    if width == 0 || count > data.len() / width {
        let expected = count.saturating_mul(width);
        return Err(format!("it has {} bytes, expected {expected}", data.len()));
    }
    let items = data.chunks_exact(width).take(count);
    if letter == 'U' {
        let text = |item: &[u8]| -> String {
            let letters = item.chunks_exact(4).map(|b| u32::from_le_bytes(in_order(b, is_big)));
            letters.filter_map(char::from_u32).filter(|letter| *letter != '\0').collect()
        };
        return Ok(Content::Texts(items.map(text).collect()));
    }
    let Some(values) = items.map(|item| number(letter, item, is_big)).collect::<Option<Vec<f64>>>()
    else {
        return Ok(Content::Other(format!("values of type {kind}")));
    };
    Ok(Content::Numbers(shape.clone(), if by_columns { by_rows(&values, &shape) } else { values }))
}

/// Byte order, letter and size of a type: `<f8`.
fn parts(kind: &str) -> Option<(char, char, usize)> {
    let mut letters = kind.chars();
    let first = letters.next()?;
    let (order, letter) = match first {
        '<' | '>' | '|' | '=' => (first, letters.next()?),
        letter => ('<', letter),
    };
    // a unit of time stands in brackets behind the size: `<M8[ns]`
    let size = letters.as_str().split('[').next().unwrap_or_default();
    let size = if letter == 'O' { 8 } else { size.parse().ok()? };
    Some((order, letter, size))
}

fn in_order<const N: usize>(item: &[u8], is_big: bool) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.copy_from_slice(&item[..N]);
    if is_big {
        bytes.reverse();
    }
    bytes
}

fn number(letter: char, item: &[u8], is_big: bool) -> Option<f64> {
    Some(match (letter, item.len()) {
        ('f', 8) => f64::from_le_bytes(in_order(item, is_big)),
        ('f', 4) => f64::from(f32::from_le_bytes(in_order(item, is_big))),
        ('i', 8) => i64::from_le_bytes(in_order(item, is_big)) as f64,
        ('i', 4) => f64::from(i32::from_le_bytes(in_order(item, is_big))),
        ('i', 2) => f64::from(i16::from_le_bytes(in_order(item, is_big))),
        ('i', 1) => f64::from(i8::from_le_bytes(in_order(item, is_big))),
        ('u', 8) => u64::from_le_bytes(in_order(item, is_big)) as f64,
        ('u', 4) => f64::from(u32::from_le_bytes(in_order(item, is_big))),
        ('u', 2) => f64::from(u16::from_le_bytes(in_order(item, is_big))),
        ('u' | 'b', 1) => f64::from(item[0]),
        // a clock, in its own unit
        ('M' | 'm', 8) => i64::from_le_bytes(in_order(item, is_big)) as f64,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_read_as_written() {
        let values = [0.5, -1e300, 3.0];
        let bytes = npy(&values);
        assert_eq!(bytes.len(), 128 + 24);
        assert_eq!(array(&bytes), Ok(Content::Numbers(vec![3], values.to_vec())));
        for length in 0..bytes.len() {
            assert!(array(&bytes[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn orders_and_types_are_read() {
        let file = |header: &str, data: &[u8]| {
            let mut bytes = [MAGIC, &[1, 0], &(header.len() as u16).to_le_bytes()].concat();
            bytes.extend(header.as_bytes());
            bytes.extend(data);
            array(&bytes)
        };
        let data: Vec<u8> = [1_i16, 2, 3, 4, 5, 6].iter().flat_map(|x| x.to_be_bytes()).collect();
        let header = "{'descr': '>i2', 'fortran_order': True, 'shape': (3, 2), }";
        let expected = vec![1.0, 4.0, 2.0, 5.0, 3.0, 6.0];
        assert_eq!(file(header, &data), Ok(Content::Numbers(vec![3, 2], expected)));
        let text: Vec<u8> = "abc\0".chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        let header = "{'descr': '<U2', 'fortran_order': False, 'shape': (2,), }";
        let expected = ["ab", "c"].map(str::to_owned).to_vec();
        assert_eq!(file(header, &text), Ok(Content::Texts(expected)));
        let header = "{'descr': '|O', 'fortran_order': False, 'shape': (2,), }";
        assert_eq!(file(header, b"pickled"), Ok(Content::Other("objects".to_owned())));
        let header = "{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (2,), }";
        assert_eq!(file(header, b""), Ok(Content::Other("records".to_owned())));
        let header =
            "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 99999999999), }";
        assert!(file(header, b"").is_err());
    }
}
