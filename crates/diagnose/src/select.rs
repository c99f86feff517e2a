//! From evidence to the answer: search, scans, refinement, operating point.

use std::collections::HashSet;

use armident_numeric::dot;
use rayon::prelude::*;

use crate::alternatives::{everyday_first, load_first};
use crate::certain::{Doubt, certain};
use crate::contact::ContactColumns;
use crate::crossval::{confirm, imperfection, with_changes, with_everyday_terms};
use crate::evidence::{At, Evidence, OperatingPoint};
use crate::fading::with_fading;
use crate::hidden::with_hidden_motion;
use crate::learn::View;
use crate::material::{held, prune};
use crate::misfit::{first_misfits, independent_share, misfits, misfits_after, stuck_weights};
use crate::problem::{Group, Problem};
use crate::refine::{fractional_ripples, recreate, refine};
use crate::ripple::RippleColumns;
use crate::search::{Answer, answer, search};
use crate::sprung::{Spring, springs, stride};
use crate::whitened::{PRICE_OF_CHOICE, Whitened, WrongBody};

/// Relative inertial errors tried: none, a good data sheet, CAD, a guess, nothing known.
const SCALES: [f64; 9] = [0.0, 0.012, 0.03, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6];
/// How many times larger the errors of a link with a wrong body may be than those of all others, as tried: a link of
/// a draft, another body, one many times as heavy.
const TIMES: [f64; 3] = [4.0, 12.0, 40.0];
/// Beyond this relative error of all links no single one is called wrong.
const ALL_LINKS_WRONG: f64 = 0.2;
/// Most links whose body is called wrong; more are a wrong arm.
const MOST_WRONG_BODIES: usize = 2;
/// Rounds of scanning what is left over.
const ROUNDS: usize = 6;
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

    /// The answer; the metric is that of the selection.
    pub(crate) fn view<'a, 'e>(
        &'a self,
        evidence: &'a Evidence<'e>,
        metric: &'a Whitened<'a>,
    ) -> View<'a, 'e> {
        View::new(evidence, metric, &self.answer, &self.point)
    }
}

/// What was found about the answer so far, kept from one problem to the next.
#[derive(Debug, Clone, Default)]
pub(crate) struct Memory {
    groups: Vec<Group>,
    /// ripple is not offered on these joints: its order was no whole number
    no_ripple: HashSet<usize>,
    /// inertial error of the last pass
    scale: Option<f64>,
}

/// What one search gives.
#[derive(Debug, Clone)]
pub(crate) struct Best {
    pub(crate) scale: f64,
    pub(crate) wide: Vec<WrongBody>,
    pub(crate) answer: Answer,
}

pub(crate) fn select(owner: &mut Evidence<'_>) -> Option<Selection> {
    let mut point = OperatingPoint::of(owner.joints());
    let mut memory = Memory::default();
    let ripple = RippleColumns::new(owner, &owner.at(&point));
    let seeks_change = owner.rows.changed_from > 0;
    let mut first = owner.problem(&point);
    if !seeks_change {
        let weights = stuck_weights(&first);
        if weights != owner.rows.stuck_weight {
            for (j, weight) in weights.into_iter().enumerate() {
                owner.rows.set_stuck_weight(j, weight);
            }
            first = owner.problem(&point);
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
        first_misfits(owner, &owner.at(&point), &first)
    };
    for (j, misfit) in misfit.into_iter().enumerate() {
        owner.rows.set_misfit_before(j, misfit);
        owner.rows.set_misfit(j, misfit);
    }
    drop(first);
    let mut last = None;
    let mut before = None;
    let mut is_right = false;
    for pass in 0..PASSES {
        let evidence: &Evidence<'_> = owner;
        let at = evidence.at(&point);
        let contact = ContactColumns::new(evidence, &at);
        let mut problem = evidence.problem(&point);
        let start: Vec<usize> = memory
            .groups
            .iter()
            .filter_map(|g| recreate(evidence, &at, &contact, &mut problem, g))
            .collect();
        let (mut best, starts) =
            best_of_scales(evidence, &at, &ripple, &contact, &mut problem, start, &memory)?;
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
                (&ripple, &contact),
                &mut problem,
                starts,
                &memory,
                best,
            );
            best.answer = with_held(&problem, &best, &point);
        }
        let Best { scale, wide, answer: found } = best;
        let found = prune(&problem.whitened(scale, &wide), found, &point);
        let rough = found.score;
        let found = refine(evidence, &at, &contact, &mut problem, (scale, &wide), found, |_| true);
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
        stride(&mut target, &point, before.as_ref());
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
        let done = (is_right && all) || pass + 1 == PASSES;
        // with other weights or sizes another scale may be right; a reference holds its own
        memory.scale = (seeks_change || !(reweighted || polished)).then_some(scale);
        let point_now = point.clone();
        last = Some(Selection { problem, answer: found, scale, wide, point: point_now, doubtful });
        if done {
            break;
        }
        before = Some(std::mem::replace(&mut point, target));
        if reweighted || !seeks_change {
            for (j, misfit) in misfit.into_iter().enumerate() {
                owner.rows.set_misfit(j, misfit);
            }
        }
        if reweighted {
            owner.rows.share = share;
        }
    }
    if seeks_change {
        return last;
    }
    let sharp = last?;
    Some(with_fading(owner, &sharp).unwrap_or(sharp))
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
    point.fading.clone_from(&from.fading);
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

