//! `armident export`.

use std::path::PathBuf;

use armident_commands::{ExportFormat, Failure, FalseAlarms, expand, export};

use super::recordings;

use crate::args::{ExportArgs, FormatArg};
use crate::failure::Outcome;
use crate::output::counted;
use crate::{output, robot};

pub(crate) fn run(args: &ExportArgs) -> Result<Outcome, Failure> {
    let (contact_free, holdout) = (expand(&args.without_contact)?, expand(&args.holdout)?);
    let inputs = contact_free.iter().chain(&holdout).chain([&args.robot]);
    let outputs = [Some(&args.output_file), args.output.json.as_ref()];
    output::protect(inputs.map(|path| path.as_path()), outputs)?;
    let to_stdout = output::is_stdout(&args.output_file);
    if to_stdout && args.output.json.as_deref().is_some_and(output::is_stdout) {
        return Err(Failure::new(
            "model and JSON cannot both be written to stdout",
            "--output-file, --json",
            Some("write one of them to a file"),
        ));
    }
    let format = match args.format {
        Some(FormatArg::Urdf) => ExportFormat::Urdf,
        Some(FormatArg::Mjcf) => ExportFormat::Mjcf,
        Some(FormatArg::DrakeSdf) => ExportFormat::DrakeSdf,
        Some(FormatArg::IsaacLab) => ExportFormat::IsaacLab,
        Some(FormatArg::Usd) => ExportFormat::Usd,
        Some(FormatArg::C) => ExportFormat::C,
        None => ExportFormat::of_path(&args.output_file)?,
    };
    if to_stdout && format == ExportFormat::C {
        return Err(Failure::new(
            "C source has a header beside it and cannot be written to stdout",
            "--output-file",
            Some("write it to a file, such as robot.c"),
        ));
    }
    let robot = robot::open(&args.robot, &args.chain)?;
    let read = |files: &[PathBuf]| recordings::read_all(files, &args.reading, &args.output);
    let (contact_free, holdout) = (read(&contact_free)?, read(&holdout)?);
    let false_alarms = args.false_alarms_per_hour.map(|per_hour| FalseAlarms {
        per_hour,
        gain: args.observer_gain,
        recordings: &contact_free,
        holdout: &holdout,
    });
    let (files, report) = export(&robot, format, &args.output_file, false_alarms)?;
    let said = if to_stdout {
        for (_, text) in &files {
            output::write_stdout(text.as_bytes())?;
        }
        String::new()
    } else {
        for (path, text) in &files {
            output::write_file(path, text.as_bytes())?;
        }
        let names: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
        format!(
            "wrote {} ({}, {}; {} exported, {} omitted)\n",
            names.join(" and "),
            report.format,
            counted(report.joints.len(), "joint"),
            counted(report.held.len(), "effect"),
            report.lost.len()
        ) + &report.thresholds.as_ref().map_or_else(String::new, |thresholds| thresholds.text())
    };
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &said, &report, &report.warnings)
}
