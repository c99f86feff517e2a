//! Viscous friction.

use crate::law::{Admissible, Effect, Export, JointMotion, JointState, Law, LookAlike, Parameter};

/// `f = b v`.
pub struct ViscousFriction;

const LAW: Law = Law {
    slug: "viscous_friction",
    title: "viscous friction",
    formula: "f = b v",
    parameters: &[Parameter {
        name: "coefficient",
        unit_rotational: "N m s/rad",
        unit_translational: "N s/m",
        admissible: Admissible::NonNegative,
    }],
    look_alikes: &[
        LookAlike {
            slug: "time_delay",
            separated_by: "the same amplitude at two frequencies: friction grows with the speed, a \
                           delay with its cube",
        },
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "slow and fast runs: at one speed the two are the same column",
        },
    ],
    export: Export { urdf: Some("damping"), mjcf: Some("damping") },
};

impl Effect for ViscousFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.velocity.to_vec()]
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * state.velocity
    }
}
