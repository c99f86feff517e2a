//! Friction of a transmission that two neighbouring joints share.

use crate::catalogue::{Against, Catalogue, Example};
use crate::direction::directions;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::{Effect, ShapeStep};
use crate::law::{Law, LawRole, LookAlike, Parameter, Scope};
use crate::mechanism::Mechanism;
use crate::motion::{JointMotion, MotionScale};

/// `s = v_b + r v_a`: `F = B s + C sign(s)`, `f_b = F`, `f_a = r F`.
pub struct JointCoupling;

const LAW: Law = Law {
    slug: "joint_coupling",
    title: "transmission coupling",
    formula: "s = v_b + r v_a: F = B s + C sign(s); f_b = F, f_a = r F",
    scope: Scope::Neighbours,
    roles: &[LawRole::Shared],
    parameters: &[
        Parameter::any("ratio", "1", "1").main(),
        Parameter::non_negative("viscous", "N m s/rad", "N s/m"),
        Parameter::non_negative("coulomb", "N m", "N"),
    ],
    contains: &["viscous_friction", "coulomb_friction"],
    companions: &["rotor_inertia"],
    look_alikes: &[
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "Move both joints at once, in equal and in opposite directions.",
        },
        LookAlike {
            slug: "viscous_friction",
            separated_by: "Move both joints at once, in equal and in opposite directions.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Two neighbouring joints share a transmission: the wrist's motors turn both.",
    sizes: &[
        "Staubli TX40, joints 5 and 6: 0.60 N m s/rad viscous and 2.0 N m Coulomb on the sum of the two speeds (FIGAROH, BIRDy)",
    ],
    signature: "The friction of one joint steps when the other reverses.",
    example: Example {
        other_joint: Some("wrist_2_joint"),
        ..Example::new("wrist_1_joint", &[1.0, 0.4, 1.2], Against::Speed)
    },
};

impl Effect for JointCoupling {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn shapes(&self, _scale: &MotionScale) -> Vec<Vec<f64>> {
        RATIOS.iter().map(|&ratio| vec![ratio]).collect()
    }

    fn pair_columns(
        &self,
        shape: &[f64],
        a: &JointMotion<'_>,
        b: &JointMotion<'_>,
    ) -> Vec<[Vec<f64>; 2]> {
        let ratio = shape[0];
        let common: Vec<f64> =
            a.velocity.iter().zip(b.velocity).map(|(va, vb)| vb + ratio * va).collect();
        let direction = directions(&common);
        let both = |f: Vec<f64>| [f.iter().map(|f| ratio * f).collect(), f];
        vec![both(common), both(direction)]
    }

    fn coefficient_jumps(&self, coefficient: usize) -> bool {
        coefficient == 1
    }

    fn parameters(&self, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![shape[0], coefficients[0], coefficients[1]]
    }

    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (vec![parameters[0]], vec![parameters[1], parameters[2]])
    }

    fn mechanism(&self, parameters: &[f64]) -> Mechanism {
        let [ratio, viscous, coulomb] = [parameters[0], parameters[1], parameters[2]];
        Mechanism::Pair { ratio, viscous, coulomb }
    }

    fn shape_step(&self, _constant: usize) -> Option<ShapeStep> {
        Some(ShapeStep::relative(0.1, 0.002))
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = (random.index(context.dof().saturating_sub(1)), random.sign());
        let (size, next) = (context.joints[joint], context.joints.get(joint + 1)?);
        let noise = size.noise.max(next.noise);
        let ratio = random.one_of(&[1.0, -1.0, 0.5, -0.5]);
        let viscous = random.between(0.3, 1.0) / next.speed;
        let drawn = DrawnEffect::new(joint, 4.0 * noise, move |x| vec![ratio, x * viscous, x]);
        Some(drawn.with_neighbour(joint + 1))
    }
}

/// Ratios to try; the fit refines them.
const RATIOS: [f64; 6] = [1.0, -1.0, 0.5, -0.5, 2.0, -2.0];
