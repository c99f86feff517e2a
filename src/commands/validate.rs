//! `armident validate`.

use std::path::PathBuf;

use armident_commands::{Failure, expand, validate};

use super::recordings;
use crate::args::ValidateArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, page, robot};

pub(crate) fn run(args: &ValidateArgs) -> Result<Outcome, Failure> {
    let files = expand(&args.recordings)?;
    let inputs = files.iter().chain([&args.robot]).map(PathBuf::as_path);
    output::protect(
        inputs,
        [
            args.output.json.as_ref(),
            args.predictions.as_ref(),
            args.mcap.as_ref(),
            args.page.report.as_ref(),
        ],
    )?;
    args.page.check()?;
    recordings::check_mcap(args.mcap.as_ref())?;
    let recorded = recordings::read_all(&files, &args.reading, &args.output)?;
    if args.predictions.is_some() && recorded.len() != 1 {
        return Err(Failure::new(
            format!("--predictions requires one recording, found {}", recorded.len()),
            "--predictions",
            Some("pass one recording, or run `armident predict` for each"),
        ));
    }
    let robot = robot::open(&args.robot, &args.chain)?;
    let found = {
        let _progress = Progress::of(&args.output, "validating");
        validate(&robot, recorded, args.cutoff_hz, !args.no_replay, &args.servo_gain)?
    };
    if let Some(path) = &args.predictions {
        let predicted = found.prediction(&found.recordings[0])?;
        let bytes = recordings::encoded(&predicted, path, &args.output)?;
        output::write_file(path, &bytes)?;
    }
    if let Some(path) = &args.mcap {
        recordings::write_mcap(path, found.mcap()?, &args.output)?;
    }
    output::say_all(&args.output, "note", &found.report.notes);
    let files = [&args.robot].into_iter().chain(&files).chain(&args.reading.mapping);
    let drawing = page::drawn(&args.page, files, || found.drawing())?;
    let report = &found.report;
    let (text, warnings) = (report.text(output::bars()), &report.warnings);
    page::write_result(&args.page, &args.output, &text, report, warnings, drawing.as_ref())
}
