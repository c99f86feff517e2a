//! One finding of a diagnosis.

use std::collections::BTreeMap;

use armident_diagnose as diagnose;
use armident_effects::is_less;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::{significant, uncertain, unit_after_number};
use crate::words::{effect_at, effect_label, location};

/// A parameter with its standard error.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct EstimateRow {
    /// Estimate.
    pub value: f64,
    /// Standard error; `null` where it is not known.
    pub stderr: Option<f64>,
    /// Unit; `1` of a pure number.
    pub unit: String,
}

impl EstimateRow {
    /// Whether it is part of the law: not a term at 0 without a standard error.
    pub fn is_needed(&self) -> bool {
        self.value != 0.0 || self.stderr.is_some()
    }

    /// `0.604 ± 0.052 kg`.
    pub fn text(&self) -> String {
        let number = match self.stderr {
            Some(stderr) => {
                let (number, error) = uncertain(self.value, stderr);
                format!("{number} \u{b1} {error}")
            }
            None => significant(self.value, 3, 0.0),
        };
        format!("{number} {}", unit_after_number(&self.unit)).trim_end().to_owned()
    }
}

/// Kind of residual structure that no law explains.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CharacterRow {
    /// `dissipative` (work is lost in both directions), `conservative` (work is returned), or `neither`.
    pub kind: String,
    /// Work lost over all work exchanged, -1 to 1.
    pub work_share: f64,
    /// Share explained by time or travel since the last reversal.
    pub memory_share: f64,
    /// Share explained by time.
    pub drift_share: f64,
    /// Cycles a turn (a metre) of the strongest wave in the position, and the share that it explains.
    pub wave: [f64; 2],
}

impl CharacterRow {
    /// The kind, and traits that explain more than half.
    pub fn traits(&self) -> Vec<String> {
        const MOST: f64 = 0.5;
        let neither = !["dissipative", "conservative"].contains(&self.kind.as_str());
        let kind = if neither { "neither dissipative nor conservative" } else { &self.kind };
        let mut traits = vec![kind.to_owned()];
        if self.memory_share > MOST {
            traits.push("hysteretic".to_owned());
        }
        if self.drift_share > MOST {
            traits.push("drifting".to_owned());
        }
        if self.wave[1] > MOST {
            traits.push(format!("periodic in position (order {})", self.wave[0]));
        }
        traits
    }
}

/// Evidence of a finding.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct EvidenceRow {
    /// Root mean square effort that only this finding explains, all else refitted, in noise levels (`effort_noise`) of
    /// `joint`.
    pub materiality: f64,
    /// Least materiality to be reported there.
    #[serde(alias = "least_materiality")]
    pub materiality_threshold: f64,
    /// The joint on which it is most material.
    pub joint: String,
    /// Of `unmodelled`: columns that the structure depends on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub variables: Vec<String>,
    /// Of `unmodelled`: kind of structure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub character: Option<CharacterRow>,
    /// Share of the squared error of the hold-out on `joint` that the finding removes, all else refitted; negative where the error
    /// is higher with it. Absent without a hold-out, for contacts, and for arms without efforts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holdout_gain: Option<f64>,
}

/// An effect that the recordings cannot distinguish from a finding.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct AlternativeRow {
    /// Slug of the effect.
    pub effect: String,
    /// Its joints.
    pub joints: Vec<String>,
    /// Its link, or `null`.
    pub link: Option<String>,
    /// Additional root mean square residual with it instead of the finding, in noise levels.
    #[serde(alias = "left_more")]
    pub extra_residual: Option<f64>,
    /// How to distinguish the two; `null` where the library knows no motion.
    pub separated_by: Option<String>,
}

impl AlternativeRow {
    /// The effect at its location.
    pub fn title(&self) -> String {
        effect_at(&self.effect, &self.joints, self.link.as_deref())
    }
}

/// One effect that is missing from the model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct FindingRow {
    /// Slug of the effect (as in `simulate --effect`), or `unmodelled`: structure that no law of the library explains.
    pub effect: String,
    /// One joint; two for `joint_coupling`; none for effects of the whole arm (`gravity_direction`, `time_delay`).
    pub joints: Vec<String>,
    /// Link of `payload` and `link_inertia_error`, else `null`.
    pub link: Option<String>,
    /// Of `external_contact`: begin and end in its recording \[s\], else `null`.
    pub window: Option<[f64; 2]>,
    /// Of `external_contact`: the recording (file without its extension), else `null`.
    pub recording: Option<String>,
    /// Parameters of the law, those that the motion does not excite left out.
    pub parameters: BTreeMap<String, EstimateRow>,
    /// A score: 0.50 at the threshold of materiality or size, 0.95 at twice the threshold; less with rivals.
    pub confidence: f64,
    /// Whether the hold-out error is lower with the finding than without it, all else refitted; `null` without a
    /// hold-out, and for contacts.
    pub confirmed: Option<bool>,
    /// Evidence.
    pub evidence: EvidenceRow,
    /// Effects that the recordings cannot distinguish from it.
    pub alternatives: Vec<AlternativeRow>,
}

impl FindingRow {
    /// Of a finding of the diagnosis.
    pub(crate) fn of(found: &diagnose::Finding) -> Self {
        let estimate = |value: &diagnose::Value| EstimateRow {
            value: value.value,
            stderr: value.stderr,
            unit: value.unit.to_owned(),
        };
        let character = found.evidence.character.as_ref().map(|character| CharacterRow {
            kind: character.kind.to_owned(),
            work_share: character.work_share,
            memory_share: character.memory_share,
            drift_share: character.drift_share,
            wave: character.wave,
        });
        Self {
            effect: found.effect.clone(),
            joints: found.joints.clone(),
            link: found.link.clone(),
            window: found.window,
            recording: found.recording.clone(),
            parameters: (found.parameters.iter())
                .map(|(name, value)| ((*name).to_owned(), estimate(value)))
                .collect(),
            confidence: found.confidence,
            confirmed: found.confirmed,
            evidence: EvidenceRow {
                materiality: found.evidence.materiality,
                materiality_threshold: found.evidence.least_materiality,
                joint: found.evidence.joint.clone(),
                variables: found.evidence.variables.clone(),
                character,
                holdout_gain: found.evidence.holdout_gain,
            },
            alternatives: (found.alternatives.iter())
                .map(|other| AlternativeRow {
                    effect: other.effect.clone(),
                    joints: other.joints.clone(),
                    link: other.link.clone(),
                    extra_residual: other.left_more,
                    separated_by: other.separated_by.map(ToOwned::to_owned),
                })
                .collect(),
        }
    }

    /// Label of the effect; `lower` before it where parameters that cannot be negative have fallen.
    pub fn label(&self) -> String {
        format!("{}{}", self.lower(), effect_label(&self.effect))
    }

    /// The label with the location.
    pub fn title(&self) -> String {
        let at = effect_at(&self.effect, &self.joints, self.link.as_deref());
        format!("{}{at}", self.lower())
    }

    fn lower(&self) -> &'static str {
        let value = |name: &str| self.parameters.get(name).map(|estimate| estimate.value);
        if is_less(&self.effect, value) { "lower " } else { "" }
    }

    /// Joint or link; nothing for effects of the whole arm.
    pub fn location(&self) -> String {
        location(&self.joints, self.link.as_deref())
    }
}
