//! Weighted least squares.
//!
//! Method: every joint is weighted by its noise level, which is estimated with the parameters.
//!
//! References: M. Gautier, P. Poignet, Extended Kalman filtering and weighted least squares dynamic identification of
//! robot, Control Eng. Practice 9 (2001).

use super::estimator::{Estimator, EstimatorError, TrainingData};
use crate::regression::{BatchEstimate, BatchProblem, BatchSettings};

/// Weighted least squares (`wls`).
#[derive(Debug, Clone, Copy)]
pub struct Wls;

impl Estimator for Wls {
    fn name(&self) -> &'static str {
        "wls"
    }

    fn title(&self) -> &'static str {
        "weighted least squares"
    }

    fn description(&self) -> &'static str {
        "weighted least squares, weights from each joint's noise"
    }

    fn fit(
        &self,
        problem: &BatchProblem,
        data: &TrainingData<'_>,
        settings: &BatchSettings,
    ) -> Result<BatchEstimate, EstimatorError> {
        let mut found = problem.estimate_with(data.rows, settings)?;
        problem.jackknife(data.rows, settings, &mut found)?;
        Ok(found)
    }
}
