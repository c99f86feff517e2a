//! From evidence to the answer: search, scans, refinement, operating point.

use std::collections::HashSet;

use armident_effects::{Place, Scope, effect};

use armident_numeric::{Cholesky, gram_of_columns};

use crate::contact::ContactColumns;
use crate::crossval::{confirm, imperfection, with_changes, with_everyday_terms};
use crate::evidence::{At, Evidence, OperatingPoint};
use crate::flexible;
use crate::learn::View;
use crate::material::{LEAST, band_noise, excess, held, prune};
use crate::problem::{Group, Meaning, Problem, Whitened, dot};
use crate::ripple::RippleColumns;
use crate::search::{Answer, answer, search};
use crate::transmission;

/// Relative inertial errors tried: none, a good data sheet, CAD, a guess, nothing known.
const SCALES: [f64; 9] = [0.0, 0.012, 0.03, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6];
/// Beyond this relative error of all links no single one is called wrong.
const ALL_LINKS_WRONG: f64 = 0.2;
/// Most links whose body is called wrong; more are a wrong arm.
const MOST_WRONG_BODIES: usize = 2;
/// Rounds of scanning what is left over.
const ROUNDS: usize = 6;
/// Least unexplained effort, in standard deviations of one recorded sample, that is described without a
/// name, and on how many joints.
const LEAST_UNEXPLAINED: f64 = 0.7;
const DESCRIBED_JOINTS: usize = 2;
/// A joint that leaves over more than this many times its noise has an imperfect model, which then
/// weighs less; and changes of its misfit (logarithm) that no longer matter.
const CLEAR_MISFIT: f64 = 1.5;
const SAME_MISFIT: f64 = 0.3;
/// Relative inertial error with which the reference is looked at first: what a URDF is off by.
const REFERENCE_SCALE: f64 = 0.2;
/// Share of the independent samples from which on their number was clearly overrated.
const FEWER_SAMPLES: f64 = 0.6;
/// Passes of moving the operating point.
const PASSES: usize = 5;
/// Moves of the operating point below these no longer matter \[rad, rad or m, s\].
const STILL: (f64, f64, f64) = (1e-3, 5e-4, 2e-4);
/// Share of an order that a ripple of a rotational joint may be off a whole number.
const WHOLE_ORDER: f64 = 0.12;

