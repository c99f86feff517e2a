//! Candidates that are expensive to try: transmissions, whose link-side motion is simulated, and smooth terms.
//!
//! Method: transmissions on joints with a residual or an inertia of their own; smooth terms where no law explains the residual.
//! References: own.

use armident_effects::{LawRole, LinkSide};

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::linear_problem::LinearProblem;
use crate::design::ripple::RippleColumns;
use crate::design::training::Design;
use crate::design::{smooth, transmission};
use crate::regression::admissible::all_admissible;
use crate::regression::elimination::InflatedLink;
use crate::regression::fit_set::{Estimate, fit_judged, fit_set};
use crate::regression::marginalised::Marginalised;
use crate::selection::materiality::{LEAST, band_noise, excess, set_without};
use crate::selection::prior_scale::{ScaleFit, SearchState, keep_better, laws_at, search_at};
use crate::selection::refine_shape::refine;

/// Least residual, in noise levels, for which smooth terms are tried, and on how many joints.
const LEAST_UNEXPLAINED: f64 = 0.7;
const DESCRIBED_JOINTS: usize = 2;
/// Residual of further joints whose transmission is simulated, as a share of the largest.
const SHARE_OF_WORST: f64 = 0.8;

/// Adds transmissions where a residual or an inertia suggests one, and smooth terms where no law explains the residual: at
/// the prior scale found, and at 0, in case link errors absorbed a missing law.
pub(crate) fn with_simulated_candidates(
    design: &Design<'_>,
    at: &[Posed<'_>],
    (ripple, contact): (&RippleColumns, &ContactColumns),
    problem: &mut LinearProblem,
    mut starts: Vec<Vec<usize>>,
    state: &mut SearchState,
    found: ScaleFit,
) -> ScaleFit {
    let mut scales = vec![found.scale];
    if found.scale > 0.0 {
        scales.push(0.0);
    }
    starts.push(found.estimate.set.clone());
    let fallback = found.clone();
    let mut offered = Vec::new();
    let mut driven: Vec<usize> = Vec::new();
    for &scale in &scales {
        let Some(now) = search_at(scale, problem, &starts, state) else { continue };
        let residual = problem.marginalised(scale, &now.inflated).residual(&now.estimate.fit);
        for j in suspects(problem, &now, &residual) {
            if !driven.contains(&j) {
                driven.push(j);
                offered.extend(transmission::offer(design, at, problem, j));
            }
        }
    }
    // a resonance, or the motion in a gap, is narrower than the steps of the grid: off a resonance the best of them may be
    // worse than none
    for &joint in &driven {
        let metric = (found.scale, &found.inflated[..]);
        for (law, side) in
            design.library.named().filter_map(|law| Some((law, law.law().link_side()?)))
        {
            let one = |g: &Candidate| g.is(law) && g.location.joints == [joint];
            let offered: Vec<usize> =
                offered.iter().copied().filter(|g| one(&problem.candidates[*g])).collect();
            let near = nearest(problem, metric, &found.estimate, &offered, with_candidate);
            let worth = |n: &Estimate| side == LinkSide::Spring || n.score < found.estimate.score;
            let mut begins: Vec<Estimate> = near.into_iter().filter(worth).collect();
            if side == LinkSide::Spring {
                let least = begins.first().map_or(f64::INFINITY, |n| n.score);
                let beside = nearest(problem, metric, &found.estimate, &offered, of_any_size);
                begins.extend(beside.filter(|n| n.score < least.min(found.estimate.score)));
            }
            for begin in begins {
                let refined = refine(design, at, contact, problem, metric, state, begin, one);
                starts.push(refined.set);
            }
        }
    }
    starts.extend(offered.iter().map(|g| vec![*g]));
    let mut best = Some(found);
    let mut described: Vec<usize> = Vec::new();
    for &scale in &scales {
        let library = if driven.is_empty() && best.as_ref().is_some_and(|b| b.scale == scale) {
            best.take()
        } else {
            search_at(scale, problem, &starts, state)
        };
        let Some(mut library) = library else { continue };
        // ripples and contacts are scanned again beside an oscillating link
        if library.estimate.set.iter().any(|g| problem.candidates[*g].moves_its_link())
            && let Some(again) =
                laws_at(scale, design, at, ripple, contact, problem, &mut starts, state)
        {
            library = again;
        }
        let residual =
            problem.marginalised(scale, &library.inflated).residual(&library.estimate.fit);
        let left = excess(problem, &residual);
        let mut worst: Vec<usize> =
            (0..left.len()).filter(|j| left[*j] > LEAST_UNEXPLAINED).collect();
        worst.sort_by(|a, b| left[*b].total_cmp(&left[*a]));
        for &j in worst.iter().take(DESCRIBED_JOINTS) {
            if !described.contains(&j) {
                described.push(j);
                let offered = smooth::offer(design, at, problem, j, &residual[j]);
                starts.extend(offered.iter().map(|g| vec![*g]));
            }
        }
        starts.push(library.estimate.set.clone());
        let mut with_all =
            if described.is_empty() { None } else { search_at(scale, problem, &starts, state) };
        if let Some(with_all) = &mut with_all {
            contest(problem, scale, with_all, library.estimate.clone());
        }
        keep_better(&mut best, Some(library));
        keep_better(&mut best, with_all);
    }
    best.unwrap_or(fallback)
}

/// The best estimate with one of the offered candidates beside those it does not exclude, fitted by `fit`.
fn nearest(
    problem: &LinearProblem,
    (scale, inflated): (f64, &[InflatedLink]),
    beside: &Estimate,
    offered: &[usize],
    fit: fn(&Marginalised<'_>, Vec<usize>, usize) -> Option<Estimate>,
) -> Option<Estimate> {
    let metric = problem.marginalised(scale, inflated);
    let candidates = &problem.candidates;
    let with = |&g: &usize| {
        let others =
            beside.set.iter().copied().filter(|o| !candidates[*o].excludes(&candidates[g]));
        fit(&metric, others.chain([g]).collect(), g)
    };
    offered.iter().filter_map(with).min_by(|a, b| a.score.total_cmp(&b.score))
}

/// The estimate with a candidate, if need be beside simpler laws.
fn with_candidate(
    metric: &Marginalised<'_>,
    set: Vec<usize>,
    candidate: usize,
) -> Option<Estimate> {
    fit_set(metric, set.clone()).or_else(|| with_simpler(metric, set, candidate))
}

/// The estimate with a spring of any size, others with the laws that they contain: off a narrow resonance a spring explains a part
/// only of what it does at it.
fn of_any_size(metric: &Marginalised<'_>, set: Vec<usize>, spring: usize) -> Option<Estimate> {
    let set = simpler_beside(metric, set, spring)?;
    let others: Vec<usize> = set.iter().copied().filter(|g| *g != spring).collect();
    let candidate = &metric.problem.candidates[spring];
    let law = candidate.law()?;
    fit_judged(metric, set, &others)
        .filter(|estimate| law.admits_fit(&[], &estimate.fit.of_candidate(candidate)))
}

/// The estimate of a set in which laws that are inadmissible beside a candidate are replaced by those they contain.
fn with_simpler(metric: &Marginalised<'_>, set: Vec<usize>, candidate: usize) -> Option<Estimate> {
    fit_set(metric, simpler_beside(metric, set, candidate)?)
}

fn simpler_beside(
    metric: &Marginalised<'_>,
    mut set: Vec<usize>,
    candidate: usize,
) -> Option<Vec<usize>> {
    let fit = metric.fit(metric.columns_of(&set))?;
    let wrong = |g: &usize| *g != candidate && !all_admissible(metric.problem, &[*g], &fit);
    for g in set.clone().into_iter().filter(wrong) {
        set = set_without(metric.problem, &set, g);
    }
    Some(set)
}

/// Joints whose transmission is worth simulating: those with an inertia of their own in the estimate, and those with a
/// residual. A joint that has become compliant looks like links that changed: where these leave a residual, their joints too.
fn suspects(problem: &LinearProblem, found: &ScaleFit, residual: &[Vec<f64>]) -> Vec<usize> {
    let left = excess(problem, residual);
    let mut worst: Vec<usize> = (0..left.len()).filter(|j| left[*j] > LEAST_UNEXPLAINED).collect();
    worst.sort_by(|a, b| left[*b].total_cmp(&left[*a]));
    let links_changed = problem.observations.comparison.seeks_change() && !worst.is_empty();
    let mut joints: Vec<usize> = found
        .estimate
        .set
        .iter()
        .map(|g| &problem.candidates[*g])
        .filter(|g| g.places == [LawRole::Inertia] || (links_changed && g.is_of_link()))
        .map(|g| g.location.joints[0])
        .collect();
    // link-side motion affects the neighbours nearly as much
    let least = worst.first().map_or(0.0, |j| SHARE_OF_WORST * left[*j]);
    let first = worst.iter().take(DESCRIBED_JOINTS);
    joints.extend(first.chain(worst.iter().skip(DESCRIBED_JOINTS).filter(|j| left[**j] >= least)));
    joints.sort_unstable();
    joints.dedup();
    joints
}

/// Keeps smooth terms only if no library law explains the same residual: a material amount, and more than half of it.
fn contest(problem: &LinearProblem, scale: f64, found: &mut ScaleFit, library: Estimate) {
    let unnamed: Vec<usize> = found
        .estimate
        .set
        .iter()
        .copied()
        .filter(|g| matches!(problem.candidates[*g].kind, CandidateKind::SmoothDirections(_)))
        .collect();
    if unnamed.is_empty() {
        return;
    }
    let metric = problem.marginalised(scale, &found.inflated);
    let library = fit_set(&metric, library.set.clone()).unwrap_or(library);
    let (by_library, by_all) =
        (metric.residual(&library.fit), metric.residual(&found.estimate.fit));
    let holds = unnamed.iter().all(|g| {
        let j = problem.candidates[*g].location.joints[0];
        let square = |r: &[f64]| problem.observations.in_sample_noise(j, r).powi(2);
        let noise = band_noise(problem, j).powi(2);
        let (left, rest) = (square(&by_library[j]), square(&by_all[j]));
        let gained = left - rest;
        gained.max(0.0).sqrt() >= LEAST && gained > 0.5 * (left - noise)
    });
    if !holds {
        found.estimate = library;
    }
}
