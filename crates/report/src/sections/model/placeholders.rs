//! Links whose given inertials were not measured.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::detail;
use crate::layout::Block;
use crate::results::DiagnoseReport;
use crate::section::{SectionData, Source};

/// Links whose given inertials are placeholders: equal for most links, zero, or wider than the arm.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct PlaceholderLinks(pub Vec<String>);

impl SectionData for PlaceholderLinks {
    const KEY: &'static str = "placeholder_links";

    fn of(source: &Source<'_>) -> Option<Self> {
        let links = &source.diagnosis.placeholder_links;
        (!links.is_empty()).then(|| Self(links.clone()))
    }

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        let Self(links) = self;
        detail(format!(
            "The given inertials are placeholders (equal for most links, zero, or wider than the arm): {}. These links are \
             fitted without a prior, and the effort columns are not checked against them.",
            links.join(", ")
        ))
    }
}
