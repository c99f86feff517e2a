//! `armident accumulate`.

use std::path::PathBuf;

use armident_commands::{Failure, Reduction, accumulate, recordings_to_reduce};

use super::recordings::reading_options;
use crate::args::AccumulateArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, robot};

pub(crate) fn run(args: &AccumulateArgs) -> Result<Outcome, Failure> {
    let files = recordings_to_reduce(&args.recordings, &args.output_file)?;
    let inputs = files.iter().chain([&args.robot]).map(PathBuf::as_path);
    output::protect(inputs, [Some(&args.output_file), args.output.json.as_ref()])?;
    let robot = robot::open(&args.robot, &args.chain)?;
    let reading = reading_options(&args.reading);
    let progress = Progress::through(&args.output, "reducing recordings", files.len());
    let done = || progress.part_done();
    let how = Reduction { cutoff_hz: args.cutoff_hz, reading: &reading, robot_column: None };
    let report = accumulate(&robot, &files, &args.output_file, &how, done)?;
    drop(progress);
    output::write_result(&args.output, &report.text(), &report, &[])
}
