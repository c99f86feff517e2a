//! Errors of all link inertias together.

use super::detail::detail;
use crate::layout::{Block, percent};
use crate::results::DiagnoseReport;
use crate::section::{DiagnosisSection, Section};

/// Prior scale of the link inertias.
pub(crate) struct LinkErrors;

impl Section<DiagnoseReport> for LinkErrors {
    fn key(&self) -> &'static str {
        "prior_scale"
    }

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        Vec::new()
    }

    fn page(&self, result: &DiagnoseReport) -> Vec<Block> {
        if result.prior_scale.is_nan() || result.prior_scale <= 0.0 {
            return Vec::new();
        }
        let material = match result.link_errors_material_on.is_empty() {
            true => String::new(),
            false => {
                format!(", which is material on {}", result.link_errors_material_on.join(", "))
            }
        };
        detail(format!(
            "Link inertias differ from the given model by about {} (prior scale){material}.",
            percent(result.prior_scale)
        ))
    }
}

impl DiagnosisSection for LinkErrors {}
