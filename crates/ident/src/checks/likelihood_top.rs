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

/// Half of the 95 % interval of a number at the top of the likelihood of all joints, by its steepness (minus the second derivative)
/// there and by the slopes of the joints, which add up to zero.
pub(super) fn half_of_95(steepness: f64, slopes: &[f64]) -> f64 {
    let by_curvature = 1.96 / steepness.sqrt();
    let others = slopes.len() as f64 - 1.0;
    if others < 1.0 {
        return by_curvature;
    }
    let of_mean = slopes.len() as f64 / others;
    let disagreement: f64 = slopes.iter().map(|slope| slope.powi(2)).sum();
    by_curvature.max(student_t_975(others) * (of_mean * disagreement).sqrt() / steepness)
}

impl Top {
    /// Of `[joint][value]`, values `step` apart; none without a joint, and where the top is at an end or there is none.
    pub(super) fn of(log_likelihood: &[Vec<f64>], step: f64) -> Option<Self> {
        let values = log_likelihood.first()?.len();
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
        let slopes: Vec<f64> =
            log_likelihood.iter().map(|l| slope(l) + curvature(l) * off).collect();
        let half = half_of_95(steepness, &slopes);
        Some(Self { best, off, half, total, height })
    }
}
