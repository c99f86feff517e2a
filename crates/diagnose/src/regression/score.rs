//! The score of a set: a description length.
//!
//! Statistic: `n ln(S / N) + ln(n) k + 12 c + ln det(1 + s² W'W)`, where `S` is the weighted sum of squares of `N` rows, `n` the
//! effective sample size, `k` the number of coefficients and searched constants, and `c` that of choices among candidates.
//! References: G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6(2), 1978; D. P. Foster, E. I. George,
//! The risk inflation criterion for multiple regression, Annals of Statistics 22(4), 1994 (price of a choice).

use crate::design::candidate::Candidate;
use crate::design::linear_problem::LinearProblem;
use crate::regression::elimination::INFLATIONS;
use crate::regression::marginalised::Marginalised;
use armident_effects::Onset;

/// Price of a candidate in the score: the logarithm of the some three hundred candidates it was chosen from,
/// doubled.
pub(crate) const PRICE_OF_CHOICE: f64 = 12.0;

/// Price of a rare law or change: odds of one in a hundred against a frequent one.
pub(crate) const PRICE_OF_SELDOM: f64 = 9.2;
/// Score difference (twice a log odds) below which two explanations are indistinguishable: odds of 20 to 1.
pub(crate) const ODDS: f64 = 6.0;

impl Marginalised<'_> {
    /// The score: log likelihood with an estimated noise level, and the price.
    pub(crate) fn score(&self, sum_of_squares: f64, columns: usize, set: &[usize]) -> f64 {
        let rows = self.effective_rows;
        let samples = rows * self.problem.observations.weights.share;
        samples * (sum_of_squares / rows).ln() + self.price(columns, set)
    }

    /// Price of every column, searched constant and choice of a candidate, and of the link errors' determinant.
    pub(crate) fn price(&self, columns: usize, set: &[usize]) -> f64 {
        let samples = self.effective_rows * self.problem.observations.weights.share;
        let searched: usize = set.iter().map(|g| self.problem.candidates[*g].searched).sum();
        samples.ln() * (columns + searched) as f64
            + PRICE_OF_CHOICE * set.len() as f64
            + self.price_of_inflated_links()
            + self.price_of_onsets(set)
            + self.log_determinant
    }

    /// Price of the inflated links: each was chosen from all links, at each of the factors tried.
    fn price_of_inflated_links(&self) -> f64 {
        let choices = self.problem.link_error_prior.links.max(1) * INFLATIONS.len();
        2.0 * (choices as f64).ln() * self.inflated.len() as f64
    }

    /// Price of rare changes; 0 without a reference.
    fn price_of_onsets(&self, set: &[usize]) -> f64 {
        if !self.problem.observations.comparison.seeks_change() {
            return 0.0;
        }
        set.iter().map(|g| self.problem.price_of_onset(&self.problem.candidates[*g])).sum()
    }
}

impl LinearProblem {
    /// Price of a candidate as a change between two recordings.
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
