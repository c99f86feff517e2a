//! Two effects on one joint as one.

use crate::effect::Effect;
use crate::law::{Admissible, Scope};
use crate::library::Library;
use crate::on_joint::EffectOnJoint;

impl Library {
    /// The one effect that two on the same joint are together: two of one law and of one shape, or a law and one that it
    /// contains. None where no law of the library is both.
    ///
    /// Friction that falls is a law with a negative level beside the one that was there: joined, they must be admissible.
    /// Coulomb friction is joined with a presliding hysteresis by its level, the travel in which that builds up stays.
    pub fn joined(&self, a: &EffectOnJoint, b: &EffectOnJoint) -> Option<EffectOnJoint> {
        if a.joint != b.joint {
            return None;
        }
        let of =
            |e: &EffectOnJoint| self.resolve(e).ok().filter(|law| law.law().scope == Scope::Joint);
        let (law_a, law_b) = (of(a)?, of(b)?);
        let parameters = if a.effect == b.effect {
            let (shape, mut sum) = law_a.shape_and_coefficients(&a.parameters);
            let (other_shape, others) = law_a.shape_and_coefficients(&b.parameters);
            if shape != other_shape {
                return None;
            }
            sum.iter_mut().zip(others).for_each(|(x, y)| *x += y);
            law_a.parameters(&shape, &sum)
        } else if law_a.law().contains_law(law_b.law()) {
            with_contained(law_a, &a.parameters, &b.parameters)
        } else if law_b.law().contains_law(law_a.law()) {
            let parameters = with_contained(law_b, &b.parameters, &a.parameters);
            return Some(EffectOnJoint { parameters, ..b.clone() });
        } else {
            return None;
        };
        Some(EffectOnJoint { parameters, ..a.clone() })
    }

    /// Whether an effect may carry its name: by its own numbers or, where it is less of what is known, by those of both.
    /// A known effect is known to a tenth, so that all of it can disappear. A law with a shape has no decrease: a
    /// level that falls while another rises is another law, which must be admitted itself.
    pub fn admitted_beside(&self, known: &[EffectOnJoint], change: &EffectOnJoint) -> bool {
        const KNOWN_TO: f64 = 0.1;
        let admits =
            |e: &EffectOnJoint| self.get(&e.effect).is_some_and(|law| law.admits(&e.parameters));
        let Ok(law) = self.resolve(change) else { return false };
        let value_of = |name: &str| {
            let named = law.law().parameters.iter().position(|p| p.name == name);
            named.map(|k| change.parameters[k])
        };
        let has_shape = !law.shape_and_coefficients(&change.parameters).0.is_empty();
        let is_less = || !has_shape && self.is_less(law.law().slug, value_of);
        admits(change)
            || is_less()
                && known.iter().filter(|k| k.joint == change.joint).any(|known| {
                    let Ok(law) = self.resolve(known) else { return false };
                    let (shape, mut coefficients) = law.shape_and_coefficients(&known.parameters);
                    coefficients.iter_mut().for_each(|c| *c *= 1.0 + KNOWN_TO);
                    let most = EffectOnJoint {
                        parameters: law.parameters(&shape, &coefficients),
                        ..known.clone()
                    };
                    self.joined(&most, change).is_some_and(|both| admits(&both))
                })
    }

    /// Whether numbers of a law, by their names, can only be a change, for the less: none that must not be negative is positive.
    pub fn is_less(&self, slug: &str, value_of: impl Fn(&str) -> Option<f64>) -> bool {
        let Some(law) = self.get(slug) else { return false };
        let signed =
            law.law().parameters.iter().filter(|p| p.admissible == Admissible::NonNegative);
        let values: Vec<f64> = signed.filter_map(|p| value_of(p.name)).collect();
        values.iter().all(|x| *x <= 0.0) && values.iter().any(|x| *x < 0.0)
    }

    /// Effects without those of a sign that only others on the same joint make possible: joined with them, as a simulated arm
    /// must have them. What no other makes possible stays as it is.
    pub fn joined_where_inadmissible(&self, mut effects: Vec<EffectOnJoint>) -> Vec<EffectOnJoint> {
        let pair = |effects: &[EffectOnJoint]| {
            let wrong = (0..effects.len()).filter(|k| !self.has_admissible_signs(&effects[*k]));
            let with = |k: usize| (0..effects.len()).filter(move |l| *l != k).map(move |l| (k, l));
            wrong
                .flat_map(with)
                .find_map(|(k, l)| Some((k, l, self.joined(&effects[l], &effects[k])?)))
        };
        while let Some((k, l, both)) = pair(&effects) {
            effects[l] = both;
            effects.remove(k);
        }
        effects
    }
}

/// Parameters of a law with one that it contains, whose only column is the law's first.
fn with_contained(law: &dyn Effect, parameters: &[f64], contained: &[f64]) -> Vec<f64> {
    let (shape, mut coefficients) = law.shape_and_coefficients(parameters);
    coefficients[law.contained_column()] += contained[0];
    law.parameters(&shape, &coefficients)
}

