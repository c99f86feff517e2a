//! Recordings of a suite of motions: what is fitted and what is held out.

use std::path::{Path, PathBuf};

use armident_excitation::Split;
use armident_recording::Formats;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::recordings::expand;

/// Name of the list of motions.
pub const SUITE_FILE: &str = "suite.toml";

/// The list of motions, `suite.toml`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SuiteFile {
    /// `armident.suite/1`.
    pub schema: String,
    /// Name of the robot.
    pub robot: String,
    /// Motions in the order of recording.
    pub motion: Vec<SuiteEntry>,
}

/// A motion of the list.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SuiteEntry {
    /// File of the planned motion; its recording has the same name with any extension.
    pub file: String,
    /// Whether a fit uses it, a test, or neither.
    pub split: Split,
    /// Length \[s\].
    pub seconds: f64,
    /// What it is for.
    pub purpose: String,
}

impl SuiteFile {
    /// Its schema.
    pub const SCHEMA: &'static str = "armident.suite/1";

    /// Reads a list.
    ///
    /// # Errors
    /// A file that cannot be read, is no list of motions or has another schema.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let hint = "copy suite.toml of `armident excite` to the recordings";
        let text = std::fs::read_to_string(path).map_err(|error| {
            Failure::new(format!("cannot read: {error}"), path.display(), Some(hint))
        })?;
        let file: Self =
            toml::from_str(&text).map_err(|error| Failure::of_toml(&error, &text, path, hint))?;
        if file.schema != Self::SCHEMA {
            let what = format!("expected schema `{}`, found `{}`", Self::SCHEMA, file.schema);
            return Err(Failure::new(what, path.display(), Some(hint)));
        }
        Ok(file)
    }
}

/// Recordings of a command line by their use.
#[derive(Debug, Clone, Default)]
pub struct SplitRecordings {
    /// Files of the fit.
    pub training: Vec<PathBuf>,
    /// Files of the hold-out.
    pub holdout: Vec<PathBuf>,
    /// Motions of a suite that are not recorded.
    pub notes: Vec<String>,
}

/// Recordings of a command line: folders are expanded, and those with a `suite.toml` (or that file itself) are split as it
/// says; motions for neither are left out.
///
/// # Errors
/// A folder without a recording, or a list that cannot be used.
pub fn split_recordings(
    given: &[PathBuf],
    holdout: &[PathBuf],
) -> Result<SplitRecordings, Failure> {
    let mut split = SplitRecordings { holdout: expand(holdout)?, ..SplitRecordings::default() };
    for path in given {
        let list = match path.file_name().is_some_and(|name| name == SUITE_FILE) {
            true => path.clone(),
            false => path.join(SUITE_FILE),
        };
        if list.is_file() {
            add_suite(&list, &mut split)?;
        } else {
            split.training.extend(expand(std::slice::from_ref(path))?);
        }
    }
    Ok(split)
}

fn add_suite(list: &Path, split: &mut SplitRecordings) -> Result<(), Failure> {
    let suite = SuiteFile::read(list)?;
    let folder = list.parent().unwrap_or_else(|| Path::new("."));
    let (before, mut missing) = (split.training.len(), Vec::new());
    for entry in suite.motion.iter().filter(|entry| entry.split != Split::Neither) {
        let stem = Path::new(&entry.file).with_extension("");
        let extensions = Formats::standard().extensions();
        let recorded = extensions.iter().map(|end| folder.join(&stem).with_extension(end));
        match recorded.into_iter().find(|file| file.is_file()) {
            Some(file) if entry.split == Split::Holdout => split.holdout.push(file),
            Some(file) => split.training.push(file),
            None => missing.push(stem.display().to_string()),
        }
    }
    if split.training.len() == before {
        return Err(Failure::new(
            format!("no recording of a motion for the fit: expected {}", missing.join(", ")),
            list.display(),
            Some("record the motions of the suite under their names, beside suite.toml"),
        ));
    }
    if !missing.is_empty() {
        split.notes.push(format!("{}: not recorded: {}", list.display(), missing.join(", ")));
    }
    Ok(())
}
