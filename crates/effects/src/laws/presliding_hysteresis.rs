//! Friction that builds up over the travel since the last reversal (Dahl; LuGre with bristle damping).

use crate::catalogue::{Against, Catalogue, Example};
use crate::controller::ControllerVariables;
use crate::direction::{deflected, deflections};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, Parameter, Scope};
use crate::motion::{JointMotion, MotionScale};

/// `dz/dt = v - s0 |v| z / Fc`, `f = s0 z + s1 dz/dt`.
pub struct PreslidingHysteresis;

const LAW: Law = Law {
    slug: "presliding_hysteresis",
    title: "presliding hysteresis",
    formula: "dz/dt = v - s0 abs(v) z / Fc, f = s0 z + s1 dz/dt",
    scope: Scope::Joint,
    roles: &[LawRole::Dry],
    parameters: &[
        Parameter::non_negative("level", "N m", "N").main(),
        Parameter::non_negative("stiffness", "N m/rad", "N/m").main(),
        Parameter::non_negative("damping", "N m s/rad", "N s/m"),
    ],
    contains: &["coulomb_friction"],
    look_alikes: &[
        LookAlike {
            slug: "stribeck_friction",
            separated_by: "Reverse slowly with different accelerations: the Stribeck peak has a constant width in speed, presliding friction in travel.",
        },
        LookAlike {
            slug: "backlash",
            separated_by: "Record with and without gravity load on the joint: hysteresis stays at the reversals, backlash moves to where the transmitted effort changes sign.",
        },
        LookAlike {
            slug: "joint_spring",
            separated_by: "Move over a long travel: presliding friction saturates, a spring does not.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Before it slides, a dry contact bends like a spring: friction comes back over a small travel after every reversal (Dahl's law, with damping).",
    sizes: &[
        "Strain-wave and cycloid gears: a law of this kind with four numbers fits measured gears better than LuGre's (MuJoCo, issue 3528)",
    ],
    signature: "The step of Coulomb friction, rounded over a travel of `level / stiffness`, the same travel at any speed: a loop against the position.",
    example: Example::new("elbow_joint", &[3.3, 60.0, 0.5], Against::Position),
};

impl Effect for PreslidingHysteresis {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn shapes(&self, scale: &MotionScale) -> Vec<Vec<f64>> {
        SHARES_OF_TRAVEL.iter().map(|share| vec![share * scale.position_deviation]).collect()
    }

    /// The bristle deflection over its saturation: exact while the joint does not reverse between two
    /// samples.
    fn columns(&self, shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        vec![deflections(motion.position, shape[0])]
    }

    fn parameters(&self, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0], coefficients[0] / shape[0], 0.0]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (vec![parameters[0] / parameters[1]], vec![parameters[0]])
    }

    fn has_deflection(&self) -> bool {
        true
    }

    /// The deflection over its saturation, so that it goes from -1 to 1.
    fn deflection_after(&self, parameters: &[f64], deflection: f64, travel: f64) -> f64 {
        deflected(deflection, travel * parameters[1] / parameters[0])
    }

    fn deflection_effort(&self, parameters: &[f64], deflection: f64, velocity: f64) -> f64 {
        let [level, _, damping] = [parameters[0], parameters[1], parameters[2]];
        level * deflection + damping * (velocity - velocity.abs() * deflection)
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        Some(format!("{:?} * {}", parameters[0], of.direction))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let level = size.visible_dry_level() * random.between(1.0, 4.0);
        let deviation = size.position_deviation;
        let parameters = move |x: f64| {
            let stiffness = level / (x * deviation);
            vec![level, stiffness, 1e-3 * stiffness]
        };
        let drawn = DrawnEffect::new(joint, 0.1, parameters).at_most(0.4);
        Some(drawn.over_travel(move |x| x * deviation))
    }
}

/// Travels `Fc / s0` to try, as shares of the standard deviation of the position.
const SHARES_OF_TRAVEL: [f64; 15] = [
    4e-4, 1e-3, 0.002, 0.0035, 0.006, 0.012, 0.02, 0.035, 0.055, 0.08, 0.11, 0.16, 0.24, 0.36, 0.5,
];
