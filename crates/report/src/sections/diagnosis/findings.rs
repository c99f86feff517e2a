//! Findings.

use super::next_motion::NextMotionResult;
use crate::layout::Block;
use crate::results::{AlternativeRow, DiagnoseReport, FindingRow};
use crate::section::{DiagnosisSection, Section};
use crate::words::{parameter_label, sentence};

/// All findings. The page has a card for each, with its chart.
pub(crate) struct Findings;

impl Section<DiagnoseReport> for Findings {
    fn key(&self) -> &'static str {
        "findings"
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        if result.findings.is_empty() {
            return Vec::new();
        }
        let title = "Findings, most material first";
        let heading = Block::heading_with_note(title, "estimate \u{b1} standard error");
        let is_searched = result.section::<NextMotionResult>().is_some();
        let findings = result.findings.iter().flat_map(|finding| paragraph(finding, is_searched));
        std::iter::once(heading).chain(findings).collect()
    }

    fn page(&self, _: &DiagnoseReport) -> Vec<Block> {
        Vec::new()
    }
}

impl DiagnosisSection for Findings {}

fn paragraph(finding: &FindingRow, next_motion_is_searched: bool) -> Vec<Block> {
    let confirmed = match finding.confirmed {
        Some(true) => ", confirmed",
        Some(false) => ", not confirmed",
        None => "",
    };
    let title = finding.title();
    let mut blocks = vec![Block::Subheading(format!(
        "{title} (confidence {:.2}{confirmed})",
        finding.confidence
    ))];
    let needed = finding.parameters.iter().filter(|(_, estimate)| estimate.is_needed());
    blocks.push(Block::KeyValues(
        needed.map(|(name, estimate)| (parameter_label(name), estimate.text())).collect(),
    ));
    if !finding.evidence.variables.is_empty() {
        let regressors = finding.evidence.variables.join(", ");
        blocks.push(Block::item(format!("regressors: {regressors}")));
    }
    if let Some(character) = &finding.evidence.character {
        blocks.push(Block::item(character.traits().join(", ")));
    }
    let alternatives = finding.alternatives.iter();
    blocks.extend(alternatives.map(|other| alternative(other, next_motion_is_searched)));
    blocks
}

fn alternative(other: &AlternativeRow, next_motion_is_searched: bool) -> Block {
    let detail = match &other.separated_by {
        Some(motion) => sentence(motion),
        None if next_motion_is_searched => String::new(),
        None => "Use --next-motion DIR to generate a motion that separates them.".to_owned(),
    };
    Block::Item { text: format!("not distinguishable from: {}", other.title()), detail }
}
