//! `armident excite`.

use std::time::Duration;

use armident_commands::{ExciteOptions, Failure, excite, expand};
use armident_excitation::SuiteSettings;

use super::recordings;
use crate::args::ExciteArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, robot};

pub(crate) fn run(args: &ExciteArgs) -> Result<Outcome, Failure> {
    let read = [Some(args.robot.as_path()), args.diagnosis.as_deref()];
    output::protect(read.into_iter().flatten(), [args.output.json.as_ref()])?;
    let robot = robot::open(&args.robot, &args.chain)?;
    let files = expand(&args.given)?;
    let given = recordings::read_all(&files, &args.reading, &args.output)?;
    let options = ExciteOptions {
        limits: args.limits.as_deref(),
        keep_out: args.keep_out.as_deref(),
        diagnosis: args.diagnosis.as_deref(),
        formats: &args.format,
        given: &given,
        settings: SuiteSettings {
            seconds: args.seconds,
            rate_hz: args.rate_hz,
            budget: Duration::from_secs_f64(args.budget),
            seed: args.seed,
            parts: args.only.clone(),
        },
    };
    let found = {
        let _progress = Progress::of(&args.output, "designing motions");
        excite(&robot, &options)?
    };
    output::create_folder(&args.output_folder)?;
    for (name, bytes) in &found.files {
        output::write_file(&args.output_folder.join(name), bytes)?;
    }
    output::say_all(&args.output, "note", &found.notes);
    output::write_result(&args.output, &found.report.text(), &found.report, &found.warnings)
}
