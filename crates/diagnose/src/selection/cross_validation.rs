//! Cross-validated usefulness: an effect must lower the error of blocks to which its coefficients were not fitted.
//!
//! Statistic: mean over folds of the log error ratio without and with a candidate, over its standard error.
//! References: own; folds as in [`crate::regression::folds`].

use crate::regression::folds::{SHORT_BLOCKS, all_errors, folds, folds_of, metrics};
use armident_inference::levels::{CHANGE_ERROR, CLEAR_T, EXPECTED_T};
use armident_inference::paired_t;

use armident_effects::BASELINE;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::linear_problem::LinearProblem;
use crate::design::observations::JointColumns;
use crate::regression::fit_set::{Estimate, admissible_part, fit_set};
use crate::regression::marginalised::Marginalised;
use crate::selection::materiality::{estimate_without, held, set_without};
use armident_model::{OperatingPoint, is_sublinear};

/// Removes effects that do not lower the cross-validated error by more than its standard error, the least useful first.
/// Windows are exempt, since no other block contains them; so are operating terms.
pub(crate) fn confirm(
    metric: &Marginalised<'_>,
    mut of: Estimate,
    point: &OperatingPoint,
) -> Estimate {
    loop {
        // ids of the restricted problem stand in the order of the candidates they were made from
        let originals = with_relatives(metric.problem, &of.set);
        let (small, ids) = metric.problem.restricted(&originals);
        let folds = folds(&small);
        let small_id = |g: usize| originals.iter().position(|o| *o == g).map(|k| ids[k]);
        let set: Vec<usize> = of.set.iter().filter_map(|g| small_id(*g)).collect();
        let metrics = metrics(&folds, metric.scale, &metric.inflated);
        let errors = |set: &[usize]| all_errors(&folds, &metrics, set);
        let with = errors(&set);
        let mut worst: Option<(f64, Estimate)> = None;
        for &g in &of.set {
            let candidate = &metric.problem.candidates[g];
            if candidate.location.window.is_some() || !held(candidate, point).is_empty() {
                continue;
            }
            let Some(without) = estimate_without(metric, &of, g) else { continue };
            let rest: Vec<usize> = without.set.iter().filter_map(|g| small_id(*g)).collect();
            let gains = gains(candidate, &errors(&rest), &with);
            if gains.len() < 2 {
                continue;
            }
            let mut ratio = paired_t(&gains);
            if metric.problem.observations.comparison.seeks_change() {
                let least = least_log_bayes_factor(
                    metric.problem.candidates.len(),
                    metric.problem,
                    candidate,
                );
                ratio = ratio.min(log_bayes_factor(metric.problem, &gains) / least);
            }
            if ratio < 1.0 && worst.as_ref().is_none_or(|w| ratio < w.0) {
                worst = Some((ratio, without));
            }
        }
        match worst {
            Some((_, without)) => of = without,
            None => return of,
        }
    }
}

/// Log error ratio per fold, without over with a candidate, summed over its joints with efforts: ratios, so that no fold and
/// no badly modelled joint outweighs the others.
fn gains(candidate: &Candidate, without: &[Vec<f64>], with: &[Vec<f64>]) -> Vec<f64> {
    gains_on((!acts_everywhere(candidate)).then_some(&candidate.location.joints), without, with)
}

/// Log error ratio per fold on these joints, or on all.
fn gains_on(joints: Option<&Vec<usize>>, without: &[Vec<f64>], with: &[Vec<f64>]) -> Vec<f64> {
    let of_block = |(without, with): (&Vec<f64>, &Vec<f64>)| {
        let recorded = || (0..with.len()).filter(|j| with[*j] > 0.0).collect();
        let joints = joints.cloned().unwrap_or_else(recorded);
        joints.iter().map(|j| (without[*j] / with[*j]).ln()).sum::<f64>()
    };
    without.iter().zip(with).map(of_block).filter(|gain| gain.is_finite()).collect()
}

/// Whether cross-validated errors are significantly less than others: model discrepancy repeats, so that scores differ by too
/// much.
pub(crate) fn significantly_less(errors: &[Vec<f64>], than: &[Vec<f64>]) -> bool {
    let gains = gains_on(None, than, errors);
    gains.len() > 1 && paired_t(&gains) > CLEAR_T
}

/// Whether a candidate loads joints other than those of its location.
fn acts_everywhere(candidate: &Candidate) -> bool {
    candidate.location.joints.is_empty() || candidate.transform.is_some()
}

/// Twice the log likelihood ratio of a candidate on the left-out blocks of a change.
fn log_bayes_factor(problem: &LinearProblem, gains: &[f64]) -> f64 {
    let rows = &problem.observations;
    let judged = (rows.len() - rows.judged_from()) as f64 / gains.len().max(1) as f64;
    rows.weights.share * judged * gains.iter().sum::<f64>()
}

