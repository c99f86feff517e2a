//! Gears between a motor whose current and a torque sensor whose effort was recorded.

use crate::layout::{Block, Table, significant, uncertain};
use crate::results::{IdentifyReport, SensedNumber};
use crate::section::Section;

/// Gears between motor and torque sensor.
pub(crate) struct SensedGears;

impl Section<IdentifyReport> for SensedGears {
    fn key(&self) -> &'static str {
        "sensed_gears"
    }

    fn text(&self, result: &IdentifyReport) -> Vec<Block> {
        if result.sensed_gears.is_empty() {
            return Vec::new();
        }
        let number = |of: SensedNumber| {
            let (value, error) = uncertain(of.value, of.standard_error);
            format!("{value} ± {error}")
        };
        let rows = result.sensed_gears.iter().map(|row| {
            let numbers = [row.gain, row.viscous, row.coulomb, row.inertia, row.offset].map(number);
            let mut cells = vec![row.joint.clone()];
            if !row.determined {
                cells.push("not identifiable".to_owned());
                cells.resize(7, "-".to_owned());
                return cells;
            }
            cells.extend(numbers);
            cells.push(significant(row.rms, 3, 0.0));
            cells
        });
        let table = Table::new("", &["joint"]).numbers(&[
            "gain [N m/A]",
            "viscous [N m s/rad]",
            "Coulomb [N m]",
            "inertia [kg m2]",
            "offset [N m]",
            "RMS [N m]",
        ]);
        vec![
            Block::heading_with_note(
                "Gears between motor and torque sensor",
                "of current and effort alone, whatever the links; friction of the joint effects is behind the sensor",
            ),
            Block::Table(table.with(rows)),
        ]
    }
}
