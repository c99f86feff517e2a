//! Content of the page of each command's result.

mod card;
mod charts;
mod check;
mod comparison;
mod diagnosis;
mod fleet;
mod identify;
mod joint_cards;
mod other;
mod scoreboard;
mod validate;

use armident_report::{DiagnoseReport, DiagnosisSection};
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::drawing::Drawing;
use crate::error::PageError;
use crate::view::View;

/// Content of the page of a result; a diagnosis has these sections.
pub(crate) fn view(
    schema: &str,
    document: &Value,
    drawing: &Drawing,
    sections: &[&dyn DiagnosisSection],
) -> Result<View, PageError> {
    let kind = schema.split('/').next().unwrap_or_default();
    Ok(match kind {
        "armident.diagnosis" => {
            let result: DiagnoseReport = read(document)?;
            for section in sections {
                section.check(&result).map_err(PageError::Form)?;
            }
            diagnosis::view(&result, drawing, sections)
        }
        "armident.identify" => identify::view(&read(document)?, drawing),
        "armident.validate" => validate::view(&read(document)?, drawing),
        "armident.check" => check::view(&read(document)?, drawing),
        "armident.comparison" => comparison::view(&read(document)?),
        "armident.card" => card::view(&read(document)?),
        "armident.fleet" => fleet::view(&read(document)?),
        "armident.scoreboard" => scoreboard::view(&read(document)?, drawing),
        _ => other::view(kind, document),
    })
}

fn read<T: DeserializeOwned>(document: &Value) -> Result<T, PageError> {
    T::deserialize(document).map_err(PageError::Form)
}
