//! Recordings named on a command line.

use std::path::{Path, PathBuf};

use armident_commands::{Failure, ReadingOptions, quality_notes};
use armident_recording::{
    Encoded, Fault, Format as _, Mcap, Recording, RecordingError, Support, encode,
};

use crate::args::{OutputArgs, ReadingArgs};
use crate::output;
use crate::progress::Progress;

/// Encodes a recording in the format of the file extension; unsupported channels become a note.
pub(crate) fn encoded(
    recording: &Recording,
    path: &Path,
    output: &OutputArgs,
) -> Result<Vec<u8>, Failure> {
    Ok(bytes_of(encode(recording, path)?, path, output))
}

/// The file; channels that its format cannot hold become a note.
pub(crate) fn bytes_of(encoded: Encoded, path: &Path, output: &OutputArgs) -> Vec<u8> {
    let Encoded { bytes, omitted } = encoded;
    if !omitted.is_empty() {
        let omitted = omitted.join(", ");
        let note = format!("{}: the format cannot hold {omitted}; omitted", path.display());
        output::say_all(output, "note", &[note]);
    }
    bytes
}

/// Refuses an MCAP file that cannot be written, before the work is done.
pub(crate) fn check_mcap(path: Option<&PathBuf>) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    if output::is_stdout(path) {
        return Err(Failure::new(
            "topics cannot be written to stdout",
            "--mcap",
            Some("pass a file, for example --mcap result.mcap"),
        ));
    }
    match Mcap.support() {
        Support::Feature(feature) => Err(RecordingError::new(
            Fault::NotBuilt { format: Mcap.name(), feature },
            &path.display().to_string(),
        )
        .into()),
        _ => Ok(()),
    }
}

/// Writes topics to an MCAP file.
pub(crate) fn write_mcap(path: &Path, topics: Encoded, output: &OutputArgs) -> Result<(), Failure> {
    output::write_file(path, &bytes_of(topics, path, output))
}

/// Reads all files, with the mapping if one is given, and prints notes on their quality.
pub(crate) fn read_all(
    files: &[PathBuf],
    reading: &ReadingArgs,
    output: &OutputArgs,
) -> Result<Vec<Recording>, Failure> {
    let recordings = {
        let progress = Progress::through(output, "reading", files.len());
        armident_commands::read_all(files, &reading_options(reading), || progress.part_done())?
    };
    output::say_all(output, "note", &quality_notes(&recordings));
    Ok(recordings)
}

/// Reads all files without printing notes.
pub(crate) fn read_quietly(
    files: &[PathBuf],
    reading: &ReadingArgs,
) -> Result<Vec<Recording>, Failure> {
    armident_commands::read_all(files, &reading_options(reading), || ())
}

/// How files are read.
pub(crate) fn reading_options(reading: &ReadingArgs) -> ReadingOptions {
    ReadingOptions { mapping: reading.mapping.clone(), topic: reading.topic.clone() }
}
