//! Residual of each joint, and what it depends on.

use crate::layout::{Block, Table, significant};
use crate::results::diagnosis::in_noise_levels;
use crate::results::{DiagnoseReport, JointResiduals};
use crate::section::{DiagnosisSection, Section};

/// Share of the residual variance below which no regressor is printed.
const SHOWN: f64 = 0.1;

/// The residual map, one row a joint. The page has it joint by joint, as charts.
pub(crate) struct ResidualMap;

impl Section<DiagnoseReport> for ResidualMap {
    fn key(&self) -> &'static str {
        "residual_map"
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        if result.residual_map.is_empty() {
            return Vec::new();
        }
        let rows = result.residual_map.iter().map(|joint| {
            if result.input_checks.excludes(&joint.joint) {
                let excluded = std::iter::repeat_n("excluded".to_owned(), 5);
                return std::iter::once(joint.joint.clone()).chain(excluded).collect();
            }
            row(joint)
        });
        let given = format!("given [{}]", result.effort_units());
        let table = Table::new("", &["joint"])
            .numbers(&[&given, "links only", "diagnosed", "residual/noise"])
            .texts(&["strongest regressor"]);
        vec![
            Block::heading_with_note(
                "Residual by joint",
                "training recordings, in-band RMS; share of its variance explained",
            ),
            Block::Table(table.with(rows)),
        ]
    }

    fn page(&self, _: &DiagnoseReport) -> Vec<Block> {
        Vec::new()
    }
}

impl DiagnosisSection for ResidualMap {}

fn row(joint: &JointResiduals) -> Vec<String> {
    let explained = |residual: f64| {
        let share = 1.0 - (residual / joint.before).powi(2);
        format!("{:.0} %", 100.0 * share.max(0.0))
    };
    let strongest = match (joint.regressors.first(), joint.variables.first()) {
        (Some(of), _) if of.share_before > SHOWN => {
            format!("{} {:.0} %: {}", of.function, 100.0 * of.share_before, of.indicates)
        }
        (_, Some(of)) if of.share_before > SHOWN => {
            format!("{} {:.0} %", of.variable.replace('_', " "), 100.0 * of.share_before)
        }
        _ => "-".to_owned(),
    };
    vec![
        joint.joint.clone(),
        significant(joint.before, 3, 0.0),
        explained(joint.rigid),
        explained(joint.after),
        in_noise_levels(joint.residual_over_noise(), 3),
        strongest,
    ]
}
