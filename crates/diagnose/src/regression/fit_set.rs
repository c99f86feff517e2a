//! A set of candidates with its fit.

use crate::design::observations::Blocks;
use crate::regression::admissible::all_admissible;
use crate::regression::marginalised::{Fit, Whitened};
/// A set of groups with its fit.
#[derive(Debug, Clone)]
pub(crate) struct Answer {
    /// group ids, rising
    pub(crate) set: Vec<usize>,
    pub(crate) fit: Fit,
    pub(crate) score: f64,
}

/// Fits a set; none where it cannot be fitted or is not admissible.
pub(crate) fn answer(metric: &Whitened<'_>, mut set: Vec<usize>) -> Option<Answer> {
    set.sort_unstable();
    set.dedup();
    let columns = metric.columns_of(&set);
    let count = columns.len();
    let fit = metric.fit(columns)?;
    if !all_admissible(metric.problem, &set, &fit) {
        return None;
    }
    let score = metric.score(fit.sum_of_squares, count, &set);
    Some(Answer { set, fit, score })
}

/// The answer of a set without those groups beside `named` that have the wrong sign.
pub(crate) fn admissible_part(
    metric: &Whitened<'_>,
    mut set: Vec<usize>,
    named: &[usize],
) -> Option<Answer> {
    loop {
        let columns = metric.columns_of(&set);
        let fit = metric.fit(columns)?;
        let before = set.len();
        set.retain(|g| named.contains(g) || all_admissible(metric.problem, &[*g], &fit));
        if set.len() == before {
            return answer(metric, set);
        }
    }
}

/// A set whose names do not count: without the effect in question they may be inadmissible.
pub(crate) fn unnamed(metric: &Whitened<'_>, set: Vec<usize>) -> Option<(Answer, Blocks)> {
    let columns = metric.columns_of(&set);
    let count = columns.len();
    let fit = metric.fit(columns)?;
    let residual = metric.residual(&fit);
    let score = metric.score(fit.sum_of_squares, count, &set);
    Some((Answer { set, fit, score }, residual))
}
