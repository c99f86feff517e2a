//! What can be wrong with a case or a result, where, and what to do about it.

use std::path::{Path, PathBuf};

/// A case or a result that cannot be read, written or made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChallengeError {
    /// A file or folder cannot be read or written.
    #[error("it cannot be {doing}: {error}")]
    Io {
        /// `read` or `written`.
        doing: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// A JSON file does not hold what the contract says.
    #[error("it is not what the challenge writes: {error}")]
    Json {
        /// The file.
        path: PathBuf,
        /// Where and what.
        error: serde_json::Error,
    },
    /// A table of samples is inconsistent.
    #[error("{reason}")]
    Table {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The robot of a case cannot be used.
    #[error("{reason}")]
    Robot {
        /// What is wrong.
        reason: String,
    },
    /// An effect that the generator does not have.
    #[error("there is no effect `{effect}` to hide in a case of this kind")]
    UnknownEffect {
        /// The slug.
        effect: String,
    },
    /// Effects that this arm does not show.
    #[error("no joint and size of {effects} shows on {robot}")]
    Invisible {
        /// The slugs.
        effects: String,
        /// The robot.
        robot: String,
    },
    /// A motion that cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] armident_simulation::SimulationError),
    /// A recording that is inconsistent or cannot be written.
    #[error(transparent)]
    Recording(#[from] armident_recording::RecordingError),
    /// The diagnoses could not be started.
    #[error("the worker threads cannot be started: {reason}")]
    Threads {
        /// What the system says.
        reason: String,
    },
    /// A folder without cases.
    #[error("there is no case in this folder")]
    NoCases {
        /// The folder.
        path: PathBuf,
    },
}

impl ChallengeError {
    /// Where: the file or folder.
    pub fn place(&self) -> String {
        match self {
            Self::Io { path, .. }
            | Self::Json { path, .. }
            | Self::Table { path, .. }
            | Self::NoCases { path } => path.display().to_string(),
            Self::Robot { .. } => "robot.urdf".to_owned(),
            Self::Threads { .. } => String::new(),
            Self::UnknownEffect { .. } | Self::Invisible { .. } => "effects of the case".to_owned(),
            Self::Simulation(error) => error.place(),
            Self::Recording(error) => error.place(),
        }
    }

    /// What to do about it, where there is something to say beyond the fault itself.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NoCases { .. } => {
                Some("give a folder whose folders hold a `truth.json` each".to_owned())
            }
            Self::UnknownEffect { .. } => Some(
                "give a slug of the effect library or `unlisted`; field and change cases have viscous and \
                 Coulomb friction anyway, and in a change no other friction law takes their place"
                    .to_owned(),
            ),
            Self::Invisible { .. } => Some("take another robot or another seed".to_owned()),
            Self::Simulation(error) => error.hint(),
            Self::Recording(error) => error.hint(),
            _ => None,
        }
    }

    pub(crate) fn io(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |error| Self::Io { doing, path, error }
    }
}
