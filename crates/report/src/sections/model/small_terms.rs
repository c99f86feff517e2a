//! Small terms: in the model because they lower the cross-validated error, below the materiality threshold.

use std::collections::BTreeMap;

use armident_effects::effect;
use armident_model::is_sublinear;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::{Block, significant};
use crate::results::DiagnoseReport;
use crate::section::{SectionData, Source};
use crate::words::effect_label;

/// A term of the model that no finding stands for.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct SmallTerm {
    /// Slug of the effect.
    pub effect: String,
    /// Joint.
    pub joint: String,
    /// Parameters of the law.
    pub parameters: BTreeMap<String, SmallTermParameter>,
}

/// A parameter of a small term.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(crate) struct SmallTermParameter {
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// Small terms of the model; not with `--reference` or a model that has effects: there, the model has all terms of
/// these, small or not.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct SmallTerms(pub Vec<SmallTerm>);

impl SectionData for SmallTerms {
    const KEY: &'static str = "small_terms";

    fn of(source: &Source<'_>) -> Option<Self> {
        let Source { chain, diagnosis, inputs } = source;
        if !inputs.reference_recordings.is_empty() || inputs.beyond_a_model {
            return None;
        }
        let is_reported = |slug: &str, joint: &String| {
            diagnosis.findings.iter().any(|f| f.effect == slug && f.joints.first() == Some(joint))
        };
        let effects = diagnosis.model.joint_effects();
        let terms: Vec<SmallTerm> = effects
            // sublinear friction is not small, and has a section of its own
            .filter(|on| !is_reported(&on.effect, &on.joint) && !is_sublinear(&on.effect))
            .filter_map(|on| {
                let law = effect(&on.effect)?.law();
                let kind = chain.joints.iter().find(|j| j.name == on.joint)?.kind;
                let parameters = law.parameters.iter().zip(&on.parameters).map(|(p, &value)| {
                    let unit = p.unit(kind).to_owned();
                    (p.name.to_owned(), SmallTermParameter { value, unit })
                });
                let parameters = parameters.collect();
                Some(SmallTerm { effect: on.effect.clone(), joint: on.joint.clone(), parameters })
            })
            .collect();
        (!terms.is_empty()).then_some(Self(terms))
    }

    /// Law by law, the joints with their numbers.
    fn text(&self, _: &DiagnoseReport) -> Vec<Block> {
        let mut by_law: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for term in &self.0 {
            let numbers: Vec<String> = (term.parameters.values())
                .map(|p| format!("{} {}", significant(p.value, 2, 0.0), p.unit))
                .collect();
            let on_joint = format!("{} {}", term.joint, numbers.join(", "));
            by_law.entry(&term.effect).or_default().push(on_joint);
        }
        let law = |(slug, joints): (&str, Vec<String>)| {
            Block::item(format!("{}: {}", effect_label(slug), joints.join(", ")))
        };
        let title = "Small terms in the model";
        std::iter::once(Block::heading_with_note(title, "below the materiality threshold"))
            .chain(by_law.into_iter().map(law))
            .collect()
    }
}
