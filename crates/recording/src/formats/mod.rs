//! File formats of recordings. A new one is a file here, its `mod` and its line in [`ALL`].

mod arrays;
mod bag;
mod bag_metadata;
mod csv;
mod db3;
mod echo;
mod format;
mod hdf5;
mod mat;
mod mcap;
mod npz;
mod other;
mod parquet;
#[cfg(feature = "mcap")]
mod ros;
mod rosbag2;
mod sage;
mod separator;

use std::path::Path;

pub use bag::Bag;
pub use csv::{Csv, write_csv_to};
pub use db3::Db3;
pub use echo::Echo;
pub use format::{ColumnRequest, Encoded, FileStart, Format, Input, ReadSettings, Support};
pub use hdf5::Hdf5;
pub use mat::Matlab;
pub use mcap::{JointTopic, Mcap, Status, StatusLevel, StatusTopic};
pub use npz::Npz;
pub use parquet::Parquet;
pub use rosbag2::Rosbag2;
pub use sage::Sage;

pub(crate) use csv::{first_text as first_csv_text, read_columns as read_csv_columns};
pub(crate) use format::{EXPORT_CSV, start_of};

use crate::error::RecordingError;
use crate::raw::RawColumns;
use crate::recording::Recording;

/// The formats that some build reads, the default one first. Formats that need a cargo feature are
/// listed in every build.
pub const ALL: &[&dyn Format] =
    &[&Csv, &Echo, &Sage, &Mcap, &Npz, &Matlab, &Parquet, &Rosbag2, &Db3, &Bag, &Hdf5];

/// A list of formats: the standard one, or that and formats of other crates.
///
/// # Examples
/// ```
/// use armident_recording::Formats;
///
/// let formats = Formats::standard();
/// assert_eq!(formats.written_extensions(), ["csv", "mcap", "npz", "parquet"]);
/// assert_eq!(formats.extensions(), ["csv", "mcap", "npz", "mat", "parquet", "db3", "bag", "h5", "hdf5"]);
/// assert_eq!(formats.by_extension("run.MCAP".as_ref()).name(), "MCAP");
/// assert_eq!(formats.by_extension("run".as_ref()).name(), "CSV");
/// ```
#[derive(Debug, Clone)]
pub struct Formats<'a> {
    /// Earlier ones take precedence.
    formats: Vec<&'a dyn Format>,
}

impl Formats<'static> {
    /// All formats of this crate.
    pub fn standard() -> Self {
        Self { formats: ALL.iter().chain(other::ALL).copied().collect() }
    }
}

impl<'a> Formats<'a> {
    /// The list with one more format, which takes precedence over the others.
    #[must_use]
    pub fn with(mut self, format: &'a dyn Format) -> Self {
        self.formats.insert(0, format);
        self
    }

    /// The formats that some build reads.
    fn read_by_some_build(&self) -> impl Iterator<Item = &'a dyn Format> {
        self.formats
            .iter()
            .copied()
            .filter(|format| !matches!(format.support(), Support::Convert(_)))
    }

    /// Names of the formats that this build, or one with more features, reads.
    pub fn names(&self) -> Vec<&'static str> {
        self.read_by_some_build().map(Format::name).collect()
    }

    /// Usual extensions of these formats, without the dot.
    pub fn extensions(&self) -> Vec<&'static str> {
        self.read_by_some_build().flat_map(|format| format.extensions()).copied().collect()
    }

    /// Usual extensions of the formats that this build, or one with more features, writes, without the dot.
    pub fn written_extensions(&self) -> Vec<&'static str> {
        let written = self.formats.iter().filter(|format| format.is_written());
        written.flat_map(|format| format.extensions()).copied().collect()
    }

    /// The format of a file that starts like this; CSV, which has no magic bytes, if no other
    /// format recognises it.
    pub fn recognise(&self, start: &FileStart<'_>) -> &'a dyn Format {
        self.other_than_csv(start).unwrap_or(&Csv)
    }

    /// The format that recognises a file; none for CSV.
    pub(crate) fn other_than_csv(&self, start: &FileStart<'_>) -> Option<&'a dyn Format> {
        self.formats.iter().copied().find(|format| format.is_it(start))
    }

    /// The format to write a file of this name in; CSV if its extension is not that of a format
    /// that is written.
    pub fn by_extension(&self, path: &Path) -> &'a dyn Format {
        let extension = extension_of(path);
        let start = FileStart { bytes: &[], extension: &extension };
        let fits = |format: &&'a dyn Format| {
            format.is_written() && start.has_extension(format.extensions())
        };
        self.formats.iter().copied().find(fits).unwrap_or(&Csv)
    }

    /// Reads a recording, its format recognised by the first bytes.
    ///
    /// A mapping sees the columns of an MCAP file as `__time` \[s\] and
    /// `<topic>/<joint>/<quantity>`, those of other files by their names.
    ///
    /// # Errors
    /// The file cannot be read, has a format that this build does not read, or any of the faults of
    /// [`read_csv_from`](crate::read_csv_from) and
    /// [`read_csv_mapped_from`](crate::read_csv_mapped_from).
    pub fn read(
        &self,
        path: impl AsRef<Path>,
        settings: &ReadSettings<'_>,
    ) -> Result<Recording, RecordingError> {
        let path = path.as_ref();
        let source = path.display().to_string();
        let request = ColumnRequest::new(&source, settings);
        let (_, raw) = self.columns(path, &request)?;
        request.recording(raw)
    }

    /// The format of a file and the columns that are wanted of it.
    pub(crate) fn columns(
        &self,
        path: &Path,
        request: &ColumnRequest<'_>,
    ) -> Result<(&'a dyn Format, RawColumns), RecordingError> {
        // the recorder's list stands for the folder of a bag
        let in_folder = path.is_dir().then(|| rosbag2::metadata_in(path)).flatten();
        let path = in_folder.as_deref().unwrap_or(path);
        let input = Input::open(path)?;
        let extension = extension_of(path);
        let format = self.recognise(&FileStart { bytes: input.start(), extension: &extension });
        Ok((format, format.read(input, request)?))
    }
}

/// Whether a folder is one recording: a bag of ROS 2 with its list of files.
pub fn is_one_recording(folder: &Path) -> bool {
    rosbag2::metadata_in(folder).is_some()
}

fn extension_of(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().into_owned()).unwrap_or_default()
}
