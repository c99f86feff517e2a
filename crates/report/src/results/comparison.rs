//! Data of `armident report A B`: two results of the same command side by side.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::by_joint::ByJoint;
use super::diagnosis::{DiagnoseReport, FindingRow};
use super::identify::IdentifyReport;
use super::parameters::{ParameterRow, of_effect};
use crate::words::{capital, counted};

/// Standard errors from which two estimates differ: of 300 parameters of one arm, fewer than one does.
pub(crate) const DIFFERS: f64 = 3.0;

/// Two results of the same command side by side.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ComparisonReport {
    /// `armident.comparison/1`.
    pub schema: String,
    /// `equal`, or `different`: parameters apart by more than 3 standard errors, or findings in one result alone.
    pub verdict: String,
    /// First line of the text.
    pub sentence: String,
    /// Robot name of the first result.
    pub robot: String,
    /// The two results.
    pub results: Vec<ComparedResult>,
    /// Parameters, the most different first.
    pub parameters: Vec<ParameterDifference>,
    /// Findings of two diagnoses, those in one result alone first.
    pub findings: Vec<FindingDifference>,
    /// Effort errors by joint: of the hold-out, or else of training.
    pub effort_error: Vec<ErrorDifference>,
    /// Warnings, each with its code in brackets.
    pub warnings: Vec<String>,
    /// Notes on what is compared.
    pub notes: Vec<String>,
}

/// One of two results.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ComparedResult {
    /// File of the result.
    pub file: String,
    /// Robot name.
    pub robot: String,
    /// Training recordings.
    pub recordings: Vec<String>,
    /// Hold-out recordings.
    pub holdout_recordings: Vec<String>,
    /// Whether its effort errors are of the hold-out.
    pub errors_of_holdout: bool,
}

/// One parameter in both results.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ParameterDifference {
    /// Label of a constant, or law and parameter.
    pub parameter: String,
    /// Joint or link.
    pub location: String,
    /// Unit; `1` of a pure number.
    pub unit: String,
    /// Estimate of each result; `null` where it has none.
    pub values: [Option<f64>; 2],
    /// Their standard errors; `null` where they are not known.
    pub standard_errors: [Option<f64>; 2],
    /// Second less first, in standard errors of the difference of independent estimates; an estimate at its bound, which has
    /// none, is given that of the other. `null` where both are unknown.
    pub deviation: Option<f64>,
}

/// One finding of two diagnoses.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct FindingDifference {
    /// The effect at its location.
    pub finding: String,
    /// Whether each result has it.
    pub present: [bool; 2],
    /// Its confidence in each result.
    pub confidence: [Option<f64>; 2],
    /// Whether the hold-out of each result confirms it.
    pub confirmed: [Option<bool>; 2],
    /// Its parameters.
    pub parameters: Vec<ParameterDifference>,
}

/// Effort error of one joint.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ErrorDifference {
    /// Joint name.
    pub joint: String,
    /// Root mean square error of each result \[N m or N\].
    pub rmse: [Option<f64>; 2],
}

/// Why two results cannot be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ComparisonError {
    /// A result of another command.
    #[error("expected a result of identify or diagnose, found schema `{found}`")]
    Schema {
        /// Which of the two files.
        file: String,
        /// Its schema.
        found: String,
    },
    /// Results of different commands.
    #[error("results of different commands: `{first}` and `{second}`")]
    Commands {
        /// Schema of the first.
        first: String,
        /// Schema of the second.
        second: String,
    },
    /// No joint is in both results.
    #[error("the two results have no joint in common")]
    Joints,
    /// A result with fields of another form.
    #[error("the result is not of the form of its schema: {error}")]
    Form {
        /// Which of the two files.
        file: String,
        /// What is wrong.
        error: serde_json::Error,
    },
}

/// What is compared of a result.
struct Side {
    result: ComparedResult,
    kind: &'static str,
    schema: String,
    joints: Vec<String>,
    parameters: Vec<ParameterRow>,
    findings: Vec<FindingRow>,
    rmse: ByJoint,
}

impl Side {
    fn of(file: &str, document: &Value) -> Result<Self, ComparisonError> {
        let schema = document.get("schema").and_then(Value::as_str).unwrap_or("none").to_owned();
        let form = |error| ComparisonError::Form { file: file.to_owned(), error };
        match schema.split('/').next().unwrap_or_default() {
            "armident.identify" => {
                let found = IdentifyReport::deserialize(document).map_err(form)?;
                let (errors, errors_of_holdout) = found.judged();
                Ok(Self {
                    kind: "identify",
                    rmse: errors.rmse.clone(),
                    parameters: found.parameter_rows(),
                    findings: Vec::new(),
                    result: ComparedResult {
                        file: file.to_owned(),
                        errors_of_holdout,
                        robot: found.robot,
                        recordings: found.recordings,
                        holdout_recordings: found.holdout_recordings,
                    },
                    joints: found.joints,
                    schema,
                })
            }
            "armident.diagnosis" => {
                let found = DiagnoseReport::deserialize(document).map_err(form)?;
                let errors = found.fit.judged();
                Ok(Self {
                    kind: "diagnose",
                    rmse: errors.map(|(errors, _)| errors.after.clone()).unwrap_or_default(),
                    parameters: found.parameter_rows(),
                    result: ComparedResult {
                        file: file.to_owned(),
                        errors_of_holdout: errors.is_some_and(|(_, of_holdout)| of_holdout),
                        robot: found.robot,
                        recordings: found.recordings,
                        holdout_recordings: found.holdout_recordings,
                    },
                    findings: found.findings,
                    joints: found.joints,
                    schema,
                })
            }
            _ => Err(ComparisonError::Schema { file: file.to_owned(), found: schema }),
        }
    }
}

