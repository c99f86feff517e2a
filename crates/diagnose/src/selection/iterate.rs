//! From evidence to the answer: search, scans, refinement, operating point.

use crate::regression::relinearise::{
    Step, is_settled, is_still, moves, other_links, springs, stride,
};
use crate::selection::change_significance::{REFERENCE_SCALE, certain};
use crate::selection::solution::Selection;
use armident_numeric::dot;

use crate::design::candidate::Group;
use crate::design::contact::ContactColumns;
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::design::rebuild::recreate;
use crate::design::ripple::RippleColumns;
use crate::regression::fit_set::{Answer, answer};
use crate::regression::score::PRICE_OF_CHOICE;
use crate::selection::cross_validation::{
    confirm, imperfection, with_changes, with_everyday_terms,
};
use crate::selection::materiality::{held, prune};
use crate::selection::prior_scale::{Best, ChosenBy, Memory, best_of_scales};
use crate::selection::refine_shape::{fractional_ripples, refine};
use crate::selection::reversal::with_turns;
use crate::selection::rivals::{everyday_first, load_first};
use crate::selection::simulated_candidates::with_hidden_motion;
use crate::selection::weights::{
    first_misfits, independent_share, misfits, misfits_after, stuck_weights,
};
use armident_model::OperatingPoint;

/// Logarithm of the ratio of two misfits that are the same.
const SAME_MISFIT: f64 = 0.3;

/// Share of the independent samples from which on their number was clearly overrated.
const FEWER_SAMPLES: f64 = 0.8;
/// Passes of moving the operating point; what is dear to try is tried from this one on wherever it moves: a spring that was
/// not seen yet keeps it moving, and takes some passes to weigh the joints anew.
const PASSES: usize = 8;
const ALL_FROM: usize = 3;

/// The answer to what the recordings show.
///
/// How far all links may be off is chosen before the operating point is right and every law was tried, in one of two
/// ways ([`ChosenBy`]). Where they part, both are walked to their ends, and the shorter description is the answer.
pub(crate) fn select(owner: &mut Evidence<'_>) -> Option<Selection> {
    let point = OperatingPoint::of(owner.joints());
    let ripple = RippleColumns::new(owner, &owner.at(&point));
    weigh_first(owner, &point)?;
    let rows = owner.rows.clone();
    let mut memory = Memory::new(ChosenBy::All);
    let End { mut found, rests } = walk(owner, &ripple, &mut memory)?;
    if owner.rows.changed_from > 0 {
        return Some(found);
    }
    if memory.ways_part {
        let rows = std::mem::replace(&mut owner.rows, rows);
        let other = walk(owner, &ripple, &mut Memory::new(ChosenBy::WhatMatters));
        let share = rows.share.min(owner.rows.share);
        // what still moves is no answer where the other one rests
        let is_better = |other: &End| match (other.rests, rests) {
            (true, false) => true,
            (false, true) => false,
            _ => other.found.length(share) < found.length(share),
        };
        match other.filter(is_better) {
            Some(other) => found = other.found,
            None => owner.rows = rows,
        }
    }
    Some(with_turns(owner, &found).unwrap_or(found))
}

/// Weighs rows and joints by what the believed arm leaves over, before anything is known. None where what is before a
/// change cannot be fitted.
fn weigh_first(owner: &mut Evidence<'_>, point: &OperatingPoint) -> Option<()> {
    let seeks_change = owner.rows.changed_from > 0;
    let mut first = owner.problem(point);
    if !seeks_change {
        let weights = stuck_weights(&first);
        if weights != owner.rows.stuck_weight {
            for (j, weight) in weights.into_iter().enumerate() {
                owner.rows.set_stuck_weight(j, weight);
            }
            first = owner.problem(point);
        }
    }
    let misfit = if seeks_change {
        // what changed must not tell how few samples of the arm's imperfection are independent
        let left_over = imperfection(&first, REFERENCE_SCALE)?;
        let reference = &first.rows.starts[..=first.rows.changed_from];
        let share = independent_share(&left_over, reference, first.rows.rows_hz);
        owner.rows.share = share.min(owner.rows.share);
        left_over.iter().map(|r| (dot(r, r) / r.len().max(1) as f64).sqrt().max(1.0)).collect()
    } else {
        first_misfits(owner, &owner.at(point), &first)
    };
    for (j, misfit) in misfit.into_iter().enumerate() {
        owner.rows.set_misfit_before(j, misfit);
        owner.rows.set_misfit(j, misfit);
    }
    Some(())
}

/// Where a walk ended.
struct End {
    found: Selection,
    /// whether nothing moved any more
    rests: bool,
}

