//! The prior scale: relative standard deviation of the given link inertias.
//!
//! Method: empirical Bayes: a search at every scale of a grid; the lowest score, whose likelihood is marginal over the link
//! errors, decides.
//! References: D. J. C. MacKay, Bayesian interpolation, Neural Computation 4(3), 1992.

use armident_effects::{Law, LawRole, LinkInertiaError};
use std::collections::HashSet;

use rayon::prelude::*;

use crate::design::candidate::Candidate;
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::linear_problem::LinearProblem;
use crate::design::ripple::RippleColumns;
use crate::design::training::Design;
use crate::regression::elimination::{INFLATIONS, InflatedLink};
use crate::regression::fit_set::{Estimate, fit_set};
use crate::regression::score::ODDS;
use crate::selection::beam_search::search;
use crate::selection::cross_validation::with_baseline_terms_of;
use crate::selection::materiality::prune;
use armident_model::OperatingPoint;

/// Prior scale of links from CAD.
pub(crate) const CAD_SCALE: f64 = 0.03;
/// Prior scales tried: exact, a good data sheet, CAD, a guess, unknown.
pub(crate) const SCALES: [f64; 9] = [0.0, 0.012, CAD_SCALE, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6];
/// Largest prior scale at which single links are inflated.
const ALL_LINKS_WRONG: f64 = 0.2;
/// Most inflated links.
const MOST_INFLATED_LINKS: usize = 2;
/// Rounds of scanning the residual.
const ROUNDS: usize = 6;

/// Criterion of the prior scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ScaleCriterion {
    /// the score of the whole set
    All,
    /// the score of its material candidates: small laws absorb a link error, and leave it to the errors of all links once
    /// removed
    Material,
}

/// State of the search, kept from one problem to the next.
#[derive(Debug, Clone)]
pub(crate) struct SearchState {
    pub(crate) candidates: Vec<Candidate>,
    /// candidates whose constants were refined
    pub(crate) refined: Vec<Candidate>,
    /// ripple is not offered on these joints: its order was no whole number
    pub(crate) no_ripple: HashSet<usize>,
    /// prior scale of the last iteration
    pub(crate) scale: Option<f64>,
    criterion: ScaleCriterion,
    /// whether the material candidates have wanted links less well known than the whole set
    pub(crate) links_less_known: bool,
}

impl SearchState {
    pub(crate) fn new(criterion: ScaleCriterion) -> Self {
        Self {
            candidates: Vec::new(),
            refined: Vec::new(),
            no_ripple: HashSet::new(),
            scale: None,
            criterion,
            links_less_known: false,
        }
    }
}

/// Result of a search at one prior scale.
#[derive(Debug, Clone)]
pub(crate) struct ScaleFit {
    pub(crate) scale: f64,
    pub(crate) inflated: Vec<InflatedLink>,
    pub(crate) estimate: Estimate,
}

