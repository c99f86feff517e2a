//! A spring on the joint, a cable or a balancer.

use crate::law::{
    Effect, Export, JointMotion, JointState, Law, LookAlike, Parameter, Place, Scope,
};

/// `f = k (q - q0)`.
pub struct JointSpring;

const LAW: Law = Law {
    slug: "joint_spring",
    title: "joint spring",
    formula: "f = k (q - q0)",
    scope: Scope::Joint,
    places: &[Place::Constant],
    parameters: &[
        Parameter::non_negative("stiffness", "N m/rad", "N/m"),
        Parameter::any("rest_angle", "rad", "m"),
    ],
    contains: &["torque_offset"],
    look_alikes: &[
        LookAlike {
            slug: "payload",
            separated_by: "a wide travel: a load follows the sine of the angle, a spring the angle",
        },
        LookAlike {
            slug: "presliding_hysteresis",
            separated_by: "a long travel in both directions: a spring has no loop",
        },
    ],
    export: Export { urdf: None, mjcf: Some("stiffness") },
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
}