/// The answer of the selection, and all it stands on.
pub(crate) struct Selection {
    pub(crate) problem: Problem,
    pub(crate) answer: Answer,
    /// relative inertial error
    pub(crate) scale: f64,
    /// links with a wrong body
    pub(crate) wide: Vec<usize>,
    /// where the columns were formed
    pub(crate) point: OperatingPoint,
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
struct Memory {
    groups: Vec<Group>,
    /// ripple is not offered on these joints: its order was no whole number
    no_ripple: HashSet<usize>,
    /// inertial error of the last pass
    scale: Option<f64>,
}

/// What one search gives.
#[derive(Debug, Clone)]
struct Best {
    scale: f64,
    wide: Vec<usize>,
    answer: Answer,
}

pub(crate) fn select(owner: &mut Evidence<'_>) -> Option<Selection> {
    let mut point = OperatingPoint::of(owner.joints());
    let mut memory = Memory::default();
    let ripple = RippleColumns::new(owner, &owner.at(&point));
    let seeks_change = owner.rows.changed_from > 0;
    let first = owner.problem(&point);
    let misfit =
        if seeks_change { imperfection(&first, REFERENCE_SCALE) } else { first_misfits(&first) };
    for (j, misfit) in misfit.into_iter().enumerate() {
        owner.rows.set_misfit(j, misfit);
    }
    if seeks_change {
        let empty = answer(&first.whitened(REFERENCE_SCALE, &[]), Vec::new())?;
        let residual = first.whitened(REFERENCE_SCALE, &[]).residual(&empty.fit);
        owner.rows.share = independent_share(&first, &residual, true).min(owner.rows.share);
    }
    drop(first);
    let mut last = None;
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
        if is_still(&moves(&problem, &pruned, &point), &point) || pass + 1 == PASSES {
            best = with_hidden_motion(evidence, &at, &contact, &mut problem, starts, &memory, best);
            best.answer = with_held(&problem, &best, &point);
        }
        let Best { scale, wide, answer: found } = best;
        let found = prune(&problem.whitened(scale, &wide), found, &point);
        let found = refine(evidence, &at, &contact, &mut problem, (scale, &wide), found, |_| true);
        let found = prune(&problem.whitened(scale, &wide), found, &point);
        let mut found = confirm(&problem.whitened(scale, &wide), found, &point);
        if seeks_change {
            let metric = problem.whitened(scale, &wide);
            found = prune(&metric, with_changes(&metric, found), &point);
        }
        let fractional = fractional_ripples(evidence, &problem, &found);
        memory.groups = found.set.iter().map(|g| problem.groups[*g].clone()).collect();
        let again = !fractional.is_empty();
        memory.no_ripple.extend(fractional);
        if again {
            memory.groups.retain(|g| {
                g.slug() != "torque_ripple" || !memory.no_ripple.contains(&g.site.joints[0])
            });
        }
        let target = moves(&problem, &found, &point);
        let still = is_still(&target, &point);
        let misfit = misfits(&problem.whitened(scale, &wide), &found);
        let reweighted = !seeks_change
            && misfit
                .iter()
                .zip(&problem.rows.misfit)
                .any(|(new, old)| (new / old).ln().abs() > SAME_MISFIT);
        // of what no term of a plain identification explains: a short answer must not look like few samples
        let residual = with_everyday_terms(&problem.whitened(scale, &wide), &found);
        let share = independent_share(&problem, &residual, false).min(problem.rows.share);
        let reweighted =
            reweighted || (!seeks_change && share < FEWER_SAMPLES * problem.rows.share);
        let done = (still && !again && !reweighted) || pass + 1 == PASSES;
        // with other weights another scale may be right
        memory.scale = (!reweighted).then_some(scale);
        last = Some(Selection { problem, answer: found, scale, wide, point: point.clone() });
        if done {
            break;
        }
        point = target;
        if !seeks_change {
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

/// What all columns of the library together leave over on each joint, each joint by itself, in units of
/// its noise: less is not in the reach of any answer. Clearly more than 1 where efforts were smoothed
/// before they were recorded, so that the noise above the band says nothing about the band, and where
/// the physics is none of the library's.
fn first_misfits(problem: &Problem) -> Vec<f64> {
    const HOLD: f64 = 1e-6;
    (0..problem.rows.joints())
        .map(|j| {
            let blocks: Vec<&[f64]> = problem
                .columns
                .iter()
                .map(|c| c[j].as_slice())
                .filter(|c| c.iter().any(|x| *x != 0.0))
                .collect();
            let effort = &problem.effort[j];
            let gram = gram_of_columns(&blocks);
            let norm: Vec<f64> = (0..blocks.len()).map(|k| gram[(k, k)].sqrt()).collect();
            let cholesky = Cholesky::of(blocks.len(), |a, b| {
                gram[(a, b)] / (norm[a] * norm[b]) + if a == b { HOLD } else { 0.0 }
            });
            let Some(cholesky) = cholesky else { return 1.0 };
            let rhs: Vec<f64> = blocks.iter().zip(&norm).map(|(c, n)| dot(c, effort) / n).collect();
            let solution = cholesky.solve(&rhs);
            let mut residual = effort.clone();
            for ((column, x), n) in blocks.iter().zip(&solution).zip(&norm) {
                for (r, c) in residual.iter_mut().zip(*column) {
                    *r -= x / n * c;
                }
            }
            let samples = effort.len() as f64 * problem.rows.share;
            // each column takes one independent sample
            let free = (1.0 - blocks.len() as f64 / samples).max(0.1);
            problem.rows.in_band_noise(j, &residual) / free.sqrt()
        })
        .map(|left| if left > CLEAR_MISFIT { left } else { 1.0 })
        .collect()
}

/// Independent samples per row of a residual: one over its autocorrelation time, joints by their number
/// of rows; of the reference alone, or of all recordings. Model errors last longer than noise in the band
/// does.
fn independent_share(problem: &Problem, residual: &[Vec<f64>], of_reference: bool) -> f64 {
    // as long as a motion lasts; beyond, the estimate is noise
    const LONGEST_S: f64 = 2.0;
    let mut time = 0.0;
    let starts = match of_reference {
        true => &problem.rows.starts[..=problem.rows.changed_from],
        false => &problem.rows.starts[..],
    };
    for residual in residual {
        let residual = &residual[..starts[starts.len() - 1]];
        let square = dot(residual, residual).max(f64::MIN_POSITIVE);
        let correlation = |lag: usize| -> f64 {
            let pairs = starts.windows(2).map(|p| &residual[p[0]..p[1]]);
            pairs
                .map(|r| dot(&r[..r.len().saturating_sub(lag)], &r[lag.min(r.len())..]))
                .sum::<f64>()
                / square
        };
        let lags = (1..(LONGEST_S * problem.rows.rows_hz) as usize).map(correlation);
        time += 1.0 + 2.0 * lags.take_while(|c| *c > 0.0).sum::<f64>();
    }
    residual.len() as f64 / time
}

/// What each joint's model leaves over, in units of its noise, where that is clearly more than noise.
fn misfits(metric: &Whitened<'_>, found: &Answer) -> Vec<f64> {
    let residual = metric.residual(&found.fit);
    (0..residual.len())
        .map(|j| {
            let left = metric.problem.rows.in_band_noise(j, &residual[j]);
            // only downward: what an answer has not yet explained must not make it unimportant
            let left = if left > CLEAR_MISFIT { left } else { 1.0 };
            left.min(metric.problem.rows.misfit[j])
        })
        .collect()
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

/// Whether a move of the operating point no longer matters.
fn is_still(to: &OperatingPoint, from: &OperatingPoint) -> bool {
    (to.tilt[0] - from.tilt[0]).hypot(to.tilt[1] - from.tilt[1]) < STILL.0
        && to.offset.iter().zip(&from.offset).all(|(a, b)| (a - b).abs() < STILL.1)
        && (to.delay_s - from.delay_s).abs() < STILL.2
}

/// The operating point with what a fit adds to it.
pub(crate) fn moves(problem: &Problem, found: &Answer, from: &OperatingPoint) -> OperatingPoint {
    let mut point = OperatingPoint::of(from.offset.len());
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

fn keep_better(best: &mut Option<Best>, found: Option<Best>) {
    if let Some(found) = found
        && best.as_ref().is_none_or(|b| found.answer.score < b.answer.score)
    {
        *best = Some(found);
    }
}

/// The best answer at one scale, with ripples and contacts scanned on what is left until nothing new
/// comes.
fn laws_at(
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

fn search_at(
    scale: f64,
    problem: &Problem,
    starts: &[Vec<usize>],
    memory: &Memory,
) -> Option<Best> {
    let banned = banned(problem, memory, scale);
    let found = search(&problem.whitened(scale, &[]), starts, &banned)?;
    Some(with_wrong_bodies(problem, scale, found, starts, &banned))
}

/// Transmissions with a hidden link where something is left over or moves by itself, and descriptions
/// without a name where even that explains nothing: at the scale found, and at none, where a wish for
/// uncertain inertias was a wrong law in disguise.
fn with_hidden_motion(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    contact: &ContactColumns,
    problem: &mut Problem,
    mut starts: Vec<Vec<usize>>,
    memory: &Memory,
    found: Best,
) -> Best {
    let mut scales = vec![found.scale];
    if found.scale > 0.0 {
        scales.push(0.0);
    }
    starts.push(found.answer.set.clone());
    let fallback = found.clone();
    let mut offered = Vec::new();
    let mut driven: Vec<usize> = Vec::new();
    for &scale in &scales {
        let Some(now) = search_at(scale, problem, &starts, memory) else { continue };
        let residual = problem.whitened(scale, &now.wide).residual(&now.answer.fit);
        for j in suspects(problem, &now, &residual) {
            if !driven.contains(&j) {
                driven.push(j);
                offered.extend(transmission::offer(evidence, at, problem, j));
            }
        }
    }
    // a resonance is narrower than the steps of a grid
    for &joint in &driven {
        let metric = (found.scale, &found.wide[..]);
        let near = nearest_spring(problem, metric, &found.answer, joint, &offered);
        let spring = |g: &Group| g.slug() == "joint_elasticity" && g.site.joints == [joint];
        if let Some(near) = near.filter(|n| n.score < found.answer.score) {
            let polished = refine(evidence, at, contact, problem, metric, near, spring);
            starts.push(polished.set);
        }
    }
    starts.extend(offered.iter().map(|g| vec![*g]));
    let mut best = Some(found);
    let mut described: Vec<usize> = Vec::new();
    for &scale in &scales {
        let library = if driven.is_empty() && best.as_ref().is_some_and(|b| b.scale == scale) {
            best.take()
        } else {
            search_at(scale, problem, &starts, memory)
        };
        let Some(library) = library else { continue };
        let residual = problem.whitened(scale, &library.wide).residual(&library.answer.fit);
        let left = excess(problem, &residual);
        let mut worst: Vec<usize> =
            (0..left.len()).filter(|j| left[*j] > LEAST_UNEXPLAINED).collect();
        worst.sort_by(|a, b| left[*b].total_cmp(&left[*a]));
        for &j in worst.iter().take(DESCRIBED_JOINTS) {
            if !described.contains(&j) {
                described.push(j);
                let offered = flexible::offer(evidence, at, problem, j, &residual[j]);
                starts.extend(offered.iter().map(|g| vec![*g]));
            }
        }
        starts.push(library.answer.set.clone());
        let mut with_all =
            if described.is_empty() { None } else { search_at(scale, problem, &starts, memory) };
        if let Some(with_all) = &mut with_all {
            contest(problem, scale, with_all, library.answer.clone());
        }
        keep_better(&mut best, Some(library));
        keep_better(&mut best, with_all);
    }
    best.unwrap_or(fallback)
}

/// An answer with the spring on a joint, of those offered, that explains most beside it.
fn nearest_spring(
    problem: &Problem,
    (scale, wide): (f64, &[usize]),
    beside: &Answer,
    joint: usize,
    offered: &[usize],
) -> Option<Answer> {
    let metric = problem.whitened(scale, wide);
    let groups = &problem.groups;
    let springs = offered
        .iter()
        .filter(|g| groups[**g].slug() == "joint_elasticity" && groups[**g].site.joints == [joint]);
    springs
        .filter_map(|&g| {
            let others = beside.set.iter().copied().filter(|o| !groups[*o].excludes(&groups[g]));
            answer(&metric, others.chain([g]).collect())
        })
        .min_by(|a, b| a.score.total_cmp(&b.score))
}

/// Places of a scale and of those beside it.
fn neighbours(scale: f64) -> Vec<usize> {
    let at = SCALES.iter().position(|s| *s == scale).unwrap_or(0);
    (at.saturating_sub(1)..(at + 2).min(SCALES.len())).collect()
}

/// Joints whose transmission is worth simulating: those with an inertia of their own in the answer, and
/// those with something left over.
fn suspects(problem: &Problem, found: &Best, residual: &[Vec<f64>]) -> Vec<usize> {
    let mut joints: Vec<usize> = found
        .answer
        .set
        .iter()
        .map(|g| &problem.groups[*g])
        .filter(|g| g.places == [Place::Inertia])
        .map(|g| g.site.joints[0])
        .collect();
    let left = excess(problem, residual);
    let mut worst: Vec<usize> = (0..left.len()).filter(|j| left[*j] > LEAST_UNEXPLAINED).collect();
    worst.sort_by(|a, b| left[*b].total_cmp(&left[*a]));
    joints.extend(worst.iter().take(DESCRIBED_JOINTS));
    joints.sort_unstable();
    joints.dedup();
    joints
}

/// Keeps structure without a name only where it explains what the best answer of the library could not:
/// a material amount, and more than half of it.
fn contest(problem: &Problem, scale: f64, found: &mut Best, library: Answer) {
    let unnamed: Vec<usize> = found
        .answer
        .set
        .iter()
        .copied()
        .filter(|g| matches!(problem.groups[*g].meaning, Meaning::Flexible(_)))
        .collect();
    if unnamed.is_empty() {
        return;
    }
    let metric = problem.whitened(scale, &found.wide);
    let library = answer(&metric, library.set.clone()).unwrap_or(library);
    let (by_library, by_all) = (metric.residual(&library.fit), metric.residual(&found.answer.fit));
    let holds = unnamed.iter().all(|g| {
        let j = problem.groups[*g].site.joints[0];
        let square = |r: &[f64]| problem.rows.in_sample_noise(j, r).powi(2);
        let noise = band_noise(problem, j).powi(2);
        let (left, rest) = (square(&by_library[j]), square(&by_all[j]));
        let gained = left - rest;
        gained.max(0.0).sqrt() >= LEAST && gained > 0.5 * (left - noise)
    });
    if !holds {
        found.answer = library;
    }
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
            let candidates = (0..links).filter(|l| !wide.contains(l)).filter_map(|link| {
                let trial = [wide.clone(), vec![link]].concat();
                let next = answer(&problem.whitened(scale, &trial), found.set.clone())?;
                Some((next.score, trial))
            });
            let Some((score, trial)) = candidates.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
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

/// The group of a new problem that stands for the same.
fn recreate(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    contact: &ContactColumns,
    problem: &mut Problem,
    group: &Group,
) -> Option<usize> {
    let known = (0..problem.groups.len()).find(|&g| {
        let other = &problem.groups[g];
        other.meaning == group.meaning && other.site == group.site && other.shape == group.shape
    });
    if known.is_some() {
        return known;
    }
    let slug = match &group.meaning {
        Meaning::Law(slug) => *slug,
        Meaning::Flexible(flexible) => {
            let joint = group.site.joints[0];
            return Some(flexible::recreate(evidence, at, problem, joint, flexible));
        }
    };
    let law = effect(slug)?;
    let id = match law.law().scope {
        Scope::Joint => {
            evidence.push_joint_law(problem, at, law, group.site.joints[0], &group.shape)?
        }
        Scope::Neighbours => {
            evidence.push_pair_law(problem, at, law, group.site.joints[0], &group.shape)
        }
        Scope::ThroughJoint if !group.shape.is_empty() => {
            transmission::push(evidence, at, problem, slug, group.site.joints[0], &group.shape)?
        }
        Scope::Arm => {
            let (recording, window) = group.site.window?;
            contact.push(evidence, problem, recording, window)
        }
        _ => return None,
    };
    problem.groups[id].searched = group.searched;
    Some(id)
}

/// Polishes the constants that were tried on a grid.
fn refine(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    contact: &ContactColumns,
    problem: &mut Problem,
    (scale, wide): (f64, &[usize]),
    found: Answer,
    polished: impl Fn(&Group) -> bool,
) -> Answer {
    // a problem of the answer's columns alone: trials are then cheap
    let (mut small, set) = problem.restricted(&found.set);
    let Some(mut best) = answer(&small.whitened(scale, wide), set) else { return found };
    for _ in 0..2 {
        for k in 0..best.set.len() {
            let group = small.groups[best.set[k]].clone();
            let count = match group.slug() {
                _ if !polished(&group) => 0,
                "torque_ripple" => 1,
                _ => group.shape.len(),
            };
            for c in 0..count {
                let (mut step, smallest, relative) = step_of(&group, c);
                while step > smallest {
                    let current = small.groups[best.set[k]].clone();
                    let mut improved = false;
                    for sign in [-1.0, 1.0] {
                        let mut trial = current.clone();
                        let change = if relative { 1.0 + sign * step } else { 1.0 };
                        trial.shape[c] = if relative {
                            trial.shape[c] * change
                        } else {
                            trial.shape[c] + sign * step
                        };
                        if let Some((recording, window)) = &mut trial.site.window {
                            let _ = recording;
                            window[c] = trial.shape[c];
                            if window[1] - window[0] < step {
                                continue;
                            }
                        }
                        let Some(id) = recreate(evidence, at, contact, &mut small, &trial) else {
                            continue;
                        };
                        let mut set = best.set.clone();
                        set[k] = id;
                        let metric = small.whitened(scale, wide);
                        let Some(mut next) = answer(&metric, set.clone()) else { continue };
                        if next.score < best.score - 1e-3 {
                            // keep the order of groups, so that k stays the same group
                            next.set = set;
                            best = next;
                            improved = true;
                            break;
                        }
                    }
                    if !improved {
                        step *= 0.5;
                    }
                }
            }
        }
    }
    // back to the full problem
    let set: Vec<usize> = best
        .set
        .iter()
        .filter_map(|g| recreate(evidence, at, contact, problem, &small.groups[*g].clone()))
        .collect();
    answer(&problem.whitened(scale, wide), set).unwrap_or(found)
}

/// First step of a constant, the smallest, and whether they are relative.
fn step_of(group: &Group, constant: usize) -> (f64, f64, bool) {
    match group.slug() {
        // the damping of a spring is not known within a factor
        "joint_elasticity" if constant == 1 => (0.6, 0.02, true),
        "external_contact" => (0.16, 0.01, false),
        "torque_ripple" => (0.25, 0.01, false),
        "joint_coupling" => (0.1, 0.002, true),
        _ => (0.16, 0.005, true),
    }
}

/// Joints whose ripple ended at an order that is no whole number.
fn fractional_ripples(evidence: &Evidence<'_>, problem: &Problem, found: &Answer) -> Vec<usize> {
    found
        .set
        .iter()
        .map(|g| &problem.groups[*g])
        .filter(|g| {
            g.slug() == "torque_ripple"
                && evidence.chain.joints[g.site.joints[0]].kind.is_rotational()
        })
        .filter(|g| (g.shape[0] - g.shape[0].round()).abs() > WHOLE_ORDER)
        .map(|g| g.site.joints[0])
        .collect()
}
