//! A robot over its recordings.

use crate::changes::FleetChange;

/// One robot over its recordings.
#[derive(Debug, Clone)]
pub struct RobotHistory {
    /// Its name.
    pub robot: String,
    /// Its recordings in their order.
    pub recordings: Vec<String>,
    /// When each was made, since 1970 \[s\], where all have it.
    pub recorded_at_s: Option<Vec<f64>>,
    /// Its changes.
    pub changes: Vec<FleetChange>,
    /// One of each parameter.
    pub trends: Vec<ParameterTrend>,
    /// Parameters of its first recordings up to its first change.
    pub values: Vec<f64>,
    /// Their standard errors, with the scatter of recordings; none where its recordings do not determine them.
    pub errors: Vec<Option<f64>>,
    /// Noise of each joint's low-passed effort \[N m or N\].
    pub noise: Vec<f64>,
}

/// A parameter over the recordings of a robot.
#[derive(Debug, Clone)]
pub struct ParameterTrend {
    /// Each recording's; none of those that do not determine it.
    pub points: Vec<Option<TrendPoint>>,
    /// Drift per recording beside the changes, and its standard error; of three recordings or more.
    pub drift: Option<(f64, f64)>,
}

/// A parameter in one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrendPoint {
    /// Its value, all others being those of the robot within their scatter.
    pub value: f64,
    /// Standard error, with the scatter of recordings.
    pub standard_error: f64,
}
