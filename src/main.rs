//! The command line of armident: arguments in, exit code out; what is computed is computed in the
//! crates.

mod analysis;
mod args;
mod commands;
mod excerpt;
mod failure;
mod output;
mod page;
mod progress;
mod robot;

use std::process::ExitCode;

use clap::Parser;

use args::Cli;
use failure::Outcome;

/// As shells report a program that SIGINT ended.
const INTERRUPTED: i32 = 130;

fn main() -> ExitCode {
    stop_cleanly();
    let outcome = commands::run(&Cli::parse().command);
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::FailedOnRequest) => ExitCode::from(3),
        Err(failure) => {
            failure.print();
            ExitCode::FAILURE
        }
    }
}

/// Ctrl-C leaves no half-written file.
fn stop_cleanly() {
    // without a handler the program ends at once, and a `.part` file may stay
    let _ = ctrlc::set_handler(|| {
        armident_recording::remove_partial_files();
        std::process::exit(INTERRUPTED);
    });
}
