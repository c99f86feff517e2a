//! `armident fleet`.

use armident_commands::{Failure, FleetOptions, fleet};
use armident_page::Drawing;

use super::recordings::reading_options;
use crate::args::FleetArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, page, robot};

pub(crate) fn run(args: &FleetArgs) -> Result<Outcome, Failure> {
    let inputs = args.inputs.iter().chain([&args.robot]).map(std::path::PathBuf::as_path);
    let outputs = [args.output.json.as_ref(), args.page.report.as_ref()];
    output::protect(inputs, outputs)?;
    args.page.check()?;
    let robot = robot::open(&args.robot, &args.chain)?;
    let options = FleetOptions {
        robot_of: args.robot_of.clone(),
        states: args.states.clone(),
        cutoff_hz: args.cutoff_hz,
        false_alarm_rate: args.false_alarm_rate,
        reading: reading_options(&args.reading),
    };
    let progress = Progress::through(&args.output, "recordings and robots", args.inputs.len());
    let found = fleet(&robot, &args.inputs, &options, || progress.part_done())?;
    drop(progress);
    let drawing = page::drawn(&args.page, [&args.robot], || Ok(Drawing::default()))?;
    let warnings = &found.warnings;
    page::write_result(&args.page, &args.output, &found.text(), &found, warnings, drawing.as_ref())
}
