//! The selection: search, scans, refinement, operating point and weights, until none of them changes.
//!
//! Method: fixed-point iteration; weights from the residual of the last estimate (feasible generalised least squares).
//! References: W. Oberhofer, J. Kmenta, A general procedure for obtaining maximum likelihood estimates in generalized regression
//! models, Econometrica 42(3), 1974.

use crate::design::observations::Weights;
use crate::regression::relinearise::{
    Step, has_converged, is_settled, moves, other_links, springs, stride,
};
use crate::selection::change_significance::{REFERENCE_SCALE, certain};
use crate::selection::solution::Selection;
use armident_effects::LawRole;
use armident_inference::independent_share;
use armident_numeric::dot;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::linear_problem::LinearProblem;
use crate::design::rebuild::recreate;
use crate::design::ripple::RippleColumns;
use crate::design::training::Design;
use crate::regression::elimination::InflatedLink;
use crate::regression::fit_set::{Estimate, admissible_part, fit_set};
use crate::regression::score::PRICE_OF_CHOICE;
use crate::selection::cross_validation::{
    confirm, imperfection, with_baseline_terms, with_changes,
};
use crate::selection::materiality::{held, prune};
use crate::selection::prior_scale::{
    ScaleCriterion, ScaleFit, SearchState, at_better_scale, best_of_scales,
};
use crate::selection::refine_shape::{fractional_ripples, refine};
use crate::selection::reversal::with_reversal_models;
use crate::selection::rivals::{baseline_first, load_first, one_body_first};
use crate::selection::simulated_candidates::with_simulated_candidates;
use crate::selection::weights::{
    discrepancies, discrepancies_after, initial_discrepancies, weights_with_dwells,
};
use armident_model::OperatingPoint;

/// Largest log ratio of two discrepancies that count as equal.
const SAME_DISCREPANCY: f64 = 0.3;

/// Ratio of the effective sample sizes below which the earlier one was clearly too large.
const FEWER_SAMPLES: f64 = 0.8;
/// Most iterations; expensive candidates are tried from this one on even if the operating point still moves: a spring that is
/// not in the set yet keeps it moving, and takes some iterations of weights.
const PASSES: usize = 8;
const ALL_FROM: usize = 3;

/// The selection of a design.
///
/// The prior scale is chosen before the operating point has converged and every law was tried, by one of two criteria
/// ([`ScaleCriterion`]). Where the material candidates want links less well known than the whole set does, both iterations are
/// completed, and the lower score is the estimate: small laws have absorbed a link error. The other way round the whole set
/// decides: what was removed as immaterial is still there, and exact links with a free one between them absorb it.
pub(crate) fn select<'a>(design: &Design<'a>) -> Option<(Design<'a>, Selection)> {
    let point = OperatingPoint::of(design.joints());
    let ripple = RippleColumns::new(design, &design.at(&point));
    let initial = design.weighted(initial_weights(design, &point)?);
    let mut state = SearchState::new(ScaleCriterion::All);
    let mut end = iterate(&initial, &ripple, &mut state)?;
    if design.observations.comparison.seeks_change() {
        return Some((end.design, end.found));
    }
    if state.links_less_known {
        let other = iterate(&initial, &ripple, &mut SearchState::new(ScaleCriterion::Material));
        // an iteration that still moves is no solution where the other one has converged
        let is_better = |other: &IterationEnd<'_>| match (other.converged, end.converged) {
            (true, false) => true,
            (false, true) => false,
            _ if other.found.scale < end.found.scale => false,
            _ => {
                let shares = [&end.design, &other.design].map(|d| d.observations.weights.share);
                let share = shares[0].min(shares[1]);
                other.found.length(share) < end.found.length(share)
            }
        };
        if let Some(other) = other.filter(is_better) {
            end = other;
        }
    }
    let IterationEnd { design, found, .. } = end;
    let found = with_one_body_a_link(found);
    let found = with_reversal_models(&design, &found).unwrap_or(found);
    Some((design, found))
}

/// The selection without what is on a link twice: where a body on an inflated link was selected, the better of the two scores
/// stays, all else fitted again.
fn with_one_body_a_link(mut of: Selection) -> Selection {
    loop {
        let is_twice = |g: &usize| {
            let body = &of.problem.candidates[*g];
            let on = |link: &InflatedLink| body.location.joints.first() == Some(&link.link);
            body.is_of_link() && of.inflated.iter().any(on)
        };
        let Some(body) = of.estimate.set.iter().copied().find(is_twice) else { return of };
        let link = of.problem.candidates[body].location.joints[0];
        let fitted = |inflated: &[InflatedLink], set: Vec<usize>| {
            fit_set(&of.problem.marginalised(of.scale, inflated), set)
        };
        let without_body = of.estimate.set.iter().copied().filter(|g| *g != body).collect();
        let others: Vec<InflatedLink> =
            of.inflated.iter().copied().filter(|inflated| inflated.link != link).collect();
        let as_link = fitted(&of.inflated, without_body);
        let as_body = fitted(&others, of.estimate.set.clone());
        (of.estimate, of.inflated) = match (as_link, as_body) {
            (Some(link), Some(body)) if body.score > link.score => (link, of.inflated),
            (_, Some(body)) => (body, others),
            (Some(link), None) => (link, of.inflated),
            (None, None) => return of,
        };
    }
}

