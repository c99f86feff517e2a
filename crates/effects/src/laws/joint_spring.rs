//! A spring on the joint, a cable or a balancer.

use crate::catalogue::{Against, Catalogue, Example};
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Export, Law, LawRole, LookAlike, Parameter, Scope};
use crate::motion::{JointMotion, JointState};

/// `f = k (q - q0)`.
pub struct JointSpring;

const LAW: Law = Law {
    slug: "joint_spring",
    title: "joint spring",
    formula: "f = k (q - q0)",
    scope: Scope::Joint,
    roles: &[LawRole::Constant],
    parameters: &[
        Parameter::non_negative("stiffness", "N m/rad", "N/m").main(),
        Parameter::any("rest_angle", "rad", "m"),
    ],
    contains: &["torque_offset"],
    look_alikes: &[
        LookAlike {
            slug: "payload",
            separated_by: "Move over a wide range: a payload varies with the sine of the angle, a spring with the angle.",
        },
        LookAlike {
            slug: "presliding_hysteresis",
            separated_by: "Move far in both directions: a spring has no hysteresis loop.",
        },
    ],
    export: Export { urdf: None, mjcf: Some("stiffness") },
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "An effort that pulls the joint to one position: balancers, hoses and cable packs.",
    sizes: &[
        "Cables of simulated arms: 0.02 to 0.17 N m/rad (defaults of FloBaRoID's simulator, not measured)",
        "The da Vinci arm's cables are identified as a term of their own (dVRK)",
    ],
    signature: "One line against the joint's own position, the same in both directions, and no other position matters. An ideal gravity balancer is not this law: its effort is exactly that of a lighter link, and no recording distinguishes the two.",
    example: Example::new("elbow_joint", &[4.0, -1.0], Against::Position),
};

impl Effect for JointSpring {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.position.to_vec(), vec![1.0; motion.position.len()]]
    }

    fn contained_column(&self) -> usize {
        1
    }

    fn parameters(&self, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0], -coefficients[1] / coefficients[0]]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (Vec::new(), vec![parameters[0], -parameters[0] * parameters[1]])
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * (state.position - parameters[1])
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        Some(format!("{:?} * ({} - {:?})", parameters[0], of.position, parameters[1]))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let deviation = size.position_deviation;
        let rest = size.position_mean + deviation * random.between(-1.0, 1.0);
        Some(DrawnEffect::new(joint, 4.0 * size.noise / deviation, move |x| vec![x, rest]))
    }
}
