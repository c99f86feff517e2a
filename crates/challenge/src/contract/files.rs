//! Texts and JSON files of cases and results.

use std::path::Path;

use armident_recording::write_whole;

use crate::error::ChallengeError;

/// Reads a JSON file.
pub(crate) fn read_json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, ChallengeError> {
    let text = std::fs::read_to_string(path).map_err(ChallengeError::io("read", path))?;
    serde_json::from_str(&text)
        .map_err(|error| ChallengeError::Json { path: path.to_owned(), error })
}

/// Writes a text, whole or not at all.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), ChallengeError> {
    write_whole(path, |file| file.write_all(text.as_bytes()))
        .map_err(ChallengeError::io("written", path))
}
