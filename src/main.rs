//! The command line of armident: arguments in, exit code out; what is computed is computed in the
//! crates.

mod args;
mod commands;
mod failure;
mod output;
mod page;
mod progress;
mod robot;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use failure::Outcome;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome = match &cli.command {
        Command::Params(args) => commands::params::run(args),
        Command::Plan(args) => commands::plan::run(args),
        Command::Simulate(args) => commands::simulate::run(args),
        Command::Check(args) => commands::check::run(args),
        Command::Identify(args) => commands::identify::run(args),
        Command::Diagnose(args) => commands::diagnose::run(args),
        Command::Validate(args) => commands::validate::run(args),
        Command::Predict(args) => commands::predict::run(args),
        Command::Export(args) => commands::export::run(args),
        Command::Report(args) => commands::report::run(args),
        Command::Demo(args) => commands::demo::run(args),
        Command::Completions(args) => commands::shell::completions(args),
        Command::Man(args) => commands::shell::man(args),
        Command::Challenge(args) => commands::challenge::run(args),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::FailedOnRequest) => ExitCode::from(3),
        Err(failure) => {
            failure.print();
            ExitCode::FAILURE
        }
    }
}
