//! A link whose mass, centre of mass or inertia are not those of the model.

use armident_dynamics::{ParameterColumns, RigidArm};
use armident_kinematics::InertialParameters;

use crate::law::{
    ArmColumns, ArmMotion, Effect, Export, Law, LookAlike, Onset, Parameter, Place, Scope,
};

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

    fn onset(&self) -> Onset {
        Onset::OftenOfLastLink
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

    fn mechanism(&self, _parameters: &[f64]) -> crate::Mechanism {
        crate::Mechanism::Arm
    }

    /// Mass and first moment in the URDF frame of the link; the inertia changes as if the mass were in
    /// one point.
    fn change_arm(
        &self,
        parameters: &[f64],
        joint: usize,
        frames: &crate::ArmFrames,
        arm: &mut RigidArm,
    ) {
        let [mass, x, y, z] = [parameters[0], parameters[1], parameters[2], parameters[3]];
        let mut change = [0.0; 10];
        change[..4].copy_from_slice(&[mass, x, y, z]);
        if mass != 0.0 {
            let inertia = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
            change[4..].iter_mut().zip(inertia).for_each(|(c, i)| *c = i / mass);
        }
        let change = InertialParameters::from_array(&change);
        arm.links[joint] = arm.links[joint].plus(&change.expressed_in(&frames.link_in_e[joint]));
    }
}
