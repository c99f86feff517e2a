//! Inertia of the rotor, reflected through the gear.

use crate::law::{Effect, Export, JointMotion, Law, LookAlike, Parameter, Place, Scope};

/// `f = Ia dv/dt`.
pub struct RotorInertia;

const LAW: Law = Law {
    slug: "rotor_inertia",
    title: "rotor inertia",
    formula: "f = Ia ddq",
    scope: Scope::Joint,
    places: &[Place::Inertia],
    parameters: &[Parameter::non_negative("inertia", "kg m2", "kg")],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "U_33",
            separated_by: "nothing on the first rotational joint, where rotor and link turn together; the rotor inertia of the data sheet times the squared gear ratio",
        },
        LookAlike {
            slug: "joint_elasticity",
            separated_by: "faster motion: elasticity resonates and moves the other joints",
        },
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "motion of the other joints: a link is felt by them, a rotor is not",
        },
    ],
    export: Export { urdf: None, mjcf: Some("armature") },
};

impl Effect for RotorInertia {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.acceleration.to_vec()]
    }

    fn added_inertia(&self, parameters: &[f64]) -> f64 {
        parameters[0]
    }
}
