//! Parameters of two results.

use crate::layout::{Block, Table, significant, uncertain};
use crate::results::{ComparisonReport, DIFFERS, ParameterDifference};
use crate::section::Section;

/// Parameters, the most different first.
pub(crate) struct Parameters;

/// Heads of the numbers.
const HEADS: [&str; 5] = ["first", "std error", "second", "std error", "difference/se"];

impl Section<ComparisonReport> for Parameters {
    fn key(&self) -> &'static str {
        "parameters"
    }

    fn text(&self, result: &ComparisonReport) -> Vec<Block> {
        // those in one result alone too
        let is_apart = |p: &&ParameterDifference| match p.deviation {
            Some(deviation) => deviation.abs() > DIFFERS,
            None => p.values.contains(&None),
        };
        let apart: Vec<&ParameterDifference> = result.parameters.iter().filter(is_apart).collect();
        if apart.is_empty() {
            return Vec::new();
        }
        vec![Block::heading("Parameters that differ"), Block::Table(table("", apart))]
    }

    fn page(&self, result: &ComparisonReport) -> Vec<Block> {
        let caption = "Parameters, the most different first";
        vec![Block::heading("Parameters"), Block::Table(table(caption, &result.parameters))]
    }
}

/// A table of parameters.
pub(super) fn table<'p>(
    caption: &str,
    parameters: impl IntoIterator<Item = &'p ParameterDifference>,
) -> Table {
    let rows = parameters.into_iter().map(|parameter| {
        let mut row = vec![parameter.parameter.clone(), parameter.location.clone()];
        for (value, error) in parameter.values.into_iter().zip(parameter.standard_errors) {
            row.extend(match (value, error) {
                (Some(value), Some(error)) => <[String; 2]>::from(uncertain(value, error)),
                (Some(value), None) => [significant(value, 4, 0.0), "-".to_owned()],
                (None, _) => ["-".to_owned(), "-".to_owned()],
            });
        }
        row.push(parameter.deviation.map_or_else(|| "-".to_owned(), |d| format!("{d:+.1}")));
        row.push(parameter.unit.clone());
        row
    });
    Table::new(caption, &["parameter", "location"]).numbers(&HEADS).texts(&["unit"]).with(rows)
}