/// From the believed arm to where the operating point, the weights and the answer no longer move.
fn walk(owner: &mut Evidence<'_>, ripple: &RippleColumns, memory: &mut Memory) -> Option<End> {
    let mut point = OperatingPoint::of(owner.joints());
    let seeks_change = owner.rows.changed_from > 0;
    let mut last = None;
    let mut last_step = None;
    let mut is_right = false;
    for pass in 0..PASSES {
        let evidence: &Evidence<'_> = owner;
        let at = evidence.at(&point);
        let contact = ContactColumns::new(evidence, &at);
        let mut problem = evidence.problem_at(&at);
        let start: Vec<usize> = memory
            .groups
            .iter()
            .filter_map(|g| recreate(evidence, &at, &contact, &mut problem, g))
            .collect();
        let (mut best, starts) =
            best_of_scales(evidence, &at, ripple, &contact, &mut problem, start, &point, memory)?;
        best.answer = with_held(&problem, &best, &point);
        // what is dear to try waits until the configuration is right
        let metric = problem.whitened(best.scale, &best.wide);
        let pruned = prune(&metric, best.answer.clone(), &point);
        // beside wrong links a spring that was found may look like none until it is polished again
        let all = is_right
            || !point.springs.is_empty()
            || is_still(&moves(&problem, &pruned, &point), &point)
            || pass >= ALL_FROM;
        if all {
            best = with_hidden_motion(
                evidence,
                &at,
                (ripple, &contact),
                &mut problem,
                starts,
                memory,
                best,
            );
            best.answer = with_held(&problem, &best, &point);
        }
        let Best { scale, wide, answer: found } = best;
        let found = prune(&problem.whitened(scale, &wide), found, &point);
        let rough = found.score;
        let metric = (scale, &wide[..]);
        let found = refine(evidence, &at, &contact, &mut problem, metric, memory, found, |_| true);
        let polished = rough - found.score > PRICE_OF_CHOICE;
        let found = prune(&problem.whitened(scale, &wide), found, &point);
        let mut doubtful = Vec::new();
        let mut found = confirm(&problem.whitened(scale, &wide), found, &point);
        // simpler relatives that came in need to matter as well
        if !seeks_change {
            found = prune(&problem.whitened(scale, &wide), found, &point);
        }
        if seeks_change {
            let metric = problem.whitened(scale, &wide);
            found = load_first(&metric, with_changes(&metric, found));
            found = prune(&metric, found, &point);
            (found, doubtful) = certain(evidence, &at, &metric, found, &point);
        } else {
            found = everyday_first(&problem.whitened(scale, &wide), found, &point);
        }
        let fractional = fractional_ripples(evidence, &problem, &found);
        let groups: Vec<Group> = found.set.iter().map(|g| problem.groups[*g].clone()).collect();
        let settled = groups.iter().all(|g| is_settled(g, &memory.groups, &point));
        memory.groups = groups;
        let again = !fractional.is_empty();
        memory.no_ripple.extend(fractional);
        if again {
            memory.groups.retain(|g| {
                g.slug() != "torque_ripple" || !memory.no_ripple.contains(&g.site.joints[0])
            });
        }
        let mut target = moves(&problem, &found, &point);
        let metric = problem.whitened(scale, &wide);
        let links = other_links(&metric, &found);
        // the links behind a transmission were found beside it, and it beside those of the pass before
        let still =
            is_still(&target, &point) && (links.is_none() || (point.links.is_some() && settled));
        // a spring that went must not shape the columns of the next pass
        target.springs = if links.is_some() { springs(&metric, &found, &at) } else { Vec::new() };
        target.links = links;
        let step = Step { from: point.springs.clone(), to: target.springs.clone() };
        stride(&mut target, &point, last_step.replace(step).as_ref());
        let (misfit, share) = if seeks_change {
            (misfits_after(&metric, &found), problem.rows.share)
        } else {
            // of what no term of a plain identification explains: a short answer must not look like few samples
            let residual = with_everyday_terms(&metric, &found);
            let share = independent_share(&residual, &problem.rows.starts, problem.rows.rows_hz);
            (misfits(&metric, &found), share.min(problem.rows.share))
        };
        let differs = |(new, old): (&f64, &f64)| (new / old).ln().abs() > SAME_MISFIT;
        // what was not tried yet must not make a joint unimportant
        let reweighted = share < FEWER_SAMPLES * problem.rows.share
            || ((all || !seeks_change) && misfit.iter().zip(&problem.rows.misfit).any(differs));
        // moves that were not confirmed must not end the search before all was tried
        // beside a law on the wrong size others were chosen, and how far links may be off, that took its part
        is_right = still && !again && !reweighted && !polished;
        let rests = is_right && all;
        // with other weights or sizes another scale may be right; a reference holds its own
        memory.scale = (seeks_change || !(reweighted || polished)).then_some(scale);
        let point_now = point.clone();
        let found = Selection { problem, answer: found, scale, wide, point: point_now, doubtful };
        last = Some(End { found, rests });
        if rests || pass + 1 == PASSES {
            break;
        }
        point = target;
        if reweighted || !seeks_change {
            for (j, misfit) in misfit.into_iter().enumerate() {
                owner.rows.set_misfit(j, misfit);
            }
        }
        if reweighted {
            owner.rows.share = share;
        }
    }
    last
}

/// The answer with what the operating point holds: at the right one nothing is left to add.
fn with_held(problem: &Problem, best: &Best, point: &OperatingPoint) -> Answer {
    let held = (0..problem.groups.len())
        .filter(|g| !held(&problem.groups[*g], point).is_empty())
        .filter(|g| !best.answer.set.contains(g));
    let set: Vec<usize> = best.answer.set.iter().copied().chain(held).collect();
    let metric = problem.whitened(best.scale, &best.wide);
    answer(&metric, set).unwrap_or_else(|| best.answer.clone())
}
