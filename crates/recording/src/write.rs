//! Writing recordings.

use std::io;
use std::path::Path;

use crate::error::{Fault, RecordingError};
use crate::formats::{Encoded, Formats, write_csv_to};
use crate::recording::Recording;
use crate::whole_file::write_whole;

/// Encodes a recording in the standard format of a file name, see [`Formats::by_extension`].
///
/// # Errors
/// The recording is inconsistent, or this build does not write the format.
pub fn encode(recording: &Recording, path: &Path) -> Result<Encoded, RecordingError> {
    Formats::standard().by_extension(path).write(recording)
}

/// Writes a CSV file, as [`write_csv_to`].
///
/// # Errors
/// The recording is inconsistent, or the file cannot be written.
pub fn write_csv(path: impl AsRef<Path>, recording: &Recording) -> Result<(), RecordingError> {
    let path = path.as_ref();
    recording.check()?;
    let source = path.display().to_string();
    let mut failed = None;
    let written = write_whole(path, |file| {
        write_csv_to(file, recording).map_err(|error| {
            let message = io::Error::other(error.to_string());
            failed = Some(error);
            message
        })
    });
    match (failed, written) {
        (Some(error), _) => Err(error.of_source(&source)),
        (None, Err(error)) => {
            Err(RecordingError::new(Fault::Io { doing: "written", error }, &source))
        }
        (None, Ok(())) => Ok(()),
    }
}
