//! `armident convert`.

use armident_commands::{Failure, expand};
use armident_recording::Formats;
use serde::Serialize;

use super::recordings;
use crate::args::ConvertArgs;
use crate::failure::Outcome;
use crate::output;
use crate::output::counted;

/// What was converted.
#[derive(Serialize)]
struct ConvertReport {
    schema: &'static str,
    recording: String,
    file: String,
    format: &'static str,
    joints: Vec<String>,
    samples: usize,
    notes: Vec<String>,
}

pub(crate) fn run(args: &ConvertArgs) -> Result<Outcome, Failure> {
    let path = &args.output_file;
    output::protect([args.recording.as_path()], [Some(path), args.output.json.as_ref()])?;
    let written = Formats::standard().written_extensions();
    let extension =
        path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !written.contains(&extension.as_str()) {
        return Err(Failure::new(
            format!("no format that is written has the extension `{extension}`"),
            path.display(),
            Some(format!("end the name in .{}", written.join(", ."))),
        ));
    }
    let files = expand(std::slice::from_ref(&args.recording))?;
    if files.len() > 1 {
        let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        return Err(Failure::new(
            format!("{} recordings in the folder, one is converted at a time", files.len()),
            args.recording.display(),
            Some(format!("pass one of {}", names.join(", "))),
        ));
    }
    let recording = recordings::read_all(&files, &args.reading, &args.output)?.remove(0);
    let bytes = recordings::encoded(&recording, path, &args.output)?;
    output::write_file(path, &bytes)?;
    let report = ConvertReport {
        schema: "armident.convert/1",
        recording: recording.source.clone(),
        file: path.display().to_string(),
        format: Formats::standard().by_extension(path).name(),
        joints: recording.joint_names().into_iter().map(str::to_owned).collect(),
        samples: recording.len(),
        notes: recording.notes.clone(),
    };
    let text = format!(
        "wrote {} ({}, {}, {})\n",
        report.file,
        report.format,
        counted(report.joints.len(), "joint"),
        counted(report.samples, "sample")
    );
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &text, &report, &[])
}
