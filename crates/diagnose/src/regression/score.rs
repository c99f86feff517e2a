//! The score of a set: a description length.

use crate::design::candidate::{Group, Meaning};
use crate::design::linear_problem::Problem;
use crate::regression::marginalised::Whitened;
use armident_effects::{Onset, effect};
/// Price of a group in the score: the logarithm of the some three hundred groups it was chosen from,
/// doubled.
pub(crate) const PRICE_OF_CHOICE: f64 = 12.0;

/// Price of a law, or a change, that seldom comes about: odds of one in a hundred against those that often
/// do.
pub(crate) const PRICE_OF_SELDOM: f64 = 9.2;

impl Whitened<'_> {
    /// A description length: misfit in units of its own size, and its price.
    pub(crate) fn score(&self, sum_of_squares: f64, columns: usize, set: &[usize]) -> f64 {
        let rows = self.effective_rows;
        let samples = rows * self.problem.rows.share;
        samples * (sum_of_squares / rows).ln() + self.price(columns, set)
    }

    /// A price for every column, every searched constant, every choice of a group, and for how much the errors of links
    /// could explain.
    pub(crate) fn price(&self, columns: usize, set: &[usize]) -> f64 {
        let samples = self.effective_rows * self.problem.rows.share;
        let searched: usize = set.iter().map(|g| self.problem.groups[*g].searched).sum();
        samples.ln() * (columns + searched) as f64
            + PRICE_OF_CHOICE * (set.len() + self.wide.len()) as f64
            + self.price_of_onsets(set)
            + self.log_determinant
    }

    /// Nothing but where a change is sought.
    fn price_of_onsets(&self, set: &[usize]) -> f64 {
        if self.problem.rows.changed_from == 0 {
            return 0.0;
        }
        set.iter().map(|g| self.problem.price_of_onset(&self.problem.groups[*g])).sum()
    }
}

impl Problem {
    /// What it costs, as a change between two recordings, that a group seldom comes about.
    pub(crate) fn price_of_onset(&self, group: &Group) -> f64 {
        let onset = match group.meaning {
            Meaning::Law(slug) => effect(slug).map_or(Onset::Seldom, |law| law.onset()),
            Meaning::SmoothDirections(_) => Onset::Seldom,
        };
        let of_last_link =
            group.site.joints.last() == self.background.links.checked_sub(1).as_ref();
        match onset {
            Onset::OftenOfLastLink if of_last_link => 0.0,
            Onset::Often => 0.0,
            Onset::OftenOfLastLink | Onset::Seldom => PRICE_OF_SELDOM,
        }
    }
}
