//! Physics beyond the rigid body, one file an effect.
//!
//! ```text
//! effort_j = rigid_j(q, q̇, q̈) + Σ f(joint motion; parameters)
//! ```
//!
//! An effect is written once and used three times: the simulator asks where it acts
//! ([`Mechanism`]) and for its effort, dry friction, added inertia and memory; the estimator for its
//! columns; reports for its law, units, admissible signs and look-alikes. Adding one is a new file that implements [`Effect`], and its line in [`LIBRARY`].
//!
//! ```
//! use armident_effects::{JointState, effect};
//! use armident_kinematics::JointKind;
//!
//! let viscous = effect("viscous_friction").expect("in the library");
//! let kind = JointKind::Rotational;
//! let state = JointState { kind, time_s: 0.0, position: 0.0, velocity: 2.0, load: 0.0 };
//! assert_eq!(viscous.smooth_effort(&[0.5], &state), 1.0);
//! ```

mod arm_motion;
mod asymmetric_coulomb_friction;
mod backlash;
mod coulomb_friction;
mod direction;
mod encoder_offset;
mod external_contact;
mod friction_drift;
mod gravity_direction;
mod joined;
mod joint_coupling;
mod joint_elasticity;
mod joint_spring;
mod law;
mod link_inertia_error;
mod load_dependent_friction;
mod mechanism;
mod payload;
mod presliding_hysteresis;
mod quadratic_drag;
mod rotor_inertia;
mod stribeck_friction;
mod sublinear_viscous_friction;
mod time_delay;
mod torque_offset;
mod torque_ripple;
mod torque_scale;
mod viscous_friction;

pub use asymmetric_coulomb_friction::AsymmetricCoulombFriction;
pub use backlash::Backlash;
pub use coulomb_friction::CoulombFriction;
pub use direction::{LEAST_SPEED_SHARE, Turn, direction, directions, directions_with};
pub use encoder_offset::EncoderOffset;
pub use external_contact::ExternalContact;
pub use friction_drift::FrictionDrift;
pub use gravity_direction::{GravityDirection, tilted};
pub use joined::{admitted_beside, is_less, joined, joined_where_inadmissible};
pub use joint_coupling::JointCoupling;
pub use joint_elasticity::JointElasticity;
pub use joint_spring::JointSpring;
pub use law::{
    Admissible, ArmColumns, ArmMotion, DryFriction, Effect, Export, JointMotion, JointState, Law,
    LookAlike, MotionScale, Onset, Parameter, Place, Scope,
};
pub use link_inertia_error::LinkInertiaError;
pub use load_dependent_friction::LoadDependentFriction;
pub use mechanism::{ArmFrames, Mechanism, Transmission, tip_jacobian};
pub use payload::Payload;
pub use presliding_hysteresis::PreslidingHysteresis;
pub use quadratic_drag::QuadraticDrag;
pub use rotor_inertia::RotorInertia;
pub use stribeck_friction::StribeckFriction;
pub use sublinear_viscous_friction::SublinearViscousFriction;
pub use time_delay::TimeDelay;
pub use torque_offset::TorqueOffset;
pub use torque_ripple::TorqueRipple;
pub use torque_scale::TorqueScale;
pub use viscous_friction::ViscousFriction;

use serde::{Deserialize, Serialize};

/// All effects, in the order in which tables list them.
pub const LIBRARY: &[&dyn Effect] = &[
    &ViscousFriction,
    &CoulombFriction,
    &TorqueOffset,
    &RotorInertia,
    &AsymmetricCoulombFriction,
    &StribeckFriction,
    &LoadDependentFriction,
    &QuadraticDrag,
    &PreslidingHysteresis,
    &FrictionDrift,
    &JointSpring,
    &TorqueRipple,
    &TorqueScale,
    &JointCoupling,
    &JointElasticity,
    &Backlash,
    &EncoderOffset,
    &Payload,
    &LinkInertiaError,
    &GravityDirection,
    &TimeDelay,
    &ExternalContact,
];

/// What every joint has: the terms of a plain identification, in the order of its parameter vectors.
pub const EVERYDAY: &[&dyn Effect] =
    &[&ViscousFriction, &CoulombFriction, &TorqueOffset, &RotorInertia];

/// Laws that a fit may have beside the others: they describe how friction grows with the speed, and a diagnosis, which says
/// what causes an effort, does not name them.
pub const DESCRIBING: &[&dyn Effect] = &[&SublinearViscousFriction];

