//! `export`: a model in another format.

use std::path::Path;

use armident_export::{Exported, Held, Lost, mjcf, urdf};
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
            _ => Err(Failure::new(
                format!("cannot infer the output format from `{}`", path.display()),
                path.display(),
                Some("use the extension .urdf, or .xml for MJCF, or pass --format"),
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

/// Text of the model in another format, which is to be written to `file`, and what it could not hold.
///
/// # Errors
/// A chain that cannot be chosen.
pub fn export(
    robot: &GivenRobot,
    format: ExportFormat,
    file: &Path,
) -> Result<(String, ExportReport), Failure> {
    let (model, without_place) = robot.arm(None)?.simulated();
    let (name, Exported { text, held, lost, mut notes }) = match format {
        ExportFormat::Urdf => ("URDF", urdf(&model)),
        ExportFormat::Mjcf => ("MJCF", mjcf(&model)),
    };
    notes.extend(lost_notes(name, &lost));
    notes.extend(without_place.iter().map(|what| format!("omitted: {what}")));
    let report = ExportReport {
        schema: "armident.export/1",
        robot: model.chain.robot.clone(),
        model: robot.source.clone(),
        format: name,
        file: file.display().to_string(),
        joints: model.chain.joints.iter().map(|j| j.name.clone()).collect(),
        held,
        lost,
        notes,
        warnings: chain_warnings(&model),
    };
    Ok((text, report))
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
