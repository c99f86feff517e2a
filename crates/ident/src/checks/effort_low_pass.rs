//! A low-pass through which the drives report their efforts, one for the robot.
//!
//! Method: likelihood of the free model of each joint with the efforts before a low-pass of first order, `e + T de/dt`, over the
//! time constant `T`. The correction amplifies noise by `sqrt(1 + (wT)^2)` at the frequency `w`; the logarithm of that, averaged
//! over the band of the fit, makes the likelihoods of two time constants comparable (the Jacobian of the correction). Interval: by
//! the curvature, and by how the joints disagree, as of a [delay](super::delay). It must explain clearly more than any delay.
//! References: L. Ljung, System Identification, 2nd ed. (1999), section 7.4, for prefilters and their likelihood.

use armident_effects::ReversalModel;
use armident_motion::{Motion, differentiate};
use armident_numeric::{AccumulatedQr, NumericError};

use super::excitation::activity;
use super::likelihood_top::{CLEARLY, Top};
use super::rows::{ChannelRows, SHIFTS_ASIDE, ShiftedResiduals, independent, shifts_s};
use crate::regression::BatchProblem;

/// Longest time constant that is tried \[s\]: a low-pass of 2 Hz; drives filter at 5 Hz and above.
const LONGEST_S: f64 = 0.08;
/// Time constants that are tried.
const TRIED: usize = 161;
/// Time constants that are tried beside presliding friction.
const TRIED_BESIDE: usize = 41;

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

/// Mean of `ln sqrt(1 + (wT)^2)` over the frequencies up to a cut-off.
fn mean_log_gain(time_constant_s: f64, cutoff_hz: f64) -> f64 {
    let u = std::f64::consts::TAU * cutoff_hz * time_constant_s;
    if u < 1e-6 { 0.0 } else { 0.5 * u.mul_add(u, 1.0).ln() - 1.0 + u.atan() / u }
}

/// Logarithm of the likelihood at a place between the shifts over that without a delay; the effort between three shifts is the
/// parabola through them.
fn at_delay(joint: &ShiftedResiduals, place: f64) -> f64 {
    let middle = (place.round() as usize).clamp(1, joint.left.len() - 2);
    let x = place - middle as f64;
    let weights = [0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)];
    let squares: f64 = (0..joint.left[middle].len())
        .map(|i| (0..3).map(|k| weights[k] * joint.left[middle + k - 1][i]).sum::<f64>().powi(2))
        .sum();
    let without: f64 = joint.left[SHIFTS_ASIDE].iter().map(|x| x * x).sum();
    -0.5 * joint.freedom * (squares / without).ln()
}

/// Logarithm of the likelihood of all joints at the delay that is best for them, over that without a delay.
fn best_delay(joints: &[ShiftedResiduals]) -> f64 {
    /// Places between two shifts that are tried: of 0.1 ms, beside noise nothing.
    const PLACES: usize = 38;
    let at = |k: usize| k as f64 / PLACES as f64;
    let total = |k: usize| joints.iter().map(|joint| at_delay(joint, at(k))).sum::<f64>();
    (0..=2 * SHIFTS_ASIDE * PLACES).map(total).fold(0.0, f64::max)
}

/// The low-pass that explains the efforts clearly better than nothing and than any delay; none where there is none.
/// `cutoff_hz`: that of the fit \[Hz\].
pub(super) fn effort_low_pass(
    rows: &[ChannelRows],
    is_silent: &[bool],
    cutoff_hz: f64,
) -> Option<EffortLowPass> {
    let shifts = shifts_s();
    let step_s = shifts[SHIFTS_ASIDE + 1] - shifts[SHIFTS_ASIDE - 1];
    let tried: Vec<f64> = (0..TRIED).map(|k| LONGEST_S * k as f64 / (TRIED - 1) as f64).collect();
    let mut log_likelihood: Vec<Vec<f64>> = Vec::new();
    let mut of_delays: Vec<ShiftedResiduals> = Vec::new();
    for (joint, _) in rows.iter().zip(is_silent).filter(|(_, silent)| !**silent) {
        let ShiftedResiduals { freedom, left } = joint.shifted_residuals();
        let squares = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        // of the effort and of its rate
        let effort = &left[SHIFTS_ASIDE];
        let (later, earlier) = (&left[SHIFTS_ASIDE + 1], &left[SHIFTS_ASIDE - 1]);
        let with = |time_constant_s: &f64| -> f64 {
            let share = time_constant_s / step_s;
            let changed = effort.iter().zip(later.iter().zip(earlier));
            let before: Vec<f64> = changed.map(|(e, (l, s))| e + share * (l - s)).collect();
            let gain = mean_log_gain(*time_constant_s, cutoff_hz);
            freedom * (gain - 0.5 * squares(&before).ln())
        };
        let own: Vec<f64> = tried.iter().map(with).collect();
        if own.iter().any(|l| !l.is_finite()) {
            continue;
        }
        of_delays.push(ShiftedResiduals { freedom, left });
        log_likelihood.push(own);
    }
    // one joint alone has no other to agree with
    if log_likelihood.len() < 2 {
        return None;
    }
    let Top { best, off, half, total, .. } = Top::of(&log_likelihood, tried[1])?;
    let time_constant_s = tried[best] + off;
    let evidence = 2.0 * (total[best] - total[0]);
    let of_best_delay = 2.0 * best_delay(&of_delays);
    let is_clear = evidence > CLEARLY && evidence - of_best_delay > CLEARLY;
    (is_clear && time_constant_s > half).then_some(EffortLowPass {
        time_constant_s,
        interval_95_s: [time_constant_s - half, time_constant_s + half],
        evidence,
    })
}

