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
        None => ExportFormat::of_path(&args.output_file)?,
    };
    let robot = robot::open(&args.robot, &args.chain)?;
    let (text, report) = export(&robot, format, &args.output_file)?;
    let said = if to_stdout {
        output::write_stdout(text.as_bytes())?;
        String::new()
    } else {
        output::write_file(&args.output_file, text.as_bytes())?;
        format!(
            "wrote {} ({}, {}; {} exported, {} omitted)\n",
            report.file,
            report.format,
            counted(report.joints.len(), "joint"),
            counted(report.held.len(), "effect"),
            report.lost.len()
        )
    };
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &said, &report, &report.warnings)
}
