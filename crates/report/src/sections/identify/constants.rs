//! The minimal set.

use super::titles::MINIMAL_SET;
use crate::layout::Block;
use crate::results::IdentifyReport;
use crate::results::constants::{page_table, text_table};
use crate::section::Section;

/// Constants with their standard errors beside the URDF's values.
pub(crate) struct Constants;

impl Section<IdentifyReport> for Constants {
    fn key(&self) -> &'static str {
        "constants"
    }

    fn text(&self, result: &IdentifyReport) -> Vec<Block> {
        vec![
            Block::heading_with_note("Inertia constants", "minimal set"),
            text_table(&result.constants, &result.joints),
        ]
    }

    fn page(&self, result: &IdentifyReport) -> Vec<Block> {
        vec![
            Block::heading(MINIMAL_SET),
            page_table(&result.constants),
            Block::Figure("intervals".to_owned()),
            Block::Figure("correlation".to_owned()),
        ]
    }
}
