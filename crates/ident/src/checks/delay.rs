//! Delay between effort and motion, one for the robot, and what looks like one.
//!
//! Presliding friction, which follows each reversal, and efforts that are held between slower updates, come late
//! too. A delay of clocks explains more than either, and is the same below another cut-off.

use std::collections::BTreeMap;

use armident_effects::ReversalModel;
use armident_motion::Motion;
use armident_numeric::{AccumulatedQr, NumericError};
use armident_recording::{Quantity, Recording, Timing};

use super::arm_columns::JointMap;
use super::excitation::activity;
use super::likelihood_top::Top;
use super::rows::{self, ChannelRows, SHIFTS_ASIDE, ShiftedResiduals, shifts_s};
use crate::regression::{BatchProblem, RANK_CUT};

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
    /// Presliding friction explains as much.
    Presliding,
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

/// Share of the evidence for a delay with which presliding friction is as good an explanation.
const AS_GOOD: f64 = 0.8;
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
    if presliding_evidence(problem, motions, is_silent)? > AS_GOOD * found.evidence {
        return Ok(Some(LookAlike::Presliding));
    }
    let Some(cutoff_hz) = motions.iter().find_map(|m| Some(LOWER * m.filter.as_ref()?.cutoff_hz()))
    else {
        return Ok(None);
    };
    let Some(lower) = map.motions_with_cutoff(cutoff_hz, recordings, &motions[0].joints) else {
        return Ok(None);
    };
    let rows = rows::accumulate(problem, problem.arm(), &lower, noise)?;
    let Some(there) = delay(&rows, is_silent) else { return Ok(None) };
    let half_there = 0.5 * (there.interval_95_s[1] - there.interval_95_s[0]);
    let agrees = (there.delay_s - found.delay_s).abs() <= half.hypot(half_there);
    let same_side = there.delay_s * found.delay_s > 0.0;
    Ok((!(agrees && same_side))
        .then_some(LookAlike::OtherCutoff { cutoff_hz, delay_s: there.delay_s }))
}

/// `2 ln` of the likelihood of efforts in time with presliding friction over that without.
fn presliding_evidence(
    problem: &BatchProblem,
    motions: &[Motion],
    is_silent: &[bool],
) -> Result<f64, NumericError> {
    let mut evidence = 0.0;
    for joint in (0..problem.arm().dof()).filter(|&j| !is_silent[j]) {
        let deviation = activity(motions, joint).range / 4.0;
        let reversals =
            ReversalModel::TRAVEL_SHARES.map(|share| ReversalModel::presliding(share * deviation));
        let terms = problem.terms_of_joint(joint).len();
        let mut rows = AccumulatedQr::new(terms + reversals.len());
        let mut independent = 0.0;
        for motion in motions {
            let Some(effort) = &motion.effort_filtered else { continue };
            let mut columns = problem.columns(joint, motion);
            columns.extend(problem.direction_columns(joint, motion, &reversals));
            rows.push_columns(&columns, &effort[joint]);
            independent += motion.independent_share() * motion.len() as f64;
        }
        let own: Vec<usize> = (0..terms).collect();
        let left = |columns: &[usize]| -> Result<f64, NumericError> {
            Ok(rows.with_unknowns(columns).solve(RANK_CUT)?.residual_sum_of_squares)
        };
        let without = left(&own)?;
        let mut best = without;
        for k in 0..reversals.len() {
            best = best.min(left(&[own.as_slice(), &[terms + k]].concat())?);
        }
        if best > 0.0 && without > 0.0 {
            evidence += (independent - terms as f64).max(1.0) * (without / best).ln();
        }
    }
    Ok(evidence)
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

    /// This delay, and the one that remains after correction of it.
    pub(super) fn and_then(&self, rest: &Self) -> Self {
        let [low, high] = rest.interval_95_s;
        Self {
            delay_s: self.delay_s + rest.delay_s,
            interval_95_s: [self.delay_s + low, self.delay_s + high],
            ..self.clone()
        }
    }
}

/// Finds the shift of the efforts at which the free model of each joint, friction included, has the smallest
/// residual. None where the likelihood of all joints together has no maximum within the range of shifts.
pub(super) fn delay(rows: &[ChannelRows], is_silent: &[bool]) -> Option<Delay> {
    let shifts = shifts_s();
    let step = shifts[1] - shifts[0];
    let mut log_likelihood: Vec<Vec<f64>> = Vec::new();
    for (joint, _) in rows.iter().zip(is_silent).filter(|(_, silent)| !**silent) {
        let ShiftedResiduals { freedom, left } = joint.shifted_residuals();
        let squares = |of: &Vec<f64>| of.iter().map(|x| x * x).sum::<f64>();
        let left: Vec<f64> = left.iter().map(squares).collect();
        if left.iter().any(|l| l.is_nan() || *l <= 0.0) {
            continue;
        }
        log_likelihood.push(left.iter().map(|l| -0.5 * freedom * l.ln()).collect());
    }
    let Top { best, off, half, total, height } = Top::of(&log_likelihood, step)?;
    let delay_s = shifts[best] + off;
    let freedom: f64 = rows.iter().map(|r| (r.effective - r.terms as f64).max(1.0)).sum::<f64>();
    let evidence = 2.0 * (height - total[SHIFTS_ASIDE]);
    Some(Delay {
        delay_s,
        interval_95_s: [delay_s - half, delay_s + half],
        evidence,
        residual_ratio: (-0.5 * evidence / freedom).exp(),
    })
}
