//! The motion that separates findings from their alternatives.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::{Block, significant};
use crate::results::DiagnoseReport;
use crate::section::SectionData;

/// The motion that best separates the findings from their alternatives. With `--next-motion`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct NextMotionResult {
    /// File of the motion; `null` where no motion separates anything.
    pub file: Option<String>,
    /// The motion in words, or `null`.
    pub description: Option<String>,
    /// Pairs that it separates.
    #[serde(alias = "told_apart")]
    pub separated: usize,
    /// Pairs of a finding and an alternative.
    pub pairs: usize,
    /// Median over the pairs of what the alternative and all that is fitted anyway do not imitate, in standard errors; `null`
    /// without a motion.
    pub separation: Option<f64>,
    /// Why no motion could be designed, or `null`.
    pub reason: Option<String>,
}

impl NextMotionResult {
    /// What the motion achieves, in a sentence; none without a motion.
    pub fn achieves(&self) -> Option<String> {
        Some(format!(
            "It separates {} of {} pairs of alternatives; what the alternative cannot imitate is {} standard errors (median).",
            self.separated,
            self.pairs,
            significant(self.separation?, 2, 0.0)
        ))
    }
}

impl SectionData for NextMotionResult {
    const KEY: &'static str = "next_motion";

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let text = match (&self.file, &self.description, self.achieves()) {
            (Some(file), Some(motion), Some(achieves)) => {
                format!("Next motion, written to {file}: {motion}. {achieves}")
            }
            _ if result.findings.iter().all(|f| f.alternatives.is_empty()) => {
                "No further motion needed: every finding is unique.".to_owned()
            }
            _ => match &self.reason {
                Some(reason) => format!("No motion was designed: {reason}."),
                None => "No motion within the joint limits separates the alternatives.".to_owned(),
            },
        };
        vec![Block::Paragraph(text)]
    }

    /// The page has it among the next steps.
    fn page(&self, _: &DiagnoseReport) -> Vec<Block> {
        Vec::new()
    }
}
