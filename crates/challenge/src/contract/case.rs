//! A case, and its folder.

use std::path::Path;

use armident_recording::{Recording, write_csv};

use crate::contract::files::write_text;
use crate::contract::truth::Truth;
use crate::error::ChallengeError;

/// A robot, its recordings and the truth.
#[derive(Debug, Clone)]
pub struct Case {
    /// The given robot.
    pub robot_urdf: String,
    /// Recordings from before a change, if the case is one.
    pub before: Vec<Recording>,
    /// Recordings to fit.
    pub train_1: Recording,
    /// Recordings to fit.
    pub train_2: Recording,
    /// The recording to judge the fit by.
    pub holdout: Recording,
    /// The recording that no diagnosis gets.
    pub exam: Recording,
    /// The truth.
    pub truth: Truth,
}

impl Case {
    /// Writes `robot.urdf`, the recordings and `truth.json` into a folder, which is made.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), ChallengeError> {
        std::fs::create_dir_all(folder).map_err(ChallengeError::io("written", folder))?;
        let urdf = folder.join("robot.urdf");
        write_text(&urdf, &self.robot_urdf)?;
        for (name, recording) in [
            ("train_1", &self.train_1),
            ("train_2", &self.train_2),
            ("holdout", &self.holdout),
            ("exam", &self.exam),
        ] {
            write_csv(folder.join(name).with_extension("csv"), recording)?;
        }
        for (k, recording) in self.before.iter().enumerate() {
            write_csv(folder.join(format!("before_{}.csv", k + 1)), recording)?;
        }
        let path = folder.join("truth.json");
        let text = serde_json::to_string_pretty(&self.truth)
            .map_err(|error| ChallengeError::Json { path: path.clone(), error })?;
        write_text(&path, &(text + "\n"))
    }
}
