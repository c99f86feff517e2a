//! ROS 2 bags as the recorder leaves them: a folder of files, listed in `metadata.yaml`, that are one recording (cargo feature
//! `mcap`; files in SQLite need `all-formats`).

use std::path::{Path, PathBuf};

use super::bag_metadata::METADATA;
use super::format::{FileStart, Format, Support};
#[cfg(feature = "mcap")]
use {
    super::bag_metadata::Metadata,
    super::format::{ColumnRequest, Input},
    super::ros::Topics,
    crate::error::{Fault, RecordingError},
    crate::raw::RawColumns,
    std::io::Read as _,
};

/// Folders of ROS 2 bags, by their `metadata.yaml`.
#[derive(Debug, Clone, Copy)]
pub struct Rosbag2;

/// First key of the list of files.
const FIRST_KEY: &[u8] = b"rosbag2_bagfile_information:";
#[cfg(feature = "mcap")]
const NAME: &str = "ROS 2 bag (folder)";

impl Format for Rosbag2 {
    fn name(&self) -> &'static str {
        "ROS 2 bag (folder)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &[]
    }

    fn support(&self) -> Support {
        if cfg!(feature = "mcap") { Support::Read } else { Support::Feature("mcap") }
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        let found = |at: &[u8]| at.starts_with(FIRST_KEY);
        start.bytes.windows(FIRST_KEY.len()).take(200).any(found)
    }

    #[cfg(feature = "mcap")]
    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let fault = |fault| RecordingError::new(fault, request.source());
        let folder = input.path().parent().map(Path::to_owned).unwrap_or_default();
        let mut bytes = Vec::new();
        input
            .into_reader()
            .read_to_end(&mut bytes)
            .map_err(|error| fault(Fault::Io { doing: "read", error }))?;
        let metadata = Metadata::of(&String::from_utf8_lossy(&bytes));
        if let Some(compression) = metadata.compression {
            return Err(fault(Fault::CompressedBag { compression }));
        }
        if metadata.files.is_empty() {
            let what = format!("{METADATA} lists no files under `relative_file_paths`");
            return Err(fault(Fault::Broken { format: NAME, what }));
        }
        let mut topics = Topics::new(request);
        let (mut ended, mut missing) = (Vec::new(), Vec::new());
        let count = metadata.files.len();
        for file in &metadata.files {
            let name = file.display().to_string();
            // old recorders wrote the folder into the list
            let below = folder.join(file);
            let beside = file.file_name().map(|name| folder.join(name)).unwrap_or_default();
            let Some(path) = [below, beside].into_iter().find(|path| path.is_file()) else {
                missing.push(name);
                continue;
            };
            let source = path.display().to_string();
            match read_into(&path, &source, &mut topics) {
                Ok(None) => {}
                Ok(Some(why)) => ended.push(format!("{name}: {why}")),
                // a recorder that was killed leaves its last file without an end
                Err(error) if count > 1 && matches!(error.fault(), Fault::Broken { .. }) => {
                    ended.push(format!("{name}: {error}"));
                }
                Err(error) => return Err(error),
            }
        }
        if missing.len() == count {
            return Err(fault(Fault::MissingBagFiles { files: missing }));
        }
        if topics.is_empty() && !ended.is_empty() {
            return Err(fault(Fault::Broken { format: NAME, what: ended.join("; ") }));
        }
        let why = (!ended.is_empty()).then(|| ended.join("; "));
        let mut raw = topics.columns(request, why)?;
        if count > 1 {
            raw.notes.insert(1, format!("{count} files of the bag, one after the other"));
        }
        if !missing.is_empty() {
            let (lost, lists) = (missing.len(), missing.join(", "));
            raw.notes.push(format!("{lost} of {count} files of the bag are missing: {lists}"));
        }
        Ok(raw)
    }
}

/// The `metadata.yaml` of a folder, where it is a bag of ROS 2.
pub(super) fn metadata_in(folder: &Path) -> Option<PathBuf> {
    let path = folder.join(METADATA);
    let is_bag = std::fs::read(&path).is_ok_and(|bytes| {
        Rosbag2.is_it(&FileStart { bytes: &bytes[..bytes.len().min(4096)], extension: "yaml" })
    });
    is_bag.then_some(path)
}

/// Reads the messages of one file; the reason if it ends early.
#[cfg(feature = "mcap")]
fn read_into(
    path: &Path,
    source: &str,
    topics: &mut Topics,
) -> Result<Option<String>, RecordingError> {
    let input = Input::open(path)?;
    let start = FileStart { bytes: input.start(), extension: "" };
    if super::Mcap.is_it(&start) {
        return super::mcap::read_messages(input.into_reader(), topics, source);
    }
    if super::Db3.is_it(&start) {
        return super::db3::read_file(path, topics, source);
    }
    let what = "the file is neither MCAP nor SQLite".to_owned();
    Err(RecordingError::new(Fault::Broken { format: NAME, what }, source))
}
