//! Recordings named on a command line.

use std::path::{Path, PathBuf};

use armident_commands::{Failure, ReadingOptions, quality_notes};
use armident_recording::{Encoded, Recording, encode};

use crate::args::{OutputArgs, ReadingArgs};
use crate::output;
use crate::progress::Progress;

/// Encodes a recording in the format of the file extension; unsupported channels become a note.
pub(crate) fn encoded(
    recording: &Recording,
    path: &Path,
    output: &OutputArgs,
) -> Result<Vec<u8>, Failure> {
    let Encoded { bytes, omitted } = encode(recording, path)?;
    if !omitted.is_empty() {
        let omitted = omitted.join(", ");
        let note = format!("{}: the format cannot hold {omitted}; omitted", path.display());
        output::say_all(output, "note", &[note]);
    }
    Ok(bytes)
}

/// Reads all files, with the mapping if one is given, and prints notes on their quality.
pub(crate) fn read_all(
    files: &[PathBuf],
    reading: &ReadingArgs,
    output: &OutputArgs,
) -> Result<Vec<Recording>, Failure> {
    let recordings = {
        let progress = Progress::through(output, "reading", files.len());
        armident_commands::read_all(files, &options(reading), || progress.part_done())?
    };
    output::say_all(output, "note", &quality_notes(&recordings));
    Ok(recordings)
}

/// Reads all files without printing notes.
pub(crate) fn read_quietly(
    files: &[PathBuf],
    reading: &ReadingArgs,
) -> Result<Vec<Recording>, Failure> {
    armident_commands::read_all(files, &options(reading), || ())
}

fn options(reading: &ReadingArgs) -> ReadingOptions {
    ReadingOptions { mapping: reading.mapping.clone(), topic: reading.topic.clone() }
}
