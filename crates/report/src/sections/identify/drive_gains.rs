//! Gains of drives whose current was recorded.

use crate::layout::{Block, Table, significant, uncertain};
use crate::results::IdentifyReport;
use crate::section::Section;

/// Drive gains.
pub(crate) struct DriveGains;

impl Section<IdentifyReport> for DriveGains {
    fn key(&self) -> &'static str {
        "drive_gains"
    }

    fn text(&self, result: &IdentifyReport) -> Vec<Block> {
        if result.drive_gains.is_empty() {
            return Vec::new();
        }
        let rows = result.drive_gains.iter().map(|row| {
            let (value, error) = match row.standard_error {
                Some(error) => uncertain(row.value, error),
                None => (significant(row.value, 4, 0.0), "-".to_owned()),
            };
            let interval = match row.interval_95 {
                Some([a, b]) => {
                    format!("{} to {}", significant(a, 4, 0.0), significant(b, 4, 0.0))
                }
                None if row.standard_error.is_some() => "not identifiable".to_owned(),
                None => "-".to_owned(),
            };
            let used = significant(row.used, 4, 0.0);
            vec![row.joint.clone(), value, error, interval, row.unit.clone(), used]
        });
        let table = Table::new("", &["joint"])
            .numbers(&["gain", "std error", "95 % interval"])
            .texts(&["unit"])
            .numbers(&["used"]);
        vec![
            Block::heading_with_note("Drive gains", "effort per unit current"),
            Block::Table(table.with(rows)),
        ]
    }
}
