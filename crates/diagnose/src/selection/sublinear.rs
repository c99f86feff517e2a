//! Sublinear viscous friction, beside the findings.
//!
//! Findings and their parameters are estimated with linear viscous friction. Where friction is sublinear, a line errs at low
//! and at high speed, so a prediction has the sublinear term if its coefficient is significant and the cross-validated error
//! does not rise, as `identify` chooses it.
//!
//! Hypothesis: the coefficient of the sublinear term is zero (t test with block-jackknife standard error).
//! References: own.

use armident_effects::{Baseline, SublinearViscousFriction};
use armident_inference::student_t_975;
use armident_inference::time_blocks;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;
use crate::regression::elimination::InflatedLink;
use crate::regression::fit_set::{Estimate, admissible_part, fit_set};
use crate::regression::folds::{LEFT_OUT_PER_RECORDING, fold_errors};
use crate::regression::marginalised::Marginalised;
use crate::selection::cross_validation::Predictor;
use crate::selection::solution::Selection;
use crate::uncertainty::jackknife::Jackknife;

/// The predictor with sublinear friction on the joints where it is significant, and the problem with these candidates after
/// those of the selection; none where no joint has any.
pub(crate) fn with_sublinear_friction(
    design: &Design<'_>,
    selection: &Selection,
    best: &Predictor,
) -> Option<(LinearProblem, Predictor)> {
    let Predictor { estimate, scale } = best;
    let scale = *scale;
    let at = design.at(&selection.point);
    let of = |problem: &LinearProblem, estimate: &Estimate, sublinear_terms: &[usize]| {
        beside(&problem.marginalised(scale, &selection.inflated), estimate, sublinear_terms)
    };
    let joints = {
        let (mut small, set) = selection.problem.restricted(&estimate.set);
        let estimate = fit_set(&small.marginalised(scale, &selection.inflated), set)?;
        let sublinear_terms = push_sublinear(design, &at, &mut small, 0..design.joints());
        sublinear_joints(&small, &estimate, &sublinear_terms, (scale, &selection.inflated))?
    };
    let mut problem = selection.problem.clone();
    let sublinear_terms = push_sublinear(design, &at, &mut problem, joints);
    let estimate = of(&problem, estimate, &sublinear_terms)?;
    Some((problem, Predictor { estimate, scale }))
}

/// Candidates of sublinear friction on these joints, where their efforts were recorded.
pub(crate) fn push_sublinear(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    joints: impl IntoIterator<Item = usize>,
) -> Vec<usize> {
    let push = |joint: usize| match problem.effort[joint].is_empty() {
        true => None,
        false => design.push_joint_law(problem, at, &SublinearViscousFriction, joint, &[]),
    };
    joints.into_iter().filter_map(push).collect()
}

/// Joints with significant sublinear friction beside an estimate.
pub(crate) fn sublinear_joints(
    problem: &LinearProblem,
    estimate: &Estimate,
    sublinear_terms: &[usize],
    (scale, inflated): (f64, &[InflatedLink]),
) -> Option<Vec<usize>> {
    let metric = problem.marginalised(scale, inflated);
    let with = |sublinear_terms: &[usize]| beside(&metric, estimate, sublinear_terms);
    let is_possible =
        |term: &usize| may_be_sublinear(problem, estimate, *term) && with(&[*term]).is_some();
    let possible: Vec<usize> = sublinear_terms.iter().copied().filter(is_possible).collect();
    let all = with(&possible)?;
    let jackknife = Jackknife::of(&metric, &all);
    let starts = &problem.observations.starts;
    let quantile = student_t_975(time_blocks(starts, LEFT_OUT_PER_RECORDING).len() as f64 - 1.0);
    let errors = |set: &[usize]| fold_errors(problem, set, scale, inflated);
    let (before, after) = (errors(&estimate.set), errors(&all.set));
    let shown = |term: &usize| {
        let candidate = &problem.candidates[*term];
        let (covariance, _) = jackknife.covariance(&metric, &all, candidate);
        let in_errors = all.fit.of_candidate(candidate)[0] / covariance[0][0].sqrt();
        let joint = candidate.location.joints[0];
        let gain: f64 = before.iter().zip(&after).map(|(b, a)| (b[joint] / a[joint]).ln()).sum();
        (in_errors > quantile && gain > 0.0).then_some(joint)
    };
    let there = possible.iter().filter(|term| all.set.contains(term));
    let joints: Vec<usize> = there.filter_map(shown).collect();
    (!joints.is_empty()).then_some(joints)
}

