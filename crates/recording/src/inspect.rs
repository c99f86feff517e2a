//! What a file holds, before anything is decided about it.

use std::path::Path;

use crate::error::RecordingError;
use crate::formats::{ColumnRequest, Formats, ReadSettings};
use crate::mapping::{Mapping, MappingGuess};
use crate::recording::Recording;

/// What a file holds.
#[derive(Debug)]
pub struct Inspection {
    /// Name of its format.
    pub format: &'static str,
    /// Names of all columns, as a mapping file names them.
    pub columns: Vec<String>,
    /// The recording by the settings: with their mapping, or else by the standard names of the columns.
    pub recording: Result<Recording, RecordingError>,
    /// The mapping that the names of the columns suggest.
    pub guess: MappingGuess,
    /// The recording with that mapping.
    pub guessed: Result<Recording, RecordingError>,
}

/// Reads what a file holds, also where its columns have other names than the standard ones. `joints` are those of the arm in
/// their order, which name numbered ones; it may be empty.
///
/// # Errors
/// The file cannot be read, has a format that this build does not read, or breaks the rules of its format.
pub fn inspect(
    path: impl AsRef<Path>,
    settings: &ReadSettings<'_>,
    joints: &[String],
) -> Result<Inspection, RecordingError> {
    let (path, formats) = (path.as_ref(), Formats::standard());
    let source = path.display().to_string();
    let request = ColumnRequest::guessing(&source, settings.topic, joints);
    let (format, raw) = formats.columns(path, &request)?;
    let columns = raw.names();
    let guess = MappingGuess::of(&columns, joints).with_values(&raw);
    let text = guess.to_toml();
    let guessed = Mapping::parse(&text, "guessed mapping").and_then(|mapping| {
        let mut recording = mapping.apply(&raw)?;
        recording.notes.splice(0..0, raw.notes.clone());
        Ok(recording)
    });
    let recording = formats.read(path, settings);
    Ok(Inspection { format: format.name(), columns, recording, guess, guessed })
}
