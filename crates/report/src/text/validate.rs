//! Text of `armident validate`.

use crate::layout::{Bars, render, significant};
use crate::results::ValidateReport;
use crate::sections;
use crate::words::counted;

impl ValidateReport {
    /// Human-readable text.
    pub fn text(&self, bars: Bars) -> String {
        let low_pass = self
            .cutoff_hz
            .map_or_else(String::new, |hz| format!(", low-pass {} Hz", significant(hz, 3, 0.0)));
        let blocks = sections::VALIDATE.iter().flat_map(|section| section.text(self));
        format!(
            "{}: {} validated on {}{low_pass}\n{}",
            self.robot,
            self.model,
            counted(self.recordings.len(), "recording"),
            render(blocks, bars)
        )
    }
}
