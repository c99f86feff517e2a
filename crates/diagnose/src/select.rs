//! From evidence to the answer: search, scans, refinement, operating point.

use std::collections::HashSet;

use armident_effects::{Scope, effect};

use crate::contact::ContactColumns;
use crate::evidence::{At, Evidence, OperatingPoint};
use crate::material::prune;
use crate::problem::{Group, Meaning, Problem, Whitened};
use crate::ripple::RippleColumns;
use crate::search::{Answer, answer, search};

/// Relative inertial errors tried: none, a good data sheet, CAD, a guess, nothing known.
const SCALES: [f64; 7] = [0.0, 0.012, 0.03, 0.05, 0.1, 0.3, 1.0];
/// Rounds of scanning what is left over.
const ROUNDS: usize = 4;
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
    /// where the columns were formed
    pub(crate) point: OperatingPoint,
}

impl Selection {
    pub(crate) fn metric(&self) -> Whitened<'_> {
        self.problem.whitened(self.scale)
    }
}

/// What was found about the answer so far, kept from one problem to the next.
#[derive(Debug, Clone, Default)]
struct Memory {
    groups: Vec<Group>,
    /// ripple is not offered on these joints: its order was no whole number
    no_ripple: HashSet<usize>,
}

pub(crate) fn select(evidence: &Evidence<'_>) -> Option<Selection> {
    let mut point = OperatingPoint::of(evidence.joints());
    let mut memory = Memory::default();
    let at = evidence.at(&point);
    let ripple = RippleColumns::new(evidence, &at);
    let mut last = None;
    for pass in 0..PASSES {
        let at = evidence.at(&point);
        let contact = ContactColumns::new(evidence, &at);
        let mut problem = evidence.problem(&point);
        let start: Vec<usize> = memory
            .groups
            .iter()
            .filter_map(|g| recreate(evidence, &at, &contact, &mut problem, g))
            .collect();
        let (scale, found) =
            best_of_scales(evidence, &at, &ripple, &contact, &mut problem, start, &memory)?;
        let on_point = |g: usize| {
            let site = &problem.groups[g].site;
            match problem.groups[g].slug() {
                "gravity_direction" => point.tilt != [0.0; 2],
                "time_delay" => point.delay_s != 0.0,
                "encoder_offset" => point.offset[site.joints[0]] != 0.0,
                _ => false,
            }
        };
        let kept: Vec<usize> = found.set.iter().copied().filter(|g| on_point(*g)).collect();
        let found = prune(&problem.whitened(scale), found, |g| kept.contains(&g));
        let found = refine(evidence, &at, &contact, &mut problem, scale, found);
        let found = prune(&problem.whitened(scale), found, |g| kept.contains(&g));
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
        let still = (target.tilt[0] - point.tilt[0]).hypot(target.tilt[1] - point.tilt[1])
            < STILL.0
            && target.offset.iter().zip(&point.offset).all(|(a, b)| (a - b).abs() < STILL.1)
            && (target.delay_s - point.delay_s).abs() < STILL.2;
        let done = (still && !again) || pass + 1 == PASSES;
        last = Some(Selection { problem, answer: found, scale, point: point.clone() });
        if done {
            break;
        }
        point = target;
    }
    last
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
) -> Option<(f64, Answer)> {
    let everyday: Vec<usize> = (0..problem.groups.len())
        .filter(|g| ["viscous_friction", "coulomb_friction"].contains(&problem.groups[*g].slug()))
        .collect();
    let mut starts = vec![start, everyday];
    let mut best: Option<(f64, Answer)> = None;
    for scale in SCALES {
        let mut found: Option<Answer> = None;
        for round in 0..ROUNDS {
            let banned: HashSet<usize> = (0..problem.groups.len())
                .filter(|&g| {
                    let group = &problem.groups[g];
                    group.slug() == "torque_ripple"
                        && memory.no_ripple.contains(&group.site.joints[0])
                })
                .collect();
            let metric = problem.whitened(scale);
            found = search(&metric, &starts, &banned);
            let Some(answer_now) = &found else { break };
            let mut residuals = vec![metric.residual(&answer_now.fit)];
            if round == 0 {
                residuals.extend(answer(&metric, Vec::new()).map(|a| metric.residual(&a.fit)));
            }
            let mut offered = Vec::new();
            for residual in &residuals {
                offered.extend(ripple.offer(evidence, at, problem, residual));
                offered.extend(contact.offer(evidence, problem, residual));
            }
            starts.push(answer_now.set.clone());
            if offered.is_empty() {
                break;
            }
            starts.extend(offered.iter().map(|g| vec![*g]));
        }
        if let Some(found) = found {
            if best.as_ref().is_none_or(|(_, b)| found.score < b.score) {
                best = Some((scale, found));
            }
        }
    }
    best
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
    let Meaning::Law(slug) = group.meaning else { return None };
    let law = effect(slug)?;
    let id = match law.law().scope {
        Scope::Joint => {
            evidence.push_joint_law(problem, at, law, group.site.joints[0], &group.shape)?
        }
        Scope::Neighbours => {
            evidence.push_pair_law(problem, at, law, group.site.joints[0], &group.shape)
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
    scale: f64,
    found: Answer,
) -> Answer {
    // a problem of the answer's columns alone: trials are then cheap
    let (mut small, set) = problem.restricted(&found.set);
    let Some(mut best) = answer(&small.whitened(scale), set) else { return found };
    for _ in 0..2 {
        for k in 0..best.set.len() {
            let group = small.groups[best.set[k]].clone();
            let count = if group.slug() == "torque_ripple" { 1 } else { group.shape.len() };
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
                        let metric = small.whitened(scale);
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
    answer(&problem.whitened(scale), set).unwrap_or(found)
}

/// First step of a constant, the smallest, and whether they are relative.
fn step_of(group: &Group, _constant: usize) -> (f64, f64, bool) {
    match group.slug() {
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
