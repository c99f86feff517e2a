//! Findings of two diagnoses.

use super::parameters::table;
use crate::layout::{Block, Table};
use crate::results::ComparisonReport;
use crate::section::Section;

/// Findings in both diagnoses and in one alone, and parameters of those in both.
pub(crate) struct Findings;

impl Section<ComparisonReport> for Findings {
    fn key(&self) -> &'static str {
        "findings"
    }

    fn text(&self, result: &ComparisonReport) -> Vec<Block> {
        if result.findings.is_empty() {
            return Vec::new();
        }
        let rows = result.findings.iter().map(|finding| {
            let mut row = vec![finding.finding.clone()];
            for side in 0..2 {
                row.push(match (finding.confidence[side], finding.confirmed[side]) {
                    (None, _) => "-".to_owned(),
                    (Some(confidence), Some(true)) => format!("{confidence:.2}, confirmed"),
                    (Some(confidence), Some(false)) => format!("{confidence:.2}, not confirmed"),
                    (Some(confidence), None) => format!("{confidence:.2}"),
                });
            }
            row
        });
        let summary = Table::new("Findings", &["finding", "first", "second"]).with(rows);
        let both = result.findings.iter().filter(|finding| finding.present == [true; 2]);
        let parameters = both.flat_map(|finding| &finding.parameters);
        let parameters = table("Parameters of findings in both results", parameters);
        let mut blocks = vec![
            Block::heading_with_note("Findings", "confidence; - where a result has none"),
            Block::Table(summary),
        ];
        if !parameters.rows.is_empty() {
            blocks.push(Block::Subheading("Parameters of findings in both results".to_owned()));
            blocks.push(Block::Table(parameters));
        }
        blocks
    }
}
