//! Blocked cross-validation: contiguous blocks of the recordings are excluded from the fit and predicted.
//!
//! Method: cross-validation by blocks, because residuals are autocorrelated.
//! References: P. Burman, E. Chow, D. Nolan, A cross-validatory method for dependent data, Biometrika 81(2), 1994.

use crate::design::linear_problem::LinearProblem;
use crate::design::observations::JointColumns;
use crate::regression::elimination::InflatedLink;
use crate::regression::marginalised::Marginalised;
use armident_inference::time_blocks;
use armident_numeric::dot;
use rayon::prelude::*;
use std::ops::Range;
/// Folds of each recording.
pub(crate) const BLOCKS_PER_RECORDING: usize = 3;

/// Folds where only the error is used: short, so that the fit lacks little data.
pub(crate) const SHORT_BLOCKS: usize = 10;

/// Least length of a block, where many are wanted \[s\]: about as long as a motion goes one way.
pub(crate) const SHORTEST_BLOCK_S: f64 = 1.0;

/// The problem of an estimate cut into a training part and a block.
pub(crate) struct Fold {
    pub(crate) fitted: LinearProblem,
    predicted: LinearProblem,
}

impl Fold {
    /// Sum of weighted squares of the block that was not fitted, by joint.
    pub(crate) fn errors(&self, set: &[usize], metric: &Marginalised<'_>) -> Vec<f64> {
        match self.residual(set, metric) {
            Some(residual) => residual.iter().map(|r| dot(r, r)).collect(),
            None => vec![f64::INFINITY; self.predicted.effort.len()],
        }
    }

    /// Error on the block of a fit to the others, by joint; none where it cannot be fitted.
    pub(crate) fn residual(
        &self,
        set: &[usize],
        metric: &Marginalised<'_>,
    ) -> Option<JointColumns> {
        let fit = metric.fit(metric.columns_of(set))?;
        Some(metric.residual_of(&fit, &self.predicted))
    }
}

/// One fold for every block.
pub(crate) fn folds(problem: &LinearProblem) -> Vec<Fold> {
    let rows = &problem.observations;
    let starts = &rows.starts[rows.comparison.first_judged()..];
    if !rows.comparison.seeks_change() {
        return folds_of(problem, starts, BLOCKS_PER_RECORDING);
    }
    let longest = starts.windows(2).map(|p| p[1] - p[0]).max().unwrap_or(0) as f64 / rows.rows_hz;
    let blocks = ((longest / SHORTEST_BLOCK_S) as usize).clamp(BLOCKS_PER_RECORDING, SHORT_BLOCKS);
    folds_of(problem, starts, blocks)
}

pub(crate) fn folds_of(problem: &LinearProblem, starts: &[usize], blocks: usize) -> Vec<Fold> {
    let fold = |inside: Range<usize>| Fold {
        fitted: problem.of_rows(|row| !inside.contains(&row)),
        predicted: problem.of_rows(|row| inside.contains(&row)),
    };
    time_blocks(starts, blocks).into_par_iter().map(fold).collect()
}

/// The training part of every fold, in a metric.
pub(crate) fn metrics<'a>(
    folds: &'a [Fold],
    scale: f64,
    inflated: &[InflatedLink],
) -> Vec<Marginalised<'a>> {
    folds.par_iter().map(|fold| fold.fitted.marginalised(scale, inflated)).collect()
}

/// Errors of every block, `[fold][joint]`, in the metrics of the others.
pub(crate) fn all_errors(
    folds: &[Fold],
    metrics: &[Marginalised<'_>],
    set: &[usize],
) -> Vec<Vec<f64>> {
    folds.par_iter().zip(metrics).map(|(fold, metric)| fold.errors(set, metric)).collect()
}

/// Errors of blocks that were not fitted, `[block][joint]`, of a set of candidates.
pub(crate) fn fold_errors(
    problem: &LinearProblem,
    set: &[usize],
    scale: f64,
    inflated: &[InflatedLink],
) -> Vec<Vec<f64>> {
    let (small, ids) = problem.restricted(set);
    let folds = folds(&small);
    all_errors(&folds, &metrics(&folds, scale, inflated), &ids)
}

/// Blocks of a recording for the jackknife.
pub(crate) const LEFT_OUT_PER_RECORDING: usize = 5;
