//! A low-pass through which the drives report their efforts, one for the robot, apart from a delay.
//!
//! Method: the likelihood of a [lag](super::lag). A low-pass must explain clearly more than any delay, also without the joint that
//! favours it most.
//! References: own.

use armident_numeric::NumericError;

use super::lag::{FoundLag, LagKind, Lags};
use super::likelihood_top::CLEARLY;

/// A low-pass of first order of all efforts.
#[derive(Debug, Clone, PartialEq)]
pub struct EffortLowPass {
    /// Time constant \[s\].
    pub time_constant_s: f64,
    /// 95 % interval \[s\].
    pub interval_95_s: [f64; 2],
    /// `2 ln` of the likelihood of it over that of no low-pass.
    pub evidence: f64,
}

impl EffortLowPass {
    /// Cut-off frequency \[Hz\].
    pub fn cutoff_hz(&self) -> f64 {
        1.0 / (std::f64::consts::TAU * self.time_constant_s)
    }
}

/// The low-pass that the efforts show; none where there is none, and where a delay explains as much.
pub(super) fn effort_low_pass(
    lags: &Lags,
    delay: Option<FoundLag>,
) -> Result<Option<EffortLowPass>, NumericError> {
    // efforts that are not clearly late have none, and one joint alone has no other to agree with
    let is_late = delay.is_some_and(|delay| delay.number_s > 0.0 && delay.evidence > CLEARLY);
    if lags.joints() < 2 || !(is_late || delay.is_none()) {
        return Ok(None);
    }
    let Some(found) = lags.most_likely(LagKind::LowPass)? else { return Ok(None) };
    let delay_s = delay.map_or(0.0, |delay| delay.number_s);
    let of_delay = lags.twice_log_likelihoods(LagKind::Delay, delay_s)?;
    let FoundLag { number_s: time_constant_s, half_s, evidence } = found;
    let of_low_pass = lags.twice_log_likelihoods(LagKind::LowPass, time_constant_s)?;
    // no joint alone decides: what its model lacks may look like either
    let over: Vec<f64> = of_low_pass.iter().zip(&of_delay).map(|(l, d)| l - d).collect();
    let largest = over.iter().copied().fold(0.0, f64::max);
    let is_clear = over.iter().sum::<f64>() - largest > CLEARLY && time_constant_s > half_s;
    Ok(is_clear.then_some(EffortLowPass {
        time_constant_s,
        interval_95_s: [time_constant_s - half_s, time_constant_s + half_s],
        evidence,
    }))
}
