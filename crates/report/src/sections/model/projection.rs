//! Projection to physically consistent links.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::detail;
use crate::layout::{Block, significant};
use crate::results::DiagnoseReport;
use crate::section::{SectionData, Source};

/// Distance \[standard errors\] between the estimated link inertias and those of the model, which are the nearest
/// physically consistent ones; absent where the estimate is physically consistent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct Projection(pub f64);

impl SectionData for Projection {
    const KEY: &'static str = "projection_standard_errors";
    const FORMER_KEYS: &'static [&'static str] = &["links_off_standard_errors"];

    fn of(source: &Source<'_>) -> Option<Self> {
        source.diagnosis.links_off.map(Self)
    }

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        detail(format!(
            "Link inertias are projected to the nearest physically consistent ones, {} standard errors from the \
             estimate.",
            significant(self.0, 3, 0.0)
        ))
    }
}
