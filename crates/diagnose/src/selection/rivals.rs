//! Alternatives of a finding: laws that explain the recordings about as well instead of it, all else refitted.
//!
//! Statistic: root mean square residual that an alternative adds, in noise levels, against a share of the materiality
//! threshold; for bodies the difference of scores.
//! References: own.

use std::cell::LazyCell;
use std::collections::BTreeMap;

use armident_effects::{Effect, Law, LinkInertiaError, Payload};
use rayon::prelude::*;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::linear_problem::LinearProblem;
use crate::design::observations::JointColumns;
use crate::regression::elimination::InflatedLink;
use crate::regression::fit_set::{Estimate, fit_set};
use crate::regression::folds::fold_errors;
use crate::regression::marginalised::Marginalised;
use crate::regression::score::{ODDS, PRICE_OF_SELDOM};
use crate::selection::cross_validation::significantly_less;
use crate::selection::materiality::{LEAST, band_noise, held};
use crate::selection::prior_scale::{may_be_inflated, with_one_more};
use armident_model::OperatingPoint;

/// Share of the materiality threshold below which the extra residual of a law leaves it indistinguishable.
const INDISTINGUISHABLE: f64 = 1.0 / 3.0;
/// Most alternatives of one finding.
const MOST: usize = 4;
/// Candidates that are fitted for one finding, by the estimate of their fit.
const TRIED: usize = 16;

/// A candidate of an estimate, or a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum InPlace {
    /// a candidate of the problem
    Candidate(usize),
    /// errors of a link beyond those of all others
    Body(usize),
}

/// An estimate with another law, or an inflated link, instead of one.
pub(crate) struct Rival {
    pub(crate) by: InPlace,
    pub(crate) estimate: Estimate,
    /// its inflated links
    pub(crate) inflated: Vec<InflatedLink>,
    /// root mean square residual that it adds, in noise levels, on the joint where that is most
    pub(crate) left: f64,
    /// by how much worse it scores, in the operating point that both are compared in
    pub(crate) behind: f64,
}

/// Rivals of a candidate of an estimate, the nearest first; one for every law and location. The candidate's part of the
/// operating point is added to the efforts first.
pub(crate) fn rivals(
    metric: &Marginalised<'_>,
    of: &Estimate,
    candidate: usize,
    point: &OperatingPoint,
) -> Vec<Rival> {
    let mut found = laws_in_place(metric, of, candidate, point);
    if metric.problem.candidates[candidate].is_of_link() {
        let rest: Vec<usize> = of.set.iter().copied().filter(|g| *g != candidate).collect();
        found.extend(bodies(metric, of, &rest, &metric.inflated, None));
        nearest_first(&mut found);
    }
    found
}

/// Those of them that are laws.
fn laws_in_place(
    metric: &Marginalised<'_>,
    of: &Estimate,
    candidate: usize,
    point: &OperatingPoint,
) -> Vec<Rival> {
    let held = held(&metric.problem.candidates[candidate], point);
    if held.is_empty() {
        return of_candidate(metric, of, candidate);
    }
    let moved = metric.problem.with_added(&held);
    let metric = moved.marginalised(metric.scale, &metric.inflated);
    fit_set(&metric, of.set.clone())
        .map_or_else(Vec::new, |of| of_candidate(&metric, &of, candidate))
}

/// The estimate with baseline friction instead of laws that the recordings do not distinguish from it: nearly every joint has
/// it, and few have another law alone.
pub(crate) fn baseline_first(
    metric: &Marginalised<'_>,
    mut of: Estimate,
    point: &OperatingPoint,
) -> Estimate {
    let baseline = |g: usize| metric.problem.candidates[g].has(Law::is_baseline_friction);
    for candidate in of.set.clone() {
        let joints = &metric.problem.candidates[candidate].location.joints;
        if baseline(candidate) || joints.len() != 1 {
            continue;
        }
        let usual = laws_in_place(metric, &of, candidate, point).into_iter().find(|rival| {
            let InPlace::Candidate(other) = rival.by else { return false };
            baseline(other)
                && metric.problem.candidates[other].location.joints == *joints
                && rival.estimate.score - of.score < PRICE_OF_SELDOM
        });
        if let Some(rival) = usual {
            of = rival.estimate;
        }
    }
    of
}