/// The effect with a slug.
pub fn effect(slug: &str) -> Option<&'static dyn Effect> {
    LIBRARY.iter().chain(DESCRIBING).copied().find(|e| e.law().slug == slug)
}

/// An effect with numbers and its place: what a simulation is told and a model file holds.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct EffectOnJoint {
    /// Slug of the effect.
    pub effect: String,
    /// Joint name; of a link, the joint that moves it; of two neighbours, the first. Effects of the
    /// whole arm need none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub joint: String,
    /// The second of two neighbours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_joint: Option<String>,
    /// Start and end of a contact in the time of its recording \[s\]; nothing: all the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window_s: Option<[f64; 2]>,
    /// Parameters in the order of the law.
    pub parameters: Vec<f64>,
}

impl EffectOnJoint {
    /// An effect on one joint.
    pub fn new(
        effect: impl Into<String>,
        joint: impl Into<String>,
        parameters: impl Into<Vec<f64>>,
    ) -> Self {
        Self {
            effect: effect.into(),
            joint: joint.into(),
            parameters: parameters.into(),
            ..Self::default()
        }
    }

    /// Whether each parameter has a sign that it may have.
    pub fn has_admissible_signs(&self) -> bool {
        let parameters = effect(&self.effect).map_or(&[][..], |law| law.law().parameters);
        parameters.iter().zip(&self.parameters).all(|(p, value)| p.admissible.allows(*value))
    }

    /// The library's entry.
    ///
    /// # Errors
    /// [`UnknownEffect`] when the library has no such slug or the number of parameters is not that
    /// of the law.
    pub fn resolve(&self) -> Result<&'static dyn Effect, UnknownEffect> {
        let known = || {
            LIBRARY.iter().chain(DESCRIBING).map(|e| e.law().slug).collect::<Vec<_>>().join(", ")
        };
        let effect = effect(&self.effect)
            .ok_or_else(|| UnknownEffect::Slug { found: self.effect.clone(), known: known() })?;
        let expected = effect.law().parameters;
        if self.parameters.len() != expected.len() {
            return Err(UnknownEffect::Parameters {
                effect: effect.law().slug,
                expected: expected.iter().map(|p| p.name).collect::<Vec<_>>().join(", "),
                found: self.parameters.len(),
            });
        }
        Ok(effect)
    }
}

