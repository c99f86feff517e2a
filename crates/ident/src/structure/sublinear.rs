//! Joints with sublinear viscous friction, chosen by the recordings.
//!
//! Viscous and Coulomb friction are a line over the speed. Where lubricants are shear-thinning, friction is sublinear, and
//! a line through it errs at low and at high speed, and in the other parameters.
//!
//! Hypothesis: the coefficient of sublinear viscous friction is 0. Statistic: the coefficient over its standard error from
//! the block jackknife, above the 97.5 % quantile of Student's t; and left-out folds must be explained no worse. The folds
//! of some seconds of motion have little power by themselves, because each has speeds of its own.
//!
//! References: block jackknife in [`jackknife`](armident_inference); the law in
//! [`SublinearViscousFriction`](armident_effects::SublinearViscousFriction); the rule is own.

use armident_numeric::NumericError;

use super::fold_errors::fold_errors;
use crate::regression::{BatchProblem, BatchSettings, JointRows};
use armident_inference::significant_gain;

/// A joint with sublinear viscous friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SublinearFound {
    /// Joint, from 0.
    pub joint: usize,
    /// Its coefficient over its standard error.
    pub t: f64,
}

impl BatchProblem {
    /// Joints without a dead zone.
    pub(super) fn sublinear_candidates(&self) -> Vec<usize> {
        (0..self.by_joint.len()).filter(|&joint| !self.has_dead_zone[joint]).collect()
    }

    /// The joints that rows with the columns of all candidates show to be sublinear beside the unknowns of this problem.
    pub(super) fn sublinear_shown(
        &self,
        all: &BatchProblem,
        rows: &JointRows,
        settings: &BatchSettings,
    ) -> Result<Vec<SublinearFound>, NumericError> {
        let possible = self.sublinear_candidates();
        let with = self.with_sublinear(&possible);
        let rows_with = rows.select(all, &with);
        let before = fold_errors(self, &rows.select(all, self), settings)?;
        let after = fold_errors(&with, &rows_with, settings)?;
        let mut found = with.estimate_with(&rows_with, settings)?;
        let regularisation = with.regularisation(settings)?;
        let scatter =
            with.with_block_errors(&rows_with, &regularisation, &mut found, 1.0, Clone::clone)?;
        if scatter.is_empty() {
            return Ok(Vec::new());
        }
        let shown = |(k, joint): (usize, usize)| {
            let t = found.values[k] / found.standard_error(k)?;
            let is_shown =
                t > found.quantile_95 && significant_gain(&before, &after, &[joint], 0.0).is_some();
            is_shown.then_some(SublinearFound { joint, t })
        };
        Ok((self.terms.len()..).zip(possible).filter_map(shown).collect())
    }
}
