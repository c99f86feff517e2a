//! A wrong zero of a joint encoder.

use std::f64::consts::FRAC_PI_2;

use armident_dynamics::{JointGeometry, RigidArm, inverse_dynamics_of_motion};

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::{STEP, derivative};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, Onset, OperatingTerm, Parameter, Scope};
use crate::mechanism::{ArmFrames, Mechanism};
use crate::motion::{ArmColumns, WholeArmMotion};

/// `recorded q = true q + offset`.
pub struct EncoderOffset;

const LAW: Law = Law {
    slug: "encoder_offset",
    title: "encoder offset",
    formula: "recorded q = true q + offset",
    scope: Scope::ThroughJoint,
    roles: &[LawRole::Zero],
    parameters: &[Parameter::any("offset", "rad", "m").main()],
    operating: Some(OperatingTerm::EncoderZero),
    fits_alone: true,
    look_alikes: &[
        LookAlike {
            slug: "gravity_direction",
            separated_by: "Move the other joints, or measure the base with a level.",
        },
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "Move the joints before it to several poses; on the last joint that gravity loads, a rotated centre of mass is equivalent.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "The zero of an encoder is wrong: the recorded position differs from the true one by a constant.",
    sizes: &[
        "One degree on an arm that carries 100 N m when level: 1.7 N m (computed, 100 sin 1 degree)",
    ],
    signature: "The change of gravity with the angle: all joints before it feel it. On the last joint that carries weight it is the same as a turned centre of mass.",
    example: Example::new("shoulder_lift_joint", &[0.02], Against::Position),
};

impl Effect for EncoderOffset {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    /// The derivative of the rigid effort by the position of the joint, with the opposite sign.
    fn arm_columns(&self, joint: usize, motion: &WholeArmMotion<'_>) -> ArmColumns {
        vec![derivative(motion, STEP, |step| {
            let mut position = motion.position.to_vec();
            position[joint].iter_mut().for_each(|q| *q -= step);
            inverse_dynamics_of_motion(motion.arm, &position, motion.velocity, motion.acceleration)
        })]
    }

    fn mechanism(&self, _parameters: &[f64]) -> Mechanism {
        Mechanism::Arm
    }

    /// In recorded positions the joint has another zero.
    fn change_arm(
        &self,
        parameters: &[f64],
        joint: usize,
        _frames: &ArmFrames,
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

    /// The columns are those of a small offset: more than a quarter turn is none.
    fn admits_fit(&self, _shape: &[f64], coefficients: &[f64]) -> bool {
        coefficients[0].abs() < FRAC_PI_2
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, side) = context.draw_joint(random);
        Some(DrawnEffect::new(joint, 0.03, move |x| vec![side * x]).at_most(0.12))
    }
}