/// `2 ln` of the likelihood of a low-pass over that of none, where dry friction of every joint may build up after each reversal over
/// any of some travels, or not at all: presliding friction comes late too, but only after reversals.
pub(super) fn evidence_beside_presliding(
    problem: &BatchProblem,
    motions: &[Motion],
    is_silent: &[bool],
    cutoff_hz: f64,
) -> Result<f64, NumericError> {
    let tried: Vec<f64> =
        (0..TRIED_BESIDE).map(|k| LONGEST_S * k as f64 / (TRIED_BESIDE - 1) as f64).collect();
    let mut total = vec![0.0; tried.len()];
    for joint in (0..problem.arm().dof()).filter(|&j| !is_silent[j]) {
        let deviation = activity(motions, joint).range / 4.0;
        let reversals =
            ReversalModel::TRAVEL_SHARES.map(|share| ReversalModel::presliding(share * deviation));
        let terms = problem.terms_of_joint(joint).len();
        let [rate, own] = [0, 1].map(|k| terms + reversals.len() + k);
        let mut rows = AccumulatedQr::new(own + 1);
        let mut samples = 0.0;
        for motion in motions {
            let Some(effort) = &motion.effort_filtered else { continue };
            let mut columns = problem.columns(joint, motion);
            columns.extend(problem.direction_columns(joint, motion, &reversals));
            columns.push(differentiate(&effort[joint], motion.rate_hz));
            columns.push(effort[joint].clone());
            rows.push_columns(&columns, &effort[joint]);
            samples += motion.independent_share() * motion.len() as f64;
        }
        let freedom = (samples - terms as f64).max(1.0);
        // what a set of columns leaves of the rate, and of the effort beside and along it
        let sharp: Vec<usize> = (0..terms).collect();
        let soft = (0..reversals.len()).map(|k| [&sharp[..], &[terms + k]].concat());
        let left = std::iter::once(sharp.clone()).chain(soft).map(|set| {
            let set = independent(&rows, &set);
            let count = set.len();
            let r = rows.reordered(&[&set[..], &[rate, own]].concat());
            [r[(count, count)], r[(count, count + 1)], r[(count + 1, count + 1)]]
        });
        let left: Vec<[f64; 3]> = left.collect();
        for (sum, time_constant_s) in total.iter_mut().zip(&tried) {
            let gain = mean_log_gain(*time_constant_s, cutoff_hz);
            let of = |[of_rate, along, beside]: &[f64; 3]| {
                let squares = (along + time_constant_s * of_rate).powi(2) + beside * beside;
                freedom * (gain - 0.5 * squares.ln())
            };
            *sum += left.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        }
    }
    let best = total.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Ok(2.0 * (best - total[0]))
}

/// Whether it stands beside presliding friction.
pub(super) fn is_clear_beside_presliding(evidence: f64) -> bool {
    evidence > CLEARLY
}

#[cfg(test)]
mod tests {
    use super::mean_log_gain;

    /// Against a sum over the frequencies.
    #[test]
    fn mean_gain_is_that_of_its_frequencies() {
        let (time_constant_s, cutoff_hz) = (0.03, 6.0);
        let w = |k: i32| std::f64::consts::TAU * cutoff_hz * (f64::from(k) + 0.5) / 10_000.0;
        let sum: f64 =
            (0..10_000).map(|k| 0.5 * (1.0 + (w(k) * time_constant_s).powi(2)).ln()).sum();
        assert!((mean_log_gain(time_constant_s, cutoff_hz) - sum / 10_000.0).abs() < 1e-6);
    }
}
