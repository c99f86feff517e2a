//! What is to be identified from commands.

use armident_model::ArmModel;
use armident_recording::{Quantity, Recording};

use super::error::ServoError;

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
    /// Whether each joint is fitted again without each of its parameters.
    pub ablations: bool,
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
