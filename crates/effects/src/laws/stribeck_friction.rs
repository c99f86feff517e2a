//! Dry friction that falls with the speed.

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::column;
use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, Parameter, Scope};
use crate::motion::{DryFriction, JointMotion, JointState, MotionScale};

/// `f = (Fc + (Fs - Fc) exp(-(v/vs)²)) sign(v)`.
pub struct StribeckFriction;

const LAW: Law = Law {
    slug: "stribeck_friction",
    title: "Stribeck friction",
    formula: "f = (Fc + (Fs - Fc) exp(-(v/vs)^2)) sign(v)",
    scope: Scope::Joint,
    roles: &[LawRole::Dry],
    varies_with_speed: true,
    parameters: &[
        Parameter::non_negative("static_level", "N m", "N").main(),
        Parameter::non_negative("coulomb_level", "N m", "N"),
        Parameter::non_negative("stribeck_velocity", "rad/s", "m/s"),
    ],
    contains: &["coulomb_friction"],
    companions: &["viscous_friction"],
    look_alikes: &[
        LookAlike {
            slug: "presliding_hysteresis",
            separated_by: "Reverse slowly with different accelerations: the Stribeck peak has a constant width in speed, presliding friction in travel.",
        },
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "Record constant speeds below and above the Stribeck velocity.",
        },
        LookAlike {
            slug: "viscous_friction",
            separated_by: "Record several constant speeds: Stribeck friction falls with speed, viscous friction rises.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Dry friction that falls as a film of oil builds up with the speed: more effort at a crawl than at a walk.",
    sizes: &[
        "RMD-X8 actuator carrying more than 9 N m: 2.4 to 3.3 N m at rest, 2.1 at 0.04 to 0.08 rad/s, 1.4 at 0.08 to 0.15, 0.7 N m at 0.15 to 0.4 rad/s (axol, issue 317)",
        "Staubli TX40: Stribeck velocities of 0.025 to 0.05 rad/s (BIRDy)",
        "KUKA LWR4+: the term takes 7 % off the residual near reversals (FloBaRoID)",
    ],
    signature: "Peaks on both sides of zero speed that fall within the Stribeck velocity. Motion that passes zero quickly hardly shows them.",
    example: Example::new("elbow_joint", &[6.0, 3.0, 0.15], Against::Speed),
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

    fn dry_friction(&self, parameters: &[f64], state: &JointState) -> DryFriction {
        let [resting, sliding, speed] = [parameters[0], parameters[1], parameters[2]];
        let share = (-(state.velocity / speed).powi(2)).exp();
        DryFriction::both(sliding + (resting - sliding) * share)
    }

    fn c_expression(&self, parameters: &[f64], of: &ControllerVariables<'_>) -> Option<String> {
        let [resting, sliding, speed] = [parameters[0], parameters[1], parameters[2]];
        let ControllerVariables { velocity, direction, .. } = of;
        let fall = format!("exp(-({velocity} / {speed:?}) * ({velocity} / {speed:?}))");
        Some(format!("{direction} * ({sliding:?} + {:?} * {fall})", resting - sliding))
    }

    /// Breakaway is up to 3.5 times sliding friction.
    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let level = size.visible_dry_level();
        let speed = random.between(0.15, 0.45) * size.speed;
        let drawn = DrawnEffect::new(joint, 1.0, move |x| vec![level * (1.0 + x), level, speed]);
        Some(drawn.at_most(2.5).with_breakaway(|x| 1.0 + x))
    }
}

/// Stribeck velocities to try, as shares of the root mean square speed: below, the motion has too few
/// samples; above, the law is a straight line.
const SHARES_OF_SPEED: [f64; 9] = [0.04, 0.06, 0.09, 0.12, 0.16, 0.21, 0.28, 0.38, 0.5];
/// Least fall, as a share of the Coulomb level, that deserves the name.
const LEAST_FALL: f64 = 0.15;
