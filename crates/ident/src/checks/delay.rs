//! Delay between effort and motion, one for the robot, and what looks like one.
//!
//! Method: the likelihood of a [lag](super::lag). Efforts that are held between slower updates come late too. A delay of clocks is
//! the same below another cut-off.
//! References: own.

use std::collections::BTreeMap;

use armident_motion::Motion;
use armident_numeric::NumericError;
use armident_recording::{Quantity, Recording, Timing};

use super::arm_columns::JointMap;
use super::lag::{FoundLag, LagKind, Lags};
use super::rows;
use crate::regression::BatchProblem;

/// Delay of the efforts behind the motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Delay {
    /// Most likely delay \[s\], positive where the efforts come late.
    pub delay_s: f64,
    /// 95 % interval \[s\].
    pub interval_95_s: [f64; 2],
    /// `2 ln` of the likelihood at this delay over that at none.
    pub evidence: f64,
    /// RMS residual at this delay over that at none, geometric mean over the joints.
    pub residual_ratio: f64,
}

/// What takes a delay for something else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LookAlike {
    /// Below another cut-off \[Hz\] it is another one \[s\].
    OtherCutoff {
        /// the cut-off
        cutoff_hz: f64,
        /// the delay there
        delay_s: f64,
    },
    /// A low-pass of this time constant explains as much \[s\].
    LowPass(f64),
    /// Samples are held for this time \[s\].
    Held(f64),
}

/// The other cut-off, as a share of the one.
const LOWER: f64 = 0.6;
/// Share of the runs of equal values that have one length where values are held.
const HELD_SHARE: f64 = 0.6;

/// Why a delay is none, if something else explains it.
pub(super) fn look_alike(
    found: &Delay,
    problem: &BatchProblem,
    (motions, noise): (&[Motion], &[f64]),
    (recordings, map): (&[Recording], &JointMap),
    is_silent: &[bool],
) -> Result<Option<LookAlike>, NumericError> {
    let [low, high] = found.interval_95_s;
    let half = 0.5 * (high - low);
    if let Some(held_s) = held_s(recordings, &motions[0].joints)
        && (found.delay_s - 0.5 * held_s).abs() < half + 0.25 * held_s
    {
        return Ok(Some(LookAlike::Held(held_s)));
    }
    let Some(cutoff_hz) = motions.iter().find_map(|m| Some(LOWER * m.filter.as_ref()?.cutoff_hz()))
    else {
        return Ok(None);
    };
    let Some(lower) = map.motions_below(cutoff_hz, recordings, &motions[0].joints) else {
        return Ok(None);
    };
    let rows = rows::accumulate(problem, problem.arm(), &lower, noise)?;
    let lags = Lags::of(problem, &lower, &rows, is_silent)?;
    let there = lags.as_ref().map(|lags| lags.most_likely(LagKind::Delay)).transpose()?.flatten();
    let (Some(there), Some(lags)) = (there, lags) else { return Ok(None) };
    let there = Delay::of(&there, &lags);
    let half_there = 0.5 * (there.interval_95_s[1] - there.interval_95_s[0]);
    let agrees = (there.delay_s - found.delay_s).abs() <= half.hypot(half_there);
    let same_side = there.delay_s * found.delay_s > 0.0;
    Ok((!(agrees && same_side))
        .then_some(LookAlike::OtherCutoff { cutoff_hz, delay_s: there.delay_s }))
}

/// How long effort samples are held \[s\], where most are held for one time.
fn held_s(recordings: &[Recording], joints: &[String]) -> Option<f64> {
    let mut lengths: BTreeMap<usize, usize> = BTreeMap::new();
    let mut step_s = f64::INFINITY;
    for recording in recordings {
        step_s = step_s.min(Timing::of(&recording.time_s).median_step_s);
        let efforts = joints.iter().filter_map(|j| recording.joint(j)?.channel(Quantity::Effort));
        for effort in efforts {
            let mut length = 1;
            for pair in effort.windows(2) {
                if pair[0] == pair[1] {
                    length += 1;
                } else {
                    *lengths.entry(length).or_default() += 1;
                    length = 1;
                }
            }
        }
    }
    let runs: usize = lengths.values().sum();
    let (length, count) = lengths.into_iter().max_by_key(|(_, count)| *count)?;
    (length > 1 && count as f64 > HELD_SHARE * runs as f64).then_some(length as f64 * step_s)
}

impl Delay {
    /// Whether the interval excludes no delay.
    pub fn excludes_zero(&self) -> bool {
        self.interval_95_s[0] > 0.0 || self.interval_95_s[1] < 0.0
    }

    pub(super) fn of(found: &FoundLag, lags: &Lags) -> Self {
        let &FoundLag { number_s: delay_s, half_s, evidence } = found;
        Self {
            delay_s,
            interval_95_s: [delay_s - half_s, delay_s + half_s],
            evidence,
            residual_ratio: (-0.5 * evidence / lags.freedom()).exp(),
        }
    }
}
