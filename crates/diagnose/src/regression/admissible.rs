//! Whether coefficients may carry the name of their law.

use crate::design::candidate::{Group, Meaning};
use crate::design::linear_problem::Problem;
use crate::regression::marginalised::Fit;
use armident_effects::{EffectOnJoint, Scope, admitted_beside, effect};
/// Whether the coefficients of a group may carry its name.
pub(crate) fn admissible(problem: &Problem, group: &Group, fit: &Fit) -> bool {
    let Meaning::Law(slug) = group.meaning else { return true };
    let Some(law) = effect(slug) else { return false };
    let coefficients = fit.of_group(group);
    match law.law().scope {
        Scope::Joint => {
            let parameters = law.parameters(&group.shape, &coefficients);
            match group.site.joints.first().map(|j| &problem.known[*j][..]) {
                None | Some([]) => law.admits(&parameters),
                Some(known) => admitted_beside(
                    known,
                    &EffectOnJoint::new(slug, known[0].joint.as_str(), parameters),
                ),
            }
        }
        Scope::Neighbours => law.admits(&law.parameters(&group.shape, &coefficients)),
        // the columns are those of a small tilt: what asks for more than a quarter turn is none
        Scope::Arm if group.slug() == "gravity_direction" => {
            coefficients.iter().all(|c| c.abs() < std::f64::consts::FRAC_PI_2)
        }
        // so are those of a joint that is off by a little
        Scope::ThroughJoint if group.slug() == "encoder_offset" => {
            coefficients[0].abs() < std::f64::consts::FRAC_PI_2
        }
        // a load has mass
        Scope::Link => group.slug() != "payload" || coefficients[0] > 0.0,
        // the simulated motion of the link, about as large as simulated, and the inertia of a motor
        Scope::ThroughJoint if !group.shape.is_empty() => {
            (0.3..1.7).contains(&coefficients[0]) && coefficients[1] >= 0.0
        }
        // a compliance and an inertia, both positive; an encoder offset has one column and any sign
        Scope::ThroughJoint if coefficients.len() > 1 => {
            coefficients[0] > 0.0 && coefficients[1] >= 0.0
        }
        _ => true,
    }
}

/// Whether all groups of a set are admissible with its fit.
pub(crate) fn all_admissible(problem: &Problem, set: &[usize], fit: &Fit) -> bool {
    set.iter().all(|g| admissible(problem, &problem.groups[*g], fit))
}