/// The estimate of a change with a load on the last link instead of another body that the recordings do not distinguish
/// from it: arms pick up loads, and few have a link exchanged.
pub(crate) fn load_first(metric: &Marginalised<'_>, mut of: Estimate) -> Estimate {
    let candidates = &metric.problem.candidates;
    let Some(load) = candidates.iter().position(|candidate| candidate.is(&Payload)) else {
        return of;
    };
    for body in of.set.clone() {
        if body == load || !candidates[body].is_of_link() {
            continue;
        }
        let mut set: Vec<usize> = of.set.iter().copied().filter(|g| *g != body).collect();
        if set.iter().any(|g| *g == load || candidates[*g].excludes(&candidates[load])) {
            continue;
        }
        set.push(load);
        if let Some(loaded) = fit_set(metric, set)
            && loaded.score - of.score < PRICE_OF_SELDOM
        {
            of = loaded;
        }
    }
    of
}

/// The estimate of a change with one body instead of several effects on single joints, where these do not clearly predict
/// left-out blocks better: a body loads several joints, and that as many of them changed on their own together is rare.
pub(crate) fn one_body_first(metric: &Marginalised<'_>, of: Estimate) -> Estimate {
    let problem = metric.problem;
    let candidates = &problem.candidates;
    let of_joint = |g: &usize| {
        candidates[*g].location.joints.len() == 1
            && !candidates[*g].is_of_link()
            && candidates[*g].location.window.is_none()
    };
    let mut joints: Vec<usize> =
        of.set.iter().filter(|g| of_joint(g)).map(|g| candidates[*g].location.joints[0]).collect();
    joints.sort_unstable();
    joints.dedup();
    if joints.len() < 2 || of.set.iter().any(|g| candidates[*g].is_of_link()) {
        return of;
    }
    let rest: Vec<usize> = of.set.iter().copied().filter(|g| !of_joint(g)).collect();
    let bodies = (0..candidates.len()).filter(|g| candidates[*g].is_of_link());
    let best = bodies
        .filter_map(|g| fit_set(metric, [rest.as_slice(), &[g]].concat()))
        .min_by(|a, b| a.score.total_cmp(&b.score));
    let Some(body) = best else { return of };
    let errors = |set: &[usize]| fold_errors(problem, set, metric.scale, &metric.inflated);
    let of_body = errors(&body.set);
    let explains = significantly_less(&of_body, &errors(&rest));
    if explains && !significantly_less(&errors(&of.set), &of_body) { body } else { of }
}

