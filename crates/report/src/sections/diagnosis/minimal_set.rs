//! The minimal set of the diagnosed arm.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::Block;
use crate::results::constants::page_table;
use crate::results::{ConstantRow, DiagnoseReport};
use crate::section::{SectionData, Source};

/// Link constants estimated jointly with all findings; absent where the recordings are consistent with the given
/// inertias.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct MinimalSetEstimate(pub Vec<ConstantRow>);

impl SectionData for MinimalSetEstimate {
    const KEY: &'static str = "constants";

    fn of(source: &Source<'_>) -> Option<Self> {
        let found = &source.diagnosis.constants.as_ref()?.constants;
        (!found.is_empty()).then(|| Self(found.iter().map(ConstantRow::of).collect()))
    }

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        Vec::new()
    }

    fn page(&self, _: &DiagnoseReport) -> Vec<Block> {
        let about = "Link constants estimated jointly with all findings. Prior share: part of the information that \
                     comes from the URDF.";
        vec![
            Block::heading("Minimal set"),
            Block::Line(about.to_owned()),
            page_table(&self.0),
            Block::Figure("intervals".to_owned()),
            Block::Figure("correlation".to_owned()),
        ]
    }
}
