//! Viscous friction.

use crate::catalogue::{Against, Catalogue, Example};
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Baseline, Export, Law, LawRole, LookAlike, Onset, Parameter, Scope};
use crate::motion::{JointMotion, JointState};

/// `f = b v`.
pub struct ViscousFriction;

const LAW: Law = Law {
    slug: "viscous_friction",
    title: "viscous friction",
    formula: "f = b v",
    scope: Scope::Joint,
    roles: &[LawRole::Viscous],
    parameters: &[Parameter::non_negative("coefficient", "N m s/rad", "N s/m").main()],
    baseline: Some(Baseline::Viscous),
    look_alikes: &[
        LookAlike {
            slug: "time_delay",
            separated_by: "Repeat the motion with the same amplitude at two frequencies: friction grows with the speed, the effect of a delay with its cube.",
        },
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "Move slowly and fast: at a single speed the two are collinear.",
        },
        LookAlike {
            slug: "friction_drift",
            separated_by: "Repeat the motion on the warm arm: drift disappears, viscous friction remains.",
        },
    ],
    export: Export { urdf: Some("damping"), mjcf: Some("damping") },
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Resistance that grows with the speed: oil in bearings and gears. Every joint has it.",
    sizes: &[
        "Staubli TX40, joints 1 to 6: 8.1, 5.6, 2.0, 1.1, 1.9, 0.64 N m s/rad (identified by the authors of FIGAROH; BIRDy has like numbers)",
        "eRob80 actuator with a gear of 100: 8.4; Dynamixel MX-106: 0.05 N m s/rad (BAM, better actuator models)",
    ],
    signature: "A straight line through zero against the speed. Where a motor voltage is recorded in the place of an effort, the back EMF is the same line.",
    example: Example::new("elbow_joint", &[1.9], Against::Speed),
};

impl Effect for ViscousFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.velocity.to_vec()]
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * state.velocity
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        Some(format!("{:?} * {}", parameters[0], of.velocity))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        Some(DrawnEffect::new(joint, 4.0 * size.noise / size.speed, |x| vec![x]))
    }
}
