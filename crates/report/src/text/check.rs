//! Text of `armident check`.

use crate::layout::{Bars, render, significant};
use crate::results::{CheckReport, CheckVerdict};
use crate::sections;
use crate::words::counted;

impl CheckReport {
    /// Human-readable text.
    pub fn text(&self) -> String {
        let counts = CheckVerdict::WORST_FIRST
            .map(|verdict| format!("{} {}", self.count(verdict), verdict.word()))
            .join(", ");
        let low_pass = self
            .cutoff_hz
            .map_or_else(String::new, |hz| format!(", low-pass {} Hz", significant(hz, 3, 0.0)));
        let blocks = sections::CHECK.iter().flat_map(|section| section.text(self));
        format!(
            "{}: {counts} ({}{low_pass})\n{}",
            self.robot,
            counted(self.recordings.len(), "recording"),
            render(blocks, Bars::default())
        )
    }
}
