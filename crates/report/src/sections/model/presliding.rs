//! Presliding friction.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::{above_zero, detail};
use crate::layout::Block;
use crate::results::{ByJoint, DiagnoseReport};
use crate::section::{SectionData, Source};

/// Travel after a reversal over which dry friction builds up, by joint \[rad or m\].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct Presliding(pub ByJoint);

impl SectionData for Presliding {
    const KEY: &'static str = "presliding_travel";
    const FORMER_KEYS: &'static [&'static str] = &["friction_builds_up_over"];

    fn of(source: &Source<'_>) -> Option<Self> {
        let diagnosis = source.diagnosis;
        above_zero(&diagnosis.joints, &diagnosis.model.presliding_travel()).map(Self)
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let travels = self.0.listed(|joint| result.position_unit(joint).to_owned());
        detail(format!(
            "Presliding: friction builds up over this travel after a reversal: {travels}"
        ))
    }
}
