//! The score of a set: a description length.

use crate::design::candidate::Candidate;
use crate::design::linear_problem::LinearProblem;
use crate::regression::marginalised::Marginalised;
use armident_effects::Onset;
/// Price of a candidate in the score: the logarithm of the some three hundred candidates it was chosen from,
/// doubled.
pub(crate) const PRICE_OF_CHOICE: f64 = 12.0;

/// Price of a law, or a change, that seldom comes about: odds of one in a hundred against those that often
/// do.
pub(crate) const PRICE_OF_SELDOM: f64 = 9.2;

impl Marginalised<'_> {
    /// A description length: discrepancy in units of its own size, and its price.
    pub(crate) fn score(&self, sum_of_squares: f64, columns: usize, set: &[usize]) -> f64 {
        let rows = self.effective_rows;
        let samples = rows * self.problem.observations.weights.share;
        samples * (sum_of_squares / rows).ln() + self.price(columns, set)
    }

    /// A price for every column, every searched constant, every choice of a candidate, and for how much the errors of links
    /// could explain.
    pub(crate) fn price(&self, columns: usize, set: &[usize]) -> f64 {
        let samples = self.effective_rows * self.problem.observations.weights.share;
        let searched: usize = set.iter().map(|g| self.problem.candidates[*g].searched).sum();
        samples.ln() * (columns + searched) as f64
            + PRICE_OF_CHOICE * (set.len() + self.inflated.len()) as f64
            + self.price_of_onsets(set)
            + self.log_determinant
    }

    /// Nothing but where a change is sought.
    fn price_of_onsets(&self, set: &[usize]) -> f64 {
        if !self.problem.observations.comparison.seeks_change() {
            return 0.0;
        }
        set.iter().map(|g| self.problem.price_of_onset(&self.problem.candidates[*g])).sum()
    }
}

impl LinearProblem {
    /// What it costs, as a change between two recordings, that a candidate seldom comes about.
    pub(crate) fn price_of_onset(&self, candidate: &Candidate) -> f64 {
        let onset = candidate.law().map_or(Onset::Seldom, |law| law.onset());
        let of_last_link =
            candidate.location.joints.last() == self.link_error_prior.links.checked_sub(1).as_ref();
        match onset {
            Onset::OftenOfLastLink if of_last_link => 0.0,
            Onset::Often => 0.0,
            Onset::OftenOfLastLink | Onset::Seldom => PRICE_OF_SELDOM,
        }
    }
}
