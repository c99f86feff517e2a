//! What a column holds beside numbers: the name of a robot in each row.

use std::fs::File;
use std::io::{Read as _, Seek as _};
use std::path::Path;

use crate::error::{Fault, RecordingError};
use crate::formats::first_csv_text;
use crate::table::TableFile;
use crate::table_column::TableColumn;

/// Text of the first row of a column of a CSV or Parquet file, whole numbers as text; none where there is no such column.
///
/// # Errors
/// The file cannot be read; Parquet in a build without the feature `parquet`.
///
/// # Examples
/// ```
/// let path = std::env::temp_dir().join("armident_first_text.csv");
/// std::fs::write(&path, "t;robot;x\n0;arm 7;1\n")?;
/// assert_eq!(armident_recording::first_text(&path, "robot")?.as_deref(), Some("arm 7"));
/// assert_eq!(armident_recording::first_text(&path, "cell")?, None);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn first_text(path: &Path, column: &str) -> Result<Option<String>, RecordingError> {
    let fault = |doing| {
        move |error| RecordingError::new(Fault::Io { doing, error }, &path.display().to_string())
    };
    let mut file = File::open(path).map_err(fault("opened"))?;
    let mut start = [0; 4];
    let read = file.read(&mut start).map_err(fault("read"))?;
    file.rewind().map_err(fault("read"))?;
    if start[..read] != *b"PAR1" {
        return first_csv_text(file, column).map_err(fault("read"));
    }
    let table = TableFile::open(path)?;
    if table.groups() == 0 {
        return Ok(None);
    }
    let texts = table.column(0, column)?.and_then(TableColumn::into_texts);
    Ok(texts.and_then(|texts| texts.into_iter().next().flatten()))
}
