//! Position errors of a diagnosis from commands.

use armident_ident::ServoJointFit;
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

/// How positions follow from commands. With commands instead of efforts.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PositionFit {
    /// Of the training recordings.
    pub train: PositionErrors,
    /// Of the hold-out; `null` without `--holdout`.
    pub holdout: Option<PositionErrors>,
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
