//! Standard errors of a batch fit from blocks of time.
//!
//! Method: delete-a-block jackknife ([`jackknife`](armident_inference)) at the noise levels of the estimate, with
//! parameters at their bounds held there. What the prior knows is not in the blocks: it joins with its own covariance,
//! `A⁻¹ P A⁻¹`.
//!
//! References: H. R. Künsch, The jackknife and the bootstrap for general stationary observations, Annals of Statistics 17
//! (1989).

use armident_numeric::{AccumulatedQr, Mat, NumericError};

use super::estimate::{BatchEstimate, RANK_CUT};
use super::joint_rows::JointRows;
use super::prior::{BatchSettings, Regularisation};
use super::problem::BatchProblem;
use armident_inference::student_t_975;
use armident_inference::{FEWEST_BLOCKS, deviations, leave_one_out};

impl BatchProblem {
    /// Replaces the covariance of an estimate by that of the block jackknife; without effect where recordings are too
    /// short for four blocks.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub fn jackknife(
        &self,
        rows: &JointRows,
        settings: &BatchSettings,
        estimate: &mut BatchEstimate,
    ) -> Result<(), NumericError> {
        self.with_block_errors(rows, &self.regularisation(settings)?, estimate, 1.0, Clone::clone)?;
        Ok(())
    }

    /// The same with the rows of every fit formed by `stage`. Returns how far each of the solutions without a block lies
    /// from their mean; none where recordings are too short.
    ///
    /// `widening` is a factor of the standard errors, for what the rows do not know of the estimator.
    pub(crate) fn with_block_errors(
        &self,
        rows: &JointRows,
        regularisation: &Regularisation,
        estimate: &mut BatchEstimate,
        widening: f64,
        stage: impl Fn(&JointRows) -> JointRows,
    ) -> Result<Vec<Vec<f64>>, NumericError> {
        let blocks = rows.blocks.iter().map(Vec::len).min().unwrap_or(0);
        if blocks < FEWEST_BLOCKS {
            return Ok(Vec::new());
        }
        let p = self.terms.len();
        let without: Vec<Vec<AccumulatedQr>> =
            rows.blocks.iter().map(|of_joint| leave_one_out(of_joint)).collect();
        let mut solutions: Vec<Vec<f64>> = Vec::with_capacity(blocks);
        let free: Vec<usize> = (0..p).filter(|&k| !estimate.at_bound[k]).collect();
        let unbound = Regularisation { bound: None, prior: regularisation.prior.clone() };
        for b in 0..blocks {
            let left = stage(&JointRows {
                triangles: without.iter().map(|of_joint| of_joint[b].clone()).collect(),
                blocks: Vec::new(),
                ..rows.clone_without_rows()
            });
            solutions.push(self.solution_of(&left, &estimate.effort_noise, &unbound, &free)?);
        }
        let off = deviations(&solutions);
        let factor = widening * widening * (blocks - 1) as f64 / blocks as f64;
        let of_prior =
            regularisation.prior.as_ref().map(|prior| prior.carried(&estimate.covariance));
        estimate.covariance = Mat::from_fn(p, p, |i, j| {
            let of_blocks: f64 = off.iter().map(|d| d[i] * d[j]).sum();
            factor * of_blocks + of_prior.as_ref().map_or(0.0, |c| c[(i, j)])
        });
        estimate.quantile_95 = student_t_975((blocks - 1) as f64);
        Ok(off)
    }

    /// Values at given noise, those not in `free` being 0.
    fn solution_of(
        &self,
        rows: &JointRows,
        noise: &[f64],
        regularisation: &Regularisation,
        free: &[usize],
    ) -> Result<Vec<f64>, NumericError> {
        let (all, mean) = self.information(rows, noise, regularisation);
        let solved = all.with_unknowns(free).solve(RANK_CUT)?;
        let mut values = vec![0.0; self.terms.len()];
        for (&k, x) in free.iter().zip(&solved.solution) {
            values[k] = x + mean.as_ref().map_or(0.0, |m| m[k]);
        }
        Ok(values)
    }
}
