//! Ripple of motor and gear, locked to the position.

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::column;
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::{Effect, ShapeStep};
use crate::law::{Law, LawRole, LookAlike, Parameter, Scan, Scope};
use crate::motion::{JointMotion, JointState, MotionScale};

/// `f = A sin(n q + phase) [+ A2 sin(2 n q + phase2)]`.
pub struct TorqueRipple;

const LAW: Law = Law {
    slug: "torque_ripple",
    title: "torque ripple",
    formula: "f = A sin(n q + phase) [+ A2 sin(2 n q + phase2)]; prismatic: sin(2 pi n q + phase)",
    scope: Scope::Joint,
    roles: &[LawRole::Ripple],
    parameters: &[
        Parameter::non_negative("amplitude", "N m", "N").main(),
        Parameter::non_negative("order", "1/turn", "1/m").main(),
        Parameter::any("phase", "rad", "rad"),
        Parameter::non_negative("amplitude_2", "N m", "N"),
        Parameter::any("phase_2", "rad", "rad"),
    ],
    scan: Scan::Residual,
    look_alikes: &[
        LookAlike {
            slug: "unmodelled",
            separated_by: "Sweep the whole range slowly: ripple has the same order everywhere.",
        },
        LookAlike {
            slug: "joint_elasticity",
            separated_by: "Move at two speeds: ripple keeps its order in position, a resonance its frequency.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "An effort that repeats with the position: cogging of the motor, the two waves of a strain-wave gear, a sensor's own ripple.",
    sizes: &["Simulators assume 0.5 % of the largest torque (default of FloBaRoID, not measured)"],
    signature: "A wave against the position, whatever the speed. At high speed and a low sample rate it folds to another frequency: with 200 periods a turn and 100 samples a second above 1.5 rad/s.",
    example: Example::new("elbow_joint", &[1.5, 16.0, 0.4, 0.0, 0.0], Against::Position),
};

impl Effect for TorqueRipple {
    fn law(&self) -> &'static Law {
        &LAW
    }

    /// None: the order is scanned, not tried.
    fn shapes(&self, _scale: &MotionScale) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn columns(&self, shape: &[f64], motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        let turn = if motion.kind.is_rotational() { 1.0 } else { std::f64::consts::TAU };
        let harmonics = 1..=shape[1] as usize;
        harmonics
            .flat_map(|k| {
                let order = k as f64 * shape[0] * turn;
                let angle = |t: usize| order * motion.position[t];
                let samples = motion.position.len();
                [column(samples, |t| angle(t).sin()), column(samples, |t| angle(t).cos())]
            })
            .collect()
    }

    fn parameters(&self, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let polar = |k: usize| match coefficients.get(2 * k..2 * k + 2) {
            Some(&[sine, cosine]) => [sine.hypot(cosine), cosine.atan2(sine)],
            _ => [0.0, 0.0],
        };
        let ([first, phase], [second, phase_2]) = (polar(0), polar(1));
        vec![first, shape[0], phase, second, phase_2]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let wave = |amplitude: f64, phase: f64| [amplitude * phase.cos(), amplitude * phase.sin()];
        let first = wave(parameters[0], parameters[2]);
        if parameters[3] == 0.0 {
            return (vec![parameters[1], 1.0], first.to_vec());
        }
        let second = wave(parameters[3], parameters[4]);
        (vec![parameters[1], 2.0], [first, second].concat())
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        let turn = if state.kind.is_rotational() { 1.0 } else { std::f64::consts::TAU };
        let angle = turn * parameters[1] * state.position;
        parameters[0] * (angle + parameters[2]).sin()
            + parameters[3] * (2.0 * angle + parameters[4]).sin()
    }

    /// The order can be refined; how many harmonics there are cannot.
    fn shape_step(&self, constant: usize) -> Option<ShapeStep> {
        (constant == 0).then_some(ShapeStep::absolute(0.25, 0.01))
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        let turn = if of.kind.is_rotational() { 1.0 } else { std::f64::consts::TAU };
        let wave = |amplitude: f64, order: f64, phase: f64| {
            format!(
                "{amplitude:?} * sin({:?} * {} + {phase:?})",
                order * turn * parameters[1],
                of.position
            )
        };
        let first = wave(parameters[0], 1.0, parameters[2]);
        Some(format!("{first} + {}", wave(parameters[3], 2.0, parameters[4])))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let order = if size.kind.is_rotational() {
            random.between(6.0, 60.0).round()
        } else {
            random.between(8.0, 50.0)
        };
        let second = if random.chance(0.3) { random.between(0.2, 0.5) } else { 0.0 };
        let phases = [random.between(-3.0, 3.0), random.between(-3.0, 3.0)];
        let parameters = move |x: f64| vec![x, order, phases[0], second * x, phases[1]];
        Some(DrawnEffect::new(joint, 4.0 * size.noise, parameters))
    }
}
