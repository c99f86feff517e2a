//! What each effort column is.

use crate::layout::{Block, Table, significant};
use crate::results::CheckReport;
use crate::section::Section;

/// The evidence on each effort column. A terminal has the verdicts only.
pub(crate) struct Columns;

impl Section<CheckReport> for Columns {
    fn key(&self) -> &'static str {
        "channels"
    }

    fn text(&self, _: &CheckReport) -> Vec<Block> {
        Vec::new()
    }

    fn page(&self, result: &CheckReport) -> Vec<Block> {
        let number = |x: f64, digits| significant(x, digits, 0.0);
        let rows = result.channels.iter().map(|c| {
            let likely = c.probability.iter().max_by(|a, b| a.1.total_cmp(b.1));
            let [low, high] = c.gain_95.map(|end| number(end.unwrap_or(f64::NAN), 4));
            vec![
                c.joint.clone(),
                c.column.clone(),
                likely.map_or_else(String::new, |(kind, _)| kind.replace('_', " ")),
                likely.map_or_else(|| "-".to_owned(), |(_, p)| number(*p, 3)),
                number(c.gain, 4),
                format!("{low} to {high}"),
                number(c.sd, 3),
                number(c.residual_rms, 3),
                number(c.urdf_sd, 3),
            ]
        });
        let heads =
            ["probability", "gain", "95 % interval", "std deviation", "free-fit residual", "URDF"];
        let table = Table::new("Effort columns", &["joint", "column", "most likely"]);
        vec![Block::heading("Checks"), Block::Table(table.numbers(&heads).with(rows))]
    }
}
