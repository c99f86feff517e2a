//! Inertia of the rotor, reflected through the gear.

use crate::catalogue::{Against, Catalogue, Example};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Baseline, Equivalent, Export, Law, LawRole, LookAlike, Parameter, Scope, Where};
use crate::motion::JointMotion;

/// `f = Ia dv/dt`.
pub struct RotorInertia;

const LAW: Law = Law {
    slug: "rotor_inertia",
    title: "rotor inertia",
    formula: "f = Ia ddq",
    scope: Scope::Joint,
    roles: &[LawRole::Inertia],
    parameters: &[Parameter::non_negative("inertia", "kg m2", "kg").main()],
    baseline: Some(Baseline::RotorInertia),
    equivalents: &[Equivalent { laws: &["link_inertia_error"], on: Where::FirstJoint }],
    look_alikes: &[
        LookAlike {
            slug: "U_33",
            separated_by: "On the first rotational joint they are equivalent; compare with the data-sheet rotor inertia times the squared gear ratio.",
        },
        LookAlike {
            slug: "joint_elasticity",
            separated_by: "Excite higher frequencies: elasticity resonates and moves the other joints.",
        },
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "Move the other joints: a link inertia loads them, a rotor inertia does not.",
        },
    ],
    export: Export { urdf: None, mjcf: Some("armature") },
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "The rotor of the motor, turned by the gear: its inertia times the square of the ratio. Often larger than the links' own.",
    sizes: &[
        "Staubli TX40, joints 1 to 6: 0.36, 0.51, 0.083, 0.034, 0.036, 0.011 kg m2 (BIRDy)",
        "KUKA iiwa 14: 4.5e-5 kg m2 at the rotor behind a gear of 160, 1.16 kg m2 at the joint (Drake, issue 19344)",
        "PUMA 560: 0.78, 2.32, 0.58, 0.19, 0.17, 0.19 kg m2 (Robotics Toolbox)",
        "eRob80 with a gear of 100: 0.96 to 1.14 kg m2 (BAM)",
    ],
    signature: "Proportional to the acceleration of its own joint, and felt by no other. On the first joint it cannot be distinguished from the links' inertia about that axis, and often on the second.",
    example: Example::new("elbow_joint", &[0.2], Against::Acceleration),
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

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let inertia = context.inertia(joint);
        let start = 4.0 * size.noise / size.acceleration;
        Some(DrawnEffect::new(joint, start, |x| vec![x]).at_most(3.0 * inertia))
    }
}
