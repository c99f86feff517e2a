//! Viscous friction.

use crate::law::{
    Effect, Export, JointMotion, JointState, Law, LookAlike, Onset, Parameter, Place, Scope,
};

/// `f = b v`.
pub struct ViscousFriction;

const LAW: Law = Law {
    slug: "viscous_friction",
    title: "viscous friction",
    formula: "f = b v",
    scope: Scope::Joint,
    places: &[Place::Viscous],
    parameters: &[Parameter::non_negative("coefficient", "N m s/rad", "N s/m")],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "time_delay",
            separated_by: "the same amplitude at two frequencies: friction grows with the speed, a delay with its cube",
        },
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "slow and fast runs: at one speed the two are the same column",
        },
        LookAlike {
            slug: "friction_drift",
            separated_by: "a second run on the warm arm: drift is gone, viscous friction stays",
        },
    ],
    export: Export { urdf: Some("damping"), mjcf: Some("damping") },
};

impl Effect for ViscousFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.velocity.to_vec()]
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * state.velocity
    }
}
