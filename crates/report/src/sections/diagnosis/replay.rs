//! Forward replay of the hold-out.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::{Block, Table, significant};
use crate::results::{ByJoint, DiagnoseReport};
use crate::section::SectionData;

/// Root mean square position error after recorded efforts drove the simulated arm over short windows of the hold-out,
/// by joint \[rad or m\].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ReplayPair {
    /// Length of a window \[s\].
    pub window_s: f64,
    /// With the given model.
    pub before: ByJoint,
    /// With the diagnosed model.
    pub after: ByJoint,
}

impl SectionData for ReplayPair {
    const KEY: &'static str = "replay";

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let rows = result.joints.iter().map(|joint| {
            let of = |errors: &ByJoint| {
                let error = errors.get(joint).map(|error| significant(*error, 3, 0.0));
                error.unwrap_or_else(|| "-".to_owned())
            };
            vec![joint.clone(), of(&self.before), of(&self.after)]
        });
        let note = format!(
            "RMS position error in {} s windows driven by the recorded efforts, {}",
            self.window_s,
            result.position_units()
        );
        let table = Table::new("", &["joint"]).numbers(&["given", "diagnosed"]);
        vec![
            Block::heading_with_note("Forward replay on the hold-out", note),
            Block::Table(table.with(rows)),
        ]
    }
}
