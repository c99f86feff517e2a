//! Viscous friction that grows more slowly than the speed.

use crate::controller::ControllerVariables;
use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, Naming, Parameter, Scope};
use crate::motion::{JointMotion, JointState};

/// `f = c v / sqrt(abs(v) + v0)`, `v0 = 0.001`: the root of the speed, without its infinite slope at rest.
///
/// Lubricants thin as they are sheared. The friction of a Universal Robots UR5e's joint by its factory table (0.057, 0.095, 0.137
/// and 0.178 N m at the motor at 0.01, 0.5, 1.5 and 3.2 rad/s) is a constant and this to 3 % of its span, a constant and
/// viscous friction to 11 %.
pub struct SublinearViscousFriction;

/// Speed below which it is proportional to the speed \[rad/s or m/s\].
const LINEAR_BELOW: f64 = 1e-3;

const LAW: Law = Law {
    slug: "sublinear_viscous_friction",
    title: "sublinear viscous friction",
    formula: "f = c v / sqrt(abs(v) + 0.001)",
    scope: Scope::Joint,
    roles: &[LawRole::Drag],
    parameters: &[Parameter::non_negative("coefficient", "N m (s/rad)^0.5", "N (s/m)^0.5")],
    naming: Naming::PredictionOnly,
    look_alikes: &[
        LookAlike { slug: "viscous_friction", separated_by: "Record several constant speeds." },
        LookAlike { slug: "coulomb_friction", separated_by: "Record several constant speeds." },
    ],
    ..Law::BLANK
};

fn at(velocity: f64) -> f64 {
    velocity / (velocity.abs() + LINEAR_BELOW).sqrt()
}

impl Effect for SublinearViscousFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn columns(&self, _shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![motion.velocity.iter().map(|&v| at(v)).collect()]
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * at(state.velocity)
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        let velocity = of.velocity;
        Some(format!(
            "{:?} * {velocity} / sqrt(fabs({velocity}) + {LINEAR_BELOW:?})",
            parameters[0]
        ))
    }
}
