//! Changes since the reference that are not certain enough to be reported.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::{Block, significant};
use crate::results::DiagnoseReport;
use crate::section::{SectionData, Source};
use crate::words::effect_at;

/// A change that is not certain enough to be reported.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct InconclusiveChange {
    /// Slug of the effect.
    pub effect: String,
    /// Its joints, base to tip; empty for the whole arm.
    pub joints: Vec<String>,
    /// Its link, or `null`.
    pub link: Option<String>,
    /// p-value of the change.
    #[serde(alias = "chance")]
    pub p_value: f64,
    /// Whether it is inconclusive because the reference does not rule out that it was already present.
    #[serde(alias = "maybe_before")]
    pub maybe_in_reference: bool,
}

/// With `--reference`: changes that are inconclusive.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct InconclusiveChanges(pub Vec<InconclusiveChange>);

impl InconclusiveChanges {
    /// Those that the reference does not rule out, in words; empty where there are none.
    pub fn maybe_in_reference(&self) -> String {
        let changes = self.0.iter().filter(|change| change.maybe_in_reference);
        changes.map(InconclusiveChange::title).collect::<Vec<_>>().join("; ")
    }

    fn not_significant(&self) -> String {
        let changes = self.0.iter().filter(|change| !change.maybe_in_reference);
        let of = |change: &InconclusiveChange| {
            format!("{} (p = {})", change.title(), significant(change.p_value, 1, 0.0))
        };
        changes.map(of).collect::<Vec<_>>().join("; ")
    }
}

impl InconclusiveChange {
    fn title(&self) -> String {
        effect_at(&self.effect, &self.joints, self.link.as_deref())
    }
}

impl SectionData for InconclusiveChanges {
    const KEY: &'static str = "inconclusive_changes";
    const FORMER_KEYS: &'static [&'static str] = &["doubtful_changes"];

    fn of(source: &Source<'_>) -> Option<Self> {
        let found = &source.diagnosis.doubtful_changes;
        let changes = found.iter().map(|change| InconclusiveChange {
            effect: change.effect.clone(),
            joints: change.joints.clone(),
            link: change.link.clone(),
            p_value: change.chance,
            maybe_in_reference: change.maybe_before,
        });
        (!found.is_empty()).then(|| Self(changes.collect()))
    }

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        let lists = [
            (
                "the reference does not rule out that this was already present",
                self.maybe_in_reference(),
            ),
            ("not significant", self.not_significant()),
        ];
        let items = lists.into_iter().filter(|(_, changes)| !changes.is_empty());
        std::iter::once(Block::heading("Model details"))
            .chain(
                items.map(|(why, changes)| Block::item(format!("Inconclusive, {why}: {changes}"))),
            )
            .collect()
    }
}
