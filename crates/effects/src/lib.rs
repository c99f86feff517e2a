//! Physics beyond the rigid body, one file an effect.
//!
//! ```text
//! effort_j = rigid_j(q, q̇, q̈) + Σ f(joint motion; parameters)
//! ```
//!
//! An effect is written once and used three times: the simulator asks for its effort, dry friction
//! and added inertia; the estimator for its columns; reports for its law, units, admissible signs and
//! look-alikes. Adding one is a new file that implements [`Effect`], and its line in [`LIBRARY`].
//!
//! ```
//! use armident_effects::{JointState, effect};
//!
//! let viscous = effect("viscous_friction").expect("in the library");
//! let state = JointState { position: 0.0, velocity: 2.0 };
//! assert_eq!(viscous.smooth_effort(&[0.5], &state), 1.0);
//! ```

mod coulomb_friction;
mod law;
mod rotor_inertia;
mod torque_offset;
mod viscous_friction;

pub use coulomb_friction::{CoulombFriction, direction};
pub use law::{Admissible, Effect, Export, JointMotion, JointState, Law, LookAlike, Parameter};
pub use rotor_inertia::RotorInertia;
pub use torque_offset::TorqueOffset;
pub use viscous_friction::ViscousFriction;

use serde::{Deserialize, Serialize};

/// All effects, in the order in which tables and parameter vectors list them.
pub const LIBRARY: &[&dyn Effect] =
    &[&ViscousFriction, &CoulombFriction, &TorqueOffset, &RotorInertia];

/// The effect with a slug.
pub fn effect(slug: &str) -> Option<&'static dyn Effect> {
    LIBRARY.iter().copied().find(|e| e.law().slug == slug)
}

/// An effect with numbers, on a joint: what a simulation is told and a model file holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectOnJoint {
    /// Slug of the effect.
    pub effect: String,
    /// Joint name.
    pub joint: String,
    /// Parameters in the order of the law.
    pub parameters: Vec<f64>,
}

impl EffectOnJoint {
    /// The library's entry.
    ///
    /// # Errors
    /// [`UnknownEffect`] when the library has no such slug or the number of parameters is not that
    /// of the law.
    pub fn resolve(&self) -> Result<&'static dyn Effect, UnknownEffect> {
        let known = || LIBRARY.iter().map(|e| e.law().slug).collect::<Vec<_>>().join(", ");
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
mod tests {
    use super::*;

    #[test]
    fn slugs_are_unique_and_every_law_is_complete() {
        for (i, a) in LIBRARY.iter().enumerate() {
            assert!(LIBRARY[i + 1..].iter().all(|b| a.law().slug != b.law().slug));
            assert!(!a.law().parameters.is_empty() && !a.law().look_alikes.is_empty());
        }
    }

    /// One effect, three uses: on a motion without reversals the columns give what the simulator's
    /// parts give.
    #[test]
    fn columns_agree_with_the_simulators_laws() {
        let velocity = [0.5, 1.0, 1.5];
        let acceleration = [0.2, -0.4, 3.0];
        let motion = JointMotion {
            time_s: &[0.0, 0.1, 0.2],
            position: &[0.0, 0.1, 0.3],
            velocity: &velocity,
            acceleration: &acceleration,
            speed_resolution: 1e-3,
        };
        for effect in LIBRARY {
            let parameters: Vec<f64> =
                (0..effect.law().parameters.len()).map(|k| 0.7 + k as f64).collect();
            let columns = effect.columns(&motion);
            for t in 0..3 {
                let by_columns: f64 = columns.iter().zip(&parameters).map(|(c, p)| c[t] * p).sum();
                let state = JointState { position: motion.position[t], velocity: velocity[t] };
                let by_law = effect.smooth_effort(&parameters, &state)
                    + effect.dry_friction(&parameters) * velocity[t].signum()
                    + effect.added_inertia(&parameters) * acceleration[t];
                assert!((by_columns - by_law).abs() < 1e-12, "{}", effect.law().slug);
            }
        }
    }
}
