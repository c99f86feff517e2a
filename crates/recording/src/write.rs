//! Recordings in the format that a file's name tells.

use std::path::Path;

use crate::csv_write::write_csv_to;
#[cfg(not(all(feature = "mcap", feature = "parquet")))]
use crate::error::Fault;
use crate::error::RecordingError;
use crate::recording::Recording;

/// A format that recordings are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileFormat {
    /// Comma-separated text.
    Csv,
    /// ROS 2 joint states.
    Mcap,
    /// Apache Parquet.
    Parquet,
}

impl FileFormat {
    /// By the end of a file's name; CSV where it tells nothing.
    pub fn of(path: &Path) -> Self {
        let end = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match end.as_deref() {
            Some("mcap") => Self::Mcap,
            Some("parquet") => Self::Parquet,
            _ => Self::Csv,
        }
    }
}

/// The bytes of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoded {
    /// The file.
    pub bytes: Vec<u8>,
    /// Channels that the format has no place for: `<joint>/<quantity>`.
    pub lost: Vec<String>,
}

/// Writes a recording in a format.
///
/// # Errors
/// The recording is inconsistent, or the format is not built in.
pub fn encode(recording: &Recording, format: FileFormat) -> Result<Encoded, RecordingError> {
    let mut bytes = Vec::new();
    let lost = match format {
        FileFormat::Csv => write_csv_to(&mut bytes, recording).map(|()| Vec::new())?,
        FileFormat::Mcap => mcap(&mut bytes, recording)?,
        FileFormat::Parquet => parquet(&mut bytes, recording)?,
    };
    Ok(Encoded { bytes, lost })
}

#[cfg(feature = "mcap")]
use crate::mcap::write_mcap_to as mcap;

#[cfg(not(feature = "mcap"))]
fn mcap(_bytes: &mut Vec<u8>, recording: &Recording) -> Result<Vec<String>, RecordingError> {
    let fault = Fault::NotBuilt { format: "an MCAP file", feature: "mcap" };
    Err(RecordingError::new(fault, &recording.source))
}

#[cfg(feature = "parquet")]
fn parquet(bytes: &mut Vec<u8>, recording: &Recording) -> Result<Vec<String>, RecordingError> {
    crate::parquet::write_parquet_to(bytes, recording).map(|()| Vec::new())
}

#[cfg(not(feature = "parquet"))]
fn parquet(_bytes: &mut Vec<u8>, recording: &Recording) -> Result<Vec<String>, RecordingError> {
    let fault = Fault::NotBuilt { format: "a Parquet file", feature: "parquet" };
    Err(RecordingError::new(fault, &recording.source))
}
