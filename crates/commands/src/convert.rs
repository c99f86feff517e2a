//! `convert`: a log as a file with standard names and SI units.

use std::path::{Path, PathBuf};

use armident_recording::{Encoded, Formats, Recording, encode};
use armident_report::counted;
use serde::Serialize;

use crate::failure::Failure;
use crate::recordings::expand;

/// What was converted.
#[derive(Debug, Serialize)]
pub struct ConvertReport {
    schema: &'static str,
    recording: String,
    file: String,
    format: &'static str,
    joints: Vec<String>,
    samples: usize,
    /// Repairs on reading.
    pub notes: Vec<String>,
}

impl ConvertReport {
    /// Human-readable text.
    pub fn text(&self) -> String {
        format!(
            "wrote {} ({}, {}, {})\n",
            self.file,
            self.format,
            counted(self.joints.len(), "joint"),
            counted(self.samples, "sample")
        )
    }
}

/// The one file that is converted to a name.
///
/// # Errors
/// A folder of several recordings; a name of a format that is not written.
pub fn one_to_convert(recording: &Path, to: &Path) -> Result<PathBuf, Failure> {
    let written = Formats::standard().written_extensions();
    let extension = to.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !written.contains(&extension.as_str()) {
        return Err(Failure::new(
            format!("no format that is written has the extension `{extension}`"),
            to.display(),
            Some(format!("end the name in .{}", written.join(", ."))),
        ));
    }
    let mut files = expand(&[recording.to_owned()])?;
    if files.len() > 1 {
        let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        return Err(Failure::new(
            format!("{} recordings in the folder, one is converted at a time", files.len()),
            recording.display(),
            Some(format!("pass one of {}", names.join(", "))),
        ));
    }
    Ok(files.remove(0))
}

/// A recording in the format of a file name, with channels that the format cannot hold.
///
/// # Errors
/// A format that this build does not write.
pub fn convert(recording: &Recording, to: &Path) -> Result<(Encoded, ConvertReport), Failure> {
    let report = ConvertReport {
        schema: "armident.convert/1",
        recording: recording.source.clone(),
        file: to.display().to_string(),
        format: Formats::standard().by_extension(to).name(),
        joints: recording.joint_names().into_iter().map(str::to_owned).collect(),
        samples: recording.len(),
        notes: recording.notes.clone(),
    };
    Ok((encode(recording, to)?, report))
}