/// An [`EffectOnJoint`] that the library cannot serve.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnknownEffect {
    /// No effect of this name.
    #[error("there is no effect `{found}`; known are {known}")]
    Slug {
        /// What was asked for.
        found: String,
        /// Slugs of the library.
        known: String,
    },
    /// Too few or too many numbers.
    #[error("effect `{effect}` takes the parameters ({expected}), found {found} numbers")]
    Parameters {
        /// The effect.
        effect: &'static str,
        /// Names of its parameters.
        expected: String,
        /// How many were given.
        found: usize,
    },
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use armident_kinematics::JointKind;

    use super::*;

    #[test]
    fn slugs_are_unique_and_every_law_is_complete() {
        for (i, a) in LIBRARY.iter().enumerate() {
            assert!(LIBRARY[i + 1..].iter().all(|b| a.law().slug != b.law().slug));
            assert!(!a.law().parameters.is_empty() && !a.law().look_alikes.is_empty());
            assert!(a.law().contains.iter().all(|slug| effect(slug).is_some()));
        }
    }

    /// A swing with reversals, sampled finely.
    fn swing() -> [Vec<f64>; 5] {
        let time: Vec<f64> = (0..2000).map(|k| 1e-3 * f64::from(k)).collect();
        let of = |f: &dyn Fn(f64) -> f64| time.iter().map(|&t| f(t)).collect::<Vec<f64>>();
        let velocity = of(&|t| 1.5 * (5.0 * t).cos());
        let direction = directions_with(&velocity, 1e-6);
        [of(&|t| 0.3 * (5.0 * t).sin()), velocity, of(&|t| -7.5 * (5.0 * t).sin()), direction, time]
    }

    /// One effect, three uses: without reversals the columns give what the simulator's parts give.
    #[test]
    fn columns_agree_with_the_simulators_laws() {
        let [position, velocity, acceleration, direction, time] = swing();
        let motion = JointMotion {
            kind: JointKind::Rotational,
            time_s: &time,
            position: &position,
            velocity: &velocity,
            acceleration: &acceleration,
            direction: &direction,
            rigid_effort: &[],
        };
        for effect in EVERYDAY.iter().chain(DESCRIBING) {
            let parameters: Vec<f64> =
                (0..effect.law().parameters.len()).map(|k| 0.7 + k as f64).collect();
            let effort = effect.effort(&parameters, &motion);
            for t in 0..time.len() {
                let state = JointState {
                    kind: JointKind::Rotational,
                    time_s: time[t],
                    position: position[t],
                    velocity: velocity[t],
                    load: 0.0,
                };
                let by_law = effect.smooth_effort(&parameters, &state)
                    + effect.dry_friction(&parameters, &state).effort(velocity[t])
                    + effect.added_inertia(&parameters) * acceleration[t];
                assert!((effort[t] - by_law).abs() < 1e-12, "{}", effect.law().slug);
            }
        }
    }

    /// The columns, by coefficients that come from the parameters, are the formula of the law.
    #[test]
    fn columns_are_the_formulas() {
        let [position, velocity, acceleration, direction, time] = swing();
        let load: Vec<f64> = time.iter().map(|t| 3.0 * (2.0 * t).sin()).collect();
        let motion = JointMotion {
            kind: JointKind::Rotational,
            time_s: &time,
            position: &position,
            velocity: &velocity,
            acceleration: &acceleration,
            direction: &direction,
            rigid_effort: &load,
        };
        type Formula = fn(f64, f64, f64, f64, &[f64]) -> f64;
        let laws: [(&str, &[f64], Formula); 9] = [
            (
                "asymmetric_coulomb_friction",
                &[2.0, 1.5],
                |_, _, v, _, p| {
                    if v > 0.0 { p[0] } else { -p[1] }
                },
            ),
            ("stribeck_friction", &[2.0, 1.2, 0.2], |_, _, v, _, p| {
                (p[1] + (p[0] - p[1]) * (-(v / p[2]).powi(2)).exp()) * v.signum()
            }),
            ("load_dependent_friction", &[0.4, 0.1], |_, _, v, load, p| {
                (p[0] + p[1] * load.abs()) * v.signum()
            }),
            ("quadratic_drag", &[0.8], |_, _, v, _, p| p[0] * v * v.abs()),
            ("sublinear_viscous_friction", &[0.6], |_, _, v, _, p| {
                p[0] * v / (v.abs() + 0.001).sqrt()
            }),
            ("friction_drift", &[2.0, 0.5, 3.0], |t, _, v, _, p| {
                (p[1] + (p[0] - p[1]) * (-t / p[2]).exp()) * v
            }),
            ("joint_spring", &[4.0, 0.2], |_, q, _, _, p| p[0] * (q - p[1])),
            ("torque_ripple", &[0.5, 12.0, 0.3, 0.2, -1.0], |_, q, _, _, p| {
                p[0] * (p[1] * q + p[2]).sin() + p[3] * (2.0 * p[1] * q + p[4]).sin()
            }),
            ("torque_scale", &[1.1], |_, _, _, load, p| (p[0] - 1.0) * load),
        ];
        for (slug, parameters, formula) in laws {
            let law = effect(slug).unwrap();
            let (shape, coefficients) = law.shape_and_coefficients(parameters);
            for (a, b) in law.parameters(&shape, &coefficients).iter().zip(parameters) {
                assert!((a - b).abs() < 1e-12, "{slug}");
            }
            let effort = law.effort(parameters, &motion);
            for t in 0..time.len() {
                let exact = formula(time[t], position[t], velocity[t], load[t], parameters);
                assert!((effort[t] - exact).abs() < 1e-9, "{slug} at {t}");
            }
        }
    }

    /// The recursion for Dahl friction against its exact solution on a one-way travel.
    #[test]
    fn presliding_saturates_over_its_travel() {
        let position: Vec<f64> = (0..4000).map(|k| 2.5e-5 * f64::from(k)).collect();
        let none = vec![0.0; position.len()];
        let motion = JointMotion {
            kind: JointKind::Rotational,
            time_s: &none,
            position: &position,
            velocity: &none,
            acceleration: &none,
            direction: &none,
            rigid_effort: &[],
        };
        let effort = PreslidingHysteresis.effort(&[2.0, 100.0, 0.0], &motion);
        for (q, f) in position.iter().zip(&effort) {
            let exact = 2.0 * (1.0 - (-q * 100.0 / 2.0).exp());
            assert!((f - exact).abs() < 2e-3, "{q}: {f} {exact}");
        }
    }
}