/// Initial weights, from the residual of all columns. None where the reference cannot be fitted.
fn initial_weights(design: &Design<'_>, point: &OperatingPoint) -> Option<Weights> {
    let seeks_change = design.observations.comparison.seeks_change();
    let weights = weights_with_dwells(design, point);
    let weighted = design.weighted(weights.clone());
    let first = weighted.problem(point);
    if seeks_change {
        // a change must not count as discrepancy in the effective sample size
        let imperfect = imperfection(&first, REFERENCE_SCALE)?;
        let rows = &first.observations;
        let reference = &rows.starts[..=rows.comparison.first_judged()];
        let share = independent_share(&imperfect, reference, rows.rows_hz);
        let discrepancy: Vec<f64> =
            imperfect.iter().map(|r| (dot(r, r) / r.len().max(1) as f64).sqrt().max(1.0)).collect();
        let weights = with_discrepancies(&weighted, discrepancy);
        let share = share.min(weights.share);
        return Some(weights.with_share(share));
    }
    let discrepancy = initial_discrepancies(&weighted, &weighted.at(point), &first);
    Some(with_discrepancies(&weighted, discrepancy))
}

/// Weights for these discrepancies before a change and after it.
fn with_discrepancies(design: &Design<'_>, discrepancy: Vec<f64>) -> Weights {
    let before = design.observations.with_discrepancy_before(discrepancy.clone());
    design.observations.weighted(before).with_discrepancy(discrepancy)
}

/// Result of an iteration.
struct IterationEnd<'a> {
    /// with the weights it ended with
    design: Design<'a>,
    found: Selection,
    /// whether it converged
    converged: bool,
}

/// Iterates the operating point, the weights and the estimate until none changes.
fn iterate<'a>(
    initial: &Design<'a>,
    ripple: &RippleColumns,
    state: &mut SearchState,
) -> Option<IterationEnd<'a>> {
    let mut weighted = initial.weighted(initial.observations.weights.clone());
    let mut point = OperatingPoint::of(weighted.joints());
    let seeks_change = initial.observations.comparison.seeks_change();
    let mut last = None;
    let mut last_step = None;
    let mut is_right = false;
    for pass in 0..PASSES {
        let design = &weighted;
        let at = design.at(&point);
        let contact = ContactColumns::new(design, &at);
        let mut problem = design.problem_at(&at);
        let start: Vec<usize> = state
            .candidates
            .iter()
            .filter_map(|g| recreate(design, &at, &contact, &mut problem, g))
            .collect();
        let (mut best, starts) =
            best_of_scales(design, &at, ripple, &contact, &mut problem, start, &point, state)?;
        best.estimate = with_operating_terms(&problem, &best, &point);
        // expensive candidates wait until the configuration has converged
        let metric = problem.marginalised(best.scale, &best.inflated);
        let pruned = prune(&metric, best.estimate.clone(), &point);
        // beside wrong links a spring may look insignificant until it is refined again
        let all = is_right
            || !point.springs.is_empty()
            || has_converged(&moves(&problem, &pruned, &point), &point)
            || pass >= ALL_FROM;
        let plain = (all && !seeks_change).then(|| best.clone());
        if all {
            best = with_simulated_candidates(
                design,
                &at,
                (ripple, &contact),
                &mut problem,
                starts,
                state,
                best,
            );
            best.estimate = with_operating_terms(&problem, &best, &point);
        }
        let mut judged = judge(design, &at, &contact, &mut problem, state, best, &point);
        // an expensive candidate that is removed again must not leave its prior scale behind
        let is_expensive = |g: &usize| {
            let candidate = &problem.candidates[*g];
            candidate.moves_its_link()
                || matches!(candidate.kind, CandidateKind::SmoothDirections(_))
        };
        if let Some(plain) = plain
            && plain.scale != judged.fit.scale
            && !judged.fit.estimate.set.iter().any(is_expensive)
        {
            judged = judge(design, &at, &contact, &mut problem, state, plain, &point);
        }
        if all
            && !seeks_change
            && !judged.fit.estimate.set.is_empty()
            && let Some(better) = at_better_scale(&problem, &judged.fit)
        {
            judged = judge(design, &at, &contact, &mut problem, state, better, &point);
        }
        let Judged { fit: ScaleFit { scale, inflated, estimate: mut found }, refined } = judged;
        let mut inconclusive = Vec::new();
        if seeks_change {
            let metric = problem.marginalised(scale, &inflated);
            found = one_body_first(&metric, with_changes(&metric, found));
            found = load_first(&metric, found);
            found = prune(&metric, found, &point);
            (found, inconclusive) = certain(design, &at, &metric, found, &point);
        } else {
            found = baseline_first(&problem.marginalised(scale, &inflated), found, &point);
        }
        let fractional = fractional_ripples(design, &problem, &found);
        let candidates: Vec<Candidate> =
            found.set.iter().map(|g| problem.candidates[*g].clone()).collect();
        let settled = candidates.iter().all(|g| is_settled(g, &state.candidates, &point));
        state.candidates = candidates;
        let again = !fractional.is_empty();
        state.no_ripple.extend(fractional);
        if again {
            state.candidates.retain(|g| {
                !g.has(|law| law.has_role(LawRole::Ripple))
                    || !state.no_ripple.contains(&g.location.joints[0])
            });
        }
        let mut target = moves(&problem, &found, &point);
        let metric = problem.marginalised(scale, &inflated);
        let links = other_links(&metric, &found);
        // the links behind a transmission were found beside it, and it beside those of the pass before
        let still = has_converged(&target, &point)
            && (links.is_none() || (point.links.is_some() && settled));
        // a removed spring must not shape the columns of the next iteration
        target.springs = if links.is_some() { springs(&metric, &found, &at) } else { Vec::new() };
        target.links = links;
        let step = Step { from: point.springs.clone(), to: target.springs.clone() };
        stride(&mut target, &point, last_step.replace(step).as_ref());
        let (discrepancy, share) = if seeks_change {
            (discrepancies_after(&metric, &found), problem.observations.weights.share)
        } else {
            // of the residual beside baseline terms: a short estimate must not look like few samples
            let residual = with_baseline_terms(&metric, &found);
            let share = independent_share(
                &residual,
                &problem.observations.starts,
                problem.observations.rows_hz,
            );
            (discrepancies(&metric, &found), share.min(problem.observations.weights.share))
        };
        let differs = |(new, old): (&f64, &f64)| (new / old).ln().abs() > SAME_DISCREPANCY;
        // a candidate that was not tried yet must not lower the weight of a joint
        let reweighted = share < FEWER_SAMPLES * problem.observations.weights.share
            || ((all || !seeks_change)
                && discrepancy.iter().zip(&problem.observations.weights.discrepancy).any(differs));
        // beside a law of the wrong size other candidates and another prior scale were chosen
        is_right = still && !again && !reweighted && !refined;
        let converged = is_right && all;
        // other weights may need another prior scale; a reference has its own
        state.scale = (seeks_change || !(reweighted || refined)).then_some(scale);
        let point_now = point.clone();
        let found =
            Selection { problem, estimate: found, scale, inflated, point: point_now, inconclusive };
        last = Some((found, converged));
        if converged || pass + 1 == PASSES {
            break;
        }
        point = target;
        if reweighted || !seeks_change {
            let weights = design.observations.with_discrepancy(discrepancy);
            weighted =
                design.weighted(if reweighted { weights.with_share(share) } else { weights });
        }
    }
    let (found, converged) = last?;
    Some(IterationEnd { design: weighted, found, converged })
}