/// [`Library::is_less`] in the standard library.
pub fn is_less(slug: &str, value_of: impl Fn(&str) -> Option<f64>) -> bool {
    Library::standard().is_less(slug, value_of)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use armident_kinematics::JointKind;

    use super::*;
    use crate::{JointMotion, directions_with};

    fn joined(a: &EffectOnJoint, b: &EffectOnJoint) -> Option<EffectOnJoint> {
        Library::standard().joined(a, b)
    }

    fn on(effect: &str, parameters: &[f64]) -> EffectOnJoint {
        EffectOnJoint::new(effect, "joint", parameters)
    }

    fn effort(of: &EffectOnJoint) -> Vec<f64> {
        let time: Vec<f64> = (0..500).map(|k| 4e-3 * f64::from(k)).collect();
        let series = |f: &dyn Fn(f64) -> f64| time.iter().map(|&t| f(t)).collect::<Vec<f64>>();
        let velocity = series(&|t| 1.5 * (5.0 * t).cos());
        let motion = JointMotion {
            kind: JointKind::Rotational,
            time_s: &time,
            position: &series(&|t| 0.3 * (5.0 * t).sin()),
            acceleration: &series(&|t| -7.5 * (5.0 * t).sin()),
            direction: &directions_with(&velocity, 1e-6),
            rigid_effort: &series(&|t| 3.0 * (2.0 * t).sin()),
            temperature_c: &[],
            velocity: &velocity,
        };
        of.resolve().unwrap().effort(&of.parameters, &motion)
    }

    /// Joined effects are the sum of both, in either order.
    #[test]
    fn joined_effect_is_sum() {
        let pairs = [
            (on("viscous_friction", &[8.0]), on("viscous_friction", &[-5.0])),
            (on("asymmetric_coulomb_friction", &[3.0, 2.0]), on("coulomb_friction", &[-1.0])),
            (on("coulomb_friction", &[4.0]), on("asymmetric_coulomb_friction", &[-1.0, -2.0])),
            (on("stribeck_friction", &[5.0, 3.0, 0.1]), on("coulomb_friction", &[-2.0])),
            (on("load_dependent_friction", &[5.0, 0.1]), on("coulomb_friction", &[-2.0])),
            (on("friction_drift", &[0.5, -4.0, 9.0]), on("viscous_friction", &[6.0])),
            (on("joint_spring", &[40.0, 0.2]), on("joint_spring", &[-10.0, 0.1])),
            (on("joint_spring", &[40.0, 0.2]), on("torque_offset", &[1.5])),
            (
                on("torque_ripple", &[2.0, 6.0, 0.3, 0.0, 0.0]),
                on("torque_ripple", &[1.0, 6.0, 2.0, 0.0, 0.0]),
            ),
        ];
        for (a, b) in pairs {
            let sum: Vec<f64> = effort(&a).iter().zip(effort(&b)).map(|(x, y)| x + y).collect();
            for both in [joined(&a, &b).unwrap(), joined(&b, &a).unwrap()] {
                for (x, y) in effort(&both).iter().zip(&sum) {
                    assert!((x - y).abs() < 1e-9, "{a:?} {b:?}: {both:?}");
                }
            }
        }
        let none = [
            (on("coulomb_friction", &[4.0]), on("viscous_friction", &[-1.0])),
            (on("stribeck_friction", &[5.0, 3.0, 0.1]), on("stribeck_friction", &[1.0, 0.5, 0.2])),
            (
                on("coulomb_friction", &[4.0]),
                EffectOnJoint::new("coulomb_friction", "other", [1.0]),
            ),
        ];
        assert!(none.iter().all(|(a, b)| joined(a, b).is_none()));
    }

    /// Friction falls as far as there is some.
    #[test]
    fn known_friction_may_decrease() {
        let known = [on("viscous_friction", &[8.0]), on("stribeck_friction", &[5.0, 3.0, 0.1])];
        let may = |slug: &str, parameters: &[f64]| {
            Library::standard().admitted_beside(&known, &on(slug, parameters))
        };
        assert!(may("viscous_friction", &[-5.0]) && may("viscous_friction", &[-8.4]));
        assert!(!may("viscous_friction", &[-9.0]) && !may("quadratic_drag", &[-0.1]));
        assert!(may("coulomb_friction", &[-2.0]) && !may("coulomb_friction", &[-4.0]));
        assert!(!may("friction_drift", &[0.0, -3.0, 10.0]) && may("viscous_friction", &[1.0]));
        assert!(may("asymmetric_coulomb_friction", &[1.0, 0.5]));
        assert!(!may("presliding_hysteresis", &[-1.0, -20.0, 0.0]));
        let elsewhere = EffectOnJoint::new("viscous_friction", "other", [-1.0]);
        assert!(!Library::standard().admitted_beside(&known, &elsewhere));
    }

    #[test]
    fn decreases_are_recognised() {
        let less = |slug: &str, values: &[(&str, f64)]| {
            Library::standard()
                .is_less(slug, |name| values.iter().find(|(n, _)| *n == name).map(|(_, x)| *x))
        };
        assert!(less("viscous_friction", &[("coefficient", -2.0)]));
        assert!(!less("viscous_friction", &[("coefficient", 2.0)]));
        assert!(!less("torque_offset", &[("offset", -2.0)]));
        let levels =
            |positive, negative| [("level_positive", positive), ("level_negative", negative)];
        assert!(less("asymmetric_coulomb_friction", &levels(-1.0, -2.0)));
        assert!(!less("asymmetric_coulomb_friction", &levels(1.0, -2.0)));
    }

    #[test]
    fn inadmissible_effects_are_joined() {
        let effects = vec![
            on("viscous_friction", &[8.0]),
            on("coulomb_friction", &[5.0]),
            on("friction_drift", &[0.0, -3.0, 10.0]),
            on("asymmetric_coulomb_friction", &[-2.0, -1.0]),
            on("quadratic_drag", &[-0.5]),
        ];
        let left = Library::standard().joined_where_inadmissible(effects);
        assert_eq!(left.len(), 3);
        assert_eq!(left[0], on("friction_drift", &[8.0, 5.0, 10.0]));
        assert_eq!(left[1], on("asymmetric_coulomb_friction", &[3.0, 4.0]));
        assert_eq!(left[2], on("quadratic_drag", &[-0.5]));
    }
}
