//! What is dear to try: links that move by themselves behind their motors, and descriptions without a name.

use armident_effects::Place;

use crate::design::candidate::{Group, Meaning};
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::design::ripple::RippleColumns;
use crate::design::{smooth, transmission};
use crate::regression::admissible::all_admissible;
use crate::regression::elimination::WrongBody;
use crate::regression::fit_set::{Answer, answer};
use crate::regression::marginalised::Whitened;
use crate::selection::materiality::{LEAST, band_noise, excess, unnamed_rest};
use crate::selection::prior_scale::{Best, Memory, keep_better, laws_at, search_at};
use crate::selection::refine_shape::refine;

/// Least unexplained effort, in standard deviations of one recorded sample, that is described without a
/// name, and on how many joints.
const LEAST_UNEXPLAINED: f64 = 0.7;
const DESCRIBED_JOINTS: usize = 2;
/// Joints beside these whose transmission is simulated: what they leave over as a share of the most that is left.
const SHARE_OF_WORST: f64 = 0.8;

/// Transmissions with a hidden link where something is left over or moves by itself, and descriptions
/// without a name where even that explains nothing: at the scale found, and at none, where a wish for
/// uncertain inertias was a wrong law in disguise.
pub(crate) fn with_hidden_motion(
    evidence: &Evidence<'_>,
    at: &[Posed<'_>],
    (ripple, contact): (&RippleColumns, &ContactColumns),
    problem: &mut Problem,
    mut starts: Vec<Vec<usize>>,
    memory: &mut Memory,
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
    // a resonance, or the motion in a gap, is narrower than the steps of a grid: beside a resonance the best of them may be
    // worse than none
    for &joint in &driven {
        let metric = (found.scale, &found.wide[..]);
        for slug in ["joint_elasticity", "backlash"] {
            let one = |g: &Group| g.slug() == slug && g.site.joints == [joint];
            let offered = offered.iter().copied().filter(|g| one(&problem.groups[*g]));
            let near = nearest(problem, metric, &found.answer, offered);
            let worth = |n: &Answer| slug == "joint_elasticity" || n.score < found.answer.score;
            if let Some(near) = near.filter(worth) {
                let polished = refine(evidence, at, contact, problem, metric, memory, near, one);
                starts.push(polished.set);
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
            search_at(scale, problem, &starts, memory)
        };
        let Some(mut library) = library else { continue };
        // what a link that rings hid is scanned for again
        if library.answer.set.iter().any(|g| problem.groups[*g].moves_its_link())
            && let Some(again) =
                laws_at(scale, evidence, at, ripple, contact, problem, &mut starts, memory)
        {
            library = again;
        }
        let residual = problem.whitened(scale, &library.wide).residual(&library.answer.fit);
        let left = excess(problem, &residual);
        let mut worst: Vec<usize> =
            (0..left.len()).filter(|j| left[*j] > LEAST_UNEXPLAINED).collect();
        worst.sort_by(|a, b| left[*b].total_cmp(&left[*a]));
        for &j in worst.iter().take(DESCRIBED_JOINTS) {
            if !described.contains(&j) {
                described.push(j);
                let offered = smooth::offer(evidence, at, problem, j, &residual[j]);
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

/// The best answer with one of the offered groups beside what it does not exclude.
fn nearest(
    problem: &Problem,
    (scale, wide): (f64, &[WrongBody]),
    beside: &Answer,
    offered: impl Iterator<Item = usize>,
) -> Option<Answer> {
    let metric = problem.whitened(scale, wide);
    let groups = &problem.groups;
    offered
        .filter_map(|g| {
            let others = beside.set.iter().copied().filter(|o| !groups[*o].excludes(&groups[g]));
            let set: Vec<usize> = others.chain([g]).collect();
            answer(&metric, set.clone()).or_else(|| with_simpler(&metric, set, g))
        })
        .min_by(|a, b| a.score.total_cmp(&b.score))
}

/// The answer of a set in which laws that made up for a group, and with it have a wrong sign, are their simpler
/// relatives.
fn with_simpler(metric: &Whitened<'_>, mut set: Vec<usize>, group: usize) -> Option<Answer> {
    let fit = metric.fit(metric.columns_of(&set))?;
    let wrong = |g: &usize| *g != group && !all_admissible(metric.problem, &[*g], &fit);
    for g in set.clone().into_iter().filter(wrong) {
        set = unnamed_rest(metric.problem, &set, g);
    }
    answer(metric, set)
}

/// Joints whose transmission is worth simulating: those with an inertia of their own in the answer, and
/// those with something left over. A joint that has become soft looks like links that changed: where these leave
/// something over, their joints as well.
fn suspects(problem: &Problem, found: &Best, residual: &[Vec<f64>]) -> Vec<usize> {
    let left = excess(problem, residual);
    let mut worst: Vec<usize> = (0..left.len()).filter(|j| left[*j] > LEAST_UNEXPLAINED).collect();
    worst.sort_by(|a, b| left[*b].total_cmp(&left[*a]));
    let links_changed = problem.rows.changed_from > 0 && !worst.is_empty();
    let mut joints: Vec<usize> = found
        .answer
        .set
        .iter()
        .map(|g| &problem.groups[*g])
        .filter(|g| g.places == [Place::Inertia] || (links_changed && g.is_of_link()))
        .map(|g| g.site.joints[0])
        .collect();
    // the motion of a hidden link is felt by its neighbours nearly as much
    let least = worst.first().map_or(0.0, |j| SHARE_OF_WORST * left[*j]);
    let first = worst.iter().take(DESCRIBED_JOINTS);
    joints.extend(first.chain(worst.iter().skip(DESCRIBED_JOINTS).filter(|j| left[**j] >= least)));
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
        .filter(|g| matches!(problem.groups[*g].meaning, Meaning::SmoothDirections(_)))
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
