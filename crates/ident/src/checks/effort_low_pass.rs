//! A low-pass through which the drives report their efforts, one for the robot, apart from a delay.
//!
//! Method: the likelihood of a [lag](super::lag). A low-pass must explain clearly more than any delay, where no joint counts for more
//! than its motion would show of the difference. Where neither explains clearly more than the other, it may be either.
//! References: D. R. Cox, J. R. Stat. Soc. B 24, 406 (1962), for ratios of separate families; the bound is own.

use armident_motion::SignalLag;
use armident_numeric::NumericError;

use super::delay::Delay;
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

/// What makes efforts late.
pub(super) enum LateBy {
    /// Nothing, or a delay.
    NoLowPass,
    /// A low-pass.
    LowPass(EffortLowPass),
    /// A delay, or a low-pass.
    Either(LowPassOrDelay),
}

impl LateBy {
    /// The lag of efforts with this delay, where that is not a low-pass.
    pub(super) fn lag(&self, delay: Option<&Delay>) -> SignalLag {
        match self {
            Self::LowPass(found) => {
                SignalLag { time_constant_s: found.time_constant_s, ..SignalLag::default() }
            }
            Self::NoLowPass | Self::Either(_) => {
                let delay_s = delay.map_or(0.0, |found| found.delay_s);
                SignalLag { delay_s, ..SignalLag::default() }
            }
        }
    }
}

/// A low-pass of first order that explains late efforts as well as a delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPassOrDelay {
    /// Its time constant \[s\].
    pub time_constant_s: f64,
    /// `2 ln` of the likelihood of the delay over its, of each joint no more than its motion would show.
    pub delay_over_low_pass: f64,
}

/// Whether efforts with this most likely delay may have gone through a low-pass: those that are not clearly late did not.
pub(super) fn is_clearly_late(delay_s: f64, evidence: f64) -> bool {
    delay_s > 0.0 && evidence > CLEARLY
}

/// Whether a low-pass makes the efforts late, or a delay.
pub(super) fn late_by(lags: &Lags) -> Result<LateBy, NumericError> {
    let delay = lags.most_likely(LagKind::Delay)?;
    // one joint alone has no other to agree with
    let is_late = delay.is_none_or(|delay| is_clearly_late(delay.number_s, delay.evidence));
    if lags.joints() < 2 || !is_late {
        return Ok(LateBy::NoLowPass);
    }
    let Some(found) = lags.most_likely(LagKind::LowPass)? else { return Ok(LateBy::NoLowPass) };
    let FoundLag { number_s: time_constant_s, half_s, evidence } = found;
    let low_pass = (LagKind::LowPass, time_constant_s);
    let delay = (LagKind::Delay, delay.map_or(0.0, |delay| delay.number_s));
    // what a joint shows beyond what it would in theory is no sign of either: its model lacks something
    let shown = lags.log_ratios(low_pass, delay)?;
    let bounded = |sign: f64, expected: Vec<f64>| -> f64 {
        shown.iter().zip(&expected).map(|(shown, most)| (sign * shown).min(*most)).sum()
    };
    let low_pass_over_delay = bounded(1.0, lags.expected_log_ratios(low_pass, delay)?);
    if time_constant_s > half_s && low_pass_over_delay > CLEARLY {
        return Ok(LateBy::LowPass(EffortLowPass {
            time_constant_s,
            interval_95_s: [time_constant_s - half_s, time_constant_s + half_s],
            evidence,
        }));
    }
    let delay_over_low_pass = bounded(-1.0, lags.expected_log_ratios(delay, low_pass)?);
    Ok(match delay_over_low_pass > CLEARLY {
        true => LateBy::NoLowPass,
        false => LateBy::Either(LowPassOrDelay { time_constant_s, delay_over_low_pass }),
    })
}