/// Searches at every prior scale; the scans of one are offered to all.
pub(crate) fn best_of_scales(
    design: &Design<'_>,
    at: &[Posed<'_>],
    ripple: &RippleColumns,
    contact: &ContactColumns,
    problem: &mut LinearProblem,
    start: Vec<usize>,
    point: &OperatingPoint,
    state: &mut SearchState,
) -> Option<(ScaleFit, Vec<Vec<usize>>)> {
    let baseline: Vec<usize> = (0..problem.candidates.len())
        .filter(|g| problem.candidates[*g].has(Law::is_baseline_friction))
        .collect();
    let mut starts = vec![start, baseline];
    // widely spaced scales first, then the neighbours of the best; later passes stay near it
    let mut found = Found::default();
    let first = match state.scale {
        Some(before) => [vec![0], neighbours(before)].concat(),
        None => (0..SCALES.len()).step_by(2).collect(),
    };
    let mut tried = Vec::new();
    let mut try_scales = |scales: Vec<usize>, found: &mut Found| {
        for k in scales {
            if !tried.contains(&k) {
                tried.push(k);
                let of_scale =
                    laws_at(SCALES[k], design, at, ripple, contact, problem, &mut starts, state);
                found.extend(problem, of_scale, point);
            }
        }
    };
    try_scales(first, &mut found);
    if state.scale.is_none() {
        let beside = found.best(state.criterion).map(|best| neighbours(best.scale));
        try_scales(beside.unwrap_or_default(), &mut found);
    }
    let [by_all, by_material] =
        [ScaleCriterion::All, ScaleCriterion::Material].map(|by| found.best(by).map(|b| b.scale));
    state.links_less_known |= by_material > by_all;
    Some((found.best(state.criterion)?.clone(), starts))
}

/// Results at some prior scales, each with the score of its material candidates.
#[derive(Default)]
struct Found(Vec<(ScaleFit, f64)>);

impl Found {
    fn extend(&mut self, problem: &LinearProblem, found: Option<ScaleFit>, point: &OperatingPoint) {
        self.0.extend(found.map(|found| {
            let score = if problem.observations.comparison.seeks_change() {
                found.estimate.score
            } else {
                let metric = problem.marginalised(found.scale, &found.inflated);
                prune(&metric, found.estimate.clone(), point).score
            };
            (found, score)
        }));
    }

    fn best(&self, by: ScaleCriterion) -> Option<&ScaleFit> {
        let score = |(found, of_what_matters): &(ScaleFit, f64)| match by {
            ScaleCriterion::All => found.estimate.score,
            ScaleCriterion::Material => *of_what_matters,
        };
        self.0.iter().min_by(|a, b| score(a).total_cmp(&score(b))).map(|(found, _)| found)
    }
}

pub(crate) fn keep_better(best: &mut Option<ScaleFit>, found: Option<ScaleFit>) {
    if let Some(found) = found
        && best.as_ref().is_none_or(|b| found.estimate.score < b.estimate.score)
    {
        *best = Some(found);
    }
}

/// The best estimate at one prior scale, with ripples and contacts scanned on the residual until nothing new is found.
pub(crate) fn laws_at(
    scale: f64,
    design: &Design<'_>,
    at: &[Posed<'_>],
    ripple: &RippleColumns,
    contact: &ContactColumns,
    problem: &mut LinearProblem,
    starts: &mut Vec<Vec<usize>>,
    state: &SearchState,
) -> Option<ScaleFit> {
    let mut found = None;
    for round in 0..ROUNDS {
        let now = search_at(scale, problem, starts, state)?;
        let metric = problem.marginalised(scale, &now.inflated);
        let mut residuals = vec![metric.residual(&now.estimate.fit)];
        if round == 0 {
            residuals.extend(fit_set(&metric, Vec::new()).map(|a| metric.residual(&a.fit)));
        }
        let mut offered = Vec::new();
        for residual in &residuals {
            offered.extend(ripple.offer(design, at, problem, residual));
            offered.extend(contact.offer(design, problem, residual));
        }
        starts.push(now.estimate.set.clone());
        found = Some(now);
        if offered.is_empty() {
            break;
        }
        starts.extend(offered.iter().map(|g| vec![*g]));
    }
    found
}

pub(crate) fn search_at(
    scale: f64,
    problem: &LinearProblem,
    starts: &[Vec<usize>],
    state: &SearchState,
) -> Option<ScaleFit> {
    let banned = banned(problem, state, scale);
    let found = search(&problem.marginalised(scale, &[]), starts, &banned)?;
    Some(with_inflated_links(problem, scale, found, starts, &banned))
}

/// Places of a scale and of those beside it.
fn neighbours(scale: f64) -> Vec<usize> {
    let at = SCALES.iter().position(|s| *s == scale).unwrap_or(0);
    (at.saturating_sub(1)..(at + 2).min(SCALES.len())).collect()
}

/// Candidates that are excluded: ripples of no whole order, single links where all links are uncertain (inflated links
/// stand for these), and windows in the reference.
fn banned(problem: &LinearProblem, state: &SearchState, scale: f64) -> HashSet<usize> {
    (0..problem.candidates.len())
        .filter(|&g| {
            let candidate = &problem.candidates[g];
            (candidate.has(|law| law.has_role(LawRole::Ripple))
                && state.no_ripple.contains(&candidate.location.joints[0]))
                || (scale > 0.0
                    && !problem.observations.comparison.seeks_change()
                    && candidate.is(&LinkInertiaError))
                || candidate
                    .location
                    .window
                    .is_some_and(|(r, _)| r < problem.observations.comparison.first_judged())
        })
        .collect()
}

/// Whether single links may be inflated: with a reference, a changed link is a law like the others.
pub(crate) fn may_be_inflated(problem: &LinearProblem, scale: f64) -> bool {
    scale > 0.0 && scale <= ALL_LINKS_WRONG && !problem.observations.comparison.seeks_change()
}

/// Scores of a set with a further inflated link: each link at every factor.
pub(crate) fn with_one_more(
    problem: &LinearProblem,
    scale: f64,
    set: &[usize],
    inflated: &[InflatedLink],
) -> Vec<(Vec<InflatedLink>, f64)> {
    let right =
        (0..problem.link_error_prior.links).filter(|l| inflated.iter().all(|body| body.link != *l));
    let bodies: Vec<InflatedLink> =
        right.flat_map(|link| INFLATIONS.map(|times| InflatedLink { link, times })).collect();
    // the columns of the set alone: link errors of every size are eliminated from them
    let (small, set) = problem.restricted(set);
    let with = |body: &InflatedLink| {
        let inflated = [inflated, &[*body]].concat();
        let score = fit_set(&small.marginalised(scale, &inflated), set.clone())?.score;
        Some((inflated, score))
    };
    bodies.par_iter().filter_map(with).collect()
}

/// The estimate at the prior scale and with the inflated links that have the lowest score beside baseline terms: beside small laws that
/// have been removed since, the error of a link may have looked like an error of all; without them the small offsets and frictions of
/// an arm would look like one. Another link costs the [odds](ODDS) of a name.
pub(crate) fn at_better_scale(problem: &LinearProblem, fit: &ScaleFit) -> Option<ScaleFit> {
    let own = problem.marginalised(fit.scale, &fit.inflated);
    let set = with_baseline_terms_of(&own, &fit.estimate);
    let is_new = |body: &&InflatedLink| fit.inflated.iter().all(|other| other.link != body.link);
    let priced = |inflated: &[InflatedLink], score: f64| {
        score + ODDS * inflated.iter().filter(is_new).count() as f64
    };
    let at = |scale: &f64| {
        let mut inflated = Vec::new();
        let mut lowest = fit_set(&problem.marginalised(*scale, &[]), set.clone())?.score;
        while may_be_inflated(problem, *scale) && inflated.len() < MOST_INFLATED_LINKS {
            let trials = with_one_more(problem, *scale, &set, &inflated).into_iter();
            let trials = trials.map(|(trial, score)| (priced(&trial, score), trial));
            let least = trials.min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((score, trial)) = least.filter(|(score, _)| *score < lowest) else { break };
            (inflated, lowest) = (trial, score);
        }
        Some((*scale, inflated, lowest))
    };
    let own_score = fit_set(&own, set.clone())?.score;
    let least = SCALES.iter().filter_map(at).min_by(|a, b| a.2.total_cmp(&b.2));
    let (scale, inflated, _) = least.filter(|(.., score)| *score < own_score)?;
    let estimate = fit_set(&problem.marginalised(scale, &inflated), fit.estimate.set.clone())?;
    Some(ScaleFit { scale, inflated, estimate })
}

/// Inflates single links as long as that lowers the score.
fn with_inflated_links(
    problem: &LinearProblem,
    scale: f64,
    mut found: Estimate,
    starts: &[Vec<usize>],
    banned: &HashSet<usize>,
) -> ScaleFit {
    let mut inflated = Vec::new();
    if may_be_inflated(problem, scale) {
        while inflated.len() < MOST_INFLATED_LINKS {
            let trials = with_one_more(problem, scale, &found.set, &inflated);
            let least = trials.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((trial, score)) = least else { break };
            if score >= found.score {
                break;
            }
            let metric = problem.marginalised(scale, &trial);
            let starts = [starts, &[found.set.clone()]].concat();
            let Some(next) = search(&metric, &starts, banned) else { break };
            (found, inflated) = (next, trial);
        }
    }
    ScaleFit { scale, inflated, estimate: found }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::{design, ur5};

    /// An immaterial term gives a prior scale the lowest score until it is removed.
    #[test]
    fn material_criterion_ignores_immaterial_terms() {
        let chain = ur5();
        let design = design(&chain, &chain, |j, v| if j == 1 { 2.0 * v.signum() } else { 0.0 });
        let point = OperatingPoint::of(design.joints());
        let problem = design.problem(&point);
        let of = |slug: &str, joint: usize| {
            let is = |g: &Candidate| g.slug() == slug && g.location.joints == [joint];
            problem.candidates.iter().position(is).unwrap()
        };
        let (coulomb, idle) = (of("coulomb_friction", 1), of("viscous_friction", 4));
        let with = |scale: f64, set: Vec<usize>| {
            let estimate = fit_set(&problem.marginalised(scale, &[]), set).unwrap();
            ScaleFit { scale, inflated: Vec::new(), estimate }
        };
        let mut found = Found::default();
        // by its score the longer one would be the better one
        let mut flattered = with(0.03, vec![coulomb, idle]);
        let other = with(0.0, vec![coulomb]);
        flattered.estimate.score = other.estimate.score - 1.0;
        found.extend(&problem, Some(flattered), &point);
        found.extend(&problem, Some(other), &point);
        assert_eq!(found.best(ScaleCriterion::All).unwrap().scale, 0.03);
        assert_eq!(found.best(ScaleCriterion::Material).unwrap().scale, 0.0);
    }
}
