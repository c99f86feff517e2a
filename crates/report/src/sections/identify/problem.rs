//! The least-squares problem.

use super::titles::FIT;
use crate::layout::{Block, percent, significant};
use crate::results::IdentifyReport;
use crate::section::Section;

/// Size and condition of the least-squares problem. A terminal has them in its first lines.
pub(crate) struct Problem;

impl Section<IdentifyReport> for Problem {
    fn key(&self) -> &'static str {
        "fit"
    }

    fn text(&self, _: &IdentifyReport) -> Vec<Block> {
        Vec::new()
    }

    fn page(&self, result: &IdentifyReport) -> Vec<Block> {
        let low_pass = result
            .cutoff_hz
            .map_or_else(|| "none".to_owned(), |hz| format!("{} Hz", significant(hz, 3, 0.0)));
        let pairs = [
            ("method", result.method_in_words().to_owned()),
            ("rank", format!("{} of {}", result.rank, result.parameters)),
            ("condition number", significant(result.condition, 3, 0.0)),
            ("rows", result.rows.to_string()),
            ("effective sample size", percent(result.effective_sample_share)),
            ("low-pass", low_pass),
            ("velocities from", result.velocities.clone()),
        ];
        let pairs = pairs.into_iter().map(|(name, value)| (name.to_owned(), value));
        vec![Block::heading(FIT), Block::KeyValues(pairs.collect())]
    }
}
