//! Effort errors, and tests of the residual.

use crate::layout::{Block, Cell, Table, significant};
use crate::results::ValidateReport;
use crate::section::Section;

/// Effort errors of the model beside the URDF's, coverage and whiteness.
pub(crate) struct EffortError;

/// Quantity of the errors.
const NOTE: &str = "RMS, low-passed; % of the effort's standard deviation";

impl Section<ValidateReport> for EffortError {
    fn key(&self) -> &'static str {
        "effort-error"
    }

    fn text(&self, result: &ValidateReport) -> Vec<Block> {
        if result.after.is_empty() {
            return Vec::new();
        }
        vec![Block::heading_with_note("Effort error", NOTE), table(result, "")]
    }

    fn page(&self, result: &ValidateReport) -> Vec<Block> {
        if result.after.is_empty() {
            return Vec::new();
        }
        let low_pass = result
            .cutoff_hz
            .map(|hz| Block::Line(format!("Low-pass of {} Hz.", significant(hz, 3, 0.0))));
        let mut blocks = vec![Block::heading("Errors")];
        blocks.extend(low_pass);
        blocks.push(table(result, &format!("Effort error ({NOTE})")));
        blocks
    }
}

fn table(result: &ValidateReport, caption: &str) -> Block {
    // an effort that is one number has no variation to be relative to
    let percent =
        |x: f64| if x.is_finite() { format!("{:.1} %", 100.0 * x) } else { "-".to_owned() };
    let optional = |x: Option<f64>, show: &dyn Fn(f64) -> String| x.map_or("-".to_owned(), show);
    let p_value = |p| if p < 1e-4 { "< 1e-4".to_owned() } else { significant(p, 2, 0.0) };
    let rows = result.joints.iter().filter_map(|joint| {
        let (urdf, model) = (result.before.get(joint)?, result.after.get(joint)?);
        let texts = [
            joint.clone(),
            significant(urdf.rmse, 4, 0.0),
            percent(urdf.relative),
            significant(model.rmse, 4, 0.0),
            percent(model.relative),
            significant(model.rmse_raw, 4, 0.0),
            optional(model.band_coverage, &percent),
            optional(model.lag1_correlation, &|x| format!("{x:.2}")),
            optional(model.whiteness_p, &p_value),
        ];
        let bar = Cell::Bar(urdf.rmse, model.rmse);
        Some(texts.map(Cell::from).into_iter().chain([bar]).collect())
    });
    let heads =
        ["URDF only", "", "model", "", "unfiltered", "in 95 % band", "lag-1 corr.", "white (p)"];
    Block::Table(Table::new(caption, &["joint"]).numbers(&heads).texts(&["model/URDF"]).with(rows))
}
