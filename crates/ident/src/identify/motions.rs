//! Motions of recordings with efforts.

use armident_motion::{Motion, MotionSettings};
use armident_recording::{Quantity, Recording};

use super::error::IdentifyError;

/// Motions of all joints of an arm, through one low-pass; every joint has an effort.
pub(crate) fn motions_with_effort(
    recordings: &[Recording],
    joints: &[&str],
    cutoff_hz: Option<f64>,
) -> Result<Vec<Motion>, IdentifyError> {
    let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
    recordings
        .iter()
        .map(|recording| {
            let motion = Motion::from_recording(recording, joints, &settings)?;
            if motion.effort.is_some() {
                return Ok(motion);
            }
            let lacks_effort = |joint: &&&str| {
                recording.joint(joint).is_none_or(|c| c.channel(Quantity::Effort).is_none())
            };
            let without = joints.iter().filter(lacks_effort).map(|j| (*j).to_owned());
            Err(IdentifyError::NoEffort {
                source_name: recording.source.clone(),
                joints: without.collect(),
            })
        })
        .collect()
}
