//! Physics beyond the rigid body, one file per law.
//!
//! ```text
//! effort_j = rigid_j(q, q̇, q̈) + Σ f(joint motion; parameters)
//! ```
//!
//! One law gives the effort instead of adding to it: [`PositionControl`], the controller that commands go through.
//!
//! An effect is written once and used four times: the simulator asks where it acts
//! ([`Mechanism`]) and for its effort, dry friction, added inertia and memory; the estimator for its
//! columns; reports for its law, units, admissible signs and look-alikes; simulated
//! cases for a random one. Adding a law is a new file in `laws/` that implements [`Effect`] and states its [`Law`], its `mod`
//! and its line in the list there; from outside, a law joins a [`Library`].
//!
//! ```
//! use armident_effects::{JointState, effect};
//! use armident_kinematics::JointKind;
//!
//! let viscous = effect("viscous_friction").expect("in the library");
//! let kind = JointKind::Rotational;
//! let state = JointState { kind, time_s: 0.0, position: 0.0, velocity: 2.0, load: 0.0, temperature_c: None };
//! assert_eq!(viscous.smooth_effort(&[0.5], &state), 1.0);
//! ```

mod catalogue;
mod columns;
mod controller;
mod direction;
mod draw;
mod effect;
mod joined;
mod law;
mod laws;
mod library;
mod mechanism;
mod motion;
mod on_joint;
mod servo;
mod transmission;

