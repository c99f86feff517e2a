//! Laws that the library does not have: variants of its laws, and unlisted ones.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

use armident_effects::{
    CoulombFriction, Draw, DrawContext, DrawnEffect, Effect, JointState, Law, PreslidingHysteresis,
    TorqueRipple,
};

use crate::hidden::UNLISTED;

/// Variants of laws of the library: smooth for sharp Coulomb friction, Dahl friction of second order for `LuGre`, straight
/// flanks for the sine of a ripple. Each draws as the law it varies, whose slug it has.
const VARIANTS: [&dyn Effect; 3] = [&SmoothCoulomb, &QuadraticDahl, &TriangularRipple];

/// Slugs of laws that have a variant, which a diagnosis should report by the law's own name.
pub fn perturbable() -> [&'static str; 3] {
    VARIANTS.map(|variant| variant.law().slug)
}

/// The variant of a law.
pub(crate) fn of(slug: &str) -> Option<&'static dyn Effect> {
    VARIANTS.into_iter().find(|variant| variant.law().slug == slug)
}

/// A law that the library does not have, up to its size.
pub(crate) struct Unlisted {
    pub(crate) effect: &'static dyn Effect,
    pub(crate) drawn: DrawnEffect,
    /// Channels it depends on.
    pub(crate) variables: &'static [&'static str],
}

/// One of the unlisted laws.
pub(crate) fn unlisted(random: &mut dyn Draw, context: &DrawContext<'_>) -> Unlisted {
    let (joint, side) = context.draw_joint(random);
    let size = context.joints[joint];
    let deviation = size.position_deviation;
    if random.chance(0.5) {
        let width = deviation * random.between(0.4, 0.8);
        let order = random.between(4.0, 7.0) / width;
        let centre = size.position_mean + 0.5 * deviation * side;
        let parameters = move |x: f64| vec![x, centre, width, order];
        let drawn = DrawnEffect::new(joint, 8.0 * size.noise, parameters);
        return Unlisted { effect: &Detent, drawn, variables: &["position"] };
    }
    let order = random.between(2.0, 4.0) / deviation;
    let phase = random.between(-3.0, 3.0);
    let start = 4.0 * size.noise / size.speed;
    let drawn = DrawnEffect::new(joint, start, move |x| vec![x, order, phase]);
    Unlisted { effect: &UnevenDrag, drawn, variables: &["position", "velocity"] }
}

const fn unlisted_law(title: &'static str, formula: &'static str) -> Law {
    Law { slug: UNLISTED, title, formula, ..Law::BLANK }
}

/// Width of smooth Coulomb friction, over the standard deviation of the speed.
const SMOOTH_WIDTH: f64 = 0.12;

/// Coulomb friction without a jump: level, width \[rad/s or m/s\].
pub(crate) struct SmoothCoulomb;

static SMOOTH_COULOMB: LazyLock<Law> = LazyLock::new(|| Law {
    title: "smooth Coulomb friction",
    formula: "f = Fc tanh(v / width)",
    ..*CoulombFriction.law()
});

impl Effect for SmoothCoulomb {
    fn law(&self) -> &'static Law {
        &SMOOTH_COULOMB
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * (state.velocity / parameters[1]).tanh()
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let drawn = CoulombFriction.draw(random, context)?;
        let width = SMOOTH_WIDTH * context.joints[drawn.joint].speed;
        Some(drawn.map_parameters(move |level| [level, vec![width]].concat()))
    }
}

/// Dahl friction with another approach to its level: level, stiffness.
pub(crate) struct QuadraticDahl;

static QUADRATIC_DAHL: LazyLock<Law> = LazyLock::new(|| Law {
    title: "Dahl friction of second order",
    formula: "dz/dt = v (1 - s0 z sign(v) / Fc)^2, f = s0 z",
    ..*PreslidingHysteresis.law()
});

impl Effect for QuadraticDahl {
    fn law(&self) -> &'static Law {
        &QUADRATIC_DAHL
    }

    fn has_deflection(&self) -> bool {
        true
    }

    fn deflection_after(&self, parameters: &[f64], deflection: f64, travel: f64) -> f64 {
        let side = if travel == 0.0 { return deflection } else { travel.signum() };
        // with u = 1 - z sign(v): du/dx = -u^2
        let u = 1.0 - side * deflection;
        let travel = travel.abs() * parameters[1] / parameters[0];
        side * (1.0 - u / (1.0 + u * travel))
    }

    fn deflection_effort(&self, parameters: &[f64], deflection: f64, _velocity: f64) -> f64 {
        parameters[0] * deflection
    }

    /// Without damping.
    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let drawn = PreslidingHysteresis.draw(random, context)?;
        Some(drawn.map_parameters(|p| vec![p[0], p[1], 0.0]))
    }
}

/// Ripple with straight flanks: amplitude, order, phase.
pub(crate) struct TriangularRipple;

static TRIANGULAR_RIPPLE: LazyLock<Law> = LazyLock::new(|| Law {
    title: "triangular ripple",
    formula: "f = A triangle(n q + phase)",
    ..*TorqueRipple.law()
});

impl Effect for TriangularRipple {
    fn law(&self) -> &'static Law {
        &TRIANGULAR_RIPPLE
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        let turn = if state.kind.is_rotational() { 1.0 } else { TAU };
        let angle = turn * parameters[1] * state.position + parameters[2];
        parameters[0] * angle.sin().asin() / FRAC_PI_2
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        TorqueRipple.draw(random, context)
    }
}

/// A detent that is felt around one position: amplitude, centre, width, order.
pub(crate) struct Detent;

const DETENT: Law =
    unlisted_law("detent around one position", "f = A exp(-((q - q0) / w)^2) sin(n (q - q0))");

impl Effect for Detent {
    fn law(&self) -> &'static Law {
        &DETENT
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        let off = state.position - parameters[1];
        parameters[0] * (-(off / parameters[2]).powi(2)).exp() * (parameters[3] * off).sin()
    }
}

/// Viscous friction that depends on the position: coefficient, order, phase.
pub(crate) struct UnevenDrag;

const UNEVEN_DRAG: Law =
    unlisted_law("viscous friction that depends on the position", "f = b (1 + cos(n q + phase)) v");

impl Effect for UnevenDrag {
    fn law(&self) -> &'static Law {
        &UNEVEN_DRAG
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        let share = 1.0 + (parameters[1] * state.position + parameters[2]).cos();
        parameters[0] * share * state.velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The solution of the law, against small steps of it.
    #[test]
    fn second_order_dahl_solves_its_law() {
        let parameters = [2.0, 50.0];
        let mut exact = 0.0;
        let mut by_steps = 0.0;
        for travel in [0.03, -0.05, 0.02] {
            exact = QuadraticDahl.deflection_after(&parameters, exact, travel);
            for _ in 0..10_000 {
                let x = travel * 25.0 / 10_000.0;
                by_steps += x * (1.0 - by_steps * x.signum()).powi(2);
            }
            assert!((exact - by_steps).abs() < 1e-3, "{exact} {by_steps}");
        }
    }
}
