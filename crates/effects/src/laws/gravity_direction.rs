//! A tilted base.

use std::f64::consts::{FRAC_PI_2, TAU};

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use nalgebra::{Isometry3, Rotation3, Vector3};

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::{STEP, derivative};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LocationKind, LookAlike, Onset, OperatingTerm, Parameter, Scope};
use crate::mechanism::{ArmFrames, Mechanism};
use crate::motion::{ArmColumns, WholeArmMotion};

/// `gravity turned by the rotation vector (tilt_x, tilt_y, 0) of the base`.
pub struct GravityDirection;

const LAW: Law = Law {
    slug: "gravity_direction",
    title: "base tilt",
    formula: "gravity turned by the rotation vector (tilt_x, tilt_y, 0) of the base in the world",
    scope: Scope::Arm,
    roles: &[LawRole::Gravity],
    parameters: &[
        Parameter::non_negative("tilt", "rad", "rad").main(),
        Parameter::any("tilt_x", "rad", "rad"),
        Parameter::any("tilt_y", "rad", "rad"),
    ],
    location: LocationKind::Arm,
    operating: Some(OperatingTerm::Tilt),
    fits_alone: true,
    look_alikes: &[
        LookAlike {
            slug: "encoder_offset",
            separated_by: "Measure the base with a level, or rotate the arm about its first axis.",
        },
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "On a vertical first axis only a base tilt causes gravity load.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "The base is tilted with respect to the URDF.",
    sizes: &["A UR5e was recorded on a slope of 45 degrees (data set of AURT)"],
    signature: "A vertical first joint feels gravity: its effort goes with the sine of its own position and grows with the reach. Nothing else at rest does that.",
    example: Example::new("", &[0.05, 0.04, 0.03], Against::Position),
};

impl Effect for GravityDirection {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn arm_columns(&self, _joint: usize, motion: &WholeArmMotion<'_>) -> ArmColumns {
        let about = |axis: Vector3<f64>| {
            derivative(motion, STEP, |step| {
                let mut arm = motion.arm.clone();
                arm.gravity_e0 = tilted(&motion.base_from_e0, &arm.gravity_e0, &(axis * step));
                inverse_dynamics_of_motion(
                    &arm,
                    motion.position,
                    motion.velocity,
                    motion.acceleration,
                )
            })
        };
        vec![about(Vector3::x()), about(Vector3::y())]
    }

    fn parameters(&self, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0].hypot(coefficients[1]), coefficients[0], coefficients[1]]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (Vec::new(), parameters[1..].to_vec())
    }

    fn mechanism(&self, _parameters: &[f64]) -> Mechanism {
        Mechanism::Arm
    }

    fn change_arm(
        &self,
        parameters: &[f64],
        _joint: usize,
        frames: &ArmFrames,
        arm: &mut RigidArm,
    ) {
        let tilt = Vector3::new(parameters[1], parameters[2], 0.0);
        arm.gravity_e0 = tilted(&frames.base_from_e0, &arm.gravity_e0, &tilt);
    }

    /// The columns are those of a small tilt: more than a quarter turn is none.
    fn admits_fit(&self, _shape: &[f64], coefficients: &[f64]) -> bool {
        coefficients.iter().all(|c| c.abs() < FRAC_PI_2)
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let towards = random.between(0.0, TAU);
        let parameters = move |x: f64| vec![x, x * towards.cos(), x * towards.sin()];
        Some(DrawnEffect::new(joint, 0.05, parameters).at_most(0.2))
    }
}

/// Gravity in `E_0` when the base is turned in the world by a rotation vector given in the axes of the
/// base link (which are those of the world before): the base then sees gravity turned the other way.
pub fn tilted(
    base_from_e0: &Isometry3<f64>,
    gravity_e0: &Vector3<f64>,
    tilt: &Vector3<f64>,
) -> Vector3<f64> {
    let base = base_from_e0.rotation;
    base.inverse() * (Rotation3::new(*tilt).inverse() * (base * gravity_e0))
}
