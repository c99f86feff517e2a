//! The placebo test.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::Block;
use crate::results::DiagnoseReport;
use crate::section::SectionData;

/// Result of the placebo test: what the selection makes of terms that are known to be wrong. With `--placebo`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PlaceboTest {
    /// Wrong terms tried.
    pub terms: usize,
    /// Terms that lower the cross-validated error by more than its standard error.
    #[serde(alias = "improve")]
    pub improving: usize,
    /// Terms that would be reported.
    #[serde(alias = "named")]
    pub reported: usize,
    /// Materiality of the largest term over the materiality threshold.
    #[serde(alias = "largest")]
    pub largest_over_threshold: f64,
}

impl From<armident_diagnose::Placebo> for PlaceboTest {
    fn from(found: armident_diagnose::Placebo) -> Self {
        Self {
            terms: found.terms,
            improving: found.improve,
            reported: found.named,
            largest_over_threshold: found.largest,
        }
    }
}

impl SectionData for PlaceboTest {
    const KEY: &'static str = "placebo";

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        let Self { terms, improving, reported, largest_over_threshold } = self;
        vec![Block::Paragraph(format!(
            "Placebo test: of {terms} wrong terms, {improving} lower the cross-validated error and {reported} would be \
             reported; the largest reaches {:.0} % of the materiality threshold.",
            100.0 * largest_over_threshold
        ))]
    }

    fn page(&self, result: &DiagnoseReport) -> Vec<Block> {
        [vec![Block::heading("Placebo test")], self.text(result)].concat()
    }
}
