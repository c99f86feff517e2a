//! Position errors under commands.

use crate::layout::{Block, Cell, Table, significant};
use crate::results::{PositionsUnderCommands, ValidateReport};
use crate::section::Section;
use crate::words::counted;

/// Positions of the model under the recorded commands, beside those of the commands themselves.
pub(crate) struct PositionError;

impl Section<ValidateReport> for PositionError {
    fn key(&self) -> &'static str {
        "position-error"
    }

    fn text(&self, result: &ValidateReport) -> Vec<Block> {
        let Some(errors) = &result.positions else { return Vec::new() };
        let note = format!("RMS, {}", result.position_units());
        vec![
            Block::heading_with_note("Position error under the commands", note),
            table(result, errors, ""),
            Block::Line(windows(errors)),
        ]
    }

    fn page(&self, result: &ValidateReport) -> Vec<Block> {
        let Some(errors) = &result.positions else { return Vec::new() };
        let caption =
            format!("Position error under the commands (RMS, {})", result.position_units());
        vec![
            Block::heading("Errors"),
            table(result, errors, &caption),
            Block::Line(windows(errors)),
        ]
    }
}

fn table(result: &ValidateReport, errors: &PositionsUnderCommands, caption: &str) -> Block {
    let rows = result.joints.iter().filter_map(|joint| {
        let of = |errors: &crate::results::ByJoint| errors.get(joint).copied();
        let (command, whole) = (of(&errors.command)?, of(&errors.whole)?);
        let numbers = [command, whole, of(&errors.in_windows)?].map(|x| significant(x, 3, 0.0));
        let cells = std::iter::once(joint.clone()).chain(numbers).map(Cell::from);
        Some(cells.chain([Cell::Bar(command, whole)]).collect())
    });
    let heads = ["command", "model", "model in windows"];
    let table = Table::new(caption, &["joint"]).numbers(&heads).texts(&["model/command"]);
    Block::Table(table.with(rows))
}

/// `140 windows of 2 s, each from its recorded state on, 1 diverged`.
fn windows(errors: &PositionsUnderCommands) -> String {
    let diverged = match errors.diverged {
        0 => String::new(),
        n => format!(", {n} diverged"),
    };
    format!(
        "{} of {} s, each from its recorded state on{diverged}",
        counted(errors.windows, "window"),
        significant(errors.window_s, 3, 0.0)
    )
}