fn of_candidate(metric: &Marginalised<'_>, of: &Estimate, candidate: usize) -> Vec<Rival> {
    let problem = metric.problem;
    let candidates = &problem.candidates;
    if matches!(candidates[candidate].kind, CandidateKind::SmoothDirections(_)) {
        return Vec::new();
    }
    let rest: Vec<usize> = of.set.iter().copied().filter(|g| *g != candidate).collect();
    let Some(fit) = metric.fit(metric.columns_of(&rest)) else { return Vec::new() };
    // the best shape of every law at every place
    let mut best: BTreeMap<(&str, Vec<usize>), (f64, usize)> = BTreeMap::new();
    for (g, other) in candidates.iter().enumerate() {
        let same = other.slug() == candidates[candidate].slug()
            && other.location.joints == candidates[candidate].location.joints;
        let smooth = matches!(other.kind, CandidateKind::SmoothDirections(_));
        let windowed = other.location.window.is_some();
        let taken = rest.iter().any(|r| *r == g || candidates[*r].excludes(other));
        // a law that contains the other explains no less; that is no reason to doubt the simpler one
        let nested =
            contains(&candidates[candidate], other) || contains(other, &candidates[candidate]);
        // where all links are uncertain, any link takes up a little: only the joint's own is a rival
        let other_link = metric.scale > 0.0
            && !problem.observations.comparison.seeks_change()
            && other.transform.is_some()
            && candidates[candidate].transform.is_none()
            && other.location.joints != candidates[candidate].location.joints;
        if same || smooth || windowed || taken || nested || other_link {
            continue;
        }
        let added: Vec<usize> =
            other.columns.iter().copied().filter(|c| !fit.columns.contains(c)).collect();
        let left = (fit.sum_of_squares - metric.gain(&fit, &added)).max(f64::MIN_POSITIVE);
        let set = [rest.as_slice(), &[g]].concat();
        let score = metric.score(left, fit.columns.len() + added.len(), &set);
        let entry = best.entry((other.slug(), other.location.joints.clone())).or_insert((score, g));
        if score < entry.0 {
            *entry = (score, g);
        }
    }
    let mut nearest: Vec<(f64, usize)> = best.into_values().collect();
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    let with = metric.residual(&of.fit);
    let left_out = |of: &Estimate| fold_errors(problem, &of.set, metric.scale, &metric.inflated);
    let errors = LazyCell::new(|| left_out(of));
    let mut found: Vec<Rival> = nearest
        .iter()
        .take(TRIED)
        .filter_map(|&(_, g)| {
            let estimate = fit_set(metric, [rest.as_slice(), &[g]].concat())?;
            let left = left_more(problem, &metric.residual(&estimate.fit), &with);
            let behind = estimate.score - of.score;
            let rival = Rival {
                by: InPlace::Candidate(g),
                estimate,
                inflated: metric.inflated.clone(),
                left,
                behind,
            };
            Some((g, rival))
        })
        .filter(|(other, rival)| {
            let near = rival.estimate.score - of.score < ODDS;
            let of_links = [candidate, *other].map(|g| candidates[g].is_of_link());
            let changed = problem.observations.comparison.seeks_change();
            if changed && of_links == [true; 2] {
                near || !significantly_less(&errors, &left_out(&rival.estimate))
            } else if !changed && candidates[candidate].transform.is_some() && metric.scale > 0.0 {
                // link errors absorb the residual of any law instead of a load: there the score decides, among its
                // look-alikes
                near && separated_by(candidates[candidate].law(), candidates[*other].law())
                    .is_some()
            } else {
                rival.left < distinguishable_from(metric, of, &with, *other)
            }
        })
        .map(|(_, rival)| rival)
        .collect();
    nearest_first(&mut found);
    found
}

fn nearest_first(found: &mut Vec<Rival>) {
    found.sort_by(|a, b| a.left.total_cmp(&b.left));
    found.truncate(MOST);
}

/// Root mean square residual added, in noise levels, on the joint where that is most.
fn left_more(problem: &LinearProblem, residual: &JointColumns, than: &JointColumns) -> f64 {
    let on_joint = |j: usize| {
        let square = |r: &[f64]| problem.observations.in_sample_noise(j, r).powi(2);
        (square(&residual[j]) - square(&than[j])).max(0.0).sqrt()
    };
    (0..residual.len()).map(on_joint).fold(0.0, f64::max)
}

/// Rivals of an inflated link: other links, and laws that look like one, the nearest first.
pub(crate) fn rivals_of_body(metric: &Marginalised<'_>, of: &Estimate, link: usize) -> Vec<Rival> {
    let inflated: Vec<InflatedLink> =
        metric.inflated.iter().copied().filter(|body| body.link != link).collect();
    let mut found = bodies(metric, of, &of.set, &inflated, Some(link));
    let problem = metric.problem;
    let others = problem.marginalised(metric.scale, &inflated);
    let with = metric.residual(&of.fit);
    let looks_alike = |g: &usize| {
        let candidate = &problem.candidates[*g];
        !candidate.is(&LinkInertiaError)
            && separated_by(candidate.law(), Some(&LinkInertiaError)).is_some()
            && of.set.iter().all(|o| o != g && !problem.candidates[*o].excludes(candidate))
    };
    let laws: Vec<usize> = (0..problem.candidates.len()).filter(looks_alike).collect();
    found.par_extend(laws.into_par_iter().filter_map(|g| {
        let estimate = fit_set(&others, [of.set.as_slice(), &[g]].concat())?;
        let left = left_more(problem, &others.residual(&estimate.fit), &with);
        let behind = estimate.score - of.score;
        (behind < ODDS).then(|| Rival {
            by: InPlace::Candidate(g),
            estimate,
            inflated: inflated.clone(),
            left,
            behind,
        })
    }));
    nearest_first(&mut found);
    found
}

