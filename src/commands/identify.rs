//! `armident identify`.

mod batch;
mod notes;
mod payloads;
mod planned;
mod report;

use std::path::PathBuf;

use armident_model::ArmModel;
use armident_page::{Correlation, Drawing, RecordingRole};
use armident_recording::Recording;
use armident_report::IdentifyReport;

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
    let recorded =
        [(train.as_slice(), RecordingRole::Training), (holdout.as_slice(), RecordingRole::Holdout)];
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

/// The result of an identification: the report, the model, and what a page draws.
struct Identified {
    report: IdentifyReport,
    model: ArmModel,
    /// training and hold-out recordings
    read: [Vec<Recording>; 2],
    correlation: Option<Correlation>,
}
