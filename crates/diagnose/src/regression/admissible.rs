//! Whether coefficients may carry the name of their law.

use crate::design::candidate::Candidate;
use crate::design::linear_problem::LinearProblem;
use crate::regression::marginalised::LeastSquaresFit;
use armident_effects::{EffectOnJoint, Scope};
/// Whether the coefficients of a candidate may carry its name.
pub(crate) fn admissible(
    problem: &LinearProblem,
    candidate: &Candidate,
    fit: &LeastSquaresFit,
) -> bool {
    let Some(law) = candidate.law() else { return true };
    let coefficients = fit.of_candidate(candidate);
    // a law of one joint may be less of what is known there
    let known = candidate.location.joints.first().map(|j| &problem.known[*j][..]);
    if let (Scope::Joint, Some(known @ [first, ..])) = (law.law().scope, known) {
        let parameters = law.parameters(&candidate.shape, &coefficients);
        let change = EffectOnJoint::new(law.slug(), first.joint.as_str(), parameters);
        return problem.library.admitted_beside(known, &change);
    }
    law.admits_fit(&candidate.shape, &coefficients)
}

/// Whether all candidates of a set are admissible with its fit.
pub(crate) fn all_admissible(
    problem: &LinearProblem,
    set: &[usize],
    fit: &LeastSquaresFit,
) -> bool {
    set.iter().all(|g| admissible(problem, &problem.candidates[*g], fit))
}
