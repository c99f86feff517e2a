//! A set of candidates with its least-squares fit.
//!
//! Method: generalised least squares of the set; a set with an inadmissible candidate has no fit, or that of its admissible
//! part.
//! References: own.

use crate::design::observations::JointColumns;
use crate::regression::admissible::all_admissible;
use crate::regression::marginalised::{LeastSquaresFit, Marginalised};

/// A set of candidates with its fit.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// candidate ids, rising
    pub(crate) set: Vec<usize>,
    pub(crate) fit: LeastSquaresFit,
    pub(crate) score: f64,
}

/// Fits a set; none where it cannot be fitted or is not admissible.
pub(crate) fn fit_set(metric: &Marginalised<'_>, mut set: Vec<usize>) -> Option<Estimate> {
    set.sort_unstable();
    set.dedup();
    let all = set.clone();
    fit_judged(metric, set, &all)
}

/// Fits a set in its order; none where it cannot be fitted or some of its candidates are not admissible.
pub(crate) fn fit_judged(
    metric: &Marginalised<'_>,
    set: Vec<usize>,
    judged: &[usize],
) -> Option<Estimate> {
    let columns = metric.columns_of(&set);
    let count = columns.len();
    let fit = metric.fit(columns)?;
    all_admissible(metric.problem, judged, &fit).then(|| {
        let score = metric.score(fit.sum_of_squares, count, &set);
        Estimate { set, fit, score }
    })
}

/// Least-squares fit of a set; candidates with an inadmissible sign are dropped, except those in `named`.
pub(crate) fn admissible_part(
    metric: &Marginalised<'_>,
    mut set: Vec<usize>,
    named: &[usize],
) -> Option<Estimate> {
    loop {
        let columns = metric.columns_of(&set);
        let fit = metric.fit(columns)?;
        let before = set.len();
        set.retain(|g| named.contains(g) || all_admissible(metric.problem, &[*g], &fit));
        if set.len() == before {
            return fit_set(metric, set);
        }
    }
}

/// Fit of a set without admissibility: without the candidate in question others may have any sign.
pub(crate) fn fit_any_sign(
    metric: &Marginalised<'_>,
    set: Vec<usize>,
) -> Option<(Estimate, JointColumns)> {
    let columns = metric.columns_of(&set);
    let count = columns.len();
    let fit = metric.fit(columns)?;
    let residual = metric.residual(&fit);
    let score = metric.score(fit.sum_of_squares, count, &set);
    Some((Estimate { set, fit, score }, residual))
}
