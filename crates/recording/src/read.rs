//! Any file that is understood, told by its first bytes.

use std::io::Read;
use std::path::Path;

use crate::csv::{START_BYTES, open, other_format, read_csv_from, read_csv_mapped_from};
use crate::error::{Fault, RecordingError};
use crate::header::Header;
use crate::mapping::Mapping;
use crate::raw::RawColumns;
use crate::recording::Recording;

/// How a file is read.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReadSettings<'a> {
    /// What its columns are; by their names where absent.
    pub mapping: Option<&'a Mapping>,
    /// Topic of an MCAP file; the only one with joint states, or `/joint_states`, where absent.
    pub topic: Option<&'a str>,
}

/// Reads a recording of any format: CSV, and MCAP and Parquet where they are built in.
///
/// A mapping sees the columns of an MCAP file as `__time` \[s\] and `<topic>/<joint>/<quantity>`, those of
/// a Parquet file by their names.
///
/// # Errors
/// A file of another format, or any of the faults of [`read_csv_from`](crate::read_csv_from) and
/// [`read_csv_mapped_from`](crate::read_csv_mapped_from).
pub fn read_recording(
    path: impl AsRef<Path>,
    settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    let path = path.as_ref();
    let (mut file, source) = open(path)?;
    let mut start = Vec::new();
    let io_fault = |error| RecordingError::new(Fault::Io { doing: "read", error }, &source);
    file.by_ref().take(START_BYTES).read_to_end(&mut start).map_err(io_fault)?;
    match other_format(&start) {
        Some("an MCAP file") => {
            drop(file);
            mcap(path, &source, settings)
        }
        Some("a Parquet file") => parquet(file, &source, settings),
        // NumPy archives are ZIP archives: their name tells them
        Some(_) if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz")) => {
            Err(RecordingError::new(Fault::NotCsv { format: "a NumPy file" }, &source))
        }
        _ => {
            let text = start.chain(file);
            match settings.mapping {
                Some(mapping) => read_csv_mapped_from(text, &source, mapping),
                None => read_csv_from(text, &source),
            }
        }
    }
}

#[cfg(feature = "mcap")]
fn mcap(
    path: &Path,
    source: &str,
    settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    let (file, _) = open(path)?;
    let reader = std::io::BufReader::with_capacity(1 << 18, file);
    let names = match settings.mapping {
        Some(_) => crate::mcap::Names::WithTopic,
        None => crate::mcap::Names::Plain,
    };
    understood(crate::mcap::read_columns(reader, source, settings.topic, names)?, settings)
}

#[cfg(not(feature = "mcap"))]
fn mcap(
    _path: &Path,
    source: &str,
    _settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    let fault = Fault::NotBuilt { format: "an MCAP file", feature: "mcap" };
    Err(RecordingError::new(fault, source))
}

#[cfg(feature = "parquet")]
fn parquet(
    file: std::fs::File,
    source: &str,
    settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    let mapping = settings.mapping;
    let raw = crate::parquet::read_columns(file, source, |names| match mapping {
        Some(mapping) => mapping.reads(names, source),
        None => Ok(Header::new(names.to_vec(), source, 0)?.is_read()),
    })?;
    understood(raw, settings)
}

#[cfg(not(feature = "parquet"))]
fn parquet(
    _file: std::fs::File,
    source: &str,
    _settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    let fault = Fault::NotBuilt { format: "a Parquet file", feature: "parquet" };
    Err(RecordingError::new(fault, source))
}

/// Columns by a mapping, or by their names.
#[cfg_attr(
    not(any(feature = "mcap", feature = "parquet")),
    expect(dead_code, reason = "no format")
)]
fn understood(
    mut raw: RawColumns,
    settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    let notes = std::mem::take(&mut raw.notes);
    let mut recording = match settings.mapping {
        Some(mapping) => mapping.apply(&raw)?,
        None => {
            let source = raw.source.clone();
            Header::new(raw.names(), &source, 0)?.draft(raw).finish()?
        }
    };
    recording.notes.splice(0..0, notes);
    Ok(recording)
}
