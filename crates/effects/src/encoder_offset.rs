//! A wrong zero of a joint encoder.

use armident_dynamics::{JointGeometry, RigidArm, inverse_dynamics_of_motion};

use crate::arm_motion::{STEP, derivative};
use crate::law::{
    ArmColumns, ArmMotion, Effect, Export, Law, LookAlike, Onset, Parameter, Place, Scope,
};

/// `recorded q = true q + offset`.
pub struct EncoderOffset;

const LAW: Law = Law {
    slug: "encoder_offset",
    title: "encoder offset",
    formula: "recorded q = true q + offset",
    scope: Scope::ThroughJoint,
    places: &[Place::Zero],
    parameters: &[Parameter::any("offset", "rad", "m")],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "gravity_direction",
            separated_by: "motion of the other joints, or a level on the base",
        },
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "several poses of the joints before it; on the last joint that gravity loads, nothing: a turned centre of mass is the same",
        },
    ],
    export: Export::NONE,
};

impl Effect for EncoderOffset {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    /// The derivative of the rigid effort by the position of the joint, with the opposite sign.
    fn arm_columns(&self, joint: usize, motion: &ArmMotion<'_>) -> ArmColumns {
        vec![derivative(motion, STEP, |step| {
            let mut position = motion.position.to_vec();
            position[joint].iter_mut().for_each(|q| *q -= step);
            inverse_dynamics_of_motion(motion.arm, &position, motion.velocity, motion.acceleration)
        })]
    }

    fn mechanism(&self, _parameters: &[f64]) -> crate::Mechanism {
        crate::Mechanism::Arm
    }

    /// In recorded positions the joint has another zero.
    fn change_arm(
        &self,
        parameters: &[f64],
        joint: usize,
        _frames: &crate::ArmFrames,
        arm: &mut RigidArm,
    ) {
        let JointGeometry { kind, mut frame, .. } = arm.joints[joint];
        if kind.is_rotational() {
            frame.theta_rad -= parameters[0];
        } else {
            frame.d_m -= parameters[0];
        }
        arm.joints[joint] = JointGeometry::new(kind, frame);
    }
}
