//! The low-pass through which the drives report their efforts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::detail;
use crate::layout::{Block, significant};
use crate::results::DiagnoseReport;
use crate::section::{SectionData, Source};

/// Low-pass of first order of all recorded efforts: it is undone before the fit, and predictions go through it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct LowPassedEfforts {
    /// Cut-off \[Hz\].
    pub cutoff_hz: f64,
    /// Time constant \[s\].
    pub time_constant_s: f64,
    /// 95 % interval of the time constant \[s\].
    pub interval_95_s: [f64; 2],
}

impl SectionData for LowPassedEfforts {
    const KEY: &'static str = "effort_low_pass";

    fn of(source: &Source<'_>) -> Option<Self> {
        let found = source.diagnosis.input_checks.effort_low_pass.as_ref()?;
        (source.diagnosis.model.effort_low_pass_s > 0.0).then(|| Self {
            cutoff_hz: found.cutoff_hz(),
            time_constant_s: found.time_constant_s,
            interval_95_s: found.interval_95_s,
        })
    }

    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        let [low, high] = self.interval_95_s.map(|s| significant(1e3 * s, 3, 0.0));
        detail(format!(
            "The drives report their efforts through a low-pass of {} Hz (time constant {} ms, 95 % interval {low} to {high} ms). It is \
             undone before the fit, and predictions go through it.",
            significant(self.cutoff_hz, 2, 0.0),
            significant(1e3 * self.time_constant_s, 3, 0.0),
        ))
    }
}
