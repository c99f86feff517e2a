//! Priors of the links and of the drive gains, before the columns are looked at.

use crate::regression::{BatchProblem, Term, UNKNOWN, spread_of_numbers};

/// Gains looked at: a factor of ten thousand to either side of a joint's effort, which takes in gears,
/// currents, milli- and per-mille units.
pub(super) const LARGEST_LOG_GAIN: f64 = 9.210_340_371_976_184;
/// Standard deviation of the logarithm of the gain of a correct channel: published drive gains of one type of arm differ
/// by up to a third.
pub(super) const USUAL_LOG_GAIN: f64 = 0.3;
/// Prior of the constants: `x = mean + spread ξ`, `ξ ~ N(0, I)`.
pub(super) struct LinkErrors {
    pub(super) mean: Vec<f64>,
    /// by columns
    pub(super) spread: Vec<Vec<f64>>,
}

impl LinkErrors {
    pub(super) fn of(problem: &BatchProblem, error: f64, load: f64) -> Self {
        let (arm, set) = (problem.arm(), problem.set());
        let mut spread = spread_of_numbers(arm, set, error, load).unwrap_or_default();
        // rotors that are part of a constant may be of any size
        for &(k, _) in problem.merged.iter().flat_map(|m| &m.into) {
            if let Term::Constant(c) = problem.terms[k] {
                let own = spread.iter().map(|column| column[c].powi(2)).sum::<f64>().sqrt();
                let mut alone = vec![0.0; set.len()];
                alone[c] = UNKNOWN * own;
                spread.push(alone);
            }
        }
        Self { mean: set.values(&arm.constants()), spread }
    }
}
