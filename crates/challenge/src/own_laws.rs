//! Laws that the library does not have: variants of its own, and laws without a name.

use std::f64::consts::{FRAC_PI_2, TAU};

use armident_effects::{Effect, Export, JointState, Law, Place, Scope};

const fn law(slug: &'static str, title: &'static str, formula: &'static str) -> Law {
    Law {
        slug,
        title,
        formula,
        scope: Scope::Joint,
        places: &[Place::Dry],
        parameters: &[],
        contains: &[],
        look_alikes: &[],
        export: Export { urdf: None, mjcf: None },
    }
}

/// Coulomb friction without a jump: level, width \[rad/s or m/s\].
pub(crate) struct SmoothCoulomb;

const SMOOTH_COULOMB: Law =
    law("coulomb_friction", "smooth Coulomb friction", "f = Fc tanh(v / width)");

impl Effect for SmoothCoulomb {
    fn law(&self) -> &'static Law {
        &SMOOTH_COULOMB
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        parameters[0] * (state.velocity / parameters[1]).tanh()
    }
}

/// Dahl friction with another approach to its level: level, stiffness.
pub(crate) struct QuadraticDahl;

const QUADRATIC_DAHL: Law = law(
    "presliding_hysteresis",
    "Dahl friction of second order",
    "dz/dt = v (1 - s0 z sign(v) / Fc)^2, f = s0 z",
);

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
}

/// Ripple with straight flanks: amplitude, order, phase.
pub(crate) struct TriangularRipple;

const TRIANGULAR_RIPPLE: Law =
    law("torque_ripple", "triangular ripple", "f = A triangle(n q + phase)");

impl Effect for TriangularRipple {
    fn law(&self) -> &'static Law {
        &TRIANGULAR_RIPPLE
    }

    fn smooth_effort(&self, parameters: &[f64], state: &JointState) -> f64 {
        let turn = if state.kind.is_rotational() { 1.0 } else { TAU };
        let angle = turn * parameters[1] * state.position + parameters[2];
        parameters[0] * angle.sin().asin() / FRAC_PI_2
    }
}

/// A detent that is felt around one position: amplitude, centre, width, order.
pub(crate) struct Detent;

const DETENT: Law =
    law("unlisted", "detent around one position", "f = A exp(-((q - q0) / w)^2) sin(n (q - q0))");

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

const UNEVEN_DRAG: Law = law(
    "unlisted",
    "viscous friction that depends on the position",
    "f = b (1 + cos(n q + phase)) v",
);

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
    fn dahl_of_second_order_solves_its_law() {
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
