//! Coulomb friction of another level in each direction.

use crate::law::{Effect, Export, JointMotion, Law, LookAlike, Parameter, Place, Scope};

/// `f = F+` if `v > 0`, `-F-` if `v < 0`.
pub struct AsymmetricCoulombFriction;

const LAW: Law = Law {
    slug: "asymmetric_coulomb_friction",
    title: "asymmetric Coulomb friction",
    formula: "f = F+ if v > 0, -F- if v < 0",
    scope: Scope::Joint,
    places: &[Place::Dry, Place::Constant],
    parameters: &[
        Parameter::non_negative("level_positive", "N m", "N"),
        Parameter::non_negative("level_negative", "N m", "N"),
    ],
    contains: &["coulomb_friction"],
    look_alikes: &[
        LookAlike {
            slug: "torque_offset",
            separated_by: "nothing on one joint: Coulomb friction and an offset are the same effort; a run with the drive off shows the offset alone",
        },
        LookAlike {
            slug: "payload",
            separated_by: "other poses of the arm: a load turns with gravity, friction does not",
        },
    ],
    export: Export::NONE,
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

    fn dry_friction(&self, parameters: &[f64], _state: &crate::JointState) -> crate::DryFriction {
        crate::DryFriction { forward: parameters[0], backward: parameters[1] }
    }
}
