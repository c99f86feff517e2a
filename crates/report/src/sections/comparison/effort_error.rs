//! Effort errors of two results.

use crate::layout::{Block, Cell, Table, significant};
use crate::results::ComparisonReport;
use crate::section::Section;

/// Effort error of each joint in both results.
pub(crate) struct EffortError;

impl Section<ComparisonReport> for EffortError {
    fn key(&self) -> &'static str {
        "effort-error"
    }

    fn text(&self, result: &ComparisonReport) -> Vec<Block> {
        let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| significant(x, 4, 0.0));
        let known = result.effort_error.iter().filter(|row| row.rmse != [None; 2]);
        let rows: Vec<Vec<Cell>> = known
            .map(|row| {
                let bar = match row.rmse {
                    [Some(first), Some(second)] => Cell::Bar(first, second),
                    _ => Cell::from(""),
                };
                let texts = [row.joint.clone(), number(row.rmse[0]), number(row.rmse[1])];
                texts.map(Cell::from).into_iter().chain([bar]).collect()
            })
            .collect();
        if rows.is_empty() {
            return Vec::new();
        }
        let table = Table::new("Effort error (RMS, N m or N)", &["joint"]);
        let table = table.numbers(&["first", "second"]).texts(&["second/first"]).with(rows);
        vec![Block::heading_with_note("Effort error", "RMS, N m or N"), Block::Table(table)]
    }
}
