//! Reading recordings.

use std::io::{self, Read};
use std::path::Path;

use crate::error::{Fault, RecordingError};
use crate::formats::{
    ColumnRequest, EXPORT_CSV, FileStart, Formats, Input, ReadSettings, Support, read_csv_columns,
    start_of,
};
use crate::mapping::Mapping;
use crate::raw::RawColumns;
use crate::recording::Recording;

/// Reads a recording of any standard format, see [`Formats::read`].
///
/// # Errors
/// See [`Formats::read`].
pub fn read_recording(
    path: impl AsRef<Path>,
    settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    Formats::standard().read(path, settings)
}

/// The recording in columns that are in memory already, with the checks and repairs of a file. Names and units are those
/// of a file: `t` in seconds and `<joint>/<quantity>`, or what the mapping of the settings expects.
///
/// # Errors
/// Columns that make no recording, see [`read_csv_from`].
pub fn recording_of_columns(
    columns: RawColumns,
    settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    let source = columns.source.clone();
    ColumnRequest::new(&source, settings).recording(columns)
}

/// Reads a CSV file. `source` of the recording is the path.
///
/// # Errors
/// The file cannot be read, or any of the faults of [`read_csv_from`].
pub fn read_csv(path: impl AsRef<Path>) -> Result<Recording, RecordingError> {
    let input = Input::open(path.as_ref())?;
    read_csv_from(input.into_reader(), &path.as_ref().display().to_string())
}

/// Reads a CSV file whose columns a mapping explains.
///
/// # Errors
/// The file cannot be read, or any of the faults of [`read_csv_mapped_from`].
pub fn read_csv_mapped(
    path: impl AsRef<Path>,
    mapping: &Mapping,
) -> Result<Recording, RecordingError> {
    let input = Input::open(path.as_ref())?;
    read_csv_mapped_from(input.into_reader(), &path.as_ref().display().to_string(), mapping)
}

/// Reads CSV text; `source` names it in messages.
///
/// The first line names the columns: `t` in seconds, then `<joint>/<quantity>` where the quantity
/// is the part after the last slash and a name of a [`Quantity`](crate::Quantity). Without a column
/// `t`, the names that PlotJuggler writes are understood: `__time` or `time`, then
/// `/joint_states/<joint>/<quantity>` or another topic. Other columns are listed in
/// [`Recording::ignored_columns`] and noted. Byte order marks, CRLF, blank lines and spaces around
/// fields are accepted. Repairs on reading are listed in [`Recording::findings`].
///
/// # Errors
/// A file of another format; a header without time stamps or without a joint column, or with a
/// duplicate column; rows with another number of fields; fields that are not numbers; infinite
/// values, and NaN beyond what is interpolated; stamps that decrease, are not in seconds or repeat
/// in more than 1 % of the samples; fewer than 8 samples; positions that their velocities show to
/// be in degrees or millimetres.
pub fn read_csv_from(reader: impl Read, source: &str) -> Result<Recording, RecordingError> {
    csv(reader, source, &ReadSettings::default())
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
    csv(reader, source, &ReadSettings { mapping: Some(mapping), topic: None })
}

fn csv(
    mut reader: impl Read,
    source: &str,
    settings: &ReadSettings<'_>,
) -> Result<Recording, RecordingError> {
    let fault = |fault| RecordingError::new(fault, source);
    let io_fault = |error| fault(Fault::Io { doing: "read", error });
    let start = start_of(&mut reader).map_err(io_fault)?;
    let formats = Formats::standard();
    if let Some(format) = formats.other_than_csv(&FileStart { bytes: &start, extension: "" }) {
        let advice = match format.support() {
            Support::Convert(advice) => advice,
            _ => EXPORT_CSV,
        };
        return Err(fault(Fault::NotCsv { found: format.name(), advice }));
    }
    let request = ColumnRequest::new(source, settings);
    let all = io::Cursor::new(start).chain(reader);
    request.recording(read_csv_columns(all, &request)?)
}
