//! Progress on stderr.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::args::OutputArgs;

const TICK: Duration = Duration::from_millis(120);

/// A progress line on stderr, removed on drop; hidden with `--quiet` or if stderr is not a terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A task of unknown length.
    pub(crate) fn of(output: &OutputArgs, doing: &str) -> Self {
        Self::new(output, ProgressBar::new_spinner(), "{spinner} {msg} ({elapsed})", doing)
    }

    /// A task with a known number of parts.
    pub(crate) fn through(output: &OutputArgs, doing: &str, parts: usize) -> Self {
        let style = "{spinner} {msg} [{bar:30}] {pos} of {len} ({elapsed})";
        Self::new(output, ProgressBar::new(parts as u64), style, doing)
    }

    fn new(output: &OutputArgs, bar: ProgressBar, style: &str, doing: &str) -> Self {
        if output.quiet {
            return Self { bar: ProgressBar::hidden() };
        }
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        bar.set_message(doing.to_owned());
        bar.enable_steady_tick(TICK);
        Self { bar }
    }

    /// Marks one part as done.
    pub(crate) fn part_done(&self) {
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
