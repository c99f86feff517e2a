//! What a diagnosis from commands says of a case, against what is in it.

use armident_diagnose::{Finding, ServoDiagnosis};
use armident_effects::{
    CoulombFriction, Effect, LoadDependentFriction, StribeckFriction, TorqueOffset,
};
use serde::Serialize;

use super::command_case::CommandCase;

/// Least confidence of a finding that counts.
const LEAST_CONFIDENCE: f64 = 0.5;

/// An effect that is there, and whether it is named on its joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedEffect {
    /// Slug of its law.
    pub effect: &'static str,
    /// Its joint.
    pub joint: String,
    /// RMS change of the positions without it, in standard deviations of the noise of a recorded position.
    pub size: f64,
    /// Whether a finding names it, or names another law and this as what it may be instead.
    pub is_named: bool,
}

/// An estimate of a controller against the true one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ControllerEstimate {
    /// The joint.
    pub joint: String,
    /// Estimated over true stiffness; `null` where the stiffness is not determined.
    pub stiffness_ratio: Option<f64>,
    /// Estimated minus true stiffness in standard errors; `null` where these are not known.
    pub stiffness_deviation: Option<f64>,
    /// Estimated minus true delay \[s\].
    pub delay_error_s: f64,
    /// The same in standard errors; `null` where these are not known.
    pub delay_deviation: Option<f64>,
}

/// The score of one case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CommandScore {
    /// Its name.
    pub case: String,
    /// The robot.
    pub robot: String,
    /// Whether its controllers are all there is.
    pub is_null: bool,
    /// What is there.
    pub effects: Vec<NamedEffect>,
    /// Findings of dry friction or an offset on a joint without them: `effect on joint: parameters`.
    pub false_names: Vec<String>,
    /// Joint by joint.
    pub controllers: Vec<ControllerEstimate>,
    /// Why there is no diagnosis, if there is none.
    pub error: Option<String>,
}

fn is_dry(effect: &str) -> bool {
    [CoulombFriction.slug(), StribeckFriction.slug(), LoadDependentFriction.slug()]
        .contains(&effect)
}

impl CommandScore {
    pub(crate) fn failed(case: String, is_null: bool, robot: &str, error: String) -> Self {
        Self {
            case,
            robot: robot.to_owned(),
            is_null,
            effects: Vec::new(),
            false_names: Vec::new(),
            controllers: Vec::new(),
            error: Some(error),
        }
    }

    pub(crate) fn of(
        name: String,
        is_null: bool,
        case: &CommandCase,
        found: &ServoDiagnosis,
    ) -> Self {
        let findings: Vec<&Finding> =
            found.findings.iter().filter(|f| f.confidence >= LEAST_CONFIDENCE).collect();
        let is_there = |effect: &str, joint: &str| {
            let same = |other: &str| other == effect || is_dry(other) && is_dry(effect);
            case.present.iter().any(|present| present.joint == joint && same(present.effect))
        };
        let names = |finding: &&Finding, effect: &str, joint: &str| {
            let has = |slug: &str, joints: &[String]| slug == effect && joints == [joint];
            has(&finding.effect, &finding.joints)
                || finding.alternatives.iter().any(|other| has(&other.effect, &other.joints))
        };
        let effects = case.present.iter().map(|present| NamedEffect {
            effect: present.effect,
            joint: present.joint.clone(),
            size: present.size,
            is_named: findings.iter().any(|f| names(f, present.effect, &present.joint)),
        });
        // controllers, damping and rotors are on every joint
        let can_be_false = |f: &&&Finding| is_dry(&f.effect) || f.effect == TorqueOffset.slug();
        let false_names = findings
            .iter()
            .filter(can_be_false)
            .filter(|f| !is_there(&f.effect, &f.joints[0]))
            .map(|f| {
                let size = |(name, value): (&&str, &armident_diagnose::Value)| {
                    let error = value.stderr.map_or_else(String::new, |e| format!(" ± {e:.3e}"));
                    format!("{name} {:.3e}{error} {}", value.value, value.unit)
                };
                let sizes: Vec<String> = f.parameters.iter().map(size).collect();
                format!("{} on {}: {}", f.effect, f.joints[0], sizes.join(", "))
            });
        let servos = &found.identification.model.servos;
        let controllers = servos.iter().zip(&case.stiffness).map(|(term, stiffness)| {
            let is_known = term.is_determined;
            let off = term.servo.stiffness - stiffness;
            let delay_error_s = term.servo.delay_s - case.delay_s;
            ControllerEstimate {
                joint: term.joint.clone(),
                stiffness_ratio: is_known.then(|| term.servo.stiffness / stiffness),
                stiffness_deviation: (term.stiffness_error.filter(|_| is_known))
                    .map(|error| off / error),
                delay_error_s,
                delay_deviation: term.delay_error_s.map(|error| delay_error_s / error),
            }
        });
        Self {
            case: name,
            robot: case.robot.clone(),
            is_null,
            effects: effects.collect(),
            false_names: false_names.collect(),
            controllers: controllers.collect(),
            error: None,
        }
    }
}
