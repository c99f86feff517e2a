//! A clock of the efforts that runs faster or slower than that of the positions, one for the robot.
//!
//! Method: least squares for the [lag](super::lag) at the start of each recording and for its growth, to first order about the lag
//! that was found, beside the free model of each joint, whose friction, offset and gain may drift too: drives that become warm are
//! no clock. The interval is the larger one of that by the curvature and of that by how the joints disagree (sandwich over joints).
//! References: own.

use armident_motion::SignalLag;
use armident_numeric::NumericError;

use super::lag::{LagGrowth, Lags};
use super::likelihood_top::{CLEARLY, half_of_95};

/// A clock of the efforts that is not that of the positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffortClock {
    /// By which share it is fast: what is recorded after `t` seconds was measured `drift t` later.
    pub drift: f64,
    /// 95 % interval.
    pub interval_95: [f64; 2],
}

/// The drift of the efforts against the positions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drift {
    pub(super) share: f64,
    /// half of its 95 % interval
    half: f64,
}

impl From<Drift> for EffortClock {
    fn from(Drift { share, half }: Drift) -> Self {
        Self { drift: share, interval_95: [share - half, share + half] }
    }
}

impl Drift {
    /// This drift and the one that remains where this one is undone.
    pub(super) fn and_then(&self, rest: &Self) -> Self {
        Self { share: self.share + rest.share, half: rest.half }
    }

    pub(super) fn is_clear(&self) -> bool {
        (1.96 * self.share / self.half).powi(2) > CLEARLY
    }
}

/// The drift about a lag of the efforts; none with one joint, which has no other to agree with.
pub(super) fn drift(lags: &Lags, lag: SignalLag) -> Result<Option<Drift>, NumericError> {
    let joints = lags.growths(lag)?;
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
    let slopes: Vec<f64> = joints
        .iter()
        .map(|g| {
            let of_lag = g.slope[0] - g.information[0] * lag_s - g.information[1] * drift;
            let of_drift = g.slope[1] - g.information[1] * lag_s - g.information[2] * drift;
            of_drift - ab / aa * of_lag
        })
        .collect();
    Ok(Some(Drift { share: drift, half: half_of_95(steepness, &slopes) }))
}
