//! A name needs a size: no effect is named whose main parameters are within two standard errors of nothing.
//!
//! Materiality and cross-validation ask whether an effort is missing. A material effort may be explained by two laws whose
//! numbers are large, uncertain and opposite; then neither is known.
//!
//! Method: backward elimination, the least certain first, all others refitted; paired t of the errors on left-out blocks.
//! References: own; the statistic in [`crate::findings::numbers`].

use std::cell::LazyCell;

use crate::design::training::Design;
use crate::findings::finding::honest_errors;
use crate::findings::numbers::numbers;
use crate::regression::admissible::admissible;
use crate::regression::fit_set::{Estimate, fit_any_sign};
use crate::regression::folds::fold_errors;
use crate::selection::cross_validation::{Predictor, predictor, significantly_less};
use crate::selection::materiality::{estimate_without, held};
use crate::selection::solution::{Selection, Solution};
use crate::uncertainty::jackknife::Jackknife;

/// A selection whose candidates have a size, what predicts best with it, and the errors of that; `best` predicts best with the
/// selection as it is.
pub(crate) fn with_size(
    design: &Design<'_>,
    mut selection: Selection,
    mut best: Predictor,
) -> (Selection, Predictor, Jackknife) {
    loop {
        let (jackknife, rest) = {
            let metric = selection.problem.marginalised(best.scale, &selection.inflated);
            let solution = Solution::new(design, &metric, &best.estimate, &selection.point);
            let jackknife = honest_errors(design, &solution);
            let rest = without_least_certain(&selection, &solution, &jackknife);
            (jackknife, rest)
        };
        let Some(rest) = rest else { return (selection, best, jackknife) };
        selection.estimate = rest;
        best = predictor(&selection.metric(), &selection.estimate);
    }
}

/// The estimate without its least certain candidate; none where all have a size. What is held in the operating point stays:
/// its columns were formed there. So does what left-out blocks miss clearly, whatever its numbers (the coupled wrist of a TX40,
/// whose friction ten seconds do not determine): of two laws that explain one effort, the other one would do.
fn without_least_certain(
    selection: &Selection,
    best: &Solution<'_, '_>,
    jackknife: &Jackknife,
) -> Option<Estimate> {
    let metric = selection.metric();
    let candidates = &selection.problem.candidates;
    let is_held = |g: usize| !held(&candidates[g], &selection.point).is_empty();
    let sizes = selection.estimate.set.iter().filter(|g| !is_held(**g)).filter_map(|&g| {
        // beside the small terms it may have a sign that its law has not
        let size = match admissible(best.metric.problem, &candidates[g], &best.estimate.fit) {
            true => numbers(best, g, jackknife).size?,
            false => 0.0,
        };
        (size < 1.0).then_some((size, g))
    });
    let mut uncertain: Vec<(f64, usize)> = sizes.collect();
    uncertain.sort_by(|a, b| a.0.total_cmp(&b.0));
    let errors =
        |set: &[usize]| fold_errors(&selection.problem, set, selection.scale, &selection.inflated);
    let before = LazyCell::new(|| errors(&selection.estimate.set));
    let seeks_change = selection.problem.observations.comparison.seeks_change();
    uncertain.into_iter().find_map(|(size, least)| {
        let rest = || selection.estimate.set.iter().copied().filter(|g| *g != least).collect();
        let without = estimate_without(&metric, &selection.estimate, least)
            .or_else(|| Some(fit_any_sign(&metric, rest())?.0))?;
        let is_missed =
            size > 0.0 && !seeks_change && significantly_less(&before, &errors(&without.set));
        (!is_missed).then_some(without)
    })
}
