//! A link whose mass, centre of mass or inertia are not those of the model.

use armident_dynamics::ParameterColumns;

use crate::law::{ArmColumns, ArmMotion, Effect, Export, Law, LookAlike, Parameter, Place, Scope};

/// `f = Y_link Δπ`.
pub struct LinkInertiaError;

const LAW: Law = Law {
    slug: "link_inertia_error",
    title: "wrong link inertia",
    formula: "f = Y_link delta_pi",
    scope: Scope::Link,
    places: &[Place::Link],
    parameters: &[
        Parameter::any("delta_mass", "kg", "kg"),
        Parameter::any("delta_mcx", "kg m", "kg m"),
        Parameter::any("delta_mcy", "kg m", "kg m"),
        Parameter::any("delta_mcz", "kg m", "kg m"),
    ],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "payload",
            separated_by: "on the last link nothing: a payload is an inertial error; with and without the load",
        },
        LookAlike {
            slug: "torque_scale",
            separated_by: "the efforts of the joints before: a link loads all of them",
        },
    ],
    export: Export { urdf: Some("inertial"), mjcf: Some("inertial") },
};

impl Effect for LinkInertiaError {
    fn law(&self) -> &'static Law {
        &LAW
    }

    /// The ten columns of the link's standard parameters.
    fn arm_columns(&self, joint: usize, motion: &ArmMotion<'_>) -> ArmColumns {
        let columns = ParameterColumns::standard(motion.arm.dof());
        let wanted: Vec<usize> = (10 * joint..10 * (joint + 1)).collect();
        let by_joint: Vec<Vec<Vec<f64>>> = (0..motion.arm.dof())
            .map(|row| {
                let (q, v, a) = (motion.position, motion.velocity, motion.acceleration);
                columns.of_motion(motion.arm, row, q, v, a, &wanted)
            })
            .collect();
        (0..10).map(|k| by_joint.iter().map(|joint| joint[k].clone()).collect()).collect()
    }
}