/// Least value of that for a candidate chosen from so many.
fn least_log_bayes_factor(choices: usize, problem: &LinearProblem, candidate: &Candidate) -> f64 {
    2.0 * (choices as f64 / CHANGE_ERROR).ln() + problem.price_of_onset(candidate)
}

/// Adds the changes that raise the likelihood of left-out blocks clearly, the largest first. The search prices every
/// coefficient of a change by the effective sample size, which is small with model discrepancy; left-out blocks need no such
/// price.
pub(crate) fn with_changes(metric: &Marginalised<'_>, mut of: Estimate) -> Estimate {
    let problem = metric.problem;
    let linear = |g: &usize| {
        let candidate = &problem.candidates[*g];
        matches!(candidate.kind, CandidateKind::Law(_))
            && candidate.shape.is_empty()
            && candidate.location.window.is_none()
    };
    loop {
        let candidates: Vec<usize> = (0..problem.candidates.len())
            .filter(|g| linear(g) && !of.set.contains(g))
            .filter(|g| {
                of.set.iter().all(|o| !problem.candidates[*o].excludes(&problem.candidates[*g]))
            })
            .collect();
        let all = [of.set.clone(), candidates.clone()].concat();
        let (small, ids) = problem.restricted(&all);
        let folds = folds(&small);
        let metrics = metrics(&folds, metric.scale, &metric.inflated);
        let errors = |set: &[usize]| all_errors(&folds, &metrics, set);
        let set = &ids[..of.set.len()];
        let without = errors(set);
        let mut best: Option<(f64, Estimate)> = None;
        for (&g, &id) in candidates.iter().zip(&ids[of.set.len()..]) {
            let candidate = &problem.candidates[g];
            let gains = gains(candidate, &without, &errors(&[set, &[id]].concat()));
            let log_factor = log_bayes_factor(problem, &gains);
            let least = least_log_bayes_factor(candidates.len(), problem, candidate);
            let sure = gains.len() > 1 && paired_t(&gains) > CLEAR_T;
            if !sure
                || log_factor < least
                || best.as_ref().is_some_and(|b| b.0 >= log_factor - least)
            {
                continue;
            }
            let found = fit_set(metric, [of.set.clone(), vec![g]].concat());
            best = found.map(|found| (log_factor - least, found)).or(best);
        }
        match best {
            Some((_, found)) => of = found,
            None => return of,
        }
    }
}

/// The estimate that predicts best: the findings and small terms of all joints.
pub(crate) struct Predictor {
    pub(crate) estimate: Estimate,
    pub(crate) scale: f64,
}

impl Predictor {
    /// Another estimate with the small terms of this one. Terms that become inadmissible there are dropped, and so is the
    /// sublinear part of a friction that it lacks, which would take the place of that.
    pub(crate) fn beside(
        &self,
        metric: &Marginalised<'_>,
        named: &Estimate,
        other: &Estimate,
    ) -> Option<Estimate> {
        let candidates = &metric.problem.candidates;
        let mut set = other.set.clone();
        let lacking: Vec<usize> =
            named.set.iter().copied().filter(|g| !other.set.contains(g)).collect();
        let stands_alone = |g: &usize| {
            is_sublinear(candidates[*g].slug())
                && lacking.iter().any(|l| candidates[*l].location == candidates[*g].location)
        };
        let beside = self.estimate.set.iter().filter(|g| !named.set.contains(g));
        for &g in beside.filter(|g| !stands_alone(g)) {
            if set.iter().all(|o| *o != g && !candidates[*o].excludes(&candidates[g])) {
                set.push(g);
            }
        }
        admissible_part(metric, set, &[])
    }
}

/// Prior scales tried for the prediction, beside the one of the selection.
const SCALES: [f64; 4] = [0.05, 0.2, 0.8, 3.2];

