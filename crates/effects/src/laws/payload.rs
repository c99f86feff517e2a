//! A load on the last link.

use armident_dynamics::RigidArm;
use armident_kinematics::InertialParameters;
use nalgebra::{Matrix3, Vector3};

use super::link_inertia_error::LinkInertiaError;
use crate::catalogue::{Against, Catalogue, Example};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{
    Equivalent, Export, Law, LawRole, LocationKind, LookAlike, Onset, Parameter, Scope, Where,
};
use crate::mechanism::{ArmFrames, Mechanism};
use crate::motion::{ArmColumns, WholeArmMotion};

/// `f = Y_last π(m, com)`.
pub struct Payload;

const LAW: Law = Law {
    slug: "payload",
    title: "payload",
    formula: "a rigid mass fixed to the last link, not in the model",
    scope: Scope::Link,
    roles: &[LawRole::Link],
    parameters: &[
        Parameter::non_negative("mass", "kg", "kg").main(),
        Parameter::any("com_x", "m", "m"),
        Parameter::any("com_y", "m", "m"),
        Parameter::any("com_z", "m", "m"),
    ],
    location: LocationKind::Link,
    companions: &["link_inertia_error"],
    equivalents: &[Equivalent { laws: &["link_inertia_error"], on: Where::AnyJoint }],
    look_alikes: &[
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "Repeat the motion with and without the payload.",
        },
        LookAlike {
            slug: "gravity_direction",
            separated_by: "On a vertical first axis only a base tilt causes gravity load.",
        },
    ],
    export: Export { urdf: Some("inertial"), mjcf: Some("inertial") },
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "A load on the last link that the model does not contain.",
    sizes: &[
        "Grippers and tools: 0.5 to 2 kg (order of magnitude, no measurement at hand)",
        "Swevers and others (2002) identify loads of KUKA arms to the accuracy that friction and gears are modelled",
    ],
    signature: "The pattern of gravity and inertia at the flange on all joints at once. An inertia error of the last link is physically equivalent: either may be reported.",
    example: Example::new("", &[1.5, 0.0, 0.0, 0.06], Against::Position),
};

impl Effect for Payload {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    /// The ten columns of the last link's standard parameters.
    fn arm_columns(&self, _joint: usize, motion: &WholeArmMotion<'_>) -> ArmColumns {
        LinkInertiaError.arm_columns(motion.arm.dof() - 1, motion)
    }

    fn mechanism(&self, _parameters: &[f64]) -> Mechanism {
        Mechanism::Arm
    }

    /// A point mass at its centre, in the URDF frame of the link that the last joint moves.
    fn change_arm(
        &self,
        parameters: &[f64],
        _joint: usize,
        frames: &ArmFrames,
        arm: &mut RigidArm,
    ) {
        let last = arm.dof() - 1;
        let centre_m = Vector3::from_column_slice(&parameters[1..4]);
        let load = InertialParameters::from_com(parameters[0], centre_m, Matrix3::zeros());
        arm.links[last] = arm.links[last].plus(&load.expressed_in(&frames.link_in_e[last]));
    }

    /// Mass and centre of mass.
    fn parameters_of_link(&self, change: [f64; 4]) -> Vec<f64> {
        let [mass, x, y, z] = change;
        vec![mass, x / mass, y / mass, z / mass]
    }

    /// A load has mass.
    fn admits_fit(&self, _shape: &[f64], coefficients: &[f64]) -> bool {
        coefficients[0] > 0.0
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (last, _) = (context.dof() - 1, random.sign());
        let centre_m: [f64; 3] = std::array::from_fn(|_| random.between(-0.06, 0.06));
        let [x_m, y_m, z_m] = [centre_m[0], centre_m[1], centre_m[2] + 0.08];
        Some(DrawnEffect::new(last, 0.3, move |mass| vec![mass, x_m, y_m, z_m]).at_most(20.0))
    }
}
