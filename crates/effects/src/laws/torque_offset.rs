//! Constant offset of the effort channel.

use crate::catalogue::{Against, Catalogue, Example};
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Baseline, Law, LawRole, LookAlike, Onset, Parameter, Scope};
use crate::motion::{JointMotion, JointState};

/// `f = c`.
pub struct TorqueOffset;

const LAW: Law = Law {
    slug: "torque_offset",
    title: "effort offset",
    formula: "f = c",
    scope: Scope::Joint,
    roles: &[LawRole::Constant],
    parameters: &[Parameter::any("offset", "N m", "N").main()],
    baseline: Some(Baseline::Offset),
    look_alikes: &[
        LookAlike {
            slug: "asymmetric_coulomb_friction",
            separated_by: "Motion of one joint cannot distinguish them; a recording with the drive off shows the offset alone.",
        },
        LookAlike {
            slug: "payload",
            separated_by: "Change the pose: a payload's effort varies with gravity, an offset does not.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "A constant in the effort channel: the zero of a sensor or amplifier.",
    sizes: &[
        "KUKA LWR4+: 0.1 to 0.9 N m (FloBaRoID)",
        "Staubli TX40: 0.04 to 1.5 N m, many of them with a relative error above 30 % (FIGAROH)",
    ],
    signature: "The same number at any speed, position and load.",
    example: Example::new("elbow_joint", &[0.5], Against::Time),
};

impl Effect for TorqueOffset {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![vec![1.0; motion.velocity.len()]]
    }

    fn smooth_effort(&self, parameters: &[f64], _state: &JointState) -> f64 {
        parameters[0]
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        let _ = of;
        Some(format!("{:?}", parameters[0]))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, side) = context.draw_joint(random);
        let size = context.joints[joint];
        Some(DrawnEffect::new(joint, 4.0 * size.noise, move |x| vec![side * x]))
    }
}
