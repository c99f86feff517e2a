//! Coulomb friction.

use crate::law::{Admissible, Effect, Export, JointMotion, Law, LookAlike, Parameter};

/// `f = Fc sign(v)`; at rest anything within `±Fc`.
pub struct CoulombFriction;

const LAW: Law = Law {
    slug: "coulomb_friction",
    title: "Coulomb friction",
    formula: "f = Fc sign(v); at rest anything within +-Fc",
    parameters: &[Parameter {
        name: "level",
        unit_rotational: "N m",
        unit_translational: "N",
        admissible: Admissible::NonNegative,
    }],
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

/// The direction of motion, fading linearly to zero below the resolved speed.
pub fn direction(velocity: f64, speed_resolution: f64) -> f64 {
    if velocity.abs() >= speed_resolution {
        if velocity == 0.0 { 0.0 } else { velocity.signum() }
    } else {
        velocity / speed_resolution
    }
}

impl Effect for CoulombFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        let sign = |&v: &f64| direction(v, motion.speed_resolution);
        vec![motion.velocity.iter().map(sign).collect()]
    }

    fn dry_friction(&self, parameters: &[f64]) -> f64 {
        parameters[0]
    }
}
