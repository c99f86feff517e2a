//! A distance between two axes that is not the given one.

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};

use crate::columns::{STEP, derivative};
use crate::effect::Effect;
use crate::law::{Law, LocationKind, LookAlike, Naming, Parameter, Scope};
use crate::mechanism::{ArmFrames, Mechanism};
use crate::motion::{ArmColumns, WholeArmMotion};

/// `b` and `d'` of the joint's driving-axis frame beyond the given ones (S.-K. Lin 1992, eq. 3): the length of the common normal from
/// the axis before, and the offset along the joint's own axis. Its estimator is a scan of the input checks: inertial errors of all links
/// are free beside it.
pub struct LinkGeometryError;

const LAW: Law = Law {
    slug: "link_geometry_error",
    title: "link geometry error",
    formula: "the common normal from the axis before is longer by normal_error, the offset along the axis by offset_error",
    scope: Scope::ThroughJoint,
    location: LocationKind::Joints,
    parameters: &[
        Parameter::any("normal_error", "m", "m").main(),
        Parameter::any("offset_error", "m", "m").main(),
    ],
    naming: Naming::FromChecks,
    look_alikes: &[
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "Move both joints fast: coupling efforts grow with the distance of the axes, weight alone does not.",
        },
        LookAlike { slug: "encoder_offset", separated_by: "Measure the distance of the axes." },
    ],
    ..Law::BLANK
};

impl Effect for LinkGeometryError {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn arm_columns(&self, joint: usize, motion: &WholeArmMotion<'_>) -> ArmColumns {
        let along = |parameters: fn(f64) -> [f64; 2]| {
            derivative(motion, STEP, |step| {
                let mut arm = motion.arm.clone();
                lengthen(&mut arm, joint, parameters(step));
                inverse_dynamics_of_motion(
                    &arm,
                    motion.position,
                    motion.velocity,
                    motion.acceleration,
                )
            })
        };
        vec![along(|step| [step, 0.0]), along(|step| [0.0, step])]
    }

    fn parameters(&self, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        coefficients.to_vec()
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (Vec::new(), parameters.to_vec())
    }

    fn mechanism(&self, _parameters: &[f64]) -> Mechanism {
        Mechanism::Arm
    }

    fn change_arm(
        &self,
        parameters: &[f64],
        joint: usize,
        _frames: &ArmFrames,
        arm: &mut RigidArm,
    ) {
        lengthen(arm, joint, [parameters[0], parameters[1]]);
    }
}

fn lengthen(arm: &mut RigidArm, joint: usize, [normal, offset]: [f64; 2]) {
    let frame = &mut arm.joints[joint].frame;
    frame.b_m += normal;
    frame.d_m += offset;
}