impl ComparisonReport {
    /// Current schema.
    pub const SCHEMA: &str = "armident.comparison/1";

    /// From the JSON of two results, each with the name of its file.
    ///
    /// # Errors
    /// [`ComparisonError`].
    pub fn of(first: (&str, &Value), second: (&str, &Value)) -> Result<Self, ComparisonError> {
        let (a, b) = (Side::of(first.0, first.1)?, Side::of(second.0, second.1)?);
        if a.kind != b.kind {
            return Err(ComparisonError::Commands { first: a.schema, second: b.schema });
        }
        if !a.joints.iter().any(|joint| b.joints.contains(joint)) {
            return Err(ComparisonError::Joints);
        }
        let mut warnings = Vec::new();
        if a.result.robot != b.result.robot {
            let robots = format!("{} and {}", a.result.robot, b.result.robot);
            warnings.push(format!(
                "the results are of {robots}: equal labels may be of different links [robots-differ]"
            ));
        }
        let alone = |own: &Side, other: &Side| -> Vec<String> {
            own.joints.iter().filter(|j| !other.joints.contains(j)).cloned().collect()
        };
        let alone = [alone(&a, &b), alone(&b, &a)].concat();
        if !alone.is_empty() {
            warnings.push(format!(
                "in one result alone: {}; constants of the minimal set depend on the joints behind them [joints-differ]",
                alone.join(", ")
            ));
        }
        let parameters = differences(&a.parameters, &b.parameters);
        let findings = findings(&a.findings, &b.findings);
        let mut joints = a.joints.clone();
        joints.extend(b.joints.iter().filter(|joint| !a.joints.contains(joint)).cloned());
        let effort_error = joints
            .into_iter()
            .map(|joint| ErrorDifference {
                rmse: [&a, &b].map(|side| side.rmse.get(&joint).copied()),
                joint,
            })
            .collect();
        let mut report = Self {
            schema: Self::SCHEMA.to_owned(),
            robot: a.result.robot.clone(),
            notes: notes(&a, &b),
            results: vec![a.result, b.result],
            parameters,
            findings,
            effort_error,
            warnings,
            ..Self::default()
        };
        report.judge(a.kind == "diagnose");
        Ok(report)
    }

    /// All parameters: constants and others, and those of findings in both results.
    pub(crate) fn compared(&self) -> impl Iterator<Item = &ParameterDifference> {
        let of_findings = self.findings.iter().filter(|finding| finding.present == [true; 2]);
        self.parameters.iter().chain(of_findings.flat_map(|finding| &finding.parameters))
    }

    fn judge(&mut self, of_diagnoses: bool) {
        let deviations: Vec<f64> = self.compared().filter_map(|p| p.deviation).collect();
        let apart = deviations.iter().filter(|d| d.abs() > DIFFERS).count();
        let alone = [0, 1].map(|side| {
            self.findings.iter().filter(|f| f.present[side] && !f.present[1 - side]).count()
        });
        let of = counted(deviations.len(), "parameter");
        let largest = self
            .compared()
            .filter(|p| p.deviation.is_some_and(|d| d.abs() > DIFFERS))
            .max_by(|p, q| size(p.deviation).total_cmp(&size(q.deviation)));
        let mut clauses = vec![match largest {
            Some(largest) => format!(
                "{apart} of {of} {} by more than {DIFFERS} standard errors, most {} of {} ({:+.1})",
                if apart == 1 { "differs" } else { "differ" },
                largest.parameter,
                largest.location,
                largest.deviation.unwrap_or_default()
            ),
            None if deviations.is_empty() => "no parameter is in both results".to_owned(),
            None => format!("none of {of} differs by more than {DIFFERS} standard errors"),
        }];
        if of_diagnoses {
            let both = self.findings.iter().filter(|f| f.present == [true; 2]).count();
            clauses.push(format!(
                "{} in both, {} in the first alone, {} in the second alone",
                counted(both, "finding"),
                alone[0],
                alone[1]
            ));
        }
        let is_equal = apart == 0 && alone == [0, 0];
        self.verdict = if is_equal { "equal" } else { "different" }.to_owned();
        self.sentence = format!("{}: {}", self.robot, clauses.join("; "));
    }
}

