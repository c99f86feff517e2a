//! `armident validate`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use armident_ident::validation::{EffortError, REPLAY_WINDOW_S, effort_errors, replay};
use armident_model::ArmModel;
use armident_motion::Motion;
use armident_page::RecordingRole;
use armident_report::{ByJoint, EffortErrorRow, ReplayReport, ValidateReport};

use super::{predict, recordings};
use crate::args::ValidateArgs;
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use crate::{output, page, robot};

pub(crate) fn run(args: &ValidateArgs) -> Result<Outcome, Failure> {
    let files = recordings::expand(&args.recordings)?;
    let inputs = files.iter().chain([&args.robot]).map(PathBuf::as_path);
    output::protect(
        inputs,
        [args.output.json.as_ref(), args.predictions.as_ref(), args.page.report.as_ref()],
    )?;
    args.page.check()?;
    let recorded = recordings::read_all(&files, &args.reading, &args.output)?;
    if args.predictions.is_some() && recorded.len() != 1 {
        return Err(Failure::new(
            format!("--predictions requires one recording, found {}", recorded.len()),
            "--predictions",
            Some("pass one recording, or run `armident predict` for each"),
        ));
    }
    let names = recordings::joints_with_position(&recorded);
    let model = robot::load(&args.robot, &args.chain, Some(&names))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let cutoff_hz =
        armident_motion::common_cutoff_hz(&recorded, &joints, args.cutoff_hz.or(model.cutoff_hz))?;
    let motions: Vec<Motion> = recordings::motions_with_effort(&recorded, &joints, cutoff_hz)?
        .into_iter()
        .zip(&recorded)
        .map(|(motion, recording)| model.motion_of(motion, recording))
        .collect();

    let before = model.before();
    let (simulated, lost) = model.simulated();
    let mut warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();
    let mut replayed = |which: &str, model: &ArmModel| match replay(model, &motions) {
        Ok(replay) => Some(ReplayReport {
            window_s: REPLAY_WINDOW_S,
            windows: replay.windows,
            diverged: replay.diverged,
            position_rms: by_joint(&names, replay.joints.iter().map(|r| r.position_rms)),
            velocity_rms: by_joint(&names, replay.joints.iter().map(|r| r.velocity_rms)),
        }),
        Err(error) => {
            warnings.push(format!("forward replay skipped ({which}): {error} [no-replay]"));
            None
        }
    };
    let mut notes = recordings::notes(&motions);
    let (replay_before, replay_after) = if args.no_replay {
        (None, None)
    } else {
        let _progress = Progress::of(&args.output, "forward replay");
        notes.extend(lost.iter().map(|what| format!("omitted from forward replay: {what}")));
        (replayed("URDF", &before), replayed("model", &simulated))
    };
    let without_effects: Vec<_> =
        motions.iter().map(|motion| before.predict_motion(motion)).collect::<Result<_, _>>()?;
    let whole = model.predict_on_grids(&motions, &recorded)?;
    if let Some(path) = &args.predictions {
        let efforts = model.predict(&recorded[0], cutoff_hz)?.efforts;
        let predicted = predict::as_recording(&names, &recorded[0], efforts)?;
        let bytes = recordings::encoded(&predicted, path, &args.output)?;
        output::write_file(path, &bytes)?;
    }
    let prismatic = model.chain.joints.iter().filter(|joint| !joint.kind.is_rotational());
    let report = ValidateReport {
        schema: ValidateReport::SCHEMA.to_owned(),
        robot: model.chain.robot.clone(),
        model: args.robot.display().to_string(),
        recordings: recorded.iter().map(|r| r.source.clone()).collect(),
        before: errors(&before, &motions, &without_effects),
        after: errors(&model, &motions, &whole),
        replay_before,
        replay_after,
        joints: names,
        prismatic_joints: Some(prismatic.map(|joint| joint.name.clone()).collect()),
        cutoff_hz,
        warnings,
        notes,
    };
    output::say_all(&args.output, "note", &report.notes);
    let files = [&args.robot].into_iter().chain(&files).chain(&args.reading.mapping);
    let recorded = [(recorded.as_slice(), RecordingRole::Holdout)];
    let models: [(&str, &ArmModel); 2] = [("URDF only", &before), ("model", &model)];
    let drawing = page::of_models(&args.page, &model.chain, &models, &recorded, cutoff_hz, files)?;
    let text = report.text(output::bars());
    let warnings = &report.warnings;
    page::write_result(&args.page, &args.output, &text, &report, warnings, drawing.as_ref())
}

fn errors(
    model: &ArmModel,
    motions: &[Motion],
    efforts: &[Vec<Vec<f64>>],
) -> BTreeMap<String, EffortErrorRow> {
    let known = |x: f64| x.is_finite().then_some(x);
    let row = |e: &EffortError| EffortErrorRow {
        rmse: e.rmse,
        relative: e.relative,
        rmse_raw: e.rmse_raw,
        band_coverage: known(e.band_coverage),
        lag1_correlation: known(e.lag1_correlation),
        whiteness_p: known(e.whiteness_p),
    };
    let all = effort_errors(model, motions, efforts);
    let names = model.chain.joints.iter().map(|j| j.name.clone());
    names.zip(all.iter().map(row)).collect()
}

fn by_joint(names: &[String], values: impl Iterator<Item = f64>) -> ByJoint {
    names.iter().cloned().zip(values).collect()
}
