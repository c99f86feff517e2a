//! Viscous friction of an arm that warms up.

use crate::law::{
    Effect, Export, JointMotion, Law, LookAlike, MotionScale, Parameter, Place, Scope, column,
};

/// `f = (bw + (bc - bw) exp(-t/T)) v`.
pub struct FrictionDrift;

const LAW: Law = Law {
    slug: "friction_drift",
    title: "friction drift",
    formula: "f = (bw + (bc - bw) exp(-t/T)) v",
    scope: Scope::Joint,
    places: &[Place::Viscous],
    parameters: &[
        Parameter::non_negative("cold_coefficient", "N m s/rad", "N s/m"),
        Parameter::non_negative("warm_coefficient", "N m s/rad", "N s/m"),
        Parameter::non_negative("time_constant", "s", "s"),
    ],
    contains: &["viscous_friction"],
    look_alikes: &[
        LookAlike { slug: "viscous_friction", separated_by: "a second run on the warm arm" },
        LookAlike {
            slug: "payload",
            separated_by: "the part that is even in the speed: friction drifts only in the odd part",
        },
    ],
    export: Export::NONE,
};

impl Effect for FrictionDrift {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn shapes(&self, scale: &MotionScale) -> Vec<Vec<f64>> {
        SHARES_OF_DURATION.iter().map(|share| vec![share * scale.duration_s]).collect()
    }

    fn columns(&self, shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        let cold = column(motion.velocity.len(), |t| {
            motion.velocity[t] * (-motion.time_s[t] / shape[0]).exp()
        });
        vec![motion.velocity.to_vec(), cold]
    }

    fn parameters(&self, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0] + coefficients[1], coefficients[0], shape[0]]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (vec![parameters[2]], vec![parameters[1], parameters[0] - parameters[1]])
    }

    fn smooth_effort(&self, parameters: &[f64], state: &crate::JointState) -> f64 {
        let [cold, warm, time_constant] = [parameters[0], parameters[1], parameters[2]];
        (warm + (cold - warm) * (-state.time_s / time_constant).exp()) * state.velocity
    }
}

/// Time constants to try, as shares of the longest recording.
const SHARES_OF_DURATION: [f64; 7] = [0.07, 0.1, 0.16, 0.24, 0.34, 0.48, 0.7];