/// A fit without what is immaterial or not confirmed.
struct Judged {
    fit: ScaleFit,
    /// whether constants of shapes have moved
    refined: bool,
}

/// The material and confirmed part of a fit, its shapes refined.
fn judge(
    design: &Design<'_>,
    at: &[Posed<'_>],
    contact: &ContactColumns,
    problem: &mut LinearProblem,
    state: &mut SearchState,
    of: ScaleFit,
    point: &OperatingPoint,
) -> Judged {
    let ScaleFit { scale, inflated, estimate: found } = of;
    let found = prune(&problem.marginalised(scale, &inflated), found, point);
    let rough = found.score;
    let metric = (scale, &inflated[..]);
    let found = refine(design, at, contact, problem, metric, state, found, |_| true);
    let refined = rough - found.score > PRICE_OF_CHOICE;
    let found = prune(&problem.marginalised(scale, &inflated), found, point);
    let mut found = confirm(&problem.marginalised(scale, &inflated), found, point);
    // contained laws that came in must be material too
    if !design.observations.comparison.seeks_change() {
        found = prune(&problem.marginalised(scale, &inflated), found, point);
    }
    Judged { fit: ScaleFit { scale, inflated, estimate: found }, refined }
}

/// The estimate with the operating terms: at the right operating point their coefficients are zero. A candidate that is
/// inadmissible beside them is dropped, not they: without them the operating point would be lost.
fn with_operating_terms(
    problem: &LinearProblem,
    best: &ScaleFit,
    point: &OperatingPoint,
) -> Estimate {
    let held: Vec<usize> = (0..problem.candidates.len())
        .filter(|g| !held(&problem.candidates[*g], point).is_empty())
        .filter(|g| !best.estimate.set.contains(g))
        .collect();
    let set = [&best.estimate.set[..], &held].concat();
    let metric = problem.marginalised(best.scale, &best.inflated);
    fit_set(&metric, set.clone())
        .or_else(|| admissible_part(&metric, set, &held))
        .unwrap_or_else(|| best.estimate.clone())
}
