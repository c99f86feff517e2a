//! Two results side by side.

use std::path::Path;

use armident_report::{ComparisonError, ComparisonReport};
use serde_json::Value;

use crate::failure::Failure;

/// What to pass.
const HINT: &str = "pass two files written by --json of identify, or two of diagnose";

/// Compares two results that `identify` or `diagnose` wrote as JSON.
///
/// # Errors
/// A file that cannot be read; results of other or different commands, or without a common joint.
pub fn compare(first: &Path, second: &Path) -> Result<ComparisonReport, Failure> {
    let documents = [read(first)?, read(second)?];
    let names = [first, second].map(|path| path.display().to_string());
    ComparisonReport::of((&names[0], &documents[0]), (&names[1], &documents[1])).map_err(|error| {
        let place = match &error {
            ComparisonError::Schema { file, .. } | ComparisonError::Form { file, .. } => {
                file.clone()
            }
            _ => names.join(", "),
        };
        Failure::new(error, place, Some(HINT))
    })
}

fn read(path: &Path) -> Result<Value, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::new(format!("cannot read: {error}"), path.display(), Some(HINT))
    })?;
    serde_json::from_str(&text).map_err(|error| {
        let place = format!("{}, line {}", path.display(), error.line());
        Failure::new(format!("the result is not valid JSON: {error}"), place, Some(HINT))
    })
}
