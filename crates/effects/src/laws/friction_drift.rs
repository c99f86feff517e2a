//! Viscous friction of an arm that warms up.

use crate::catalogue::{Against, Catalogue, Example};
use crate::columns::column;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LookAlike, Parameter, Scope};
use crate::motion::{JointMotion, JointState, MotionScale};

/// `f = (bw + (bc - bw) exp(-t/T)) v`.
pub struct FrictionDrift;

const LAW: Law = Law {
    slug: "friction_drift",
    title: "friction drift",
    formula: "f = (bw + (bc - bw) exp(-t/T)) v",
    scope: Scope::Joint,
    roles: &[LawRole::Viscous],
    parameters: &[
        Parameter::non_negative("cold_coefficient", "N m s/rad", "N s/m").main(),
        Parameter::non_negative("warm_coefficient", "N m s/rad", "N s/m").main(),
        Parameter::non_negative("time_constant", "s", "s"),
    ],
    contains: &["viscous_friction"],
    look_alikes: &[
        LookAlike {
            slug: "viscous_friction",
            separated_by: "Repeat the motion on the warm arm: drift disappears, viscous friction remains.",
        },
        LookAlike {
            slug: "payload",
            separated_by: "Separate the even and odd parts in speed: drift appears only in the odd part.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Viscous friction that falls while the gear warms up.",
    sizes: &[
        "UR5e, KUKA KR10: factory and measured friction tables carry the temperature, and load, speed and temperature are the largest influences (AURT; Nevmerzhitskiy 2019)",
    ],
    signature: "Points between two lines through zero, the steeper one cold. A recording of seconds does not show it; it takes minutes, or two recordings.",
    example: Example::new("elbow_joint", &[3.0, 1.5, 4.0], Against::Speed),
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

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        let [cold, warm, time_constant] = [parameters[0], parameters[1], parameters[2]];
        (warm + (cold - warm) * (-state.time_s / time_constant).exp()) * state.velocity
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let warm = size.viscous.max(2.0 * size.noise / size.speed);
        let constant = random.between(0.12, 0.4) * context.duration_s;
        let parameters = move |x: f64| vec![warm * (1.0 + x), warm, constant];
        Some(DrawnEffect::new(joint, 1.0, parameters).at_most(15.0))
    }
}

/// Time constants to try, as shares of the longest recording.
const SHARES_OF_DURATION: [f64; 7] = [0.07, 0.1, 0.16, 0.24, 0.34, 0.48, 0.7];
