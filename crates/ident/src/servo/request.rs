//! What is to be identified from commands, and why it may fail.

use armident_model::ArmModel;
use armident_recording::{Quantity, Recording, RecordingError};

use super::commands::CommandFault;

/// Recordings of commands and positions of an arm.
#[derive(Debug, Clone, Copy)]
pub struct ServoRequest<'a> {
    /// The given model: geometry, links, gravity.
    pub model: &'a ArmModel,
    /// Training recordings.
    pub train: &'a [Recording],
    /// Gain of the controllers in each of them, over a common one.
    pub train_gains: &'a [f64],
    /// Hold-out recordings: predicted only.
    pub holdout: &'a [Recording],
    /// Gain of the controllers in each of them, over the same.
    pub holdout_gains: &'a [f64],
}

impl ServoRequest<'_> {
    /// Whether recordings have commands and positions of all joints and efforts of none: what this identification is for.
    pub fn suits(recordings: &[Recording], joints: &[String]) -> bool {
        let channel = |recording: &Recording, joint: &String, quantity| {
            recording.joint(joint).is_some_and(|c| c.channel(quantity).is_some())
        };
        let suits = |recording: &Recording| {
            joints.iter().all(|joint| {
                channel(recording, joint, Quantity::Command)
                    && channel(recording, joint, Quantity::Position)
                    && !channel(recording, joint, Quantity::Effort)
            })
        };
        !joints.is_empty() && !recordings.is_empty() && recordings.iter().all(suits)
    }

    pub(super) fn check(&self) -> Result<(), ServoError> {
        for (what, recordings, gains) in [
            ("training", self.train, self.train_gains),
            ("hold-out", self.holdout, self.holdout_gains),
        ] {
            if recordings.len() != gains.len() {
                let (expected, found) = (recordings.len(), gains.len());
                return Err(ServoError::GainCount { what, expected, found });
            }
            let bad = |gain: &f64| !(gain.is_finite() && *gain > 0.0);
            if let Some((recording, gain)) =
                recordings.iter().zip(gains).find(|(_, gain)| bad(gain))
            {
                let source_name = recording.source.clone();
                return Err(ServoError::Gain { source_name, found: *gain });
            }
            for recording in recordings {
                for joint in self.model.chain.joint_names() {
                    let lacks = |quantity: &Quantity| {
                        recording.joint(joint).is_none_or(|c| c.channel(*quantity).is_none())
                    };
                    let wanted = [Quantity::Command, Quantity::Position];
                    if let Some(quantity) = wanted.into_iter().find(lacks) {
                        return Err(ServoError::MissingChannel {
                            source_name: recording.source.clone(),
                            joint: joint.to_owned(),
                            quantity,
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Why controllers cannot be identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServoError {
    /// A recording cannot become a motion.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording lacks a channel.
    #[error("no {quantity} column for {joint}")]
    MissingChannel {
        /// Source of the recording.
        source_name: String,
        /// The joint.
        joint: String,
        /// What it lacks.
        quantity: Quantity,
    },
    /// Gains that are not one a recording.
    #[error("{found} gains for {expected} {what} recordings")]
    GainCount {
        /// Which recordings.
        what: &'static str,
        /// Recordings.
        expected: usize,
        /// Gains.
        found: usize,
    },
    /// A gain that no controller has.
    #[error("gain {found}, expected a positive number")]
    Gain {
        /// Source of the recording.
        source_name: String,
        /// The gain.
        found: f64,
    },
    /// A command column that is not what its header states.
    #[error("{fault}")]
    Command {
        /// What is wrong.
        fault: CommandFault,
        /// Source of the recording.
        source_name: String,
        /// The joint.
        joint: String,
    },
}
