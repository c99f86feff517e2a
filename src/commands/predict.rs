//! `armident predict`.

use armident_commands::{Failure, Predicted, predict, predict_closed_loop};

use super::recordings;
use crate::args::PredictArgs;
use crate::failure::Outcome;
use crate::output::counted;
use crate::progress::Progress;
use crate::{output, robot};

pub(crate) fn run(args: &PredictArgs) -> Result<Outcome, Failure> {
    output::protect(
        [args.robot.as_path(), args.motion.as_path()],
        [Some(&args.output_file), args.output.json.as_ref()],
    )?;
    let json_on_stdout = args.output.json.as_deref().is_some_and(output::is_stdout);
    if output::is_stdout(&args.output_file) && json_on_stdout {
        return Err(Failure::new(
            "prediction and JSON cannot both be written to stdout",
            "--output-file, --json",
            Some("write one of them to a file"),
        ));
    }
    let mut motions =
        recordings::read_all(std::slice::from_ref(&args.motion), &args.reading, &args.output)?;
    let motion = motions.remove(0);
    let robot = robot::open(&args.robot, &args.chain)?;
    let progress = Progress::of(&args.output, "predicting");
    let Predicted { report, channels } = if args.closed_loop {
        predict_closed_loop(&robot, &motion, args.servo_gain)?
    } else {
        predict(&robot, &motion, args.cutoff_hz)?
    };
    drop(progress);
    let bytes = recordings::encoded(&channels, &args.output_file, &args.output)?;
    let to_stdout = output::is_stdout(&args.output_file);
    let text = if to_stdout {
        output::write_stdout(&bytes)?;
        String::new()
    } else {
        output::write_file(&args.output_file, &bytes)?;
        format!(
            "wrote {} ({}, {})\n",
            args.output_file.display(),
            counted(report.joints.len(), "joint"),
            counted(report.samples, "sample")
        )
    };
    output::say_all(&args.output, "note", &report.notes);
    output::write_result(&args.output, &text, &report, &report.warnings)
}
