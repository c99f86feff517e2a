//! Coulomb friction.

use crate::law::{Effect, Export, JointMotion, Law, LookAlike, Onset, Parameter, Place, Scope};

/// `f = Fc sign(v)`; at rest anything within `±Fc`.
pub struct CoulombFriction;

const LAW: Law = Law {
    slug: "coulomb_friction",
    title: "Coulomb friction",
    formula: "f = Fc sign(v); at rest anything within +-Fc",
    scope: Scope::Joint,
    places: &[Place::Dry],
    parameters: &[Parameter::non_negative("level", "N m", "N")],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "torque_offset",
            separated_by: "motion in both directions through the same positions",
        },
        LookAlike {
            slug: "viscous_friction",
            separated_by: "slow and fast runs: at one speed the two are the same column",
        },
        LookAlike {
            slug: "presliding_hysteresis",
            separated_by: "small slow reversals: presliding follows the travel since the reversal",
        },
    ],
    export: Export { urdf: Some("friction"), mjcf: Some("frictionloss") },
};

impl Effect for CoulombFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.direction.to_vec()]
    }

    fn dry_friction(&self, parameters: &[f64], _state: &crate::JointState) -> crate::DryFriction {
        crate::DryFriction::both(parameters[0])
    }
}
