//! Dry friction that falls with the speed.

use crate::law::{
    Effect, Export, JointMotion, Law, LookAlike, MotionScale, Parameter, Place, Scope, column,
};

/// `f = (Fc + (Fs - Fc) exp(-(v/vs)²)) sign(v)`.
pub struct StribeckFriction;

const LAW: Law = Law {
    slug: "stribeck_friction",
    title: "Stribeck friction",
    formula: "f = (Fc + (Fs - Fc) exp(-(v/vs)^2)) sign(v)",
    scope: Scope::Joint,
    places: &[Place::Dry],
    parameters: &[
        Parameter::non_negative("static_level", "N m", "N"),
        Parameter::non_negative("coulomb_level", "N m", "N"),
        Parameter::non_negative("stribeck_velocity", "rad/s", "m/s"),
    ],
    contains: &["coulomb_friction"],
    look_alikes: &[
        LookAlike {
            slug: "presliding_hysteresis",
            separated_by: "slow reversals of different acceleration: Stribeck keeps its width in speed, presliding in travel",
        },
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "constant speeds below and above the Stribeck velocity",
        },
        LookAlike {
            slug: "viscous_friction",
            separated_by: "constant speeds: Stribeck friction falls where viscous friction rises",
        },
    ],
    export: Export::NONE,
};

impl Effect for StribeckFriction {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn shapes(&self, scale: &MotionScale) -> Vec<Vec<f64>> {
        SHARES_OF_SPEED.iter().map(|share| vec![share * scale.speed_rms]).collect()
    }

    fn columns(&self, shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        let fall = column(motion.velocity.len(), |t| {
            motion.direction[t] * (-(motion.velocity[t] / shape[0]).powi(2)).exp()
        });
        vec![motion.direction.to_vec(), fall]
    }

    fn parameters(&self, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0] + coefficients[1], coefficients[0], shape[0]]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (vec![parameters[2]], vec![parameters[1], parameters[0] - parameters[1]])
    }

    /// A fall, not a rise.
    fn admits(&self, parameters: &[f64]) -> bool {
        parameters[1] >= 0.0 && parameters[0] > (1.0 + LEAST_FALL) * parameters[1]
    }

    fn dry_friction(&self, parameters: &[f64], state: &crate::JointState) -> crate::DryFriction {
        let [resting, sliding, speed] = [parameters[0], parameters[1], parameters[2]];
        let share = (-(state.velocity / speed).powi(2)).exp();
        crate::DryFriction::both(sliding + (resting - sliding) * share)
    }
}

/// Stribeck velocities to try, as shares of the root mean square speed: below, the motion has too few
/// samples; above, the law is a straight line.
const SHARES_OF_SPEED: [f64; 9] = [0.04, 0.06, 0.09, 0.12, 0.16, 0.21, 0.28, 0.38, 0.5];
/// Least fall, as a share of the Coulomb level, that deserves the name.
const LEAST_FALL: f64 = 0.15;
