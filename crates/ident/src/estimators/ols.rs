//! Ordinary least squares.
//!
//! Method: every row of every joint has the same weight.
//!
//! References: C. H. An, C. G. Atkeson, J. M. Hollerbach, Estimation of inertial parameters of rigid body links of
//! manipulators, IEEE CDC 1985.

use super::estimator::{Estimator, EstimatorError, TrainingData};
use crate::regression::{BatchEstimate, BatchProblem, BatchSettings};

/// Ordinary least squares (`ols`).
#[derive(Debug, Clone, Copy)]
pub struct Ols;

impl Estimator for Ols {
    fn name(&self) -> &'static str {
        "ols"
    }

    fn title(&self) -> &'static str {
        "ordinary least squares"
    }

    fn fit(
        &self,
        problem: &BatchProblem,
        data: &TrainingData<'_>,
        settings: &BatchSettings,
    ) -> Result<BatchEstimate, EstimatorError> {
        // the noise levels are those of the joints, but one level weighs all rows
        let weighted = problem.estimate_with(data.rows, settings)?;
        let n = weighted.effort_noise.len();
        let level = weighted.effort_noise.iter().map(|s| s * s).sum::<f64>() / n as f64;
        let mut found = problem.estimate_at_noise(data.rows, settings, vec![level.sqrt(); n])?;
        problem.jackknife(data.rows, settings, &mut found)?;
        found.effort_noise = weighted.effort_noise;
        Ok(found)
    }
}
