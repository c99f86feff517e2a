//! `armident check`.

use std::path::PathBuf;

use armident_ident::checks::{check, with_drive_signals};
use armident_model::ArmModel;
use armident_page::RecordingRole;
use armident_report::CheckReport;

use super::recordings;
use crate::args::CheckArgs;
use crate::failure::{Failure, Outcome};
use crate::{output, page, robot};

pub(crate) fn run(args: &CheckArgs) -> Result<Outcome, Failure> {
    let files = recordings::expand(&args.recordings)?;
    let inputs = files.iter().chain([&args.robot]).map(PathBuf::as_path);
    output::protect(inputs, [args.output.json.as_ref(), args.page.report.as_ref()])?;
    args.page.check()?;
    let read = recordings::read_quietly(&files, &args.reading)?;
    let (recorded, signals) = with_drive_signals(&read);
    let names = recordings::joints_with_position(&recorded);
    let (model, unused) = robot::load_links(&args.robot, &args.chain, Some(&names))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let cutoff_hz =
        armident_motion::common_cutoff_hz(&recorded, &joints, args.cutoff_hz.or(model.cutoff_hz))?;
    let motions = recordings::motions_with_effort(&recorded, &joints, cutoff_hz)?;
    let found = check(&model, &recorded, &motions, &signals)?;
    let warnings = model.chain.warnings.iter().map(ToString::to_string).collect();
    let sources = recorded.iter().map(|r| r.source.clone()).collect();
    let mut notes = recordings::notes(&motions);
    notes.extend(unused);
    let robot = model.chain.robot.clone();
    let report = CheckReport::new(&robot, sources, names, cutoff_hz, &found, warnings, notes);
    output::say_all(&args.output, "note", &report.notes);
    let files = [&args.robot].into_iter().chain(&files).chain(&args.reading.mapping);
    let recorded = [(recorded.as_slice(), RecordingRole::Training)];
    let models: [(&str, &ArmModel); 1] = [("given", &model)];
    let drawing = page::of_models(&args.page, &model.chain, &models, &recorded, cutoff_hz, files)?;
    let text = report.text();
    let warnings = &report.warnings;
    page::write_result(&args.page, &args.output, &text, &report, warnings, drawing.as_ref())
}
