//! The trait of file formats and the types in it.

use std::fmt;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use crate::error::{Fault, RecordingError};
use crate::mapping::{Header, Mapping, MappingGuess};
use crate::raw::RawColumns;
use crate::recording::Recording;

/// Leading bytes that formats are recognised by.
const START_BYTES: u64 = 4096;
/// Advice for formats without a converter of their own.
pub(crate) const EXPORT_CSV: &str = "export it as comma-separated UTF-8 text: a column `t` in \
                                     seconds, then `<joint>/position` and so on";

/// Support of a format in this build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// Read only.
    Read,
    /// Read and written.
    ReadWrite,
    /// Recognised; read and written by builds with this cargo feature.
    Feature(&'static str),
    /// Recognised only; the text is a hint on conversion.
    Convert(&'static str),
}

/// A file format of recordings.
///
/// A format is one file in `formats/` and its line in [`ALL`](crate::STANDARD_FORMATS), or a type
/// of another crate that [`Formats::with`](crate::Formats::with) adds.
pub trait Format: fmt::Debug + Sync {
    /// Its name in messages: `MCAP`.
    fn name(&self) -> &'static str;

    /// File extensions without the dot, lower case, the usual one first.
    fn extensions(&self) -> &'static [&'static str];

    /// Support in this build.
    fn support(&self) -> Support;

    /// Whether this build, or one with more features, writes it; formats whose feature is missing state it here.
    fn is_written(&self) -> bool {
        matches!(self.support(), Support::ReadWrite)
    }

    /// Whether a file that starts like this has the format, usually by its magic bytes.
    fn is_it(&self, start: &FileStart<'_>) -> bool;

    /// Reads the columns that `request` wants.
    ///
    /// # Errors
    /// The file breaks the rules of the format or lacks columns; by default
    /// [`Fault::NotBuilt`] or [`Fault::Unsupported`], see [`support`](Self::support).
    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        drop(input);
        Err(RecordingError::new(unsupported(self.name(), self.support()), request.source))
    }

    /// The recording as a file of the format.
    ///
    /// # Errors
    /// The recording is inconsistent or does not fit; by default [`Fault::NotBuilt`] or
    /// [`Fault::Unsupported`], see [`support`](Self::support).
    fn write(&self, recording: &Recording) -> Result<Encoded, RecordingError> {
        Err(RecordingError::new(unsupported(self.name(), self.support()), &recording.source))
    }
}

fn unsupported(format: &'static str, support: Support) -> Fault {
    match support {
        Support::Feature(feature) => Fault::NotBuilt { format, feature },
        Support::Convert(advice) => Fault::Unsupported { format, advice },
        Support::Read | Support::ReadWrite => Fault::Unsupported { format, advice: EXPORT_CSV },
    }
}

/// How a file is read.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReadSettings<'a> {
    /// Meaning of the columns; by their names if absent.
    pub mapping: Option<&'a Mapping>,
    /// Topic of the joints in a recording of ROS; by default the only one with joint states, or `/joint_states`.
    pub topic: Option<&'a str>,
}

/// First bytes and extension of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FileStart<'a> {
    /// The first 4096 bytes, or all of a shorter file.
    pub bytes: &'a [u8],
    /// Extension without the dot as written; empty if there is none.
    pub extension: &'a str,
}

impl FileStart<'_> {
    /// Whether the file has one of these extensions, in upper or lower case.
    pub fn has_extension(&self, extensions: &[&str]) -> bool {
        extensions.iter().any(|extension| self.extension.eq_ignore_ascii_case(extension))
    }
}

/// An open file, of which the first bytes are known.
#[derive(Debug)]
pub struct Input {
    path: PathBuf,
    start: Vec<u8>,
    rest: File,
}