/// What the comparison takes for granted.
fn notes(a: &Side, b: &Side) -> Vec<String> {
    let mut notes = Vec::new();
    let shared: Vec<&str> = (a.result.recordings.iter())
        .filter(|recording| b.result.recordings.contains(recording))
        .map(String::as_str)
        .collect();
    if !shared.is_empty() {
        notes.push(format!(
            "both results are fitted to {}: their estimates are not independent, and deviations are smaller than stated",
            shared.join(", ")
        ));
    }
    if a.result.errors_of_holdout != b.result.errors_of_holdout {
        let kind =
            |side: &Side| if side.result.errors_of_holdout { "hold-out" } else { "training" };
        notes.push(format!("effort errors are of {} and of {} recordings", kind(a), kind(b)));
    }
    notes
}

fn size(deviation: Option<f64>) -> f64 {
    deviation.map_or(-1.0, f64::abs)
}

/// Parameters of both lists, the most different first, then those in one alone.
fn differences(a: &[ParameterRow], b: &[ParameterRow]) -> Vec<ParameterDifference> {
    let same =
        |p: &ParameterRow, q: &ParameterRow| p.parameter == q.parameter && p.location == q.location;
    let mut all: Vec<ParameterDifference> = a
        .iter()
        .map(|p| difference([Some(p), b.iter().find(|q| same(p, q))]))
        .chain(
            b.iter().filter(|q| !a.iter().any(|p| same(p, q))).map(|q| difference([None, Some(q)])),
        )
        .collect();
    all.sort_by(|p, q| size(q.deviation).total_cmp(&size(p.deviation)));
    all
}

fn difference(rows: [Option<&ParameterRow>; 2]) -> ParameterDifference {
    let of = rows[0].or(rows[1]);
    let text = |field: fn(&ParameterRow) -> &String| of.map(field).cloned().unwrap_or_default();
    let values = rows.map(|row| row.map(|row| row.value));
    let standard_errors = rows.map(|row| row?.standard_error);
    // an estimate at its bound has no standard error: that of the other stands for it
    let [first, second] = standard_errors;
    let deviation = match (values, first.or(second), second.or(first)) {
        ([Some(x), Some(y)], Some(e), Some(f)) => Some((y - x) / e.hypot(f)),
        _ => None,
    };
    ParameterDifference {
        parameter: text(|row| &row.parameter),
        location: text(|row| &row.location),
        unit: text(|row| &row.unit),
        values,
        standard_errors,
        deviation: deviation.filter(|d| d.is_finite()),
    }
}

/// Findings of both diagnoses, those in one alone first.
fn findings(a: &[FindingRow], b: &[FindingRow]) -> Vec<FindingDifference> {
    let mut taken = vec![false; b.len()];
    let mut all: Vec<FindingDifference> = Vec::new();
    for first in a {
        let same = |(k, second): (usize, &FindingRow)| !taken[k] && is_same(first, second);
        let partner = b.iter().enumerate().position(|(k, second)| same((k, second)));
        if let Some(k) = partner {
            taken[k] = true;
        }
        all.push(found([Some(first), partner.map(|k| &b[k])]));
    }
    let alone = b.iter().zip(&taken).filter(|(_, taken)| !**taken);
    all.extend(alone.map(|(second, _)| found([None, Some(second)])));
    all.sort_by_key(|finding| finding.present == [true; 2]);
    all
}

/// The same effect at the same location and, of a contact, at overlapping times of one recording.
fn is_same(a: &FindingRow, b: &FindingRow) -> bool {
    let overlap = match (a.window, b.window) {
        (Some(a), Some(b)) => a[0] < b[1] && b[0] < a[1],
        (None, None) => true,
        _ => false,
    };
    a.effect == b.effect
        && a.joints == b.joints
        && a.link == b.link
        && a.recording == b.recording
        && overlap
}

fn found(sides: [Option<&FindingRow>; 2]) -> FindingDifference {
    let rows = sides.map(|side| side.map(parameters_of).unwrap_or_default());
    let title = sides[0].or(sides[1]).map(FindingRow::title).unwrap_or_default();
    FindingDifference {
        finding: capital(&title),
        present: sides.map(|side| side.is_some()),
        confidence: sides.map(|side| side.map(|side| side.confidence)),
        confirmed: sides.map(|side| side?.confirmed),
        parameters: differences(&rows[0], &rows[1]),
    }
}

fn parameters_of(finding: &FindingRow) -> Vec<ParameterRow> {
    let needed = finding.parameters.iter().filter(|(_, estimate)| estimate.is_needed());
    needed
        .map(|(name, estimate)| ParameterRow {
            parameter: of_effect(&finding.effect, name),
            location: finding.location(),
            unit: estimate.unit.clone(),
            value: estimate.value,
            standard_error: estimate.stderr,
            ..ParameterRow::default()
        })
        .collect()
}
