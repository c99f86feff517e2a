//! The set of laws with the lowest score.
//!
//! Method: beam search over adding, removing and replacing candidates.
//! References: B. T. Lowerre, The HARPY speech recognition system, thesis, Carnegie Mellon University, 1976.

use crate::regression::fit_set::{Estimate, admissible_part, fit_set};
use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use crate::regression::marginalised::{LeastSquaresFit, Marginalised};

/// Sets kept at every step.
const BEAM: usize = 5;
/// Successors of one set that are kept.
const SUCCESSORS: usize = 8;
/// Most candidates in a set.
const MOST_CANDIDATES: usize = 60;

/// The best set reachable from any of the starts and from the empty set, of candidates that are not banned.
pub(crate) fn search(
    metric: &Marginalised<'_>,
    starts: &[Vec<usize>],
    banned: &HashSet<usize>,
) -> Option<Estimate> {
    let mut known: HashMap<Vec<usize>, Option<f64>> = HashMap::new();
    let mut expanded: HashSet<Vec<usize>> = HashSet::new();
    let mut front: Vec<Estimate> = Vec::new();
    for start in starts.iter().chain([&Vec::new()]) {
        let allowed: Vec<usize> = start.iter().copied().filter(|g| !banned.contains(g)).collect();
        front.extend(start_of(metric, allowed));
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

/// The fit of a start, or of its admissible part: laws that are missing still may give others a wrong sign.
fn start_of(metric: &Marginalised<'_>, set: Vec<usize>) -> Option<Estimate> {
    fit_set(metric, set.clone()).or_else(|| admissible_part(metric, set, &[]))
}

/// A set to go on with.
struct Successor {
    /// without a look at signs
    score: f64,
    set: Vec<usize>,
    /// the candidate that is new in it
    added: Option<usize>,
}

fn successors(
    metric: &Marginalised<'_>,
    from: &Estimate,
    banned: &HashSet<usize>,
    known: &mut HashMap<Vec<usize>, Option<f64>>,
) -> Vec<Estimate> {
    let candidates = &metric.problem.candidates;
    // the rest of the set beside a new candidate, and its fit: few different ones
    let staying = |g: usize| -> Vec<Vec<usize>> {
        let candidate = &candidates[g];
        let stay: Vec<usize> =
            from.set.iter().copied().filter(|o| !candidates[*o].excludes(candidate)).collect();
        // links load the same joints: beside a changed one another adds little, but instead of it it may. Without a
        // reference, single links stand for errors of all, and the best of pairs is no finding
        let link_changed =
            metric.problem.observations.comparison.seeks_change() && candidate.is_of_link();
        let replaced = stay.iter().filter(|o| link_changed && candidates[**o].is_of_link());
        let instead = replaced.map(|r| stay.iter().copied().filter(|o| o != r).collect());
        std::iter::once(stay.clone()).chain(instead).collect()
    };
    let exchanges: Vec<(usize, Vec<usize>)> = (0..candidates.len())
        .filter(|g| !banned.contains(g) && !from.set.contains(g))
        .filter(|_| from.set.len() < MOST_CANDIDATES)
        .flat_map(|g| staying(g).into_iter().map(move |rest| (g, rest)))
        .collect();
    let mut rests: HashMap<Vec<usize>, Option<LeastSquaresFit>> = HashMap::new();
    for (_, rest) in &exchanges {
        if rest.len() < from.set.len() && !rests.contains_key(rest) {
            let fit = metric.fit(metric.columns_of(rest));
            rests.insert(rest.clone(), fit);
        }
    }
    let score_with = |(g, rest): &(usize, Vec<usize>)| -> Option<Successor> {
        let fit = match rests.get(rest) {
            Some(fit) => fit.as_ref()?,
            None => &from.fit,
        };
        let mut added: Vec<usize> =
            candidates[*g].columns.iter().copied().filter(|c| !fit.columns.contains(c)).collect();
        added.sort_unstable();
        added.dedup();
        let left = (fit.sum_of_squares - metric.gain(fit, &added)).max(f64::MIN_POSITIVE);
        let mut set = [rest.clone(), vec![*g]].concat();
        set.sort_unstable();
        let score = metric.score(left, fit.columns.len() + added.len(), &set);
        Some(Successor { score, set, added: Some(*g) })
    };
    let mut scored: Vec<Successor> = exchanges.par_iter().filter_map(score_with).collect();
    for k in 0..from.set.len() {
        let mut set = from.set.clone();
        set.remove(k);
        let columns = metric.columns_of(&set);
        if let Some(fit) = metric.fit(columns.clone()) {
            let score = metric.score(fit.sum_of_squares, columns.len(), &set);
            scored.push(Successor { score, set, added: None });
        }
    }
    scored.sort_by(|a, b| a.score.total_cmp(&b.score));
    let mut kept = Vec::new();
    for Successor { set, added, .. } in scored {
        if kept.len() == SUCCESSORS {
            break;
        }
        if known.get(&set).is_some_and(Option::is_none) {
            continue;
        }
        // beside the right law those that imitated it may have a wrong sign: they make way for it where that is better
        let without_others = |g: usize| {
            admissible_part(metric, set.clone(), &[g]).filter(|found| found.score < from.score)
        };
        let found = fit_set(metric, set.clone()).or_else(|| added.and_then(without_others));
        known.insert(set, found.as_ref().map(|a| a.score));
        kept.extend(found);
    }
    kept
}

#[cfg(test)]
mod tests {
    use armident_model::OperatingPoint;

    use super::*;
    use crate::design::candidate::Candidate;
    use crate::test_arms::{design, ur5};

    /// Joint 1 has friction that falls with the speed, so that viscous friction has a wrong sign as long as nothing else explains that.
    #[test]
    fn start_keeps_its_admissible_part() {
        let chain = ur5();
        let design = design(&chain, &chain, |j, v| match j {
            1 => 4.0 * v.signum() - 1.5 * v,
            2 => 3.0 * v.signum() + 2.0 * v,
            _ => 0.0,
        });
        let problem = design.problem(&OperatingPoint::of(design.joints()));
        let of = |slug: &str, joint: usize| {
            let is = |g: &Candidate| g.slug() == slug && g.location.joints == [joint];
            problem.candidates.iter().position(is).unwrap()
        };
        let metric = problem.marginalised(0.0, &[]);
        let [wrong, dry, viscous, other_dry] = [
            of("viscous_friction", 1),
            of("coulomb_friction", 1),
            of("viscous_friction", 2),
            of("coulomb_friction", 2),
        ];
        let start = vec![wrong, dry, viscous, other_dry];
        assert!(fit_set(&metric, start.clone()).is_none());
        let mut kept = vec![dry, viscous, other_dry];
        kept.sort_unstable();
        assert_eq!(start_of(&metric, start).unwrap().set, kept);
    }
}
