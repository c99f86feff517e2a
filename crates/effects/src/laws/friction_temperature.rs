//! Viscous friction that follows the temperature of the drive.

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::column;
use crate::effect::{Effect, ShapeStep};
use crate::law::{Law, LawRole, LookAlike, Parameter, Scope};
use crate::motion::{JointMotion, JointState, MotionScale};

/// `f = (b + c (T - T0)) v`, with the recorded temperature `T`.
pub struct FrictionTemperature;

const LAW: Law = Law {
    slug: "friction_temperature",
    title: "friction by temperature",
    formula: "f = (b + c (T - T0)) v",
    scope: Scope::Joint,
    roles: &[LawRole::Viscous],
    parameters: &[
        Parameter::non_negative("coefficient", "N m s/rad", "N s/m").main(),
        Parameter::any("coefficient_per_kelvin", "N m s/(rad K)", "N s/(m K)").main(),
        Parameter::any("reference_temperature", "°C", "°C"),
    ],
    contains: &["viscous_friction"],
    look_alikes: &[
        LookAlike {
            slug: "friction_drift",
            separated_by: "Let the arm cool for some minutes between two recordings: drift starts again with each, friction by temperature follows the thermometer.",
        },
        LookAlike {
            slug: "viscous_friction",
            separated_by: "Repeat the motion on the cold and on the warm arm: viscous friction is the same.",
        },
    ],
    follows_temperature: true,
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Viscous friction that falls as the lubricant warms, by the temperature that the drive records.",
    sizes: &[
        "A standard industrial robot: load and temperature beside the speed reduce the mean error of a static friction model six-fold (Bittencourt and Gunnarsson 2012)",
    ],
    signature: "A line through zero at each temperature, less steep the warmer the drive is; drawn at the reference temperature. Unlike with a drift, a recording that begins warm begins on the less steep line. It is looked for only where a temperature is recorded that changes.",
    example: Example::new("elbow_joint", &[2.0, -0.04, 45.0], Against::Speed),
};

/// Change of the temperature below which no friction is seen by it \[K\]: drives record whole degrees.
const LEAST_CHANGE_K: f64 = 2.0;

impl Effect for FrictionTemperature {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn shapes(&self, scale: &MotionScale) -> Vec<Vec<f64>> {
        let changes = |[low, high]: &[f64; 2]| high - low >= LEAST_CHANGE_K;
        let middle = scale.temperature_c.filter(changes).map(|[low, high]| 0.5 * (low + high));
        middle.into_iter().map(|reference_c| vec![reference_c]).collect()
    }

    /// Another reference is the same law.
    fn shape_step(&self, _constant: usize) -> Option<ShapeStep> {
        None
    }

    fn columns(&self, shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        let warmer = column(motion.velocity.len(), |t| {
            motion.velocity[t] * motion.temperature_c.get(t).map_or(0.0, |at| at - shape[0])
        });
        vec![motion.velocity.to_vec(), warmer]
    }

    fn parameters(&self, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0], coefficients[1], shape[0]]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (vec![parameters[2]], vec![parameters[0], parameters[1]])
    }

    /// Lubricants get thinner.
    fn is_plausible(&self, parameters: &[f64]) -> bool {
        parameters[1] <= 0.0
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        let warmer = state.temperature_c.map_or(0.0, |at| at - parameters[2]);
        (parameters[0] + parameters[1] * warmer) * state.velocity
    }
}
