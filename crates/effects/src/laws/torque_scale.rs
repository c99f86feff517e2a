//! A wrong gain of the effort channel.

use crate::catalogue::{Against, Catalogue, Example};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, OperatingTerm, Parameter, Scope};
use crate::mechanism::Mechanism;
use crate::motion::JointMotion;

/// `recorded effort = gain × true effort`.
pub struct TorqueScale;

const LAW: Law = Law {
    slug: "torque_scale",
    title: "effort gain error",
    formula: "recorded effort = gain * true effort",
    scope: Scope::Joint,
    roles: &[LawRole::Gain],
    parameters: &[Parameter::non_negative("gain", "1", "1").main().neutral(1.0)],
    operating: Some(OperatingTerm::Gain),
    look_alikes: &[
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "If all joints share the factor, only a known mass distinguishes them; otherwise compare the efforts of the other joints.",
        },
        LookAlike {
            slug: "load_dependent_friction",
            separated_by: "Move up and down through the same poses: friction changes sign with direction, a gain error does not.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "The effort channel reads too much or too little by a factor: a wrong torque constant.",
    sizes: &[
        "Two published sets of gains for the same UR10e recordings: 14.87, 13.26, 11.13, 10.62, 11.03, 11.47 and 10.0, 10.7, 8.5, 9.0, 9.5, 10.1 N m/A, apart by 12 to 33 %",
    ],
    signature: "Proportional to all that the joint does: a line against the effort. When every channel has the same factor no unloaded motion distinguishes it from heavier links; a known load does (`identify --payload`).",
    example: Example::new("elbow_joint", &[1.1], Against::Load),
};

impl Effect for TorqueScale {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.rigid_effort.to_vec()]
    }

    fn parameters(&self, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![1.0 + coefficients[0]]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (Vec::new(), vec![parameters[0] - 1.0])
    }

    /// A channel off by more than a factor of 2.5 is in another unit, which is no physics.
    fn admits(&self, parameters: &[f64]) -> bool {
        (0.4..2.5).contains(&parameters[0])
    }

    fn mechanism(&self, parameters: &[f64]) -> Mechanism {
        Mechanism::EffortGain(parameters[0])
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, side) = context.draw_joint(random);
        Some(DrawnEffect::new(joint, 0.15, move |x| vec![1.0 + side * x]).at_most(0.45))
    }
}
