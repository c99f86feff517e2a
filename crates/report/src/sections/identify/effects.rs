//! Parameters of effects on joints.

use super::titles::MINIMAL_SET;
use crate::layout::{Block, Table, significant, uncertain};
use crate::results::{EffectRow, IdentifyReport, NOT_IDENTIFIED};
use crate::section::Section;
use crate::words::{effect_label, parameter_label};

/// Effects on joints.
pub(crate) struct JointEffects;

impl Section<IdentifyReport> for JointEffects {
    fn key(&self) -> &'static str {
        "effects"
    }

    fn text(&self, result: &IdentifyReport) -> Vec<Block> {
        if result.effects.is_empty() {
            return Vec::new();
        }
        let name = |row: &EffectRow| match &row.other_joint {
            Some(_) => format!("{}.{}", row.effect, row.parameter),
            None => row.effect.clone(),
        };
        vec![Block::heading("Joint effects"), table(result, "effect", name)]
    }

    fn page(&self, result: &IdentifyReport) -> Vec<Block> {
        if result.effects.is_empty() {
            return Vec::new();
        }
        let name = |row: &EffectRow| {
            format!("{}, {}", effect_label(&row.effect), parameter_label(&row.parameter))
        };
        vec![Block::heading(MINIMAL_SET), table(result, "effect, parameter", name)]
    }
}

fn table(result: &IdentifyReport, head: &str, name: impl Fn(&EffectRow) -> String) -> Block {
    let rows = result.effects.iter().map(|row| {
        let (value, error) = match row.standard_error {
            Some(error) => uncertain(row.value, error),
            None if row.at_bound => ("0".to_owned(), "-".to_owned()),
            None => (significant(row.value, 4, 0.0), "-".to_owned()),
        };
        let remark = if row.at_bound {
            "at bound (0)".to_owned()
        } else if row.undetermined > NOT_IDENTIFIED {
            format!("{:.0} % not identified", 100.0 * row.undetermined)
        } else if row.admissible {
            String::new()
        } else {
            "inadmissible sign".to_owned()
        };
        let other = row.other_joint.iter();
        let joints: Vec<&str> =
            std::iter::once(&row.joint).chain(other).map(String::as_str).collect();
        vec![name(row), joints.join(", "), value, error, row.unit.clone(), remark]
    });
    let table = Table::new("Joint effects", &[head, "joint"])
        .numbers(&["estimate", "std error", "unit"])
        .texts(&[""]);
    Block::Table(table.with(rows))
}
