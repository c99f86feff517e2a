//! Drag that grows with the square of the speed.

use crate::law::{
    Effect, Export, JointMotion, JointState, Law, LookAlike, Parameter, Place, Scope,
};

/// `f = c v |v|`.
pub struct QuadraticDrag;

const LAW: Law = Law {
    slug: "quadratic_drag",
    title: "quadratic drag",
    formula: "f = c v abs(v)",
    scope: Scope::Joint,
    places: &[Place::Drag],
    parameters: &[Parameter::non_negative("coefficient", "N m s2/rad2", "N s2/m2")],
    contains: &[],
    look_alikes: &[
        LookAlike { slug: "viscous_friction", separated_by: "a ladder of speeds" },
        LookAlike { slug: "coulomb_friction", separated_by: "a ladder of speeds" },
    ],
    export: Export::NONE,
};

impl Effect for QuadraticDrag {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.velocity.iter().map(|v| v * v.abs()).collect()]
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * state.velocity * state.velocity.abs()
    }
}
