//! Errors of a batch fit on folds of time that it was not fitted to.
//!
//! Method: leave-one-fold-out cross-validation on triangles ([`folds`](armident_inference)), each joint weighted by the
//! noise that its own columns leave.
//!
//! References: in [`folds`](armident_inference).

use armident_numeric::{AccumulatedQr, NumericError};

use crate::regression::{BatchProblem, BatchSettings, JointRows};
use armident_inference::{FOLDS, merged, without};

/// Whether every joint has at least as many blocks as there are folds.
pub(super) fn has_folds(rows: &JointRows) -> bool {
    rows.blocks.iter().all(|blocks| blocks.len() >= FOLDS)
}

/// Squared error of every joint on each fold, fitted to the others, as `[fold][joint]`.
pub(super) fn fold_errors(
    problem: &BatchProblem,
    rows: &JointRows,
    settings: &BatchSettings,
) -> Result<Vec<Vec<f64>>, NumericError> {
    let regularisation = problem.regularisation(settings)?;
    let noise = problem.noise_alone(rows)?;
    let blocks = rows.blocks.iter().map(Vec::len).min().unwrap_or(0);
    // by joint
    let of_joints: Vec<Vec<AccumulatedQr>> =
        rows.blocks.iter().map(|of_joint| merged(of_joint, blocks)).collect();
    (0..FOLDS)
        .map(|left_out| {
            let triangles = of_joints.iter().map(|folds| without(folds, left_out)).collect();
            let fitted = JointRows { triangles, ..rows.clone_without_rows() };
            let values = problem.weighted(&fitted, &noise, &regularisation)?.answer.solution;
            let error = |(joint, folds): (usize, &Vec<AccumulatedQr>)| {
                let x: Vec<f64> = problem.by_joint[joint].iter().map(|&k| values[k]).collect();
                folds[left_out].residual_sum_of_squares(&x).max(f64::MIN_POSITIVE)
            };
            Ok(of_joints.iter().enumerate().map(error).collect())
        })
        .collect()
}
