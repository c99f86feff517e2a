//! Admissibility: whether the coefficients of a fit have the signs and sizes that their laws allow.
//!
//! Method: unconstrained fit, then a check of every candidate by its law; a candidate on a joint with known effects may be a
//! decrease of these.
//! References: own.

use crate::design::candidate::Candidate;
use crate::design::linear_problem::LinearProblem;
use crate::regression::marginalised::LeastSquaresFit;
use armident_effects::{EffectOnJoint, Scope};

/// Whether the coefficients of a candidate are admissible for its law.
pub(crate) fn admissible(
    problem: &LinearProblem,
    candidate: &Candidate,
    fit: &LeastSquaresFit,
) -> bool {
    let Some(law) = candidate.law() else { return true };
    let coefficients = fit.of_candidate(candidate);
    // a law of one joint may be a decrease of a known effect there
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
