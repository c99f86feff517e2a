//! Joints whose friction grows more slowly than the speed, chosen by the recordings.
//!
//! Viscous and Coulomb friction are a line over the speed. Where lubricants thin as they are sheared friction bends, and a
//! line through it errs at low and at high speed, and in what is fitted beside it. A joint has the bend where its
//! coefficient is essential, by standard errors that count what is correlated, and stretches of time that were not fitted
//! are explained no worse: of some seconds of motion these say little by themselves, for each has speeds of its own.

use armident_effects::{Effect, SublinearViscousFriction};
use armident_numeric::NumericError;

use crate::batch::{BatchProblem, BatchSettings, LAWS, Term};
use crate::coupling::rows_of;
use crate::left_out::{clear_gain, errors_left_out};
use crate::rows::JointRows;

/// A joint whose friction bends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BendFound {
    /// Joint, from 0.
    pub joint: usize,
    /// Its coefficient over the standard error of it.
    pub in_errors: f64,
}

impl BendFound {
    /// The law's name in files.
    pub fn slug() -> &'static str {
        SublinearViscousFriction.law().slug
    }
}

impl BatchProblem<'_> {
    /// The same with sub-linear viscous friction of these joints behind its unknowns.
    #[must_use]
    pub fn with_bends(&self, joints: &[usize]) -> Self {
        let mut problem = self.clone();
        let Some(effect) = LAWS.iter().position(|law| law.law().slug == BendFound::slug()) else {
            return problem;
        };
        for &joint in joints {
            problem.by_joint[joint].push(problem.terms.len());
            problem.terms.push(Term::Effect { joint, effect, parameter: 0 });
        }
        problem
    }

    /// Joints whose efforts are reported.
    pub(crate) fn possible_bends(&self) -> Vec<usize> {
        (0..self.by_joint.len()).filter(|&joint| !self.unreported[joint]).collect()
    }

    /// The bends that rows with the columns of all possible ones show beside the unknowns of this problem.
    pub(crate) fn bends_shown(
        &self,
        all: &BatchProblem<'_>,
        rows: &JointRows,
        settings: &BatchSettings,
    ) -> Result<Vec<BendFound>, NumericError> {
        let possible = self.possible_bends();
        let with = self.with_bends(&possible);
        let rows_with = rows_of(rows, all, &with);
        let before = errors_left_out(self, &rows_of(rows, all, self), settings)?;
        let after = errors_left_out(&with, &rows_with, settings)?;
        let mut found = with.estimate_with(&rows_with, settings)?;
        let beliefs = with.beliefs(settings)?;
        let scatter =
            with.with_block_errors(&rows_with, &beliefs, &mut found, 1.0, Clone::clone)?;
        if scatter.is_empty() {
            return Ok(Vec::new());
        }
        let shown = |(k, joint): (usize, usize)| {
            let in_errors = found.values[k] / found.standard_error(k)?;
            let is_shown = in_errors > found.quantile_95
                && clear_gain(&before, &after, &[joint], 0.0).is_some();
            is_shown.then_some(BendFound { joint, in_errors })
        };
        Ok((self.terms.len()..).zip(possible).filter_map(shown).collect())
    }
}
