//! Friction of a transmission that two neighbouring joints share.

use crate::direction::directions;
use crate::law::{
    Effect, Export, JointMotion, Law, LookAlike, MotionScale, Parameter, Place, Scope,
};

/// `s = v_b + r v_a`: `F = B s + C sign(s)`, `f_b = F`, `f_a = r F`.
pub struct JointCoupling;

const LAW: Law = Law {
    slug: "joint_coupling",
    title: "transmission coupling",
    formula: "s = v_b + r v_a: F = B s + C sign(s); f_b = F, f_a = r F",
    scope: Scope::Neighbours,
    places: &[Place::Shared],
    parameters: &[
        Parameter::any("ratio", "1", "1"),
        Parameter::non_negative("viscous", "N m s/rad", "N s/m"),
        Parameter::non_negative("coulomb", "N m", "N"),
    ],
    contains: &["viscous_friction", "coulomb_friction"],
    look_alikes: &[
        LookAlike {
            slug: "coulomb_friction",
            separated_by: "both joints in motion at once, in equal and in opposite directions",
        },
        LookAlike {
            slug: "viscous_friction",
            separated_by: "both joints in motion at once, in equal and in opposite directions",
        },
    ],
    export: Export::NONE,
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

    fn mechanism(&self, parameters: &[f64]) -> crate::Mechanism {
        let [ratio, viscous, coulomb] = [parameters[0], parameters[1], parameters[2]];
        crate::Mechanism::Pair { ratio, viscous, coulomb }
    }
}

/// Ratios to try; the fit refines them.
const RATIOS: [f64; 6] = [1.0, -1.0, 0.5, -0.5, 2.0, -2.0];
