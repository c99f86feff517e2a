//! Delay between effort and motion, one for the robot.

use super::rows::{ChannelRows, SHIFTS_ASIDE, shifts_s};
use armident_inference::student_t_975;

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
/// residual; the likelihood of all joints together is a parabola near its maximum. None where it has no maximum
/// within the range of shifts.
///
/// The half-width of the interval is the larger one of that by the curvature, and of that by how the
/// joints disagree (sandwich over joints, quantile of Student's t): unmodelled physics pulls each joint
/// its own way, a delay pulls all of them.
pub(super) fn delay(rows: &[ChannelRows], is_silent: &[bool]) -> Option<Delay> {
    let shifts = shifts_s();
    let step = shifts[1] - shifts[0];
    let mut log_likelihood: Vec<Vec<f64>> = Vec::new();
    for (joint, _) in rows.iter().zip(is_silent).filter(|(_, silent)| !**silent) {
        let order: Vec<usize> =
            (0..joint.terms).chain((0..shifts.len()).map(|k| joint.shifted(k))).collect();
        let r = joint.triangle.reordered(&order);
        let freedom = (joint.effective - joint.terms as f64).max(1.0);
        let left: Vec<f64> = (0..shifts.len())
            .map(|k| {
                let column = joint.terms + k;
                (joint.terms..=column).map(|i| r[(i, column)].powi(2)).sum()
            })
            .collect();
        if left.iter().any(|l| l.is_nan() || *l <= 0.0) {
            continue;
        }
        log_likelihood.push(left.iter().map(|l| -0.5 * freedom * l.ln()).collect());
    }
    let joints = log_likelihood.len();
    let total: Vec<f64> =
        (0..shifts.len()).map(|k| log_likelihood.iter().map(|l| l[k]).sum()).collect();
    let best = (0..shifts.len()).max_by(|&a, &b| total[a].total_cmp(&total[b]))?;
    if joints == 0 || best == 0 || best + 1 == shifts.len() {
        return None;
    }
    let slope = |l: &[f64]| (l[best + 1] - l[best - 1]) / (2.0 * step);
    let curvature = |l: &[f64]| (l[best + 1] - 2.0 * l[best] + l[best - 1]) / (step * step);
    let steepness = -curvature(&total);
    if steepness.is_nan() || steepness <= 0.0 {
        return None;
    }
    let off = slope(&total) / steepness;
    let top = total[best] + 0.5 * steepness * off * off;
    // slopes of the joints at the common top add up to zero
    let disagreement: f64 =
        log_likelihood.iter().map(|l| (slope(l) + curvature(l) * off).powi(2)).sum();
    let by_curvature = 1.96 / steepness.sqrt();
    let by_joints = if joints > 1 {
        let of_mean = joints as f64 / (joints - 1) as f64;
        student_t_975((joints - 1) as f64) * (of_mean * disagreement).sqrt() / steepness
    } else {
        0.0
    };
    let half = by_curvature.max(by_joints);
    let delay_s = shifts[best] + off;
    let freedom: f64 = rows.iter().map(|r| (r.effective - r.terms as f64).max(1.0)).sum::<f64>();
    let evidence = 2.0 * (top - total[SHIFTS_ASIDE]);
    Some(Delay {
        delay_s,
        interval_95_s: [delay_s - half, delay_s + half],
        evidence,
        residual_ratio: (-0.5 * evidence / freedom).exp(),
    })
}
