//! States as lines of JSON.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader};
use std::path::Path;

use armident_ident::ReducedArm;
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::failure::Failure;

/// What is read of every state at first.
#[derive(Debug, Deserialize)]
pub(crate) struct Head {
    pub(crate) schema: String,
    pub(crate) recording: String,
    #[serde(default)]
    pub(crate) robot: Option<String>,
    #[serde(default)]
    pub(crate) recorded_at_s: Option<f64>,
    #[serde(default)]
    pub(crate) content: Option<String>,
    pub(crate) arm: ReducedArm,
    /// Text of a column of a table.
    #[serde(skip)]
    pub(crate) named: Option<String>,
    /// In lines; tables have it in columns of their own.
    #[serde(default)]
    pub(crate) joints: Option<IgnoredAny>,
}

/// Lines of a file with their ends.
pub(crate) fn each_line(path: &Path) -> Result<impl Iterator<Item = io::Result<Vec<u8>>>, Failure> {
    let mut reader = BufReader::new(File::open(path).map_err(|error| unreadable(path, &error))?);
    Ok(std::iter::from_fn(move || {
        let mut line = Vec::new();
        match reader.read_until(b'\n', &mut line) {
            Ok(0) => None,
            Ok(_) => Some(Ok(line)),
            Err(error) => Some(Err(error)),
        }
    }))
}

/// A file that cannot be read.
pub(crate) fn unreadable(path: &Path, error: &io::Error) -> Failure {
    Failure::new(
        format!("cannot read: {error}"),
        path.display(),
        Some("pass a file that `armident accumulate` has written"),
    )
}
