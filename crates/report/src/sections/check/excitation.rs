//! Which constants the recordings determine.

use crate::layout::{Block, Table, percent, significant};
use crate::results::{CheckReport, CheckVerdict, ConstantCheckRow};
use crate::section::Section;

/// Constants and how well they are determined; on a terminal the poorly determined ones only.
pub(crate) struct Excitation;

impl Section<CheckReport> for Excitation {
    fn key(&self) -> &'static str {
        "constants"
    }

    fn text(&self, result: &CheckReport) -> Vec<Block> {
        let poor = result.constants.iter().filter(|c| c.verdict != CheckVerdict::Ok);
        let rows: Vec<Vec<String>> = poor
            .map(|c| {
                vec![
                    c.label.clone(),
                    c.joint.clone(),
                    error(c),
                    significant(c.size, 2, 0.0),
                    c.unit.clone(),
                    c.reason.clone().unwrap_or_default(),
                ]
            })
            .collect();
        if rows.is_empty() {
            return Vec::new();
        }
        let table = Table::new("", &["constant", "joint"])
            .numbers(&["std error", "size"])
            .texts(&["unit", "reason"]);
        vec![
            Block::heading_with_note(
                "Poorly determined constants",
                "standard error above 10 % of size",
            ),
            Block::Table(table.with(rows)),
        ]
    }

    fn page(&self, result: &CheckReport) -> Vec<Block> {
        let mut ordered: Vec<&ConstantCheckRow> = result.constants.iter().collect();
        ordered.sort_by_key(|constant| std::cmp::Reverse(constant.verdict));
        let rows = ordered.into_iter().map(|c| {
            let share = c.standard_error.map(|error| error / c.size);
            vec![
                c.label.clone(),
                c.joint.clone(),
                error(c),
                significant(c.size, 3, 0.0),
                share.map_or_else(|| "-".to_owned(), percent),
                c.unit.clone(),
                c.reason.clone().unwrap_or_default(),
            ]
        });
        let mut about = format!(
            "The recordings alone determine {} of {} parameters; a constant is well determined if its standard error \
             is below 10 % of its size by the URDF.",
            result.rank, result.parameters
        );
        if let Some(hz) = result.cutoff_hz {
            about += &format!(" Low-pass of {} Hz.", significant(hz, 3, 0.0));
        }
        let table = Table::new("Constants", &["constant", "joint"])
            .numbers(&["std error", "size", "relative"])
            .texts(&["unit", "reason"]);
        vec![
            Block::heading("Minimal set and excitation"),
            Block::Line(about),
            Block::Table(table.with(rows)),
        ]
    }
}

fn error(of: &ConstantCheckRow) -> String {
    of.standard_error.map_or_else(|| "-".to_owned(), |error| significant(error, 2, 0.0))
}
