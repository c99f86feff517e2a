//! What a diagnosed model has beside its findings: terms too small to be named that help its predictions.

use std::collections::BTreeMap;

use armident_diagnose::Diagnosis;
use armident_effects::effect;
use armident_kinematics::DrivingAxisChain;
use armident_model::is_sublinear;
use serde::{Deserialize, Serialize};

use crate::numbers::significant;

/// A term of the model that no finding stands for.
#[derive(Debug, Serialize, Deserialize)]
pub struct SmallTerm {
    effect: String,
    joint: String,
    parameters: BTreeMap<String, Parameter>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Parameter {
    value: f64,
    unit: String,
}

impl SmallTerm {
    /// Those of a diagnosed model, but for friction that bends, which is not small and has no name.
    pub(crate) fn of(chain: &DrivingAxisChain, diagnosis: &Diagnosis) -> Vec<Self> {
        let named = |slug: &str, joint: &String| {
            diagnosis.findings.iter().any(|f| f.effect == slug && f.joints.first() == Some(joint))
        };
        let effects = diagnosis.model.joint_effects();
        effects
            .filter(|on| !named(&on.effect, &on.joint) && !is_sublinear(&on.effect))
            .filter_map(|on| {
                let law = effect(&on.effect)?.law();
                let kind = chain.joints.iter().find(|j| j.name == on.joint)?.kind;
                let parameters = law.parameters.iter().zip(&on.parameters);
                let parameters = parameters
                    .map(|(p, &value)| {
                        (p.name.to_owned(), Parameter { value, unit: p.unit(kind).to_owned() })
                    })
                    .collect();
                Some(Self { effect: on.effect.clone(), joint: on.joint.clone(), parameters })
            })
            .collect()
    }
}

/// One line: law by law, the joints with their numbers.
pub fn small_terms_text(terms: &[SmallTerm]) -> String {
    let mut by_law: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for term in terms {
        let numbers: Vec<String> = (term.parameters.values())
            .map(|p| format!("{} {}", significant(p.value, 2, 0.0), p.unit))
            .collect();
        let on_joint = format!("{} {}", term.joint, numbers.join(", "));
        by_law.entry(&term.effect).or_default().push(on_joint);
    }
    let of_law = |(slug, joints): (&&str, &Vec<String>)| {
        let title = effect(slug).map_or(*slug, |law| law.law().title);
        format!("{title} on {}", joints.join(", "))
    };
    by_law.iter().map(of_law).collect::<Vec<_>>().join("; ")
}
