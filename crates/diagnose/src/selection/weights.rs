//! Weights of the rows: model discrepancy of each joint over its noise, and the effective sample size.
//!
//! Method: residual of all columns of the library as an estimate of the discrepancy; one sample per autocorrelation time.
//! References: G. V. Bayley, J. M. Hammersley, The "effective" number of independent observations in an autocorrelated time
//! series, Supplement to the Journal of the Royal Statistical Society 8(2), 1946.

use armident_model::OperatingPoint;
use armident_numeric::{Cholesky, dot, gram_of_columns};
use rayon::prelude::*;

use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::observations::Weights;
use crate::design::smooth;
use crate::design::training::Design;
use crate::regression::fit_set::Estimate;
use crate::regression::marginalised::Marginalised;

/// Residual over noise above which a joint has model discrepancy and a lower weight.
const CLEAR_DISCREPANCY: f64 = 1.5;

/// Residual of all columns of the library together, each joint alone, and the share of independent samples beside so many
/// columns.
fn left_by_all(problem: &LinearProblem) -> Vec<Option<(Vec<f64>, f64)>> {
    const HOLD: f64 = 1e-6;
    (0..problem.observations.joints())
        .into_par_iter()
        .map(|j| {
            let blocks: Vec<&[f64]> = problem
                .columns
                .iter()
                .map(|c| c[j].as_slice())
                .filter(|c| c.iter().any(|x| *x != 0.0))
                .collect();
            let effort = &problem.effort[j];
            let gram = gram_of_columns(&blocks);
            let norm: Vec<f64> = (0..blocks.len()).map(|k| gram[(k, k)].sqrt()).collect();
            let cholesky = Cholesky::of(blocks.len(), |a, b| {
                gram[(a, b)] / (norm[a] * norm[b]) + if a == b { HOLD } else { 0.0 }
            })?;
            let rhs: Vec<f64> = blocks.iter().zip(&norm).map(|(c, n)| dot(c, effort) / n).collect();
            let solution = cholesky.solve(&rhs);
            let mut residual = effort.clone();
            for ((column, x), n) in blocks.iter().zip(&solution).zip(&norm) {
                for (r, c) in residual.iter_mut().zip(*column) {
                    *r -= x / n * c;
                }
            }
            let samples = effort.len() as f64 * problem.observations.weights.share;
            // each column takes one independent sample
            let free = (1.0 - blocks.len() as f64 / samples).max(0.1);
            Some((residual, free))
        })
        .collect()
}

/// Weights of rows in which joints rest, from the residual that all columns of the library have there when only the
/// rows in motion decide.
pub(crate) fn weights_with_dwells(design: &Design<'_>, point: &OperatingPoint) -> Weights {
    let moving = design.weighted(design.observations.without_dwells());
    let problem = moving.problem(point);
    let residual = |(j, left): (usize, &Option<(Vec<f64>, f64)>)| {
        let (residual, _) = left.as_ref()?;
        problem.observations.residual_at_rest(j, residual)
    };
    let left = left_by_all(&problem);
    let at_rest = left.iter().enumerate().map(residual);
    design.observations.with_residual_at_rest(at_rest.map(Option::unwrap_or_default).collect())
}

/// Residual of all columns of the library and a smooth term, each joint alone, in units of its noise: a lower bound for any
/// estimate. Clearly more than 1 where efforts were smoothed before they were recorded, so that the noise above the band
/// does not determine that in the band, and where motion that is not recorded moves the joint.
pub(crate) fn initial_discrepancies(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &LinearProblem,
) -> Vec<f64> {
    let discrepancy = |(j, left): (usize, Option<(Vec<f64>, f64)>)| {
        let Some((residual, free)) = left else { return 1.0 };
        let left = problem.observations.in_band_noise(j, &residual) / free.sqrt();
        if left <= CLEAR_DISCREPANCY {
            return 1.0;
        }
        // with a weight lowered by structure that only a smooth term explains, that term would not be selected
        let left = left * smooth::least_left(design, at, j, &residual).sqrt();
        if left > CLEAR_DISCREPANCY { left } else { 1.0 }
    };
    left_by_all(problem).into_iter().enumerate().map(discrepancy).collect()
}

/// Model discrepancy of each joint, in units of its noise, where that is clearly more than noise.
pub(crate) fn discrepancies(metric: &Marginalised<'_>, found: &Estimate) -> Vec<f64> {
    let residual = metric.residual(&found.fit);
    (0..residual.len())
        .map(|j| {
            let left = metric.problem.observations.in_band_noise(j, &residual[j]);
            // only downward: structure that is not yet explained must not lower the weight
            let left = if left > CLEAR_DISCREPANCY { left } else { 1.0 };
            left.min(metric.problem.observations.weights.discrepancy[j])
        })
        .collect()
}

/// Model discrepancy after a change: it may exceed that of the reference, and a joint on which it does must not decide about
/// the others.
pub(crate) fn discrepancies_after(metric: &Marginalised<'_>, found: &Estimate) -> Vec<f64> {
    let rows = &metric.problem.observations;
    let residual = metric.residual(&found.fit);
    let left = residual.iter().enumerate().map(|(j, residual)| rows.in_band_noise(j, residual));
    left.zip(&rows.weights.discrepancy_before).map(|(left, before)| left.max(*before)).collect()
}
