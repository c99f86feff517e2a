//! Dry friction that grows with the load the gear carries.

use crate::law::{Effect, Export, JointMotion, Law, LookAlike, Parameter, Place, Scope, column};

/// `f = (Fc + µ |rigid|) sign(v)`.
pub struct LoadDependentFriction;

const LAW: Law = Law {
    slug: "load_dependent_friction",
    title: "load-dependent friction",
    formula: "f = (Fc + mu abs(rigid)) sign(v)",
    scope: Scope::Joint,
    places: &[Place::Dry],
    parameters: &[
        Parameter::non_negative("level", "N m", "N"),
        Parameter::non_negative("load_coefficient", "1", "1"),
    ],
    contains: &["coulomb_friction"],
    look_alikes: &[
        LookAlike {
            slug: "torque_scale",
            separated_by: "up and down through the same poses: a gain keeps its sign, friction changes it",
        },
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "the same motion with another payload or in another pose",
        },
    ],
    export: Export::NONE,
};

impl Effect for LoadDependentFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        let load =
            column(motion.velocity.len(), |t| motion.direction[t] * motion.rigid_effort[t].abs());
        vec![motion.direction.to_vec(), load]
    }

    fn dry_friction(&self, parameters: &[f64], state: &crate::JointState) -> crate::DryFriction {
        crate::DryFriction::both(parameters[0] + parameters[1] * state.load.abs())
    }
}
