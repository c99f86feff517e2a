//! A comparison bandwidth below the usual one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::detail;
use crate::layout::Block;
use crate::results::DiagnoseReport;
use crate::section::{SectionData, Source};

/// Comparison bandwidth \[Hz\] where it is below the usual 10 Hz, because the fits of both bandwidths disagree.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct ComparisonBandwidth(pub f64);

impl SectionData for ComparisonBandwidth {
    const KEY: &'static str = "comparison_bandwidth_hz";
    const FORMER_KEYS: &'static [&'static str] = &["narrowed_to_hz"];

    fn of(source: &Source<'_>) -> Option<Self> {
        source.diagnosis.narrowed_to_hz.map(Self)
    }

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        let Self(hz) = self;
        detail(format!(
            "Comparison bandwidth reduced to {hz} Hz: the 10 Hz and {hz} Hz fits disagree (Hausman test, p < 0.001)."
        ))
    }

    fn page(&self, result: &DiagnoseReport) -> Vec<Block> {
        let cause = "Encoder jitter or controller feedback dominates above it.";
        let lines = self.text(result).into_iter();
        lines
            .map(|block| match block {
                Block::Item { text, .. } => Block::Item { text, detail: cause.to_owned() },
                other => other,
            })
            .collect()
    }
}
