//! `armident accumulate` and `armident merge`: states of recordings and the arm they identify, as data and text.

use armident_ident::{MergedIdentification, Term};
use armident_model::ArmModel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::layout::{aligned, significant, uncertain};
use crate::words::counted;

/// A file that is not part of the result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SetAside {
    /// The file or recording.
    pub file: String,
    /// Why.
    pub reason: String,
}

/// The result of `accumulate`.
#[derive(Debug, Clone, Serialize)]
pub struct AccumulateReport {
    schema: &'static str,
    reduced: Vec<String>,
    already_there: Vec<String>,
    set_aside: Vec<SetAside>,
}

impl AccumulateReport {
    /// Files that were reduced now, that had been reduced before, and that could not be.
    pub fn new(reduced: Vec<String>, already_there: Vec<String>, set_aside: Vec<SetAside>) -> Self {
        Self { schema: "armident.accumulate/1", reduced, already_there, set_aside }
    }

    /// What could not be reduced.
    pub fn into_set_aside(self) -> Vec<SetAside> {
        self.set_aside
    }

    /// The result as text.
    pub fn text(&self) -> String {
        format!(
            "{} reduced, {} already there, {} set aside\n{}",
            counted(self.reduced.len(), "recording"),
            self.already_there.len(),
            self.set_aside.len(),
            set_aside_text(&self.set_aside)
        )
    }
}

/// The result of `merge`.
#[derive(Debug, Clone, Serialize)]
pub struct MergeReport {
    schema: &'static str,
    robot: String,
    recordings: usize,
    seconds: f64,
    rows: usize,
    cutoff_hz: f64,
    parameters: Vec<MergedParameter>,
    joints: Vec<MergedJoint>,
    set_aside: Vec<SetAside>,
}

#[derive(Debug, Clone, Serialize)]
struct MergedParameter {
    label: String,
    value: f64,
    standard_error: Option<f64>,
    is_constant: bool,
}

#[derive(Debug, Clone, Serialize)]
struct MergedJoint {
    joint: String,
    given_rmse: f64,
    rmse: f64,
    relative: f64,
}

impl MergeReport {
    /// The arm from so many recordings of so many seconds, and what is not part of it.
    pub fn new(
        given: &ArmModel,
        found: &MergedIdentification,
        (recordings, seconds, cutoff_hz): (usize, f64, f64),
        set_aside: Vec<SetAside>,
    ) -> Self {
        let names = given.chain.joint_names();
        let terms = found.problem.terms.iter().enumerate();
        let fits = names.iter().zip(&found.fits).zip(&found.given_fits);
        Self {
            schema: "armident.merge/1",
            robot: given.chain.robot.clone(),
            recordings,
            seconds,
            rows: found.rows,
            cutoff_hz,
            parameters: terms
                .map(|(k, term)| MergedParameter {
                    label: found.problem.label(term, &names),
                    value: found.estimate.values[k],
                    standard_error: found.estimate.standard_error(k),
                    is_constant: matches!(term, Term::Constant(_)),
                })
                .collect(),
            joints: fits
                .map(|((joint, fit), given)| MergedJoint {
                    joint: (*joint).to_owned(),
                    given_rmse: given.rmse,
                    rmse: fit.rmse,
                    relative: fit.relative,
                })
                .collect(),
            set_aside,
        }
    }

    /// The result as text.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{}: {} parameters from {} ({:.0} s, {} observations, low-pass {} Hz) by weighted least squares\n",
            self.robot,
            self.parameters.len(),
            counted(self.recordings, "recording"),
            self.seconds,
            self.rows,
            self.cutoff_hz
        );
        text += "\nEffort error (RMS below the low-pass)\n";
        let rows: Vec<Vec<String>> = self
            .joints
            .iter()
            .map(|joint| {
                let number = |x: f64| significant(x, 3, 0.0);
                vec![joint.joint.clone(), number(joint.given_rmse), number(joint.rmse)]
            })
            .collect();
        text += &aligned(&["joint", "given", "identified"], &rows, 1);
        text += "\nParameters\n";
        let rows: Vec<Vec<String>> = self
            .parameters
            .iter()
            .map(|parameter| {
                let (value, error) = match parameter.standard_error {
                    Some(error) => uncertain(parameter.value, error),
                    None => (significant(parameter.value, 3, 0.0), "-".to_owned()),
                };
                vec![parameter.label.clone(), value, error]
            })
            .collect();
        text += &aligned(&["parameter", "value", "std error"], &rows, 1);
        text + &set_aside_text(&self.set_aside)
    }
}

pub(super) fn set_aside_text(all: &[SetAside]) -> String {
    let mut text = String::new();
    if !all.is_empty() {
        text += "\nSet aside\n";
        for one in all {
            text += &format!("  {}: {}\n", one.file, one.reason);
        }
    }
    text
}
