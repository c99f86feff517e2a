//! Drag that grows with the square of the speed.

use crate::catalogue::{Against, Catalogue, Example};
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, Parameter, Scope};
use crate::motion::{JointMotion, JointState};

/// `f = c v |v|`.
pub struct QuadraticDrag;

const LAW: Law = Law {
    slug: "quadratic_drag",
    title: "quadratic drag",
    formula: "f = c v abs(v)",
    scope: Scope::Joint,
    roles: &[LawRole::Drag],
    parameters: &[Parameter::non_negative("coefficient", "N m s2/rad2", "N s2/m2").main()],
    look_alikes: &[
        LookAlike { slug: "viscous_friction", separated_by: "Record several constant speeds." },
        LookAlike { slug: "coulomb_friction", separated_by: "Record several constant speeds." },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Resistance that grows with the square of the speed: churning grease, air.",
    sizes: &[
        "UR5e, friction table of the factory at the motor: 0.057, 0.095, 0.137, 0.178 N m at 0.01, 0.5, 1.5, 3.2 rad/s, at the joint (gear of 101) 5.8, 9.6, 13.9, 17.9 N m (AURT): there the friction is sublinear, which this law does not admit; the rest is `unmodelled`",
    ],
    signature: "A curve that is flat at zero speed. It takes fast motion to see it.",
    example: Example::new("elbow_joint", &[1.0], Against::Speed),
};

impl Effect for QuadraticDrag {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.velocity.iter().map(|v| v * v.abs()).collect()]
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * state.velocity * state.velocity.abs()
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        let velocity = of.velocity;
        Some(format!("{:?} * {velocity} * fabs({velocity})", parameters[0]))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let start = 4.0 * size.noise / size.speed.powi(2);
        Some(DrawnEffect::new(joint, start, |x| vec![x]))
    }
}
