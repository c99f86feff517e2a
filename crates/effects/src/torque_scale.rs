//! A wrong gain of the effort channel.

use crate::law::{Effect, Export, JointMotion, Law, LookAlike, Parameter, Place, Scope};

/// `recorded effort = gain × true effort`.
pub struct TorqueScale;

const LAW: Law = Law {
    slug: "torque_scale",
    title: "effort gain",
    formula: "recorded effort = gain * true effort",
    scope: Scope::Joint,
    places: &[Place::Gain],
    parameters: &[Parameter::non_negative("gain", "1", "1")],
    contains: &[],
    look_alikes: &[
        LookAlike {
            slug: "link_inertia_error",
            separated_by: "nothing if every joint has the same gain: a known mass; else the efforts of the other joints",
        },
        LookAlike {
            slug: "load_dependent_friction",
            separated_by: "up and down through the same poses: friction changes its sign",
        },
    ],
    export: Export::NONE,
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

    fn mechanism(&self, parameters: &[f64]) -> crate::Mechanism {
        crate::Mechanism::EffortGain(parameters[0])
    }
}
