//! The clock of the efforts, where it is not that of the positions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::detail;
use crate::layout::{Block, significant};
use crate::results::DiagnoseReport;
use crate::section::{SectionData, Source};

/// Clock of all recorded efforts against that of the positions: its drift is undone before the fit, and predictions have it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct ClockOfEfforts {
    /// By which share it is fast: what is recorded after `t` seconds was measured `drift t` later.
    pub drift: f64,
    /// 95 % interval of the drift.
    pub interval_95: [f64; 2],
}

impl SectionData for ClockOfEfforts {
    const KEY: &'static str = "effort_clock";

    fn of(source: &Source<'_>) -> Option<Self> {
        let found = source.diagnosis.input_checks.effort_clock.as_ref()?;
        (source.diagnosis.model.effort_clock_drift != 0.0)
            .then_some(Self { drift: found.drift, interval_95: found.interval_95 })
    }

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        let [low, high] = self.interval_95.map(|share| significant(1e6 * share, 3, 0.0));
        detail(format!(
            "The clock of the efforts drifts by {} ppm against that of the positions (95 % interval {low} to {high} ppm; positive: the \
             efforts come ever earlier). This is undone before the fit, and predictions have it.",
            significant(1e6 * self.drift, 3, 0.0),
        ))
    }
}
