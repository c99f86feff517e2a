//! Searches with every size of the errors that all links have.

use std::collections::HashSet;

use rayon::prelude::*;

use crate::design::candidate::Group;
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::design::ripple::RippleColumns;
use crate::regression::elimination::WrongBody;
use crate::regression::fit_set::{Answer, answer};
use crate::selection::beam_search::search;
use crate::selection::materiality::prune;
use armident_model::OperatingPoint;

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

/// By what the size of inertial errors is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ChosenBy {
    /// the answer with all that seems to be there
    All,
    /// what is left of it once what does not matter has gone: small laws take the part of a link that is wrong, and
    /// leave it to errors of all links when they go
    WhatMatters,
}

/// What was found about the answer so far, kept from one problem to the next.
#[derive(Debug, Clone)]
pub(crate) struct Memory {
    pub(crate) groups: Vec<Group>,
    /// groups whose constants were polished
    pub(crate) polished: Vec<Group>,
    /// ripple is not offered on these joints: its order was no whole number
    pub(crate) no_ripple: HashSet<usize>,
    /// inertial error of the last pass
    pub(crate) scale: Option<f64>,
    chosen_by: ChosenBy,
    /// whether another choice would have been made once
    pub(crate) ways_part: bool,
}

impl Memory {
    pub(crate) fn new(chosen_by: ChosenBy) -> Self {
        Self {
            groups: Vec::new(),
            polished: Vec::new(),
            no_ripple: HashSet::new(),
            scale: None,
            chosen_by,
            ways_part: false,
        }
    }
}

/// What one search gives.
#[derive(Debug, Clone)]
pub(crate) struct Best {
    pub(crate) scale: f64,
    pub(crate) wide: Vec<WrongBody>,
    pub(crate) answer: Answer,
}

/// Searches with every scale of inertial errors; the scans that one brings are offered to all.
pub(crate) fn best_of_scales(
    evidence: &Evidence<'_>,
    at: &[Posed<'_>],
    ripple: &RippleColumns,
    contact: &ContactColumns,
    problem: &mut Problem,
    start: Vec<usize>,
    point: &OperatingPoint,
    memory: &mut Memory,
) -> Option<(Best, Vec<Vec<usize>>)> {
    let everyday: Vec<usize> = (0..problem.groups.len())
        .filter(|g| ["viscous_friction", "coulomb_friction"].contains(&problem.groups[*g].slug()))
        .collect();
    let mut starts = vec![start, everyday];
    // widely spaced scales first, then the neighbours of the best; later passes stay near it
    let mut found = Found::default();
    let first = match memory.scale {
        Some(before) => [vec![0], neighbours(before)].concat(),
        None => (0..SCALES.len()).step_by(2).collect(),
    };
    let mut tried = Vec::new();
    let mut try_scales = |scales: Vec<usize>, found: &mut Found| {
        for k in scales {
            if !tried.contains(&k) {
                tried.push(k);
                let of_scale =
                    laws_at(SCALES[k], evidence, at, ripple, contact, problem, &mut starts, memory);
                found.extend(problem, of_scale, point);
            }
        }
    };
    try_scales(first, &mut found);
    if memory.scale.is_none() {
        let beside = found.best(memory.chosen_by).map(|best| neighbours(best.scale));
        try_scales(beside.unwrap_or_default(), &mut found);
    }
    let [by_all, by_what_matters] =
        [ChosenBy::All, ChosenBy::WhatMatters].map(|by| found.best(by).map(|b| b.scale));
    memory.ways_part |= by_all != by_what_matters;
    Some((found.best(memory.chosen_by)?.clone(), starts))
}

/// What was found with some scales, each with the score of what matters of it.
#[derive(Default)]
struct Found(Vec<(Best, f64)>);

impl Found {
    fn extend(&mut self, problem: &Problem, found: Option<Best>, point: &OperatingPoint) {
        self.0.extend(found.map(|found| {
            let score = if problem.rows.changed_from > 0 {
                found.answer.score
            } else {
                let metric = problem.whitened(found.scale, &found.wide);
                prune(&metric, found.answer.clone(), point).score
            };
            (found, score)
        }));
    }

    fn best(&self, by: ChosenBy) -> Option<&Best> {
        let score = |(found, of_what_matters): &(Best, f64)| match by {
            ChosenBy::All => found.answer.score,
            ChosenBy::WhatMatters => *of_what_matters,
        };
        self.0.iter().min_by(|a, b| score(a).total_cmp(&score(b))).map(|(found, _)| found)
    }
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
    at: &[Posed<'_>],
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

/// Whether single links are called wrong by errors larger than those of all others: where a change is sought, a link that
/// changed is a law like the others.
pub(crate) fn may_be_wrong(problem: &Problem, scale: f64) -> bool {
    scale > 0.0 && scale <= ALL_LINKS_WRONG && problem.rows.changed_from == 0
}

/// Scores of a set with a further link whose body is wrong: each link, in every size of its errors.
pub(crate) fn with_one_more(
    problem: &Problem,
    scale: f64,
    set: &[usize],
    wide: &[WrongBody],
) -> Vec<(Vec<WrongBody>, f64)> {
    let right = (0..problem.background.links).filter(|l| wide.iter().all(|body| body.link != *l));
    let bodies: Vec<WrongBody> =
        right.flat_map(|link| TIMES.map(|times| WrongBody { link, times })).collect();
    // the columns of the set alone: errors of every size are integrated out of them
    let (small, set) = problem.restricted(set);
    let with = |body: &WrongBody| {
        let wide = [wide, &[*body]].concat();
        let score = answer(&small.whitened(scale, &wide), set.clone())?.score;
        Some((wide, score))
    };
    bodies.par_iter().filter_map(with).collect()
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
    if may_be_wrong(problem, scale) {
        while wide.len() < MOST_WRONG_BODIES {
            let trials = with_one_more(problem, scale, &found.set, &wide);
            let least = trials.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((trial, score)) = least else { break };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::{evidence, ur5};

    /// What does not matter gives a size the shortest answer, until it has gone.
    #[test]
    fn a_size_is_chosen_by_all_that_seems_there_or_by_what_matters_of_it() {
        let chain = ur5();
        let evidence = evidence(&chain, &chain, |j, v| if j == 1 { 2.0 * v.signum() } else { 0.0 });
        let point = OperatingPoint::of(evidence.joints());
        let problem = evidence.problem(&point);
        let of = |slug: &str, joint: usize| {
            let is = |g: &Group| g.slug() == slug && g.site.joints == [joint];
            problem.groups.iter().position(is).unwrap()
        };
        let (coulomb, idle) = (of("coulomb_friction", 1), of("viscous_friction", 4));
        let with = |scale: f64, set: Vec<usize>| {
            let answer = answer(&problem.whitened(scale, &[]), set).unwrap();
            Best { scale, wide: Vec::new(), answer }
        };
        let mut found = Found::default();
        // by its score the longer one would be the better one
        let mut flattered = with(0.03, vec![coulomb, idle]);
        let other = with(0.0, vec![coulomb]);
        flattered.answer.score = other.answer.score - 1.0;
        found.extend(&problem, Some(flattered), &point);
        found.extend(&problem, Some(other), &point);
        assert_eq!(found.best(ChosenBy::All).unwrap().scale, 0.03);
        assert_eq!(found.best(ChosenBy::WhatMatters).unwrap().scale, 0.0);
    }
}
