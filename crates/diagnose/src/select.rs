//! From evidence to the answer: search, scans, refinement, operating point.

use armident_numeric::dot;

use crate::alternatives::{everyday_first, load_first};
use crate::certain::{Doubt, certain};
use crate::contact::ContactColumns;
use crate::crossval::{confirm, imperfection, with_changes, with_everyday_terms};
use crate::evidence::Evidence;
use crate::hidden::with_hidden_motion;
use crate::learn::View;
use crate::material::{held, prune};
use crate::misfit::{first_misfits, independent_share, misfits, misfits_after, stuck_weights};
use crate::problem::{Group, Problem};
use crate::refine::{fractional_ripples, recreate, refine};
use crate::ripple::RippleColumns;
use crate::scales::{Best, ChosenBy, Memory, best_of_scales};
use crate::search::{Answer, answer};
use crate::sprung::{Step, springs, stride};
use crate::turning::with_turns;
use crate::whitened::{PRICE_OF_CHOICE, Whitened, WrongBody};
use armident_model::{OperatingPoint, Spring};

/// Logarithm of the ratio of two misfits that are the same.
const SAME_MISFIT: f64 = 0.3;
/// Relative inertial error with which the reference is looked at first: what a URDF is off by.
pub(crate) const REFERENCE_SCALE: f64 = 0.2;
/// Share of the independent samples from which on their number was clearly overrated.
const FEWER_SAMPLES: f64 = 0.8;
/// Passes of moving the operating point; what is dear to try is tried from this one on wherever it moves: a spring that was
/// not seen yet keeps it moving, and takes some passes to weigh the joints anew.
const PASSES: usize = 8;
const ALL_FROM: usize = 3;
/// Moves of the operating point below these no longer matter \[rad, rad or m, s, 1\].
const STILL: (f64, f64, f64, f64) = (1e-3, 5e-4, 2e-4, 2e-3);

/// A stiffness or a gap that moves by less than this share is settled.
const SETTLED: f64 = 5e-3;

/// The answer of the selection, and all it stands on.
pub(crate) struct Selection {
    pub(crate) problem: Problem,
    pub(crate) answer: Answer,
    /// relative inertial error
    pub(crate) scale: f64,
    /// links with a wrong body
    pub(crate) wide: Vec<WrongBody>,
    /// where the columns were formed
    pub(crate) point: OperatingPoint,
    /// changes that are not certain
    pub(crate) doubtful: Vec<Doubt>,
}

impl Selection {
    pub(crate) fn metric(&self) -> Whitened<'_> {
        self.problem.whitened(self.scale, &self.wide)
    }

    /// Description length with so many independent samples a row, what is left on each joint in units of its own size:
    /// the score of selections that weighed joints differently.
    fn length(&self, share: f64) -> f64 {
        let (metric, rows, fit) = (self.metric(), &self.problem.rows, &self.answer.fit);
        let residual = metric.residual(fit);
        let squares: Vec<f64> = residual.iter().map(|r| dot(r, r)).collect();
        let misfit = |(j, square): (usize, &f64)| -> f64 {
            let samples = rows.effective_on(j);
            if samples == 0.0 {
                return 0.0;
            }
            // nothing is explained better than to the noise
            samples * (square * rows.misfit[j].powi(2) / samples).max(1.0).ln()
        };
        let left: f64 = squares.iter().enumerate().map(misfit).sum();
        let of_links = fit.sum_of_squares - squares.iter().sum::<f64>();
        let columns = metric.columns_of(&self.answer.set).len();
        share * left + rows.share * of_links + metric.price(columns, &self.answer.set)
    }

    /// The answer; the metric is that of the selection.
    pub(crate) fn view<'a, 'e>(
        &'a self,
        evidence: &'a Evidence<'e>,
        metric: &'a Whitened<'a>,
    ) -> View<'a, 'e> {
        View::new(evidence, metric, &self.answer, &self.point)
    }
}

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

/// By what the links are changed, where one of them moves by itself behind its motor, or seems to to first order, or
/// friction follows the load.
fn other_links(metric: &Whitened<'_>, found: &Answer) -> Option<Vec<f64>> {
    let groups = || found.set.iter().map(|g| &metric.problem.groups[*g]);
    let matters = |group: &Group| {
        group.moves_its_link()
            || ["joint_elasticity", "load_dependent_friction"].contains(&group.slug())
    };
    if !groups().any(matters) {
        return None;
    }
    let mut change = metric.inertial_errors(&found.fit);
    for group in groups() {
        group.add_to_links(&found.fit.of_group(group), &mut change);
    }
    change.iter().any(|x| *x != 0.0).then_some(change)
}

/// Whether a move of the operating point no longer matters.
fn is_still(to: &OperatingPoint, from: &OperatingPoint) -> bool {
    (to.tilt[0] - from.tilt[0]).hypot(to.tilt[1] - from.tilt[1]) < STILL.0
        && to.offset.iter().zip(&from.offset).all(|(a, b)| (a - b).abs() < STILL.1)
        && (to.delay_s - from.delay_s).abs() < STILL.2
        && to.gain.iter().zip(&from.gain).all(|(a, b)| (a - b).abs() < STILL.3)
}

/// Whether the constants of a transmission are those beside which its links were fitted; what is none always is.
fn is_settled(group: &Group, before: &[Group], point: &OperatingPoint) -> bool {
    let near = |a: f64, b: f64| (a / b).ln().abs() < SETTLED;
    if !group.moves_its_link() {
        return true;
    }
    if group.slug() == "joint_elasticity" {
        let same = |spring: &&Spring| spring.joint == group.site.joints[0];
        let fitted_beside = point.springs.iter().find(same);
        return fitted_beside.is_some_and(|s| near(group.shape[0], s.transmission.stiffness));
    }
    let same = |other: &&Group| other.meaning == group.meaning && other.site == group.site;
    before.iter().find(same).is_some_and(|other| near(group.shape[0], other.shape[0]))
}

/// The operating point with what a fit adds to it.
pub(crate) fn moves(problem: &Problem, found: &Answer, from: &OperatingPoint) -> OperatingPoint {
    let mut point = OperatingPoint::of(from.offset.len());
    point.links.clone_from(&from.links);
    point.springs.clone_from(&from.springs);
    point.turns.clone_from(&from.turns);
    for &g in &found.set {
        let group = &problem.groups[g];
        let coefficients = found.fit.of_group(group);
        match group.slug() {
            "gravity_direction" => {
                point.tilt = [from.tilt[0] + coefficients[0], from.tilt[1] + coefficients[1]];
            }
            "time_delay" => point.delay_s = from.delay_s + coefficients[0],
            "encoder_offset" => {
                let j = group.site.joints[0];
                point.offset[j] = from.offset[j] + coefficients[0];
            }
            "torque_scale" => point.gain[group.site.joints[0]] = 1.0 + coefficients[0],
            _ => {}
        }
    }
    point
}
