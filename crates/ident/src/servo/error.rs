//! Why controllers cannot be identified.

use std::fmt;

use armident_recording::{Quantity, RecordingError};
use armident_simulation::SimulationError;

/// What a column of commands is instead of the position that a joint is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CommandFault {
    /// Degrees, or millimetres of a prismatic joint.
    OtherUnit,
    /// Steps of an encoder.
    Ticks,
    /// The recorded position.
    Position,
    /// The same value throughout.
    Constant,
}

impl CommandFault {
    /// What to do.
    pub fn advice(self) -> &'static str {
        match self {
            Self::OtherUnit => {
                "state the unit of the command in a mapping (unit = \"deg\"), and pass it with --mapping"
            }
            Self::Ticks => {
                "state counts_per_turn of the command in a mapping (unit = \"counts\"), and pass it with --mapping"
            }
            Self::Position => {
                "record what the controller is given, or map that column as quantity = \"command\""
            }
            Self::Constant => {
                "add a recording in which the joint moves, or lock the joint with --lock JOINT=VALUE"
            }
        }
    }
}

impl fmt::Display for CommandFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OtherUnit => {
                "the command is not in the unit of the position: expected rad or m, found what degrees or mm give"
            }
            Self::Ticks => {
                "the command is not in the unit of the position: expected rad or m, found what encoder steps give"
            }
            Self::Position => {
                "the command equals the recorded position: expected what the controller is given"
            }
            Self::Constant => {
                "the command is constant in all recordings: expected a command that moves the joint"
            }
        })
    }
}

/// Why controllers cannot be identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServoError {
    /// A recording cannot become a motion.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The arm cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
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
