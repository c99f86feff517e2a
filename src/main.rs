//! Command line of armident: arguments in, exit code out. All computation is in the crates.

mod analysis;
mod args;
mod commands;
mod failure;
mod output;
mod page;
mod progress;
mod robot;

use std::process::ExitCode;

use clap::Parser;

use args::Cli;
use failure::Outcome;

/// Exit code of shells for a program ended by SIGINT.
const INTERRUPTED: i32 = 130;

fn main() -> ExitCode {
    stop_cleanly();
    let outcome = commands::run(&Cli::parse().command);
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::FailedOnRequest) => ExitCode::from(3),
        Err(failure) => {
            failure::print(&failure);
            ExitCode::FAILURE
        }
    }
}

/// Removes partial files on Ctrl-C.
fn stop_cleanly() {
    // without a handler a `.part` file may remain
    let _ = ctrlc::set_handler(|| {
        armident_recording::remove_partial_files();
        std::process::exit(INTERRUPTED);
    });
}
