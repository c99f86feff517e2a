//! Position errors of a diagnosis from commands.

use armident_ident::{ServoJointFit, ServoParameter};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::{Block, Cell, Table, significant};
use crate::results::{ByJoint, DiagnoseReport};
use crate::section::SectionData;

/// Root mean square position errors over all recordings of a kind, by joint \[rad or m\].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PositionErrors {
    /// Command minus position.
    pub before: ByJoint,
    /// Simulated from the commands by the diagnosed model.
    pub after: ByJoint,
}

/// Position error of a joint without a law, all others fitted again, over that with it. Errors count by their logarithm where they
/// are large, as in the fit.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ErrorWithoutLaw {
    /// Joint.
    pub joint: String,
    /// `sag` (weight that no controller carries), `sag_and_offset` (both), `delay`, `damping`, `lag` (both), `dry_friction`, `static_friction`, `load_friction`, `offset` or
    /// `inertia`.
    pub law: String,
    /// On the training recordings.
    pub train: f64,
    /// On the hold-out; `null` without one.
    pub holdout: Option<f64>,
}

const LAWS: [(&[ServoParameter], &str); 10] = [
    (&[ServoParameter::Compliance], "sag"),
    (&[ServoParameter::Compliance, ServoParameter::Offset], "sag_and_offset"),
    (&[ServoParameter::Delay, ServoParameter::Damping], "lag"),
    (&[ServoParameter::Delay], "delay"),
    (&[ServoParameter::Damping], "damping"),
    (&[ServoParameter::DryFriction], "dry_friction"),
    (&[ServoParameter::StaticExcess], "static_friction"),
    (&[ServoParameter::LoadFriction], "load_friction"),
    (&[ServoParameter::Offset], "offset"),
    (&[ServoParameter::Inertia], "inertia"),
];

fn without_laws(joints: &[ServoJointFit]) -> Vec<ErrorWithoutLaw> {
    let mut all = Vec::new();
    for fit in joints {
        for (parameters, law) in LAWS {
            let ablation = fit.ablations.iter().find(|without| without.parameters == parameters);
            let Some(ablation) = ablation else { continue };
            let ratio = |[with, without]: [f64; 2]| without / with.max(f64::MIN_POSITIVE);
            all.push(ErrorWithoutLaw {
                joint: fit.joint.clone(),
                law: law.to_owned(),
                train: ratio(ablation.train),
                holdout: ablation.holdout.map(ratio),
            });
        }
    }
    all
}

/// How positions follow from commands. With commands instead of efforts.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PositionFit {
    /// Of the training recordings.
    pub train: PositionErrors,
    /// Of the hold-out; `null` without `--holdout`.
    pub holdout: Option<PositionErrors>,
    /// What each law is worth.
    pub without: Vec<ErrorWithoutLaw>,
    /// Joints whose recorded current is a magnitude.
    pub currents_without_sign: Vec<String>,
    /// Joints whose stiffness no motion determines: their friction is known over it.
    pub stiffness_not_determined: Vec<String>,
}

impl PositionFit {
    /// Of an identification from commands.
    pub(crate) fn of(joints: &[ServoJointFit], magnitudes: &[String]) -> Self {
        let all = |of: &dyn Fn(&ServoJointFit) -> Vec<f64>| -> ByJoint {
            let together = |fit: &ServoJointFit| {
                let each = of(fit);
                let squares = each.iter().map(|x| x * x).sum::<f64>();
                (fit.joint.clone(), (squares / each.len().max(1) as f64).sqrt())
            };
            joints.iter().map(together).collect()
        };
        let has_holdout = joints.iter().any(|fit| !fit.holdout.is_empty());
        let open = joints.iter().filter(|fit| !fit.is_determined);
        Self {
            train: PositionErrors {
                before: all(&|fit| fit.command_error[0].clone()),
                after: all(&|fit| fit.train.clone()),
            },
            holdout: has_holdout.then(|| PositionErrors {
                before: all(&|fit| fit.command_error[1].clone()),
                after: all(&|fit| fit.holdout.clone()),
            }),
            without: without_laws(joints),
            currents_without_sign: magnitudes.to_vec(),
            stiffness_not_determined: open.map(|fit| fit.joint.clone()).collect(),
        }
    }
}

impl SectionData for PositionFit {
    const KEY: &'static str = "position_fit";

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let (errors, on) = match &self.holdout {
            Some(errors) => (errors, "hold-out"),
            None => (&self.train, "training recordings"),
        };
        let rows = result.joints.iter().map(|joint| {
            let of = |errors: &ByJoint| errors.get(joint).copied();
            let cell = |error: Option<f64>| {
                Cell::from(error.map_or_else(|| "-".to_owned(), |x| significant(x, 3, 0.0)))
            };
            let (before, after) = (of(&errors.before), of(&errors.after));
            let bar = before.zip(after).map_or_else(|| Cell::from(""), |(b, a)| Cell::Bar(b, a));
            vec![Cell::from(joint.clone()), cell(before), cell(after), bar]
        });
        let table =
            Table::new("", &["joint"]).numbers(&["given", "diagnosed"]).texts(&["diagnosed/given"]);
        let note = format!(
            "RMS, {}; given: command minus position; diagnosed: simulated from the commands",
            result.position_units()
        );
        let mut blocks = vec![
            Block::heading_with_note(format!("Position error on the {on}"), note),
            Block::Table(table.with(rows)),
        ];
        blocks.extend(self.worth(result, on));
        if !self.stiffness_not_determined.is_empty() {
            blocks.push(Block::Paragraph(format!(
                "The stiffness of {} is not identifiable: the weight on the joint moves it too little, and commands give only \
                 ratios to the stiffness. Record a known load on the joint.",
                self.stiffness_not_determined.join(", ")
            )));
        }
        if !self.currents_without_sign.is_empty() {
            blocks.push(Block::Paragraph(format!(
                "The currents of {} are magnitudes, never negative while the controller pushes both ways. They are not used.",
                self.currents_without_sign.join(", ")
            )));
        }
        blocks
    }
}

impl PositionFit {
    /// How much larger the error of each joint is without each law.
    fn worth(&self, result: &DiagnoseReport, on: &str) -> Vec<Block> {
        if self.without.is_empty() {
            return Vec::new();
        }
        let titles: Vec<String> = LAWS.iter().map(|(_, law)| law.replace('_', " ")).collect();
        let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
        let rows = result.joints.iter().map(|joint| {
            let of = |law: &str| {
                let one = self.without.iter().find(|one| one.joint == *joint && one.law == law);
                let percent = one.map(|one| 100.0 * (one.holdout.unwrap_or(one.train) - 1.0));
                percent.map_or_else(String::new, |p| format!("{p:.0} %"))
            };
            std::iter::once(joint.clone()).chain(LAWS.iter().map(|(_, law)| of(law))).collect()
        });
        let rows: Vec<Vec<String>> = rows.collect();
        vec![
            Block::heading_with_note(
                "What each law is worth",
                format!(
                    "increase of the position error on the {on} without it, all others fitted again"
                ),
            ),
            Block::Table(
                Table::new("", &["joint"]).numbers(&titles).with(rows).without_empty_columns(),
            ),
        ]
    }
}