/// The estimate with small terms and another prior scale, where these lower the cross-validated error by more than its
/// standard error: a finding must be material, a prediction needs every term that helps.
pub(crate) fn predictor(metric: &Marginalised<'_>, named: &Estimate) -> Predictor {
    let problem = metric.problem;
    let extended = with_baseline(problem, &named.set);
    let (small, ids) = problem.restricted(&extended);
    let folds = folds(&small);
    let small_id = |g: &usize| extended.iter().position(|o| o == g).map(|k| ids[k]);
    let mut scales = vec![metric.scale];
    scales.extend(SCALES.iter().filter(|s| **s != metric.scale));
    // logarithms of squared errors, `[fold][joint]`: no block and no joint outweighs the others
    let errors = |found: &Estimate, metrics: &[Marginalised<'_>]| -> Vec<Vec<f64>> {
        let set: Vec<usize> = found.set.iter().filter_map(&small_id).collect();
        let squares = all_errors(&folds, metrics, &set).into_iter();
        squares.map(|of| of.iter().map(|e| e.max(f64::MIN_POSITIVE).ln()).collect()).collect()
    };
    // by joint, or over all joints
    let gains = |before: &[Vec<f64>], after: &[Vec<f64>], joint: Option<usize>| -> Vec<f64> {
        before
            .iter()
            .zip(after)
            .map(|(b, a)| match joint {
                Some(j) => b[j] - a[j],
                None => b.iter().zip(a).map(|(b, a)| b - a).sum(),
            })
            .collect()
    };
    let mut best: Option<(Predictor, Vec<Vec<f64>>)> = None;
    for scale in scales {
        let full = problem.marginalised(scale, &metric.inflated);
        let metrics = metrics(&folds, scale, &metric.inflated);
        let of = |set: Vec<usize>| admissible_part(&full, set, &named.set);
        let Some(short) = of(named.set.clone()) else { continue };
        let of_short = errors(&short, &metrics);
        let mut found = (short, of_short);
        if let Some(long) = of(extended.clone()) {
            // small terms of joints that improve: all at once; where that does not pay, one after the other, the largest first
            let of_long = errors(&long, &metrics);
            let total = |gains: Vec<f64>| gains.iter().sum::<f64>();
            let mut helped: Vec<(f64, usize)> = (0..problem.observations.joints())
                .map(|j| (total(gains(&found.1, &of_long, Some(j))), j))
                .filter(|(gain, _)| *gain > 0.0)
                .collect();
            helped.sort_by(|a, b| b.0.total_cmp(&a.0));
            let with = |set: &[usize], joints: &[(f64, usize)]| {
                let on_joints = |g: &usize| {
                    let of_candidate = problem.candidates[*g].location.joints.first();
                    !set.contains(g) && joints.iter().any(|(_, j)| Some(j) == of_candidate)
                };
                let beside = long.set.iter().copied().filter(|g| on_joints(g));
                let chosen = of(set.iter().copied().chain(beside).collect())?;
                let errors = errors(&chosen, &metrics);
                Some((chosen, errors))
            };
            let pays =
                |before: &[Vec<f64>], after: &[Vec<f64>]| total(gains(before, after, None)) > 0.0;
            match with(&found.0.set, &helped) {
                Some(all) if pays(&found.1, &all.1) => found = all,
                _ => {
                    for joint in &helped {
                        if let Some(more) = with(&found.0.set, std::slice::from_ref(joint))
                            && pays(&found.1, &more.1)
                        {
                            found = more;
                        }
                    }
                }
            }
        }
        let better = best
            .as_ref()
            .is_none_or(|(_, before)| paired_t(&gains(before, &found.1, None)) > EXPECTED_T);
        if better {
            best = Some((Predictor { estimate: found.0, scale }, found.1));
        }
    }
    let Some((mut predictor, mut errors_of_best)) = best else {
        return Predictor { estimate: named.clone(), scale: metric.scale };
    };
    // of joints whose small terms do not help together some may help alone: one after the other, the most helpful first
    let full = problem.marginalised(predictor.scale, &metric.inflated);
    let metrics = metrics(&folds, predictor.scale, &metric.inflated);
    let with = |set: &[usize], g: usize| {
        let chosen = admissible_part(&full, [set, &[g]].concat(), &named.set)?;
        let errors = chosen.set.contains(&g).then(|| errors(&chosen, &metrics))?;
        Some((chosen, errors))
    };
    let gain = |before: &[Vec<f64>], after: &[Vec<f64>]| -> f64 {
        gains(before, after, None).iter().sum()
    };
    let left = extended.iter().copied().filter(|g| !predictor.estimate.set.contains(g));
    let mut tried: Vec<(f64, usize)> = left
        .filter_map(|g| {
            let (_, errors) = with(&predictor.estimate.set, g)?;
            Some((gain(&errors_of_best, &errors), g))
        })
        .filter(|(gain, _)| *gain > 0.0)
        .collect();
    tried.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, g) in tried {
        if let Some((more, errors)) = with(&predictor.estimate.set, g)
            && gain(&errors_of_best, &errors) > 0.0
        {
            (predictor.estimate, errors_of_best) = (more, errors);
        }
    }
    predictor
}

