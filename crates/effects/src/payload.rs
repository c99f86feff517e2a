//! A load on the last link.

use armident_dynamics::RigidArm;
use armident_kinematics::InertialParameters;
use nalgebra::{Matrix3, Vector3};

use crate::LinkInertiaError;
use crate::law::{
    ArmColumns, ArmMotion, Effect, Export, Law, LookAlike, Onset, Parameter, Place, Scope,
};

/// `f = Y_last π(m, com)`.
pub struct Payload;

const LAW: Law = Law {
    slug: "payload",
    title: "payload",
    formula: "a rigid mass fixed to the last link, not in the model",
    scope: Scope::Link,
    places: &[Place::Link],
    parameters: &[
        Parameter::non_negative("mass", "kg", "kg"),
        Parameter::any("com_x", "m", "m"),
        Parameter::any("com_y", "m", "m"),
        Parameter::any("com_z", "m", "m"),
    ],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "the same motion with and without the load",
        },
        LookAlike {
            slug: "gravity_direction",
            separated_by: "the first axis, if it is vertical: only a tilt loads it with gravity",
        },
    ],
    export: Export { urdf: Some("inertial"), mjcf: Some("inertial") },
};

impl Effect for Payload {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    /// The ten columns of the last link's standard parameters.
    fn arm_columns(&self, _joint: usize, motion: &ArmMotion<'_>) -> ArmColumns {
        LinkInertiaError.arm_columns(motion.arm.dof() - 1, motion)
    }

    fn mechanism(&self, _parameters: &[f64]) -> crate::Mechanism {
        crate::Mechanism::Arm
    }

    /// A point mass at its centre, in the URDF frame of the link that the last joint moves.
    fn change_arm(
        &self,
        parameters: &[f64],
        _joint: usize,
        frames: &crate::ArmFrames,
        arm: &mut RigidArm,
    ) {
        let last = arm.dof() - 1;
        let centre_m = Vector3::from_column_slice(&parameters[1..4]);
        let load = InertialParameters::from_com(parameters[0], centre_m, Matrix3::zeros());
        arm.links[last] = arm.links[last].plus(&load.expressed_in(&frames.link_in_e[last]));
    }
}
