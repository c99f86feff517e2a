//! How failures are printed, and outcomes of commands.

use armident_commands::Failure;
use clap::builder::styling::{AnsiColor, Style};

/// Outcome of a command whose result was written.
pub(crate) enum Outcome {
    /// Exit code 0, for any verdict.
    Done,
    /// Exit code 3: the condition of `--fail-on` is met.
    FailedOnRequest,
}

/// Warnings and notes; clap has its own.
pub(crate) const WARNING: Style = AnsiColor::Yellow.on_default().bold();
pub(crate) const NOTE: Style = AnsiColor::Cyan.on_default().bold();
const ERROR: Style = AnsiColor::Red.on_default().bold();
const DIM: Style = Style::new().bold();

/// The three lines on stderr.
pub(crate) fn print(failure: &Failure) {
    anstream::eprintln!("{ERROR}error:{ERROR:#} {}", failure.what());
    if !failure.place().is_empty() {
        anstream::eprintln!("   {DIM}in:{DIM:#} {}", failure.place());
    }
    if let Some(excerpt) = failure.excerpt() {
        anstream::eprintln!("{}", excerpt.styled());
    }
    if let Some(hint) = failure.hint() {
        anstream::eprintln!(" {DIM}hint:{DIM:#} {hint}");
    }
}
