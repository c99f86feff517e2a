//! `export`: a model in another format.

use std::path::{Path, PathBuf};

use armident_export::{Exported, Held, Lost, controller, mjcf, urdf};
use armident_report::significant;
use serde::Serialize;

use crate::failure::Failure;
use crate::robot::{GivenRobot, chain_warnings};

/// A format that models are exported to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportFormat {
    /// Links, limits, damping and friction.
    Urdf,
    /// MuJoCo format: also armature, gravity and motors.
    Mjcf,
    /// C99 source for a controller, with a header beside it.
    C,
}

impl ExportFormat {
    /// The format of a file extension.
    ///
    /// # Errors
    /// Another extension.
    pub fn of_path(path: &Path) -> Result<Self, Failure> {
        let end = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match end.as_str() {
            "urdf" => Ok(Self::Urdf),
            "xml" | "mjcf" => Ok(Self::Mjcf),
            "c" => Ok(Self::C),
            _ => Err(Failure::new(
                format!("cannot infer the output format from `{}`", path.display()),
                path.display(),
                Some("use the extension .urdf, .xml for MJCF, or .c, or pass --format"),
            )),
        }
    }
}

/// What was written and what the format could not hold.
#[derive(Debug, Clone, Serialize)]
pub struct ExportReport {
    schema: &'static str,
    robot: String,
    model: String,
    /// Name of the format.
    pub format: &'static str,
    /// File that was written.
    pub file: String,
    /// Header beside it, for C.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub header: Option<String>,
    /// Joints of the arm in order.
    pub joints: Vec<String>,
    /// Effects that the format holds.
    pub held: Vec<Held>,
    /// Effects that it cannot hold.
    pub lost: Vec<Lost>,
    /// Other omissions and assumed values.
    pub notes: Vec<String>,
    /// Warnings on the arm.
    pub warnings: Vec<String>,
}

/// The model in another format, as the texts of the files to be written, `file` first, and what it could not hold.
///
/// # Errors
/// A chain that cannot be chosen.
pub fn export(
    robot: &GivenRobot,
    format: ExportFormat,
    file: &Path,
) -> Result<(Vec<(PathBuf, String)>, ExportReport), Failure> {
    let model = robot.arm(None)?;
    let (simulated, without_place) = model.simulated();
    let (name, without_place, exported) = match format {
        ExportFormat::Urdf => ("URDF", without_place, urdf(&simulated)),
        ExportFormat::Mjcf => ("MJCF", without_place, mjcf(&simulated)),
        ExportFormat::C => ("C", Vec::new(), controller(&model)),
    };
    let Exported { text, companion, held, lost, mut notes } = exported;
    let mut files = vec![(file.to_owned(), text)];
    files.extend(companion.map(|header| (file.with_file_name(header.file), header.text)));
    notes.extend(lost_notes(name, &lost));
    notes.extend(without_place.iter().map(|what| format!("omitted: {what}")));
    let report = ExportReport {
        schema: "armident.export/1",
        robot: model.chain.robot.clone(),
        model: robot.source.clone(),
        format: name,
        file: file.display().to_string(),
        header: files.get(1).map(|(path, _)| path.display().to_string()),
        joints: model.chain.joints.iter().map(|j| j.name.clone()).collect(),
        held,
        lost,
        notes,
        warnings: chain_warnings(&model),
    };
    Ok((files, report))
}

/// One note per omitted effect and reason.
fn lost_notes(format: &str, lost: &[Lost]) -> Vec<String> {
    let mut kinds: Vec<(&str, &str, Vec<String>)> = Vec::new();
    for one in lost {
        let values: Vec<String> = one.parameters.iter().map(|p| significant(*p, 3, 0.0)).collect();
        let entry = format!("{} {}", one.joint, values.join(" "));
        match kinds.iter_mut().find(|k| k.0 == one.effect && k.1 == one.reason) {
            Some((_, _, entries)) => entries.push(entry),
            None => kinds.push((&one.effect, one.reason, vec![entry])),
        }
    }
    let sentence = |(effect, reason, entries): &(&str, &str, Vec<String>)| {
        format!("{effect} omitted from {format} ({reason}): {}", entries.join(", "))
    };
    kinds.iter().map(sentence).collect()
}