/// Cross-validated improvement of a candidate on its joints, in standard errors.
pub(crate) fn usefulness(
    metric: &Marginalised<'_>,
    of: &Estimate,
    candidate: usize,
) -> Option<f64> {
    let (small, ids) = metric.problem.restricted(&of.set);
    let joints = &metric.problem.candidates[candidate].location.joints;
    let without: Vec<usize> =
        of.set.iter().zip(&ids).filter(|(g, _)| **g != candidate).map(|(_, id)| *id).collect();
    let folds = folds(&small);
    let gains: Vec<f64> = folds
        .iter()
        .zip(&metrics(&folds, metric.scale, &metric.inflated))
        .map(|(fold, metric)| {
            let [with, without] = [&ids, &without].map(|set| {
                let errors = fold.errors(set, metric);
                joints.iter().map(|j| errors[*j]).sum::<f64>()
            });
            (without / with).ln()
        })
        .filter(|gain| gain.is_finite())
        .collect();
    (gains.len() > 1).then(|| paired_t(&gains))
}

/// Residual of an estimate with baseline terms beside it.
pub(crate) fn with_baseline_terms(metric: &Marginalised<'_>, named: &Estimate) -> JointColumns {
    let extended = with_baseline(metric.problem, &named.set);
    let found = admissible_part(metric, extended, &named.set);
    metric.residual(&found.as_ref().unwrap_or(named).fit)
}

/// The candidates of an estimate and the baseline terms beside it.
pub(crate) fn with_baseline_terms_of(metric: &Marginalised<'_>, named: &Estimate) -> Vec<usize> {
    let extended = with_baseline(metric.problem, &named.set);
    admissible_part(metric, extended, &named.set).map_or_else(|| named.set.clone(), |a| a.set)
}

/// A set with baseline terms on every joint, where no candidate of the set has their role.
fn with_baseline(problem: &LinearProblem, set: &[usize]) -> Vec<usize> {
    let candidates = &problem.candidates;
    let mut all = set.to_vec();
    // a smooth term has baseline terms of its own
    let described = |candidate: &Candidate| {
        set.iter().any(|g| {
            candidates[*g].location == candidate.location
                && matches!(candidates[*g].kind, CandidateKind::SmoothDirections(_))
        })
    };
    for (g, candidate) in candidates.iter().enumerate() {
        if described(candidate) {
            continue;
        }
        let baseline = BASELINE.iter().any(|law| law.law().slug == candidate.slug());
        if baseline && all.iter().all(|o| *o != g && !candidates[*o].excludes(candidate)) {
            all.push(g);
        }
    }
    all
}

/// Cross-validated residual of the reference alone, by joint, in its order and in units of its noise: the model discrepancy
/// where nothing changed. None where a part of it cannot be fitted.
pub(crate) fn imperfection(problem: &LinearProblem, scale: f64) -> Option<JointColumns> {
    let rows = &problem.observations;
    let until = rows.judged_from();
    let reference = problem.restricted(&[]).0.of_rows(|row| row < until);
    let folds = folds_of(&reference, &rows.starts[..=rows.comparison.first_judged()], SHORT_BLOCKS);
    let mut left_over: JointColumns = vec![Vec::with_capacity(until); rows.joints()];
    for fold in &folds {
        // blocks follow each other without gaps
        let residual = fold.residual(&[], &fold.fitted.marginalised(scale, &[]))?;
        for (all, of_block) in left_over.iter_mut().zip(residual) {
            all.extend(of_block);
        }
    }
    Some(left_over)
}

/// The candidates of a set and the simpler relatives that could take their places.
fn with_relatives(problem: &LinearProblem, set: &[usize]) -> Vec<usize> {
    let mut all = set.to_vec();
    for &g in set {
        all.extend(set_without(problem, set, g));
    }
    all.sort_unstable();
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::{design, ur5};

    /// Friction below the materiality threshold helps a prediction, also beside a law of the whole arm.
    #[test]
    fn small_terms_are_kept_beside_arm_level_effect() {
        let chain = ur5();
        let friction = |j: usize, v: f64| if j == 2 { 0.3 * v } else { 0.0 };
        let design = design(&chain, &chain, friction);
        let problem = design.problem(&OperatingPoint::of(design.joints()));
        let of = |slug: &str, joints: &[usize]| {
            let is = |g: &Candidate| g.slug() == slug && g.location.joints == joints;
            problem.candidates.iter().position(is).unwrap()
        };
        let metric = problem.marginalised(0.0, &[]);
        let named = fit_set(&metric, vec![of("gravity_direction", &[])]).unwrap();
        let found = predictor(&metric, &named).estimate;
        let viscous = of("viscous_friction", &[2]);
        assert!(found.set.contains(&viscous) && found.set.contains(&named.set[0]));
        let coefficient = found.fit.of_candidate(&problem.candidates[viscous])[0];
        assert!((coefficient - 0.3).abs() < 0.01, "{coefficient}");
    }
}
