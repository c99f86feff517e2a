//! `armident merge`.

use armident_commands::{Failure, merge};

use crate::args::MergeArgs;
use crate::failure::Outcome;
use crate::{output, robot};

pub(crate) fn run(args: &MergeArgs) -> Result<Outcome, Failure> {
    let inputs = args.states.iter().chain([&args.robot]).map(std::path::PathBuf::as_path);
    output::protect(inputs, [args.save_model.as_ref(), args.output.json.as_ref()])?;
    let found = merge(&robot::open(&args.robot, &args.chain)?, &args.states)?;
    if let Some(path) = &args.save_model {
        found.model.save(path).map_err(|error| Failure::unwritable(path, &error))?;
    }
    output::write_result(&args.output, &found.report.text(), &found.report, &[])
}
