//! Text of two results side by side.

use crate::layout::{Bars, render};
use crate::results::ComparisonReport;
use crate::sections;

impl ComparisonReport {
    /// Human-readable text.
    pub fn text(&self, bars: Bars) -> String {
        let files = self.results.iter().zip(["first", "second"]);
        let files: String =
            files.map(|(result, which)| format!("  {which}: {}\n", result.file)).collect();
        let blocks = sections::COMPARISON.iter().flat_map(|section| section.text(self));
        format!("{}\n{files}{}", self.sentence, render(blocks, bars))
    }
}
