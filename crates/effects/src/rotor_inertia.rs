//! Inertia of the rotor, reflected through the gear.

use crate::law::{Admissible, Effect, Export, JointMotion, Law, LookAlike, Parameter};

/// `f = Ia q̈`.
pub struct RotorInertia;

const LAW: Law = Law {
    slug: "rotor_inertia",
    title: "rotor inertia",
    formula: "f = Ia ddq",
    parameters: &[Parameter {
        name: "inertia",
        unit_rotational: "kg m2",
        unit_translational: "kg",
        admissible: Admissible::NonNegative,
    }],
    look_alikes: &[LookAlike {
        slug: "U_33",
        separated_by: "nothing on the first rotational joint, where rotor and link turn together; \
                       the data sheet's rotor inertia times the squared gear ratio",
    }],
    export: Export { urdf: None, mjcf: Some("armature") },
};

impl Effect for RotorInertia {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.acceleration.to_vec()]
    }

    fn added_inertia(&self, parameters: &[f64]) -> f64 {
        parameters[0]
    }
}
