//! A recording made ready once, for the predictions of many models.

use armident_motion::{BAND_HZ, BandMotion, EvenGrid};
use armident_recording::{Recording, RecordingError};

/// A recording as models of one arm see it.
pub struct PreparedRecording<'a> {
    pub(crate) recording: &'a Recording,
    pub(crate) grid: EvenGrid,
    /// It on its grid.
    pub signals: BandMotion,
}

impl<'a> PreparedRecording<'a> {
    /// By models with these joints, base to tip.
    ///
    /// # Errors
    /// A recording without the positions of the joints, or mostly gaps.
    pub fn of(recording: &'a Recording, joints: &[String]) -> Result<Self, RecordingError> {
        let grid = EvenGrid::of(recording)?;
        let signals = BandMotion::on(&grid, recording, joints, BAND_HZ)?;
        Ok(Self { recording, grid, signals })
    }

    /// The recording.
    pub fn recording(&self) -> &'a Recording {
        self.recording
    }
}
