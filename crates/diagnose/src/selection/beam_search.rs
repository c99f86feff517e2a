//! The set of laws with the shortest description: a beam search over adding, removing and replacing.

use crate::regression::fit_set::{Answer, answer};
use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use crate::regression::marginalised::{Fit, Whitened};

/// Sets kept at every step.
const BEAM: usize = 5;
/// Successors of one set that are kept.
const SUCCESSORS: usize = 8;
/// Most groups in a set: beyond, the description has stopped to be one.
const MOST_GROUPS: usize = 60;

/// The best set reachable from any of the starts and from the empty set, of groups that are not banned.
pub(crate) fn search(
    metric: &Whitened<'_>,
    starts: &[Vec<usize>],
    banned: &HashSet<usize>,
) -> Option<Answer> {
    let mut known: HashMap<Vec<usize>, Option<f64>> = HashMap::new();
    let mut expanded: HashSet<Vec<usize>> = HashSet::new();
    let mut front: Vec<Answer> = Vec::new();
    for start in starts.iter().chain([&Vec::new()]) {
        let allowed: Vec<usize> = start.iter().copied().filter(|g| !banned.contains(g)).collect();
        front.extend(answer(metric, allowed));
    }
    loop {
        front.sort_by(|a, b| a.score.total_cmp(&b.score));
        front.dedup_by(|a, b| a.set == b.set);
        front.truncate(BEAM);
        let Some(next) = front.iter().find(|a| !expanded.contains(&a.set)).cloned() else { break };
        expanded.insert(next.set.clone());
        front.extend(successors(metric, &next, banned, &mut known));
    }
    front.into_iter().next()
}

fn successors(
    metric: &Whitened<'_>,
    from: &Answer,
    banned: &HashSet<usize>,
    known: &mut HashMap<Vec<usize>, Option<f64>>,
) -> Vec<Answer> {
    let groups = &metric.problem.groups;
    // what may stay when a group comes in, and its fit: few different ones
    let staying = |g: usize| -> Vec<Vec<usize>> {
        let group = &groups[g];
        let stay: Vec<usize> =
            from.set.iter().copied().filter(|o| !groups[*o].excludes(group)).collect();
        // links load the same joints: beside a changed one another has little to add, but in its place it may. Where
        // no change is sought, single links stand for errors of all, and the best of pairs is no name
        let link_changed = metric.problem.rows.changed_from > 0 && group.is_of_link();
        let replaced = stay.iter().filter(|o| link_changed && groups[**o].is_of_link());
        let instead = replaced.map(|r| stay.iter().copied().filter(|o| o != r).collect());
        std::iter::once(stay.clone()).chain(instead).collect()
    };
    let candidates: Vec<(usize, Vec<usize>)> = (0..groups.len())
        .filter(|g| !banned.contains(g) && !from.set.contains(g))
        .filter(|_| from.set.len() < MOST_GROUPS)
        .flat_map(|g| staying(g).into_iter().map(move |rest| (g, rest)))
        .collect();
    let mut rests: HashMap<Vec<usize>, Option<Fit>> = HashMap::new();
    for (_, rest) in &candidates {
        if rest.len() < from.set.len() && !rests.contains_key(rest) {
            let fit = metric.fit(metric.columns_of(rest));
            rests.insert(rest.clone(), fit);
        }
    }
    let estimate = |(g, rest): &(usize, Vec<usize>)| -> Option<(f64, Vec<usize>)> {
        let fit = match rests.get(rest) {
            Some(fit) => fit.as_ref()?,
            None => &from.fit,
        };
        let mut added: Vec<usize> =
            groups[*g].columns.iter().copied().filter(|c| !fit.columns.contains(c)).collect();
        added.sort_unstable();
        added.dedup();
        let left = (fit.sum_of_squares - metric.gain(fit, &added)).max(f64::MIN_POSITIVE);
        let mut set = [rest.clone(), vec![*g]].concat();
        set.sort_unstable();
        Some((metric.score(left, fit.columns.len() + added.len(), &set), set))
    };
    let mut estimates: Vec<(f64, Vec<usize>)> =
        candidates.par_iter().filter_map(estimate).collect();
    for k in 0..from.set.len() {
        let mut set = from.set.clone();
        set.remove(k);
        let columns = metric.columns_of(&set);
        if let Some(fit) = metric.fit(columns.clone()) {
            estimates.push((metric.score(fit.sum_of_squares, columns.len(), &set), set));
        }
    }
    estimates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept = Vec::new();
    for (_, set) in estimates {
        if kept.len() == SUCCESSORS {
            break;
        }
        if known.get(&set).is_some_and(Option::is_none) {
            continue;
        }
        let found = answer(metric, set.clone());
        known.insert(set, found.as_ref().map(|a| a.score));
        kept.extend(found);
    }
    kept
}