/// Estimates of a set with a further inflated link, all but one link tried, that are about as probable as an estimate.
fn bodies(
    metric: &Marginalised<'_>,
    of: &Estimate,
    set: &[usize],
    inflated: &[InflatedLink],
    but: Option<usize>,
) -> Vec<Rival> {
    let (problem, scale) = (metric.problem, metric.scale);
    if !may_be_inflated(problem, scale) {
        return Vec::new();
    }
    let with = metric.residual(&of.fit);
    let mut best: BTreeMap<usize, (Vec<InflatedLink>, f64)> = BTreeMap::new();
    for (inflated, score) in with_one_more(problem, scale, set, inflated) {
        let Some(InflatedLink { link, .. }) = inflated.last().copied() else { continue };
        if best.get(&link).is_none_or(|b| score < b.1) && Some(link) != but {
            best.insert(link, (inflated, score));
        }
    }
    best.into_iter()
        .filter(|(_, (_, score))| score - of.score < ODDS)
        .filter_map(|(link, (inflated, _))| {
            let others = problem.marginalised(scale, &inflated);
            let estimate = fit_set(&others, set.to_vec())?;
            let residual = others.residual(&estimate.fit);
            let left = left_more(problem, &residual, &with);
            let behind = estimate.score - of.score;
            Some(Rival { by: InPlace::Body(link), estimate, inflated, left, behind })
        })
        .collect()
}

/// Added residual from which on two laws are distinguished on these recordings.
fn distinguishable_from(
    metric: &Marginalised<'_>,
    of: &Estimate,
    with: &[Vec<f64>],
    rival: usize,
) -> f64 {
    // the larger a joint's discrepancy, the less its details distinguish
    let joints = of
        .set
        .iter()
        .chain([&rival])
        .flat_map(|g| metric.problem.candidates[*g].location.joints.clone());
    let imperfect = joints
        .map(|j| {
            let noise = band_noise(metric.problem, j);
            metric.problem.observations.in_sample_noise(j, &with[j]) / noise.max(f64::MIN_POSITIVE)
        })
        .fold(1.0, f64::max);
    INDISTINGUISHABLE * LEAST * imperfect.min(2.0)
}

/// Whether a law contains the other on the same joints: the simpler one was tried already and is worse.
fn contains(law: &Candidate, other: &Candidate) -> bool {
    law.location.joints == other.location.joints
        && law.has(|law| law.contains.contains(&other.slug()))
}

/// The motion that separates two laws, as the library has it; none beside a smooth term.
pub(crate) fn separated_by(
    law: Option<&'static dyn Effect>,
    other: Option<&'static dyn Effect>,
) -> Option<&'static str> {
    law?.law().separated_from(other?.law())
}

#[cfg(test)]
mod tests {
    use armident_kinematics::InertialParameters;
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::test_arms::{design, ur5};
    use armident_model::changed;

    /// A mass on the axis of a joint belongs to either of its links.
    #[test]
    fn mass_on_axis_has_both_links_as_rivals() {
        let given = ur5();
        let mut true_arm = given.clone();
        let link = given.joints.len() - 1;
        let mass = InertialParameters::from_com(0.1, Vector3::z() * 0.05, Matrix3::zeros());
        true_arm.joints[link].link = changed(&true_arm.joints[link].link, &mass.to_array());
        let design = design(&given, &true_arm, |_, _| 0.0);
        let problem = design.problem(&OperatingPoint::of(design.joints()));
        let inflated = [InflatedLink { link: link - 1, times: 12.0 }];
        let metric = problem.marginalised(0.05, &inflated);
        let found = fit_set(&metric, Vec::new()).unwrap();
        let of_body = rivals_of_body(&metric, &found, link - 1);
        let body = of_body.iter().find(|rival| rival.by == InPlace::Body(link)).unwrap();
        assert!(body.inflated.iter().map(|body| body.link).eq([link]));
        // nor is it a body of the shoulder
        assert!(of_body.iter().all(|rival| rival.by != InPlace::Body(0)));
        // a load has the same rivals
        let load =
            problem.candidates.iter().position(|candidate| candidate.slug() == "payload").unwrap();
        let metric = problem.marginalised(0.05, &[]);
        let loaded = fit_set(&metric, vec![load]).unwrap();
        let point = OperatingPoint::of(design.joints());
        let of_load = rivals(&metric, &loaded, load, &point);
        assert!(of_load.iter().any(|rival| rival.by == InPlace::Body(link - 1)));
    }
}
