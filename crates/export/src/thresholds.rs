//! Thresholds of the momentum observer, as data.

use serde::Serialize;

/// Thresholds of the residual of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointThresholds {
    /// Joint name.
    pub joint: String,
    /// Speeds, increasing \[rad/s or m/s\].
    pub speed: Vec<f64>,
    /// Threshold at each speed \[N m or N\]; linear between, constant outside.
    pub threshold: Vec<f64>,
    /// Smallest constant effort of the surroundings that is detected in 95 % of the samples at each speed \[N m or N\].
    pub detectable: Vec<f64>,
}

/// Alarms in recordings without contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ObservedAlarms {
    /// Alarms.
    pub alarms: usize,
    /// Length of the recordings \[h\].
    pub hours: f64,
    /// Alarms per hour.
    pub per_hour: f64,
}

/// Thresholds of the observer for a false-alarm rate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlarmThresholds {
    /// False alarms per hour of the whole arm that were asked for.
    pub false_alarms_per_hour: f64,
    /// Gain of the observer \[1/s\].
    pub gain: f64,
    /// Rate of the recordings \[Hz\].
    pub rate_hz: f64,
    /// Thresholds by joint, in the order of the chain.
    pub joints: Vec<JointThresholds>,
    /// Alarms in the recordings that the thresholds are of.
    pub observed: ObservedAlarms,
    /// Alarms that the recordings have at this rate; below about ten the tail is continued.
    pub expected_alarms: f64,
    /// Shape of the tail: 0 exponential.
    pub shape: f64,
}

impl JointThresholds {
    /// The threshold at a speed.
    pub(crate) fn at(&self, speed: f64) -> f64 {
        let above = self.speed.partition_point(|known| *known < speed);
        match (above.checked_sub(1), self.speed.get(above)) {
            (Some(below), Some(to)) => {
                let share = (speed - self.speed[below]) / (to - self.speed[below]);
                self.threshold[below] + share * (self.threshold[above] - self.threshold[below])
            }
            (Some(below), None) => self.threshold[below],
            (None, _) => self.threshold[0],
        }
    }
}
