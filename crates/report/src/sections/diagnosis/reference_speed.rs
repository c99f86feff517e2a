//! Joints that move faster than in the reference.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::Block;
use crate::results::{ByJoint, DiagnoseReport};
use crate::section::{SectionData, Source};

/// With `--reference`: maximum speed there, by joint that now moves faster \[rad/s or m/s\]. Motion over 20 % faster is
/// excluded.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct ReferenceSpeed(pub ByJoint);

impl ReferenceSpeed {
    /// `joint_1 1.2 rad/s, joint_2 1 rad/s`.
    pub fn listed(&self, result: &DiagnoseReport) -> String {
        self.0.listed(|joint| format!("{}/s", result.position_unit(joint)))
    }
}

impl SectionData for ReferenceSpeed {
    const KEY: &'static str = "reference_max_speed";
    const FORMER_KEYS: &'static [&'static str] = &["beyond_reference"];

    fn of(source: &Source<'_>) -> Option<Self> {
        let speeds = &source.diagnosis.beyond_reference;
        (!speeds.is_empty()).then(|| Self(speeds.clone().into()))
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        vec![
            Block::heading("Model details"),
            Block::item(format!(
                "Excluded: motion over 20 % faster than the reference, where its friction is unknown. Reference \
                 maximum speed: {}",
                self.listed(result)
            )),
        ]
    }
}
