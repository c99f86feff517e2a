//! The prior scale: how far the links differ from the URDF, estimated from the recordings.
//!
//! Method: marginal likelihood (evidence) of the prior scale `r`. With the effects projected out, the constants `x` and the
//! prior's `N(x₀, r² C)` give efforts the density `|r² C|^(-1/2) |A' A + C⁻¹/r²|^(-1/2) exp(-S/2)`, `S` the squares left by
//! both together (eq. 2.9 of MacKay); each joint's noise is that of the fit with the given settings, and dependent
//! samples count for less. Taken is the largest scale within one standard error of the most likely one.
//!
//! References: D. J. C. MacKay, Bayesian interpolation, Neural Computation 4 (1992); the one-standard-error rule is own.

use armident_numeric::NumericError;

use super::estimate::RANK_CUT;
use super::joint_rows::JointRows;
use super::prior::{BatchSettings, Regularisation, TermPrior, triangle_of};
use super::problem::BatchProblem;
use super::unknown::Term;

/// Scales `r` that are tried: from the best URDFs of vendors to links without information.
const LEAST_SCALE: f64 = 0.1;
const LARGEST_SCALE: f64 = 3.0;
/// Steps between them, each of 12 %: an arm's constants hardly distinguish finer ones.
const SCALE_STEPS: usize = 30;
/// Twice the logarithm of the marginal likelihood that a larger scale may be below the most likely one: one standard error
/// of a parameter. Too small a scale gives too small standard errors.
const ONE_STANDARD_ERROR: f64 = 1.0;

impl BatchProblem {
    /// The prior scale by accumulated recordings: the largest `r` within a standard error of the most likely one. None where
    /// the URDF gives no link a mass: there is no prior.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub(crate) fn estimate_prior_scale(
        &self,
        rows: &JointRows,
        settings: &BatchSettings,
    ) -> Result<Option<f64>, NumericError> {
        // the prior's rows are in proportion to 1/r
        let Some(TermPrior { mean, rows: at_one }) = self.link_prior_over_terms(1.0)? else {
            return Ok(None);
        };
        let noise = self.estimate_with(rows, settings)?.effort_noise;
        let besides = TermPrior { mean, rows: self.load_prior() };
        let besides = Regularisation { bound: None, prior: Some(besides) };
        let (recorded, _) = self.information(rows, &noise, &besides);
        let at_one = triangle_of(&at_one, self.terms.len());
        let terms: Vec<usize> = (0..self.terms.len()).collect();
        let constants = self.terms.iter().filter(|t| matches!(t, Term::Constant(_))).count() as f64;
        let step = (LARGEST_SCALE / LEAST_SCALE).powf((SCALE_STEPS as f64).recip());
        let scales: Vec<f64> =
            (0..=SCALE_STEPS).map(|k| LEAST_SCALE * step.powi(k as i32)).collect();
        let evidence = scales
            .iter()
            .map(|&scale| {
                let mut all = recorded.clone();
                all.merge_weighted(&at_one, &terms, 1.0 / (scale * rows.share.sqrt()));
                let root = all.root(1.0);
                let diagonal = (0..root.nrows()).map(|k| root[(k, k)].abs());
                let determinant: f64 = diagonal.map(|d| d.max(f64::MIN_POSITIVE).ln()).sum();
                let left = rows.share * all.solve(RANK_CUT)?.residual_sum_of_squares;
                Ok(-2.0 * (constants * scale.ln() + determinant) - left)
            })
            .collect::<Result<Vec<f64>, NumericError>>()?;
        let most = evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let near = |k: &usize| evidence[*k] >= most - ONE_STANDARD_ERROR;
        Ok((0..=SCALE_STEPS).rev().find(near).map(|k| scales[k]))
    }
}
