//! A clock of the efforts that runs faster or slower than that of the positions, one for the robot.
//!
//! Method: least squares for the [lag](super::lag) at the start of each recording and for its growth, to first order about the lag
//! that was found, beside the free model of each joint whose parameters may drift too: friction that warms up is no clock. The
//! interval is the larger one of that by the curvature and of that by how the joints disagree (sandwich over joints).
//! References: own.

use armident_inference::student_t_975;
use armident_motion::SignalLag;
use armident_numeric::NumericError;

use super::lag::{LagGrowth, Lags};
use super::likelihood_top::CLEARLY;

/// A clock of the efforts that is not that of the positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffortClock {
    /// By which share it is fast: what is recorded after `t` seconds was measured `drift t` later.
    pub drift: f64,
    /// 95 % interval.
    pub interval_95: [f64; 2],
}

/// The clock of the efforts, where it is clearly another one; `lag` is the lag of the efforts.
pub(super) fn effort_clock(
    lags: &Lags,
    lag: SignalLag,
) -> Result<Option<EffortClock>, NumericError> {
    let joints = lags.growths(lag)?;
    // one joint alone has no other to agree with
    if joints.len() < 2 {
        return Ok(None);
    }
    let sum = |of: fn(&LagGrowth) -> f64| joints.iter().map(of).sum::<f64>();
    let (aa, ab, bb) =
        (sum(|g| g.information[0]), sum(|g| g.information[1]), sum(|g| g.information[2]));
    let (a, b) = (sum(|g| g.slope[0]), sum(|g| g.slope[1]));
    // of the drift, whatever the lag
    let steepness = bb - ab * ab / aa;
    let drift = (b - ab / aa * a) / steepness;
    let lag_s = (a - ab * drift) / aa;
    let slope_at_top = |g: &LagGrowth| {
        let [of_lag, of_drift] = [
            g.slope[0] - g.information[0] * lag_s - g.information[1] * drift,
            g.slope[1] - g.information[1] * lag_s - g.information[2] * drift,
        ];
        of_drift - ab / aa * of_lag
    };
    let others = joints.len() as f64 - 1.0;
    let disagreement: f64 = joints.iter().map(|g| slope_at_top(g).powi(2)).sum();
    let by_joints = (joints.len() as f64 / others * disagreement).sqrt() / steepness;
    let deviation = by_joints.max(steepness.sqrt().recip());
    let half = (student_t_975(others) * by_joints).max(1.96 / steepness.sqrt());
    let is_clear = (drift / deviation).powi(2) > CLEARLY && drift.abs() > half;
    Ok(is_clear.then_some(EffortClock { drift, interval_95: [drift - half, drift + half] }))
}
