//! How efforts come into the recordings, apart from what a search finds: undone before it, and in the models it gives.

use armident_model::ArmModel;
use armident_motion::BandMotion;
use armident_recording::RecordingError;

use super::effort_columns::InputChecks;

/// A low-pass in the drives, and a clock of their own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct EffortReporting {
    /// time constant \[s\]; 0 without a low-pass
    low_pass_s: f64,
    /// by which share the clock is fast
    clock_drift: f64,
}

impl EffortReporting {
    /// What the checks found beyond the given model: what that has is in the efforts that it takes off.
    pub(crate) fn found(checks: &InputChecks, model: &ArmModel) -> Self {
        let low_pass = checks.effort_low_pass.as_ref().filter(|_| model.effort_low_pass_s == 0.0);
        let clock = checks.effort_clock.filter(|_| model.effort_clock_drift == 0.0);
        Self {
            low_pass_s: low_pass.map_or(0.0, |found| found.time_constant_s),
            clock_drift: clock.map_or(0.0, |found| found.drift),
        }
    }

    /// With the efforts as they were before.
    ///
    /// # Errors
    /// A rate that allows no low-pass.
    pub(crate) fn undone_in(self, signals: BandMotion) -> Result<BandMotion, RecordingError> {
        let signals = match self.clock_drift {
            0.0 => signals,
            drift => signals.before_clock(drift),
        };
        match self.low_pass_s {
            0.0 => Ok(signals),
            time_constant_s => signals.before_low_pass(time_constant_s),
        }
    }

    /// Has a model report its efforts like this.
    pub(crate) fn put_into(self, model: &mut ArmModel) {
        model.effort_low_pass_s += self.low_pass_s;
        model.effort_clock_drift += self.clock_drift;
    }
}
