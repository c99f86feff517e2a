//! Robust weighted least squares: Huber's estimator by iteratively reweighted least squares.
//!
//! Method: rows whose residual exceeds 1.345 scales of their joint get weight in proportion to the inverse of their
//! residual; the scale is the median absolute residual. Standard errors are widened by Huber's `Σw / Σψ'`.
//!
//! References: P. J. Huber, Robust Statistics (1981), chapter 7.

use armident_dynamics::ArmMotion;
use armident_motion::Motion;
use rayon::prelude::*;

use super::estimator::{Estimator, EstimatorError, TrainingData};
use crate::regression::{BatchEstimate, BatchProblem, BatchSettings, TermColumn};
use crate::used_samples::used_samples;

/// Huber's constant: 95 % efficiency where the noise is normal after all.
const HUBER: f64 = 1.345;
/// Standard deviation of normal noise over the median of its absolute values.
const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;
/// Robust weights are done when no value moves by more of its standard error.
const TOLERANCE: f64 = 0.02;
const MOST_PASSES: usize = 10;
/// Passes after which the scales stay: they hardly move, and cost a pass each.
const SCALE_PASSES: usize = 2;
/// Robust weighted least squares (`irls`).
#[derive(Debug, Clone, Copy)]
pub struct Huber;

impl Estimator for Huber {
    fn name(&self) -> &'static str {
        "irls"
    }

    fn title(&self) -> &'static str {
        "robust weighted least squares (Huber)"
    }

    fn fit(
        &self,
        problem: &BatchProblem,
        data: &TrainingData<'_>,
        settings: &BatchSettings,
    ) -> Result<BatchEstimate, EstimatorError> {
        let TrainingData { motions, rows: plain, .. } = *data;
        let regularisation = problem.regularisation(settings)?;
        let mut found = problem.estimate_with(plain, settings)?;
        let mut rows = plain.clone();
        let n = problem.by_joint.len();
        // what jumps is the costly part, and the same in every pass
        let jumping: Vec<Vec<Vec<TermColumn>>> = (0..n)
            .into_par_iter()
            .map(|joint| motions.iter().map(|m| problem.jumping_columns(joint, m)).collect())
            .collect();
        let moved = problem.arm_motions(motions);
        let mut scales = vec![0.0; n];
        // the weights follow the values: only samples within the scale resist, all carry weight
        // (Huber's Σψ' against Σw)
        let mut widening = 1.0;
        for pass in 0..MOST_PASSES {
            let values = found.values.clone();
            let mut weighing: Vec<Weighing> = (0..n)
                .into_par_iter()
                .map(|joint| residuals(problem, joint, motions, &moved, &jumping[joint], &values))
                .collect();
            for (weighing, scale) in weighing.iter_mut().zip(&mut scales) {
                if pass < SCALE_PASSES {
                    *scale = weighing.scale();
                }
                weighing.weigh(HUBER * *scale);
            }
            rows = problem.accumulate_with(
                motions,
                |index, joint, effort| {
                    let jumping = &jumping[joint][index];
                    let mut columns =
                        problem.columns_beside(joint, motions[index], &moved[index], jumping);
                    let mut y = effort.to_vec();
                    let roots = &weighing[joint].roots[index];
                    for column in columns.iter_mut().chain([&mut y]) {
                        let used = &mut column[used_samples(motions[index])];
                        used.iter_mut().zip(roots).for_each(|(x, root)| *x *= root);
                    }
                    (columns, y)
                },
                |joint| problem.by_joint[joint].len(),
            );
            let total = |of: fn(&Weighing) -> f64| weighing.iter().map(of).sum::<f64>();
            widening = total(|w| w.sum) / f64::max(total(|w| w.within), 0.5 * total(|w| w.samples));
            found = problem.estimate_with(&rows, settings)?;
            let moved = (0..values.len())
                .filter_map(|k| {
                    Some((found.values[k] - values[k]).abs() / found.standard_error(k)?)
                })
                .filter(|moved| moved.is_finite())
                .fold(0.0, f64::max);
            if moved < TOLERANCE {
                break;
            }
        }
        problem.with_block_errors(&rows, &regularisation, &mut found, widening, |r| r.clone())?;
        // noise and fit are those of all samples alike
        found.train = problem.fit(plain, &found.values);
        for (noise, fit) in found.effort_noise.iter_mut().zip(&found.train) {
            *noise = noise.max(fit.rmse);
        }
        Ok(found)
    }
}

/// Absolute residuals of a joint at these values.
fn residuals(
    problem: &BatchProblem,
    joint: usize,
    motions: &[&Motion],
    moved: &[ArmMotion<'_>],
    jumping: &[Vec<TermColumn>],
    values: &[f64],
) -> Weighing {
    let residual = |index: usize| -> Option<Vec<f64>> {
        let motion = motions[index];
        let effort = &motion.effort_filtered.as_ref()?[joint];
        let explained = problem.explained(joint, motion, &moved[index], &jumping[index], values);
        Some(used_samples(motion).map(|t| (effort[t] - explained[t]).abs()).collect())
    };
    let roots = (0..motions.len()).map(|index| residual(index).unwrap_or_default());
    let at_rest = motions.iter().map(|m| m.at_rest(joint)[used_samples(m)].to_vec());
    let (roots, at_rest) = (roots.collect(), at_rest.collect());
    Weighing { roots, at_rest, sum: 0.0, within: 0.0, samples: 0.0 }
}

/// Huber's weights of one joint.
struct Weighing {
    /// per motion and used sample: absolute residual, then the root of the weight
    roots: Vec<Vec<f64>>,
    /// per motion and used sample: whether the joint is at rest
    at_rest: Vec<Vec<bool>>,
    /// sum of the weights, samples within the scale, and all
    sum: f64,
    within: f64,
    samples: f64,
}

impl Weighing {
    /// Standard deviation of the residual in motion, if it is normal, from its median.
    fn scale(&self) -> f64 {
        let all = self.roots.iter().flatten().zip(self.at_rest.iter().flatten());
        let mut left: Vec<f64> =
            all.filter(|(_, at_rest)| !**at_rest).map(|(left, _)| *left).collect();
        let middle = left.len() / 2;
        if left.is_empty() {
            return f64::MIN_POSITIVE;
        }
        let median = *left.select_nth_unstable_by(middle, f64::total_cmp).1;
        (MAD_TO_SIGMA * median).max(f64::MIN_POSITIVE)
    }

    fn weigh(&mut self, limit: f64) {
        for left in self.roots.iter_mut().flatten() {
            let off = *left / limit;
            self.samples += 1.0;
            self.sum += off.max(1.0).recip();
            if off <= 1.0 {
                self.within += 1.0;
                *left = 1.0;
            } else {
                *left = off.recip().sqrt();
            }
        }
    }
}
