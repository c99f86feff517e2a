//! `armident info`.

use std::path::PathBuf;

use armident_commands::{ChainOptions, Failure, GivenRobot, expand, info};

use super::recordings::reading_options;
use crate::args::InfoArgs;
use crate::failure::Outcome;
use crate::output;

pub(crate) fn run(args: &InfoArgs) -> Result<Outcome, Failure> {
    let files = expand(&args.recordings)?;
    let inputs = files.iter().chain(&args.robot).map(PathBuf::as_path);
    output::protect(inputs, [args.output.json.as_ref(), args.write_mapping.as_ref()])?;
    let joints = match &args.robot {
        Some(path) => GivenRobot::open(path, ChainOptions::default())?.joint_names()?,
        None => Vec::new(),
    };
    let report = info(&files, &joints, &reading_options(&args.reading))?;
    if let Some(path) = &args.write_mapping {
        output::write_file(path, report.mapping()?.as_bytes())?;
    }
    output::write_result(&args.output, &report.text(), &report, &report.warnings())
}
