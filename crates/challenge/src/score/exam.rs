//! The prediction of a motion that the diagnosis has not seen.

use std::collections::BTreeMap;
use std::path::Path;

use armident_recording::Recording;
use serde::Serialize;

use crate::contract::truth::{EDGE_S, Floors, PerJoint};
use crate::error::ChallengeError;

/// Two stamps of the same sample \[s\].
const SAME_STAMP_S: f64 = 1e-6;

/// Root mean square error of a prediction.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ExamScore {
    /// The recording that was predicted: `exam`, or `holdout` where a case has no exam.
    pub recording: &'static str,
    /// Why there is no prediction to judge.
    pub failed: Option<String>,
    /// Root mean square error per joint \[N m or N\].
    pub rmse: PerJoint,
    /// The same over the noise floor.
    pub over_oracle: PerJoint,
    /// The same over what a careful user attains.
    pub over_attainable: PerJoint,
}

/// Judges the prediction of a result on the exam of a case; a bad prediction is a score.
pub(crate) fn score_exam(
    exam: &Table,
    predicted: Result<Table, String>,
    floors: &Floors,
    recording: &'static str,
) -> ExamScore {
    match predicted.and_then(|predicted| rmse_by_joint(exam, &predicted)) {
        Err(reason) => ExamScore { recording, failed: Some(reason), ..ExamScore::default() },
        Ok(rmse) => ExamScore {
            recording,
            failed: None,
            over_oracle: ratios(&rmse, &floors.oracle_rmse),
            over_attainable: ratios(&rmse, &floors.attainable_rmse),
            rmse,
        },
    }
}

/// `a / b` for the joints of both.
pub(crate) fn ratios(a: &PerJoint, b: &PerJoint) -> PerJoint {
    a.iter()
        .filter_map(|(joint, a)| b.get(joint).map(|b| (joint.clone(), a / b)))
        .filter(|(_, ratio)| ratio.is_finite())
        .collect()
}

fn rmse_by_joint(exam: &Table, predicted: &Table) -> Result<PerJoint, String> {
    let stamps = exam.column("t").ok_or("the exam has no column `t`")?;
    let predicted_stamps = predicted.column("t").ok_or("there is no column `t`")?;
    if predicted_stamps.len() != stamps.len() {
        return Err(format!(
            "the motion has {} samples, the prediction {}",
            stamps.len(),
            predicted_stamps.len()
        ));
    }
    let same = |k: usize| (stamps[k] - predicted_stamps[k]).abs() <= SAME_STAMP_S;
    if let Some(k) = (0..stamps.len()).find(|&k| !same(k)) {
        return Err(format!("sample {k} is at {} s, not {} s", predicted_stamps[k], stamps[k]));
    }
    let (first_s, last_s) = (stamps[0] + EDGE_S, stamps[stamps.len() - 1] - EDGE_S);
    let judged: Vec<usize> =
        (0..stamps.len()).filter(|&k| (first_s..=last_s).contains(&stamps[k])).collect();
    let mut rmse = PerJoint::new();
    for (name, recorded) in &exam.columns {
        let Some(joint) = name.strip_suffix("/effort") else { continue };
        let found = predicted.column(name).ok_or(format!("there is no column `{name}`"))?;
        if let Some(k) = (0..found.len()).find(|&k| !found[k].is_finite()) {
            return Err(format!("`{name}` is {} in sample {k}", found[k]));
        }
        let sum: f64 = judged.iter().map(|&k| (recorded[k] - found[k]).powi(2)).sum();
        rmse.insert(joint.to_owned(), (sum / judged.len().max(1) as f64).sqrt());
    }
    Ok(rmse)
}

/// Columns of numbers by their names, without repairs.
pub(crate) struct Table {
    columns: BTreeMap<String, Vec<f64>>,
}

impl Table {
    /// Stamps and efforts of a recording.
    pub(crate) fn of(recording: &Recording) -> Self {
        let efforts = recording
            .joints
            .iter()
            .filter_map(|joint| Some((format!("{}/effort", joint.name), joint.effort.clone()?)));
        let mut columns: BTreeMap<String, Vec<f64>> = efforts.collect();
        columns.insert("t".to_owned(), recording.time_s.clone());
        Self { columns }
    }

    pub(crate) fn read(path: &Path) -> Result<Self, ChallengeError> {
        let file = std::fs::File::open(path).map_err(ChallengeError::io("read", path))?;
        let table = |reason: String| ChallengeError::Table { path: path.to_owned(), reason };
        let mut reader = csv::Reader::from_reader(file);
        let header = reader.headers().map_err(|error| table(error.to_string()))?.clone();
        let mut columns = vec![Vec::new(); header.len()];
        for row in reader.records() {
            let row = row.map_err(|error| table(error.to_string()))?;
            for (column, text) in columns.iter_mut().zip(&row) {
                let value = text.trim().parse().map_err(|_| {
                    table(format!("`{text}` in sample {} is no number", column.len()))
                })?;
                column.push(value);
            }
        }
        if columns.first().is_none_or(Vec::is_empty) {
            return Err(table("there is no sample".to_owned()));
        }
        let names = header.iter().map(|name| name.trim().to_owned());
        Ok(Self { columns: names.zip(columns).collect() })
    }

    fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.get(name).map(Vec::as_slice)
    }
}
