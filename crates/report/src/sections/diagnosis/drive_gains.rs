//! Gains of drives whose current or voltage was recorded.

use crate::layout::{Block, Table, significant};
use crate::results::DiagnoseReport;
use crate::section::{DiagnosisSection, Section};

/// Drive gains inferred from the masses of the URDF, or known from an earlier fit.
pub(crate) struct DriveGains;

impl Section<DiagnoseReport> for DriveGains {
    fn key(&self) -> &'static str {
        "drive-gains"
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let gains = &result.input_checks.drive_gains;
        if gains.is_empty() {
            return Vec::new();
        }
        let rows = gains.iter().map(|row| {
            let [low, high] =
                row.interval_95.map(|end| significant(end.unwrap_or(f64::NAN), 3, 0.0));
            let gain = match row.determined {
                true => significant(row.gain, 3, 0.0),
                false => "not identifiable, joint excluded".to_owned(),
            };
            let source = if row.of_model { "model" } else { "URDF masses" };
            let interval = format!("{low} to {high}");
            vec![row.joint.clone(), row.quantity.clone(), source.to_owned(), gain, interval]
        });
        let of_masses = gains.iter().any(|row| !row.of_model);
        let table = Table::new("Effort per unit", &["joint", "recorded", "source"])
            .numbers(&["gain", "95 % interval"]);
        let heading = match of_masses {
            true => Block::heading_with_note(
                "Drive gains inferred from the URDF masses",
                "only their ratios are reliable",
            ),
            false => Block::heading("Drive gains of the given model"),
        };
        vec![heading, Block::Table(table.with(rows))]
    }
}

impl DiagnosisSection for DriveGains {}
