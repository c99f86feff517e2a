//! The maximum of a likelihood that is tabulated over one number, joint by joint.
//!
//! Method: the parabola through the highest value and its neighbours. The half-width of the 95 % interval is the larger one of that
//! by the curvature, and of that by how the joints disagree (sandwich over joints, quantile of Student's t): unmodelled physics pulls
//! each joint its own way, a number of the whole robot pulls all of them.
//! References: own.

use armident_inference::student_t_975;

/// `2 ln` of a thousand to one: by so much an explanation must be better than another.
pub(super) const CLEARLY: f64 = 13.8;

/// Where the likelihood of all joints together is highest.
pub(super) struct Top {
    /// Index of the highest value.
    pub(super) best: usize,
    /// From there to the top, in the unit of the number.
    pub(super) off: f64,
    /// Half of the 95 % interval.
    pub(super) half: f64,
    /// Logarithm of the likelihood of all joints, at each value.
    pub(super) total: Vec<f64>,
    /// The same at the top.
    pub(super) height: f64,
}

impl Top {
    /// Of `[joint][value]`, values `step` apart; none without a joint, and where the top is at an end or there is none.
    pub(super) fn of(log_likelihood: &[Vec<f64>], step: f64) -> Option<Self> {
        let (joints, values) = (log_likelihood.len(), log_likelihood.first()?.len());
        let total: Vec<f64> =
            (0..values).map(|k| log_likelihood.iter().map(|l| l[k]).sum()).collect();
        let best = (0..values).max_by(|&a, &b| total[a].total_cmp(&total[b]))?;
        if best == 0 || best + 1 == values {
            return None;
        }
        let slope = |l: &[f64]| (l[best + 1] - l[best - 1]) / (2.0 * step);
        let curvature = |l: &[f64]| (l[best + 1] - 2.0 * l[best] + l[best - 1]) / (step * step);
        let steepness = -curvature(&total);
        if steepness.is_nan() || steepness <= 0.0 {
            return None;
        }
        let off = slope(&total) / steepness;
        let height = total[best] + 0.5 * steepness * off * off;
        // slopes of the joints at the common top add up to zero
        let disagreement: f64 =
            log_likelihood.iter().map(|l| (slope(l) + curvature(l) * off).powi(2)).sum();
        let by_joints = if joints > 1 {
            let of_mean = joints as f64 / (joints - 1) as f64;
            student_t_975((joints - 1) as f64) * (of_mean * disagreement).sqrt() / steepness
        } else {
            0.0
        };
        let half = (1.96 / steepness.sqrt()).max(by_joints);
        Some(Self { best, off, half, total, height })
    }
}
