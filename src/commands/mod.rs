//! One file a command: read, call, write.

pub(crate) mod accumulate;
pub(crate) mod challenge;
pub(crate) mod check;
pub(crate) mod convert;
pub(crate) mod demo;
pub(crate) mod diagnose;
pub(crate) mod excite;
pub(crate) mod export;
pub(crate) mod fleet;
pub(crate) mod identify;
pub(crate) mod info;
pub(crate) mod merge;
pub(crate) mod params;
pub(crate) mod plan;
pub(crate) mod predict;
pub(crate) mod recordings;
pub(crate) mod report;
pub(crate) mod run;
pub(crate) mod shell;
pub(crate) mod simulate;
pub(crate) mod validate;

use crate::args::Command;
use crate::failure::Outcome;
use armident_commands::Failure;

/// Runs a command.
pub(crate) fn run(command: &Command) -> Result<Outcome, Failure> {
    match command {
        Command::Params(args) => params::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Excite(args) => excite::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Info(args) => info::run(args),
        Command::Convert(args) => convert::run(args),
        Command::Check(args) => check::run(args),
        Command::Identify(args) => identify::run(args),
        Command::Diagnose(args) => diagnose::run(args),
        Command::Accumulate(args) => accumulate::run(args),
        Command::Fleet(args) => fleet::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Validate(args) => validate::run(args),
        Command::Predict(args) => predict::run(args),
        Command::Export(args) => export::run(args),
        Command::Report(args) => report::run(args),
        Command::Run(args) => run::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Completions(args) => shell::completions(args),
        Command::Man(args) => shell::man(args),
        Command::Challenge(args) => challenge::run(args),
    }
}
