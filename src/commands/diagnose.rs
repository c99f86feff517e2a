//! `armident diagnose`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use armident_diagnose::{DiagnosedModel, Errors, diagnose, diagnose_change};
use armident_report::DiagnoseReport;

use super::recordings;
use crate::args::DiagnoseArgs;
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use crate::{output, robot};

pub(crate) fn run(args: &DiagnoseArgs) -> Result<Outcome, Failure> {
    let train_files = recordings::expand(&args.recordings)?;
    let holdout_files = recordings::expand(&args.holdout)?;
    let inputs =
        train_files.iter().chain(&holdout_files).chain([&args.robot]).map(PathBuf::as_path);
    output::protect(inputs, [args.output.json.as_ref(), args.save_model.as_ref()])?;
    let train = recordings::read_all(&train_files, &args.reading, &args.output)?;
    let holdout = recordings::read_all(&holdout_files, &args.reading, &args.output)?;
    let recorded = recordings::joints_with_position(&train);
    let model = robot::load(&args.robot, &args.chain, Some(&recorded))?;
    let reference =
        recordings::read_all(&recordings::expand(&args.reference)?, &args.reading, &args.output)?;
    let progress = Progress::of(&args.output, "diagnosing");
    let (before, diagnosis) = if reference.is_empty() {
        (DiagnosedModel::believed(&model), diagnose(&model, &train)?)
    } else {
        diagnose_change(&model, &reference, &train)?
    };
    drop(progress);
    let on_holdout: Vec<Errors> =
        holdout.iter().map(|r| diagnosis.errors(&before, r)).collect::<Result<_, _>>()?;
    let on_train: Vec<Errors> =
        train.iter().map(|r| diagnosis.errors(&before, r)).collect::<Result<_, _>>()?;
    if let Some(path) = &args.save_model {
        let text = diagnosis.model.to_json().map_err(|error| {
            Failure::new(format!("cannot form JSON: {error}"), path.display(), None::<String>)
        })?;
        output::write_file(path, text.as_bytes())?;
    }
    let warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();
    let report = DiagnoseReport::new(
        &model.chain,
        &diagnosis,
        train.iter().map(|r| r.source.clone()).collect(),
        holdout.iter().map(|r| r.source.clone()).collect(),
        pooled(
            &on_train,
            &train.iter().map(armident_recording::Recording::len).collect::<Vec<_>>(),
        ),
        pooled(
            &on_holdout,
            &holdout.iter().map(armident_recording::Recording::len).collect::<Vec<_>>(),
        ),
        warnings.clone(),
    );
    output::write_result(&args.output, &report.text(), &report, &warnings)
}

/// Errors of several recordings taken together, by their numbers of samples.
fn pooled(errors: &[Errors], samples: &[usize]) -> Option<Errors> {
    if errors.is_empty() {
        return None;
    }
    let total: usize = samples.iter().sum();
    let pool = |of: &dyn Fn(&Errors) -> &BTreeMap<String, f64>| -> BTreeMap<String, f64> {
        let mut squares: BTreeMap<String, f64> = BTreeMap::new();
        for (errors, n) in errors.iter().zip(samples) {
            for (joint, rmse) in of(errors) {
                *squares.entry(joint.clone()).or_default() += rmse * rmse * *n as f64;
            }
        }
        squares.into_iter().map(|(joint, s)| (joint, (s / total as f64).sqrt())).collect()
    };
    Some(Errors {
        before: pool(&|e| &e.before),
        rigid: pool(&|e| &e.rigid),
        after: pool(&|e| &e.after),
    })
}
