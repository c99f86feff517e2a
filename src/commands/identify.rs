//! `armident identify`.

mod batch;
mod planned;

use std::path::PathBuf;

use armident_ident::{Consistent, JointFit, MinimalSet};
use armident_model::ArmModel;
use armident_page::{Correlation, Drawing, Role};
use armident_recording::Recording;
use armident_report::{ByJoint, ConstantRow, FitRows, IdentifyReport};

use super::recordings;
use crate::args::IdentifyArgs;
use crate::failure::{Failure, Outcome};
use crate::{output, page};

pub(crate) fn run(args: &IdentifyArgs) -> Result<Outcome, Failure> {
    // a folder without recordings is refused below, where it is known whether it holds a plan
    let files = recordings::expand(&args.recordings).unwrap_or_default();
    let inputs = files.iter().chain(&args.holdout).chain([&args.robot]).map(PathBuf::as_path);
    output::protect(
        inputs,
        [args.output.json.as_ref(), args.save_model.as_ref(), args.page.report.as_ref()],
    )?;
    args.page.check()?;
    let with_plan: Vec<PathBuf> =
        args.recordings.iter().filter_map(|p| recordings::plan_in(p)).collect();
    let Identified { report, model, read, correlation } = match &with_plan[..] {
        [] => batch::batch(args)?,
        [plan] if args.recordings.len() == 1 => planned::by_algorithm2(args, plan)?,
        _ => {
            return Err(Failure::new(
                "a folder with a plan cannot be combined with other recordings",
                args.recordings[0].display(),
                Some(
                    "identify one planned folder at a time, or pass its CSV files for a batch fit",
                ),
            ));
        }
    };
    if let Some(path) = &args.save_model {
        model.save(path).map_err(|error| Failure::unwritable(path, &error))?;
    }
    output::say_all(&args.output, "note", &report.notes);
    let [train, holdout] = &read;
    let recorded = [(train.as_slice(), Role::Training), (holdout.as_slice(), Role::Holdout)];
    let before = model.before();
    let models: [(&str, &ArmModel); 2] = [("URDF only", &before), ("model", &model)];
    let used = [&args.robot].into_iter().chain(&files).chain(&args.holdout);
    let used = used.chain(&args.reading.mapping).chain(&with_plan);
    let drawing =
        page::of_models(&args.page, &model.chain, &models, &recorded, report.cutoff_hz, used)?
            .map(|drawing| Drawing { correlation, ..drawing });
    let text = report.text(output::bars());
    let warnings = &report.warnings;
    page::write_result(&args.page, &args.output, &text, &report, warnings, drawing.as_ref())
}

/// What an identification leaves: the result, the model, and what a page draws.
struct Identified {
    report: IdentifyReport,
    model: ArmModel,
    /// training and hold-out recordings
    read: [Vec<Recording>; 2],
    correlation: Option<Correlation>,
}

fn constant_row(
    set: &MinimalSet,
    k: usize,
    joints: &[&str],
    urdf: f64,
    found: Option<(f64, f64, f64)>,
    undetermined: f64,
    prior_share: f64,
) -> ConstantRow {
    let constant = &set.constants[k];
    ConstantRow {
        label: constant.label(),
        joint: joints[constant.joint].to_owned(),
        unit: constant.unit().to_owned(),
        value: found.map(|(value, _, _)| value),
        standard_error: found.map(|(_, error, _)| error),
        interval_95: found.map(|(value, error, t)| [value - t * error, value + t * error]),
        urdf,
        consistent: None,
        prior_share,
        undetermined,
    }
}

/// Adds the physically consistent values to the estimates, in the order of the set.
fn add_consistent(rows: &mut [ConstantRow], set: &MinimalSet, found: Option<&Consistent>) {
    let Some(found) = found else { return };
    for (k, constant) in set.constants.iter().enumerate() {
        let label = constant.label();
        if let Some(row) = rows.iter_mut().find(|row| row.label == label) {
            row.consistent = Some(found.estimated[k]);
        }
    }
}

fn fit_rows(fits: &[JointFit], joints: &[&str]) -> FitRows {
    let pick = |value: fn(&JointFit) -> f64| {
        joints.iter().zip(fits).map(|(j, fit)| ((*j).to_owned(), value(fit))).collect()
    };
    FitRows { rmse: pick(|f| f.rmse), relative: pick(|f| f.relative) }
}

fn by_joint(values: &[f64], joints: &[&str]) -> ByJoint {
    joints.iter().zip(values).map(|(j, v)| ((*j).to_owned(), *v)).collect()
}
