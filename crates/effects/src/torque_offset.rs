//! Constant offset of the effort channel.

use crate::law::{Admissible, Effect, Export, JointMotion, JointState, Law, LookAlike, Parameter};

/// `f = c`.
pub struct TorqueOffset;

const LAW: Law = Law {
    slug: "torque_offset",
    title: "effort offset",
    formula: "f = c",
    parameters: &[Parameter {
        name: "offset",
        unit_rotational: "N m",
        unit_translational: "N",
        admissible: Admissible::Any,
    }],
    look_alikes: &[LookAlike {
        slug: "asymmetric_coulomb_friction",
        separated_by: "nothing on one joint: the two are the same effort; a run with the drive off \
                       shows the offset alone",
    }],
    export: Export { urdf: None, mjcf: None },
};

impl Effect for TorqueOffset {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![vec![1.0; motion.velocity.len()]]
    }

    fn smooth_effort(&self, parameters: &[f64], _state: &JointState) -> f64 {
        parameters[0]
    }
}
