//! Constant offset of the effort channel.

use crate::law::{
    Effect, Export, JointMotion, JointState, Law, LookAlike, Onset, Parameter, Place, Scope,
};

/// `f = c`.
pub struct TorqueOffset;

const LAW: Law = Law {
    slug: "torque_offset",
    title: "effort offset",
    formula: "f = c",
    scope: Scope::Joint,
    places: &[Place::Constant],
    parameters: &[Parameter::any("offset", "N m", "N")],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "asymmetric_coulomb_friction",
            separated_by: "nothing on one joint: the two are the same effort; a run with the drive off shows the offset alone",
        },
        LookAlike {
            slug: "payload",
            separated_by: "other poses of the arm: a load turns with gravity, an offset does not",
        },
    ],
    export: Export::NONE,
};

impl Effect for TorqueOffset {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![vec![1.0; motion.velocity.len()]]
    }

    fn smooth_effort(&self, parameters: &[f64], _state: &JointState) -> f64 {
        parameters[0]
    }
}