impl Input {
    /// Opens a file and reads its first bytes.
    ///
    /// # Errors
    /// The path names no file, or the file cannot be read.
    pub(crate) fn open(path: &Path) -> Result<Self, RecordingError> {
        let fault = |fault| RecordingError::new(fault, &path.display().to_string());
        if path.is_dir() {
            return Err(fault(Fault::IsDirectory));
        }
        let mut rest = File::open(path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => fault(Fault::NotFound),
            _ => fault(Fault::Io { doing: "opened", error }),
        })?;
        let start =
            start_of(&mut rest).map_err(|error| fault(Fault::Io { doing: "read", error }))?;
        Ok(Self { path: path.to_owned(), start, rest })
    }

    /// Its path, for readers that open files themselves.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The first bytes.
    pub(crate) fn start(&self) -> &[u8] {
        &self.start
    }

    /// All bytes from the first one on, also of a pipe.
    pub fn into_reader(self) -> impl Read {
        Cursor::new(self.start).chain(self.rest)
    }

    /// The file, rewound.
    ///
    /// # Errors
    /// It is a pipe.
    pub fn into_file(mut self) -> io::Result<File> {
        self.rest.rewind()?;
        Ok(self.rest)
    }
}

/// The first bytes of a file.
pub(crate) fn start_of(reader: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    reader.by_ref().take(START_BYTES).read_to_end(&mut start)?;
    Ok(start)
}

/// Which columns of a file are wanted, and how they are named.
#[derive(Debug, Clone, Copy)]
pub struct ColumnRequest<'a> {
    source: &'a str,
    settings: ReadSettings<'a>,
    /// joints of the arm; set where the meaning of the columns is guessed
    guess: Option<&'a [String]>,
}

impl<'a> ColumnRequest<'a> {
    /// The columns of the file `source` that the settings need.
    pub(crate) fn new(source: &'a str, settings: &ReadSettings<'a>) -> Self {
        Self { source, settings: *settings, guess: None }
    }

    /// All columns that a guess uses; `joints` name numbered ones.
    pub(crate) fn guessing(source: &'a str, topic: Option<&'a str>, joints: &'a [String]) -> Self {
        Self { source, settings: ReadSettings { mapping: None, topic }, guess: Some(joints) }
    }

    /// Name of the file in messages.
    pub fn source(&self) -> &'a str {
        self.source
    }

    /// The topic that is wanted, of formats that have topics.
    pub fn topic(&self) -> Option<&'a str> {
        self.settings.topic
    }

    /// Whether a mapping gives the columns their meaning. It expects `__time` and
    /// `<topic>/<joint>/<quantity>` of formats with topics; without one, columns are `t` and
    /// `<joint>/<quantity>`.
    pub fn is_mapped(&self) -> bool {
        self.settings.mapping.is_some() || self.guess.is_some()
    }

    /// Which of the columns of a file are needed, given all names and the line that they stand
    /// on (0 in formats without lines). A format may read the others as well.
    ///
    /// # Errors
    /// The names lack time stamps or joints, or do not fit the mapping.
    pub fn wanted(&self, names: &[String], line: u64) -> Result<Vec<bool>, RecordingError> {
        if let Some(joints) = self.guess {
            return Ok(MappingGuess::of(names, joints).reads(names));
        }
        match self.settings.mapping {
            Some(mapping) => mapping.reads(names, self.source),
            None => Ok(Header::new(names.to_vec(), self.source, line)?.is_read()),
        }
    }

    /// The recording in the columns that were read.
    ///
    /// # Errors
    /// The columns do not make a recording.
    pub(crate) fn recording(&self, mut raw: RawColumns) -> Result<Recording, RecordingError> {
        let notes = std::mem::take(&mut raw.notes);
        let mut recording = match self.settings.mapping {
            Some(mapping) => mapping.apply(&raw)?,
            None => {
                let source = raw.source.clone();
                Header::new(raw.names(), &source, 0)?.import(raw).finish()?
            }
        };
        recording.notes.splice(0..0, notes);
        Ok(recording)
    }
}

/// A recording as the bytes of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoded {
    /// The file.
    pub bytes: Vec<u8>,
    /// Channels that the format cannot hold: `<joint>/<quantity>`.
    pub omitted: Vec<String>,
}