/// The estimate with admissible sublinear terms, instead of viscous friction where that is inadmissible beside them; none
/// where another candidate is.
pub(crate) fn beside(
    metric: &Marginalised<'_>,
    estimate: &Estimate,
    sublinear_terms: &[usize],
) -> Option<Estimate> {
    let candidates = &metric.problem.candidates;
    let gives_way = |g: &usize| {
        candidates[*g].has(|law| law.baseline == Some(Baseline::Viscous))
            && sublinear_terms
                .iter()
                .any(|term| candidates[*term].location == candidates[*g].location)
    };
    let stays: Vec<usize> = estimate.set.iter().copied().filter(|g| !gives_way(g)).collect();
    admissible_part(metric, [&estimate.set[..], sublinear_terms].concat(), &stays)
}

/// Whether a joint may have sublinear friction beside an estimate: not where a candidate has its role, or dry friction varies
/// with the speed.
fn may_be_sublinear(problem: &LinearProblem, estimate: &Estimate, term: usize) -> bool {
    let term = &problem.candidates[term];
    let is_nonlinear = |other: &Candidate| {
        let is_smooth = matches!(other.kind, CandidateKind::SmoothDirections(_));
        other.location == term.location && (other.has(|law| law.varies_with_speed) || is_smooth)
    };
    let mut others = estimate.set.iter().map(|g| &problem.candidates[*g]);
    !others.any(|other| other.excludes(term) || is_nonlinear(other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::{design, ur5};
    use armident_model::OperatingPoint;
    use armident_model::is_sublinear;

    /// Of two joints with viscous friction one is sublinear; findings stay linear.
    #[test]
    fn distinguishes_sublinear_from_linear_friction() {
        const SUBLINEAR: usize = 0;
        let chain = ur5();
        let design = design(&chain, &chain, |j, v| match j {
            SUBLINEAR => 2.0 * v.signum() + 3.0 * v.signum() * v.abs().sqrt(),
            1 => 2.0 * v.signum() + 3.0 * v,
            _ => 0.0,
        });
        let point = OperatingPoint::of(design.joints());
        let problem = design.problem(&point);
        let of = |slug: &str, joint: usize| {
            let is = |g: &Candidate| g.slug() == slug && g.location.joints == [joint];
            problem.candidates.iter().position(is).unwrap()
        };
        let named = ["viscous_friction", "coulomb_friction"];
        let set = named.iter().flat_map(|slug| [of(slug, 0), of(slug, 1)]).collect();
        let viscous = of("viscous_friction", SUBLINEAR);
        let estimate = fit_set(&problem.marginalised(0.0, &[]), set).unwrap();
        let best = Predictor { estimate: estimate.clone(), scale: 0.0 };
        let (inflated, inconclusive) = (Vec::new(), Vec::new());
        let selection = Selection { problem, estimate, scale: 0.0, inflated, point, inconclusive };

        let (problem, sublinear) = with_sublinear_friction(&design, &selection, &best).unwrap();
        let sublinear_terms: Vec<&Candidate> = sublinear
            .estimate
            .set
            .iter()
            .map(|g| &problem.candidates[*g])
            .filter(|g| is_sublinear(g.slug()))
            .collect();
        let [term] = sublinear_terms[..] else { panic!("{sublinear_terms:?}") };
        assert_eq!(term.location.joints, [SUBLINEAR]);
        let coefficient = sublinear.estimate.fit.of_candidate(term)[0];
        assert!((coefficient - 3.0).abs() < 0.05, "{coefficient}");

        // without the viscous friction its sublinear part is dropped too
        let metric = problem.marginalised(0.0, &[]);
        let rest = selection.estimate.set.iter().copied().filter(|g| *g != viscous).collect();
        let without = fit_set(&metric, rest).unwrap();
        let model = sublinear.beside(&metric, &selection.estimate, &without).unwrap();
        assert!(model.set.iter().all(|g| !is_sublinear(problem.candidates[*g].slug())));
    }
}