/// Searches with every scale of inertial errors; the scans that one brings are offered to all.
fn best_of_scales(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    ripple: &RippleColumns,
    contact: &ContactColumns,
    problem: &mut Problem,
    start: Vec<usize>,
    memory: &Memory,
) -> Option<(Best, Vec<Vec<usize>>)> {
    let everyday: Vec<usize> = (0..problem.groups.len())
        .filter(|g| ["viscous_friction", "coulomb_friction"].contains(&problem.groups[*g].slug()))
        .collect();
    let mut starts = vec![start, everyday];
    // widely spaced scales first, then the neighbours of the best; later passes stay near it
    let mut best = None;
    let first = match memory.scale {
        Some(before) => [vec![0], neighbours(before)].concat(),
        None => (0..SCALES.len()).step_by(2).collect(),
    };
    let mut tried = Vec::new();
    for k in first {
        if !tried.contains(&k) {
            tried.push(k);
            let found =
                laws_at(SCALES[k], evidence, at, ripple, contact, problem, &mut starts, memory);
            keep_better(&mut best, found);
        }
    }
    if memory.scale.is_none() {
        for k in best.as_ref().map(|b: &Best| neighbours(b.scale)).unwrap_or_default() {
            if !tried.contains(&k) {
                let found =
                    laws_at(SCALES[k], evidence, at, ripple, contact, problem, &mut starts, memory);
                keep_better(&mut best, found);
            }
        }
    }
    Some((best?, starts))
}

pub(crate) fn keep_better(best: &mut Option<Best>, found: Option<Best>) {
    if let Some(found) = found
        && best.as_ref().is_none_or(|b| found.answer.score < b.answer.score)
    {
        *best = Some(found);
    }
}

/// The best answer at one scale, with ripples and contacts scanned on what is left until nothing new
/// comes.
pub(crate) fn laws_at(
    scale: f64,
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    ripple: &RippleColumns,
    contact: &ContactColumns,
    problem: &mut Problem,
    starts: &mut Vec<Vec<usize>>,
    memory: &Memory,
) -> Option<Best> {
    let mut found = None;
    for round in 0..ROUNDS {
        let now = search_at(scale, problem, starts, memory)?;
        let metric = problem.whitened(scale, &now.wide);
        let mut residuals = vec![metric.residual(&now.answer.fit)];
        if round == 0 {
            residuals.extend(answer(&metric, Vec::new()).map(|a| metric.residual(&a.fit)));
        }
        let mut offered = Vec::new();
        for residual in &residuals {
            offered.extend(ripple.offer(evidence, at, problem, residual));
            offered.extend(contact.offer(evidence, problem, residual));
        }
        starts.push(now.answer.set.clone());
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
    problem: &Problem,
    starts: &[Vec<usize>],
    memory: &Memory,
) -> Option<Best> {
    let banned = banned(problem, memory, scale);
    let found = search(&problem.whitened(scale, &[]), starts, &banned)?;
    Some(with_wrong_bodies(problem, scale, found, starts, &banned))
}

/// Places of a scale and of those beside it.
fn neighbours(scale: f64) -> Vec<usize> {
    let at = SCALES.iter().position(|s| *s == scale).unwrap_or(0);
    (at.saturating_sub(1)..(at + 2).min(SCALES.len())).collect()
}

/// Groups that may not be named: ripples of no whole order, and single links where all links are
/// uncertain, which wrong bodies stand for.
fn banned(problem: &Problem, memory: &Memory, scale: f64) -> HashSet<usize> {
    (0..problem.groups.len())
        .filter(|&g| {
            let group = &problem.groups[g];
            (group.slug() == "torque_ripple" && memory.no_ripple.contains(&group.site.joints[0]))
                || (scale > 0.0
                    && problem.rows.changed_from == 0
                    && group.slug() == "link_inertia_error")
                || group.site.window.is_some_and(|(r, _)| r < problem.rows.changed_from)
        })
        .collect()
}

/// Lets the errors of single links be larger than those of all others, as long as that is a shorter
/// description.
fn with_wrong_bodies(
    problem: &Problem,
    scale: f64,
    mut found: Answer,
    starts: &[Vec<usize>],
    banned: &HashSet<usize>,
) -> Best {
    let mut wide = Vec::new();
    // where a change is sought, a link that changed is a law like the others
    if scale > 0.0 && scale <= ALL_LINKS_WRONG && problem.rows.changed_from == 0 {
        let links = problem.background.links;
        while wide.len() < MOST_WRONG_BODIES {
            let right = (0..links).filter(|l| wide.iter().all(|body: &WrongBody| body.link != *l));
            let bodies: Vec<WrongBody> =
                right.flat_map(|link| TIMES.map(|times| WrongBody { link, times })).collect();
            let judged = |body: &WrongBody| {
                let trial = [&wide[..], &[*body]].concat();
                let next = answer(&problem.whitened(scale, &trial), found.set.clone())?;
                Some((next.score, trial))
            };
            let candidates: Vec<_> = bodies.par_iter().filter_map(judged).collect();
            let least = candidates.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((score, trial)) = least else { break };
            if score >= found.score {
                break;
            }
            let metric = problem.whitened(scale, &trial);
            let starts = [starts, &[found.set.clone()]].concat();
            let Some(next) = search(&metric, &starts, banned) else { break };
            (found, wide) = (next, trial);
        }
    }
    Best { scale, wide, answer: found }
}
