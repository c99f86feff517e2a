//! `armident params`.

use armident_commands::{Failure, params};

use crate::args::ParamsArgs;
use crate::failure::Outcome;
use crate::{output, robot};

pub(crate) fn run(args: &ParamsArgs) -> Result<Outcome, Failure> {
    output::protect([args.robot.as_path()], [args.output.json.as_ref()])?;
    let (report, notes) = params(&robot::open(&args.robot, &args.chain)?)?;
    output::say_all(&args.output, "note", &notes);
    output::write_result(&args.output, &report.text(), &report, report.warnings())
}
