//! Apache Parquet: flat columns of numbers (cargo feature `parquet`).

#[cfg(feature = "parquet")]
mod codec;
#[cfg(feature = "parquet")]
mod dataset;

use super::format::{FileStart, Format, Support};
#[cfg(feature = "parquet")]
use {
    super::format::{ColumnRequest, Encoded, Input},
    crate::error::{Fault, RecordingError},
    crate::raw::RawColumns,
    crate::recording::Recording,
};

/// Parquet files with the columns of CSV, and those of LeRobot datasets.
#[derive(Debug, Clone, Copy)]
pub struct Parquet;

impl Format for Parquet {
    fn name(&self) -> &'static str {
        "Parquet"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["parquet"]
    }

    fn support(&self) -> Support {
        if cfg!(feature = "parquet") { Support::ReadWrite } else { Support::Feature("parquet") }
    }

    fn is_written(&self) -> bool {
        true
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(b"PAR1")
    }

    #[cfg(feature = "parquet")]
    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let path = input.path().to_owned();
        let file = input.into_file().map_err(|error| {
            RecordingError::new(Fault::Io { doing: "read", error }, request.source())
        })?;
        codec::read_columns(file, &path, request)
    }

    #[cfg(feature = "parquet")]
    fn write(&self, recording: &Recording) -> Result<Encoded, RecordingError> {
        codec::write(recording)
    }
}
