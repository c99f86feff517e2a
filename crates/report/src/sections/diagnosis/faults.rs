//! Effort columns that failed an input check.

use crate::layout::Block;
use crate::results::DiagnoseReport;
use crate::section::{DiagnosisSection, Section};

/// Failed input checks. The page has them in its verdict.
pub(crate) struct Faults;

impl Section<DiagnoseReport> for Faults {
    fn key(&self) -> &'static str {
        "input-checks"
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let mut blocks = Vec::new();
        for fault in &result.input_checks.faults {
            blocks.push(Block::Paragraph(format!("{}{}", fault.prefix(), fault.message)));
            blocks.extend(fault.advice.iter().map(|advice| Block::item(format!("hint: {advice}"))));
        }
        let skipped = result.input_checks.unchecked.iter();
        blocks.extend(skipped.map(|why| Block::Paragraph(format!("Input checks skipped: {why}"))));
        blocks
    }

    fn page(&self, _: &DiagnoseReport) -> Vec<Block> {
        Vec::new()
    }
}

impl DiagnosisSection for Faults {}
