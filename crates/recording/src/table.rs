//! Tables in Parquet files, one group of rows at a time, so that memory does not grow with their number.

use std::io;
use std::path::Path;

#[cfg(not(feature = "parquet"))]
use crate::error::Fault;
use crate::error::RecordingError;
#[cfg(feature = "parquet")]
use crate::table_codec as codec;
use crate::table_column::{TableColumn, TableKind};

/// An open table.
pub struct TableFile {
    #[cfg(feature = "parquet")]
    inner: codec::Reader,
    #[cfg(not(feature = "parquet"))]
    never: std::convert::Infallible,
}

impl TableFile {
    /// Opens a table.
    ///
    /// # Errors
    /// A file that is no Parquet; a build without the feature `parquet`.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        #[cfg(feature = "parquet")]
        return codec::Reader::open(path).map(|inner| Self { inner });
        #[cfg(not(feature = "parquet"))]
        Err(not_built(path))
    }

    /// Names of the columns.
    pub fn names(&self) -> Vec<String> {
        #[cfg(feature = "parquet")]
        return self.inner.names();
        #[cfg(not(feature = "parquet"))]
        match self.never {}
    }

    /// Number of groups of rows.
    pub fn groups(&self) -> usize {
        #[cfg(feature = "parquet")]
        return self.inner.groups();
        #[cfg(not(feature = "parquet"))]
        match self.never {}
    }

    /// A column of one group; none where the table has no such column, or one of another kind than texts, numbers and lists
    /// of numbers.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn column(&self, group: usize, name: &str) -> Result<Option<TableColumn>, RecordingError> {
        #[cfg(feature = "parquet")]
        return self.inner.column(group, name);
        #[cfg(not(feature = "parquet"))]
        {
            let _ = (group, name);
            match self.never {}
        }
    }
}

/// Whether this build reads and writes tables.
///
/// # Errors
/// A build without the feature `parquet`.
pub fn tables_are_built(path: &Path) -> Result<(), RecordingError> {
    #[cfg(feature = "parquet")]
    {
        let _ = path;
        Ok(())
    }
    #[cfg(not(feature = "parquet"))]
    Err(not_built(path))
}

/// Writes a table: one group of rows after another, each with all columns in their order, until there is none.
///
/// # Errors
/// The file cannot be written, columns that do not fit, an error of `next`; a build without the feature `parquet`.
pub fn write_table(
    out: &mut dyn io::Write,
    columns: &[(&str, TableKind)],
    next: impl FnMut() -> io::Result<Option<Vec<TableColumn>>>,
) -> io::Result<()> {
    #[cfg(feature = "parquet")]
    return codec::write(out, columns, next);
    #[cfg(not(feature = "parquet"))]
    {
        let _ = (out, columns, next);
        Err(io::Error::other(not_built(Path::new(""))))
    }
}

#[cfg(not(feature = "parquet"))]
fn not_built(path: &Path) -> RecordingError {
    let fault = Fault::NotBuilt { format: "Parquet", feature: "parquet" };
    RecordingError::new(fault, &path.display().to_string())
}
