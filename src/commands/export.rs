//! `armident export`.

use armident_commands::{ExportFormat, Failure, export};

use crate::args::{ExportArgs, FormatArg};
use crate::failure::Outcome;
use crate::output::counted;
use crate::{output, robot};

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
        Some(FormatArg::Urdf) => ExportFormat::Urdf,
        Some(FormatArg::Mjcf) => ExportFormat::Mjcf,
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
    let (files, report) = export(&robot, format, &args.output_file)?;
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
        )
    };
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &said, &report, &report.warnings)
}
