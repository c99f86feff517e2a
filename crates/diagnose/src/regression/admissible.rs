//! Whether coefficients may carry the name of their law.

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::linear_problem::LinearProblem;
use crate::regression::marginalised::LeastSquaresFit;
use armident_effects::{EffectOnJoint, Scope, admitted_beside, effect};
/// Whether the coefficients of a candidate may carry its name.
pub(crate) fn admissible(
    problem: &LinearProblem,
    candidate: &Candidate,
    fit: &LeastSquaresFit,
) -> bool {
    let CandidateKind::Law(slug) = candidate.kind else { return true };
    let Some(law) = effect(slug) else { return false };
    let coefficients = fit.of_candidate(candidate);
    match law.law().scope {
        Scope::Joint => {
            let parameters = law.parameters(&candidate.shape, &coefficients);
            match candidate.location.joints.first().map(|j| &problem.known[*j][..]) {
                None | Some([]) => law.admits(&parameters),
                Some(known) => admitted_beside(
                    known,
                    &EffectOnJoint::new(slug, known[0].joint.as_str(), parameters),
                ),
            }
        }
        Scope::Neighbours => law.admits(&law.parameters(&candidate.shape, &coefficients)),
        // the columns are those of a small tilt: what asks for more than a quarter turn is none
        Scope::Arm if candidate.slug() == "gravity_direction" => {
            coefficients.iter().all(|c| c.abs() < std::f64::consts::FRAC_PI_2)
        }
        // so are those of a joint that is off by a little
        Scope::ThroughJoint if candidate.slug() == "encoder_offset" => {
            coefficients[0].abs() < std::f64::consts::FRAC_PI_2
        }
        // a load has mass
        Scope::Link => candidate.slug() != "payload" || coefficients[0] > 0.0,
        // the simulated motion of the link, about as large as simulated, and the inertia of a motor
        Scope::ThroughJoint if !candidate.shape.is_empty() => {
            (0.3..1.7).contains(&coefficients[0]) && coefficients[1] >= 0.0
        }
        // a compliance and an inertia, both positive; an encoder offset has one column and any sign
        Scope::ThroughJoint if coefficients.len() > 1 => {
            coefficients[0] > 0.0 && coefficients[1] >= 0.0
        }
        _ => true,
    }
}

/// Whether all candidates of a set are admissible with its fit.
pub(crate) fn all_admissible(
    problem: &LinearProblem,
    set: &[usize],
    fit: &LeastSquaresFit,
) -> bool {
    set.iter().all(|g| admissible(problem, &problem.candidates[*g], fit))
}
