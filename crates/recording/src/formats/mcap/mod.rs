//! MCAP, the recordings of ROS 2: joint states of one topic (cargo feature `mcap`).
//!
//! Messages of joints are read (ROS 2, and ROS 1 as `mcap convert` leaves it); other topics are listed in a note.

#[cfg(feature = "mcap")]
mod reader;
mod topics;
#[cfg(feature = "mcap")]
mod writer;

#[cfg(feature = "mcap")]
pub(super) use reader::read_messages;
pub use topics::{JointTopic, Status, StatusLevel, StatusTopic};

use super::format::{FileStart, Format, Support};
#[cfg(feature = "mcap")]
use {
    super::bag_metadata::part_note,
    super::format::{ColumnRequest, Encoded, Input},
    super::ros::Topics,
    crate::error::RecordingError,
    crate::raw::RawColumns,
    crate::recording::Recording,
};

/// MCAP files of ROS 2 joint states.
#[derive(Debug, Clone, Copy)]
pub struct Mcap;

impl Format for Mcap {
    fn name(&self) -> &'static str {
        "MCAP"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["mcap"]
    }

    fn support(&self) -> Support {
        if cfg!(feature = "mcap") { Support::ReadWrite } else { Support::Feature("mcap") }
    }

    fn is_written(&self) -> bool {
        true
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(b"\x89MCAP")
    }

    #[cfg(feature = "mcap")]
    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let part = part_note(input.path());
        let mut topics = Topics::new(request);
        let ended = read_messages(input.into_reader(), &mut topics, request.source())?;
        let mut raw = topics.columns(request, ended)?;
        raw.notes.extend(part);
        Ok(raw)
    }

    #[cfg(feature = "mcap")]
    fn write(&self, recording: &Recording) -> Result<Encoded, RecordingError> {
        writer::write(recording)
    }
}