pub use catalogue::{Against, Catalogue, Example};
pub use controller::ControllerVariables;
pub use direction::{LEAST_SPEED_SHARE, ReversalModel, direction, directions, directions_with};
pub use draw::{Draw, DrawContext, DrawnEffect, JointSize};
pub use effect::{Effect, ShapeStep};
pub use joined::is_less;
pub use law::{
    Admissible, Baseline, Equivalent, Export, Law, LawRole, LinkSide, LocationKind, LookAlike,
    Naming, Onset, OperatingTerm, Parameter, Scan, Scope, UNMODELLED, Where,
};
pub use laws::*;
pub use library::{Library, effect};
pub use mechanism::{ArmFrames, Mechanism, tip_jacobian};
pub use motion::{ArmColumns, DryFriction, JointMotion, JointState, MotionScale, WholeArmMotion};
pub use on_joint::{EffectOnJoint, UnknownEffect};
pub use servo::PositionServo;
pub use transmission::{Transmission, resting_links};

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use armident_kinematics::JointKind;

    use super::*;

    #[test]
    fn laws_are_unique_and_complete() {
        let laws: Vec<&dyn Effect> = Library::standard().all().collect();
        let known = |slugs: &[&str]| slugs.iter().all(|slug| effect(slug).is_some());
        for (i, a) in laws.iter().enumerate() {
            let law = a.law();
            assert!(laws[i + 1..].iter().all(|b| a.slug() != b.slug()));
            assert!(!law.parameters.is_empty() && !law.look_alikes.is_empty());
            assert!(known(law.contains) && known(law.companions), "{}", law.slug);
            assert!(law.equivalents.iter().all(|set| known(set.laws)), "{}", law.slug);
            assert_eq!(
                law.location == LocationKind::Link,
                law.scope == Scope::Link,
                "{}",
                law.slug
            );
            let whole = [LocationKind::TipLink, LocationKind::AllJoints, LocationKind::Arm];
            assert_eq!(whole.contains(&law.location), law.scope == Scope::Arm, "{}", law.slug);
            let is_named = law.naming == Naming::Named;
            assert_eq!(law.catalogue.is_some(), is_named, "{}", law.slug);
            if let Some(page) = law.catalogue {
                let joint = page.example.joint;
                assert!(a.admits(page.example.parameters), "{}", law.slug);
                let is_placed = !matches!(law.scope, Scope::Arm) && law.slug != Payload.slug();
                assert_eq!(joint.is_empty(), !is_placed, "{}", law.slug);
            }
        }
    }

    #[test]
    fn baseline_terms_lead_the_library() {
        let standard = Library::standard();
        let terms = standard.all().filter(|effect| effect.law().baseline.is_some());
        assert!(terms.map(Effect::slug).eq(BASELINE.iter().map(|effect| effect.slug())));
        assert!(BASELINE.windows(2).all(|w| w[0].law().baseline < w[1].law().baseline));
        let others = [SublinearViscousFriction.slug(), PositionControl.slug()];
        assert!(standard.named().all(|effect| !others.contains(&effect.slug())));
    }

    #[test]
    fn library_takes_law_from_outside() {
        struct Other;
        const LAW: Law = Law { slug: "other", title: "other", ..Law::BLANK };
        impl Effect for Other {
            fn law(&self) -> &'static Law {
                &LAW
            }
        }
        let library = Library::standard().with(&Other);
        let placed = EffectOnJoint::new("other", "joint", []);
        assert!(library.resolve(&placed).is_ok() && placed.resolve().is_err());
        let count = |library: &Library| library.all().count();
        assert_eq!(count(&library), count(Library::standard()) + 1);
        assert_eq!(count(&library.with(&Other)), count(&library));
    }

    /// Laws whose columns are those of a small change admit no large one.
    #[test]
    fn fits_are_admitted_by_their_laws() {
        assert!(
            CoulombFriction.admits_fit(&[], &[1.0]) && !CoulombFriction.admits_fit(&[], &[-1.0])
        );
        assert!(EncoderOffset.admits_fit(&[], &[-1.5]) && !EncoderOffset.admits_fit(&[], &[1.6]));
        assert!(Payload.admits_fit(&[], &[0.1]) && !Payload.admits_fit(&[], &[-0.1]));
        assert!(JointElasticity.admits_fit(&[900.0, 1.0], &[1.0, 0.0]));
        assert!(!JointElasticity.admits_fit(&[900.0, 1.0], &[2.0, 0.0]));
        assert!(Backlash.admits_fit(&[], &[2.0, 0.0]) && !Backlash.admits_fit(&[], &[-2.0, 0.0]));
        assert!(TimeDelay.admits_fit(&[], &[-0.01]));
    }

    /// A swing with reversals, sampled finely.
    fn swing() -> [Vec<f64>; 5] {
        let time: Vec<f64> = (0..2000).map(|k| 1e-3 * f64::from(k)).collect();
        let of = |f: &dyn Fn(f64) -> f64| time.iter().map(|&t| f(t)).collect::<Vec<f64>>();
        let velocity = of(&|t| 1.5 * (5.0 * t).cos());
        let direction = directions_with(&velocity, 1e-6);
        [of(&|t| 0.3 * (5.0 * t).sin()), velocity, of(&|t| -7.5 * (5.0 * t).sin()), direction, time]
    }

    /// Without reversals the columns give what the simulator's parts give.
    #[test]
    fn columns_agree_with_simulated_laws() {
        let [position, velocity, acceleration, direction, time] = swing();
        let motion = JointMotion {
            kind: JointKind::Rotational,
            time_s: &time,
            position: &position,
            velocity: &velocity,
            acceleration: &acceleration,
            direction: &direction,
            rigid_effort: &[],
            temperature_c: &[],
        };
        let others: [&dyn Effect; 1] = [&SublinearViscousFriction];
        for effect in BASELINE.iter().chain(&others) {
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
                    temperature_c: None,
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
    fn columns_follow_formulas() {
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
            temperature_c: &[],
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
    fn presliding_saturates_over_travel() {
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
            temperature_c: &[],
        };
        let effort = PreslidingHysteresis.effort(&[2.0, 100.0, 0.0], &motion);
        for (q, f) in position.iter().zip(&effort) {
            let exact = 2.0 * (1.0 - (-q * 100.0 / 2.0).exp());
            assert!((f - exact).abs() < 2e-3, "{q}: {f} {exact}");
        }
    }
}
