//! `armident export`.

use std::path::Path;

use armident_export::{Exported, Held, Lost, controller, mjcf, urdf};
use armident_report::significant;
use serde::Serialize;

use crate::args::{ExportArgs, FormatArg};
use crate::failure::{Failure, Outcome};
use crate::output::counted;
use crate::{output, robot};

/// What was written and what the format could not hold.
#[derive(Serialize)]
struct ExportReport {
    schema: &'static str,
    robot: String,
    model: String,
    format: &'static str,
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    header: Option<String>,
    joints: Vec<String>,
    held: Vec<Held>,
    lost: Vec<Lost>,
    notes: Vec<String>,
    warnings: Vec<String>,
}

pub(crate) fn run(args: &ExportArgs) -> Result<Outcome, Failure> {
    output::protect([args.robot.as_path()], [Some(&args.output_file), args.output.json.as_ref()])?;
    let to_stdout = output::is_stdout(&args.output_file);
    if to_stdout && args.output.json.as_deref().is_some_and(output::is_stdout) {
        return Err(Failure::new(
            "model and JSON cannot both be written to stdout",
            "--output-file, --json",
            Some("write one of them to a file"),
        ));
    }
    let format = match args.format {
        Some(format) => format,
        None => format_of(&args.output_file)?,
    };
    if to_stdout && format == FormatArg::C {
        return Err(Failure::new(
            "C source has a header beside it and cannot be written to stdout",
            "--output-file",
            Some("write it to a file, such as robot.c"),
        ));
    }
    let model = robot::load(&args.robot, &args.chain, None)?;
    let (simulated, without_place) = model.simulated();
    let (name, without_place, exported) = match format {
        FormatArg::Urdf => ("URDF", without_place, urdf(&simulated)),
        FormatArg::Mjcf => ("MJCF", without_place, mjcf(&simulated)),
        FormatArg::C => ("C", Vec::new(), controller(&model)),
    };
    let Exported { text, companion, held, lost, mut notes } = exported;
    let beside = |name: &String| args.output_file.with_file_name(name);
    let header = companion.as_ref().map(|header| beside(&header.file));
    notes.extend(lost_notes(name, &lost));
    notes.extend(without_place.iter().map(|what| format!("omitted: {what}")));
    let report = ExportReport {
        schema: "armident.export/1",
        robot: model.chain.robot.clone(),
        model: args.robot.display().to_string(),
        format: name,
        file: args.output_file.display().to_string(),
        header: header.as_ref().map(|path| path.display().to_string()),
        joints: model.chain.joints.iter().map(|j| j.name.clone()).collect(),
        held,
        lost,
        notes,
        warnings: model.chain.warnings.iter().map(ToString::to_string).collect(),
    };
    let said = if to_stdout {
        output::write_stdout(text.as_bytes())?;
        String::new()
    } else {
        output::write_file(&args.output_file, text.as_bytes())?;
        let mut files = report.file.clone();
        if let (Some(path), Some(header)) = (&header, &companion) {
            output::write_file(path, header.text.as_bytes())?;
            files += &format!(" and {}", path.display());
        }
        format!(
            "wrote {files} ({name}, {}; {} exported, {} omitted)\n",
            counted(report.joints.len(), "joint"),
            counted(report.held.len(), "effect"),
            report.lost.len()
        )
    };
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &said, &report, &report.warnings)
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

/// The format of a file extension.
fn format_of(path: &Path) -> Result<FormatArg, Failure> {
    let end = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match end.as_str() {
        "urdf" => Ok(FormatArg::Urdf),
        "xml" | "mjcf" => Ok(FormatArg::Mjcf),
        "c" => Ok(FormatArg::C),
        _ => Err(Failure::new(
            format!("cannot infer the output format from `{}`", path.display()),
            path.display(),
            Some("use the extension .urdf, .xml for MJCF, or .c, or pass --format"),
        )),
    }
}
