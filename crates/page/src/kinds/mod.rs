//! What the page of each command's result says.

mod check;
mod constants;
mod diagnosis;
mod identify;
mod other;
mod scoreboard;
mod validate;

use std::collections::BTreeMap;
use std::ops::Deref;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::drawing::{Drawing, Role};
use crate::figures;
use crate::page::{JointCard, PageError, View, number, percent};

/// What the page of a result says.
pub(crate) fn view(schema: &str, document: &Value, drawing: &Drawing) -> Result<View, PageError> {
    let kind = schema.split('/').next().unwrap_or_default();
    Ok(match kind {
        "armident.diagnosis" => diagnosis::view(read(document)?, drawing),
        "armident.identify" => identify::view(read(document)?, drawing),
        "armident.validate" => validate::view(read(document)?, drawing),
        "armident.check" => check::view(read(document)?, drawing),
        "armident.scoreboard" => scoreboard::view(&read(document)?, drawing),
        _ => other::view(kind, document),
    })
}

fn read<T: DeserializeOwned>(document: &Value) -> Result<T, PageError> {
    serde_json::from_value(document.clone()).map_err(PageError::Form)
}

/// A number a joint.
#[derive(Debug, Default, Deserialize)]
#[serde(from = "BTreeMap<String, Option<f64>>")]
struct ByJoint(BTreeMap<String, f64>);

impl From<BTreeMap<String, Option<f64>>> for ByJoint {
    /// `null` is what could not be determined.
    fn from(map: BTreeMap<String, Option<f64>>) -> Self {
        Self(map.into_iter().filter_map(|(joint, x)| Some((joint, x?))).collect())
    }
}

impl Deref for ByJoint {
    type Target = BTreeMap<String, f64>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

/// A section a joint: efforts over time, where residuals lie, their spectra. `open` are the joints that
/// are open at first; `noise` is the noise of one recorded sample.
fn joints(drawing: &Drawing, open: &[String], noise: &ByJoint) -> Vec<JointCard> {
    (drawing.joints.iter().zip(&drawing.residuals).enumerate())
        .filter(|(_, (_, residual))| !residual.rms.is_empty())
        .map(|(j, (joint, residual))| {
            let noise = noise.get(&joint.name).copied();
            let all = [
                figures::efforts(drawing, j, Role::Training, noise),
                figures::efforts(drawing, j, Role::Holdout, noise),
                figures::maps(drawing, j, residual),
                figures::spectra(drawing, j, residual),
            ];
            let errors: Vec<String> = drawing
                .models
                .iter()
                .zip(&residual.rms)
                .map(|(model, rms)| {
                    let share = percent(rms / residual.effort_deviation);
                    format!("{model} {} {} ({share})", number(*rms, 3), joint.effort_unit)
                })
                .collect();
            JointCard {
                name: joint.name.clone(),
                summary: format!("RMS residual: {}", errors.join(", ")),
                figures: all.into_iter().flatten().collect(),
                open: open.contains(&joint.name),
            }
        })
        .collect()
}

/// `1 recording`, `2 recordings`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
