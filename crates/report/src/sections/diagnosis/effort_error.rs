//! Effort errors on the hold-out, or else on the training recordings.

use crate::layout::{Block, Cell, Table, significant};
use crate::results::{ByJoint, DiagnoseReport, EffortErrors};
use crate::section::{DiagnosisSection, Section};
use crate::words::counted;

/// Effort errors of the given model, the links-only fit and the diagnosed model.
pub(crate) struct EffortError;

impl Section<DiagnoseReport> for EffortError {
    fn key(&self) -> &'static str {
        "effort-error"
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let Some((errors, is_holdout)) = result.fit.judged() else { return Vec::new() };
        let on = if is_holdout { "hold-out" } else { "training recordings" };
        vec![
            Block::heading_with_note(
                format!("Effort error on the {on}"),
                format!("RMS, unfiltered, {}; bar: diagnosed/given", result.effort_units()),
            ),
            table(result, errors, is_holdout, String::new()),
        ]
    }

    fn page(&self, result: &DiagnoseReport) -> Vec<Block> {
        let both = [("hold-out", &result.fit.holdout), ("training", &result.fit.train)];
        let tables = both.into_iter().filter_map(|(name, errors)| {
            let caption =
                format!("Effort error, {name} (RMS, unfiltered, {})", result.effort_units());
            Some(table(result, errors.as_ref()?, name == "hold-out", caption))
        });
        let tables: Vec<Block> = tables.collect();
        if tables.is_empty() {
            return Vec::new();
        }
        let recordings = format!(
            "{}, {}.",
            counted(result.recordings.len(), "training recording"),
            counted(result.holdout_recordings.len(), "hold-out recording")
        );
        [vec![Block::heading("Errors"), Block::Line(recordings)], tables].concat()
    }
}

impl DiagnosisSection for EffortError {}

/// One row a joint; whiteness is known of the hold-out.
fn table(
    result: &DiagnoseReport,
    errors: &EffortErrors,
    is_holdout: bool,
    caption: String,
) -> Block {
    let mut table =
        Table::new(caption, &["joint"]).numbers(&["given", "links only", "diagnosed", "noise"]);
    if is_holdout {
        table = table.numbers(&["white (p)"]);
    }
    let table = table.texts(&["diagnosed/given"]);
    let columns = table.columns.len();
    let rows = result.joints.iter().map(|joint| {
        if result.input_checks.excludes(joint) {
            let excluded = std::iter::repeat_n(Cell::from("excluded"), columns - 1);
            return std::iter::once(Cell::from(joint.clone())).chain(excluded).collect();
        }
        let cell = |of: &ByJoint, digits: usize| {
            let number = of.get(joint).map(|number| significant(*number, digits, 0.0));
            Cell::from(number.unwrap_or_else(|| "-".to_owned()))
        };
        let of = [&errors.before, &errors.rigid, &errors.after, &result.effort_noise];
        let mut row = vec![Cell::from(joint.clone())];
        row.extend(of.map(|numbers| cell(numbers, 3)));
        if is_holdout {
            row.push(cell(&result.whiteness_p, 2));
        }
        let ends = errors.before.get(joint).zip(errors.after.get(joint));
        row.push(ends.map_or_else(|| Cell::from(""), |(given, found)| Cell::Bar(*given, *found)));
        row
    });
    Block::Table(table.with(rows))
}
