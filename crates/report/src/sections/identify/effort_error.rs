//! Effort errors by joint.

use super::titles::FIT;
use crate::layout::{Block, Cell, Table, percent, significant};
use crate::results::{ByJoint, FitRows, IdentifyReport};
use crate::section::Section;

/// Effort errors of training, cross-validation and hold-out beside the URDF's.
pub(crate) struct EffortError;

impl Section<IdentifyReport> for EffortError {
    fn key(&self) -> &'static str {
        "effort-error"
    }

    fn text(&self, result: &IdentifyReport) -> Vec<Block> {
        let cells = |rows: &FitRows, joint: &String| {
            [
                number(&rows.rmse, joint, 4),
                rows.relative.get(joint).map_or("-".to_owned(), |x| format!("{:.1} %", 100.0 * x)),
            ]
            .map(Cell::from)
        };
        let fits = [
            ("training", Some(&result.fit.train)),
            ("cross-validated", result.cross_validation.as_ref()),
            ("hold-out", result.fit.holdout.as_ref()),
            ("URDF only", Some(&result.fit.urdf)),
        ];
        let fits: Vec<(&str, &FitRows)> =
            fits.into_iter().filter_map(|(name, rows)| Some((name, rows?))).collect();
        let rows = result.joints.iter().map(|joint| {
            let mut row = vec![Cell::from(joint.clone())];
            row.extend(fits.iter().flat_map(|(_, rows)| cells(rows, joint)));
            // the URDF was evaluated on the same recordings
            let (model, _) = result.judged();
            let ends = result.fit.urdf.rmse.get(joint).zip(model.rmse.get(joint));
            row.push(ends.map_or_else(|| Cell::from(""), |(urdf, model)| Cell::Bar(*urdf, *model)));
            row
        });
        let heads: Vec<&str> = fits.iter().flat_map(|(name, _)| [*name, ""]).collect();
        let table = Table::new("", &["joint"]).numbers(&heads).texts(&["model/URDF"]);
        vec![
            Block::heading_with_note(
                "Effort error",
                "RMS, low-passed; % of the effort's standard deviation",
            ),
            Block::Table(table.with(rows)),
        ]
    }

    fn page(&self, result: &IdentifyReport) -> Vec<Block> {
        let share = |numbers: &ByJoint, joint: &String| {
            numbers.get(joint).map_or_else(|| "-".to_owned(), |x| percent(*x))
        };
        let empty = FitRows::default();
        let holdout = result.fit.holdout.as_ref().unwrap_or(&empty);
        let rows = result.joints.iter().map(|joint| {
            let fits = [&result.fit.train, holdout, &result.fit.urdf];
            let of = |fit: &FitRows| [number(&fit.rmse, joint, 4), share(&fit.relative, joint)];
            let mut row = vec![joint.clone()];
            row.extend(fits.into_iter().flat_map(of));
            row.push(number(&result.effort_noise, joint, 3));
            row
        });
        let caption = "Effort error (RMS, low-passed; % of the effort's standard deviation)";
        let heads = ["training", "%", "hold-out", "%", "URDF only", "%", "noise level"];
        let table = Table::new(caption, &["joint"]).numbers(&heads);
        vec![Block::heading(FIT), Block::Table(table.with(rows))]
    }
}

fn number(numbers: &ByJoint, joint: &String, digits: usize) -> String {
    numbers.get(joint).map_or_else(|| "-".to_owned(), |x| significant(*x, digits, 0.0))
}
