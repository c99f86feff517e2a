//! Coulomb friction of another level in each direction.

use crate::catalogue::{Against, Catalogue, Example};
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Equivalent, Law, LawRole, LookAlike, Parameter, Scope, Where};
use crate::motion::{DryFriction, JointMotion, JointState};

/// `f = F+` if `v > 0`, `-F-` if `v < 0`.
pub struct AsymmetricCoulombFriction;

const LAW: Law = Law {
    slug: "asymmetric_coulomb_friction",
    title: "asymmetric Coulomb friction",
    formula: "f = F+ if v > 0, -F- if v < 0",
    scope: Scope::Joint,
    roles: &[LawRole::Dry, LawRole::Constant],
    parameters: &[
        Parameter::non_negative("level_positive", "N m", "N").main(),
        Parameter::non_negative("level_negative", "N m", "N").main(),
    ],
    contains: &["coulomb_friction"],
    companions: &["torque_offset"],
    equivalents: &[Equivalent {
        laws: &["coulomb_friction", "torque_offset"],
        on: Where::AnyJoint,
    }],
    look_alikes: &[
        LookAlike {
            slug: "torque_offset",
            separated_by: "Motion of one joint cannot distinguish them; a recording with the drive off shows the offset alone.",
        },
        LookAlike {
            slug: "payload",
            separated_by: "Change the pose: a payload's effort varies with gravity, friction does not.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Dry friction with a different level in each direction.",
    sizes: &[
        "PUMA 560: the two levels differ by 10 % on joint 1 and by a factor of 2.6 on joint 6 (Robotics Toolbox)",
    ],
    signature: "Two levels of different height. Half their difference is a constant while the joint moves: Coulomb friction with an offset looks the same until the joint is at rest.",
    example: Example::new("elbow_joint", &[4.5, 2.5], Against::Speed),
};

impl Effect for AsymmetricCoulombFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.direction.to_vec(), vec![1.0; motion.direction.len()]]
    }

    fn parameters(&self, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0] + coefficients[1], coefficients[0] - coefficients[1]]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let [positive, negative] = [parameters[0], parameters[1]];
        (Vec::new(), vec![0.5 * (positive + negative), 0.5 * (positive - negative)])
    }

    fn dry_friction(&self, parameters: &[f64], _state: &JointState) -> DryFriction {
        DryFriction { forward: parameters[0], backward: parameters[1] }
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        let (_, coefficients) = self.shape_and_coefficients(parameters);
        Some(format!("{:?} * {} + {:?}", coefficients[0], of.direction, coefficients[1]))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, side) = context.draw_joint(random);
        let level = context.joints[joint].visible_dry_level();
        let levels = move |x: f64| vec![level * (1.0 + side * x), level * (1.0 - side * x)];
        Some(DrawnEffect::new(joint, 0.3, levels).at_most(0.8))
    }
}
