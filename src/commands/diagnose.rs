//! `armident diagnose`.

use std::path::PathBuf;

use armident_diagnose::{Books, Errors, Known, diagnose_change, diagnose_with_placebo};
use armident_ident::validate::{REPLAY_WINDOW_S, replay};
use armident_model::{ArmModel, PreparedRecording};
use armident_page::Role;
use armident_recording::Recording;
use armident_report::{ByJoint, DiagnoseInputs, DiagnoseReport, Fits, ReplayPair};

use super::recordings;
use crate::args::DiagnoseArgs;
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use crate::{output, page, robot};

pub(crate) fn run(args: &DiagnoseArgs) -> Result<Outcome, Failure> {
    let train_files = recordings::expand(&args.recordings)?;
    let holdout_files = recordings::expand(&args.holdout)?;
    let reference_files = recordings::expand(&args.reference)?;
    let next_motion = args.next_motion.as_ref().map(|folder| folder.join("next_motion.csv"));
    let recorded = train_files.iter().chain(&holdout_files).chain(&reference_files);
    let inputs = recorded.chain([&args.robot]).map(PathBuf::as_path);
    let outputs = [
        args.output.json.as_ref(),
        args.save_model.as_ref(),
        next_motion.as_ref(),
        args.page.report.as_ref(),
    ];
    output::protect(inputs, outputs)?;
    args.page.check()?;
    not_twice(&train_files, &holdout_files)?;
    let train = recordings::read_all(&train_files, &args.reading, &args.output)?;
    let holdout = recordings::read_all(&holdout_files, &args.reading, &args.output)?;
    let reference = recordings::read_all(&reference_files, &args.reading, &args.output)?;
    let names = recordings::joints_with_position(&train);
    let model = robot::load(&args.robot, &args.chain, Some(&names))?;
    // a reference shows all that a model of the same arm knows, as it is now
    let known = (reference.is_empty() && !model.is_links_only()).then(|| Known::of(model.clone()));
    let warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();

    // gains of drives come from recordings of the arm as it is believed to be
    let mut books = match &known {
        // friction that a model has too much of, taken out, would look like a sign
        Some(known) => Books::of(known.arm(), &train)?,
        None => Books::of(&model, if reference.is_empty() { &train } else { &reference })?,
    };
    let in_effort = |recordings: &[Recording]| -> Vec<Recording> {
        recordings.iter().map(|r| books.in_effort(r)).collect()
    };
    let [train, holdout, reference] = [&train, &holdout, &reference].map(|r| in_effort(r));
    let sources = |recordings: &[Recording]| recordings.iter().map(|r| r.source.clone()).collect();
    let inputs = DiagnoseInputs {
        recordings: sources(&train),
        holdout_recordings: sources(&holdout),
        reference_recordings: sources(&reference),
        beyond_a_model: known.is_some(),
        warnings: warnings.clone(),
    };
    let progress = Progress::of(&args.output, "diagnosing");
    let mut placebo = None;
    if args.trust_columns {
        books.faults.clear();
    }
    let heard = books.hear(model.chain.dof(), &train, &reference, |train, reference| {
        if !reference.is_empty() {
            return diagnose_change(&model, reference, train);
        }
        let (found, tried) = match &known {
            Some(known) => known.diagnose(train, args.placebo)?,
            None => diagnose_with_placebo(&model, train, args.placebo)?,
        };
        placebo = tried;
        Ok(found)
    });
    let Some(heard) = heard else {
        let report = DiagnoseReport::of_failed_checks(&model.chain, &books, inputs);
        // the efforts against the robot show what the columns are
        let joints = model.chain.joint_names();
        let cutoff_hz = armident_motion::common_cutoff_hz(&train, &joints, None)?;
        let models: [(&str, &ArmModel); 1] = [("given", &model)];
        let files = used(args, &train_files, &[], &[]);
        let recorded = [(train.as_slice(), Role::Training)];
        let drawing =
            page::of_models(&args.page, &model.chain, &models, &recorded, cutoff_hz, files)?;
        let text = report.text(output::bars());
        return page::write_result(
            &args.page,
            &args.output,
            &text,
            &report,
            &warnings,
            drawing.as_ref(),
        );
    };
    let mut diagnosis = heard?;
    diagnosis.doubt_gains(&books.drive_gains);
    let (seen_train, seen_holdout) = (diagnosis.see(&train)?, diagnosis.see(&holdout)?);
    diagnosis.confirm(&seen_holdout)?;
    drop(progress);
    if let Some(path) = &args.save_model {
        let text = diagnosis.model.to_json().map_err(|error| {
            Failure::new(format!("cannot write JSON: {error}"), path.display(), None::<String>)
        })?;
        output::write_file(path, text.as_bytes())?;
    }
    let next = match &next_motion {
        Some(path) => {
            if let Some(folder) = path.parent() {
                output::create_folder(folder)?;
            }
            let next = diagnosis.next_motion()?;
            if let Some(next) = &next {
                output::write_file(path, &recordings::encoded(&next.motion, path, &args.output)?)?;
            }
            next.map(|next| (path.display().to_string(), next))
        }
        None => None,
    };
    let errors = |of: &[PreparedRecording<'_>]| -> Result<Option<Errors>, Failure> {
        Ok(if of.is_empty() { None } else { Some(diagnosis.errors(of)?) })
    };
    let fits = Fits::of(errors(&seen_train)?, errors(&seen_holdout)?);
    let whiteness = diagnosis.whiteness(&seen_holdout)?;
    let replay = if holdout.is_empty() || args.no_replay {
        None
    } else {
        replayed(&diagnosis.believed, &diagnosis.model, &holdout)
    };
    let report = DiagnoseReport::new(&model.chain, &diagnosis, inputs, fits)
        .with_holdout_tests(whiteness, replay)
        .with_input_checks(&books)
        .with_placebo(placebo)
        .with_next_motion(args.next_motion.is_some(), next);
    let drawing = if args.page.wanted() {
        let mut drawing = page::of_diagnosis(&diagnosis, &seen_train, &seen_holdout)?;
        let files = used(args, &train_files, &holdout_files, &reference_files);
        drawing.provenance = page::provenance(&args.page, files);
        Some(drawing)
    } else {
        None
    };
    let text = report.text(output::bars());
    page::write_result(&args.page, &args.output, &text, &report, &warnings, drawing.as_ref())
}

/// The files that a diagnosis was made of.
fn used<'a>(
    args: &'a DiagnoseArgs,
    train: &'a [PathBuf],
    holdout: &'a [PathBuf],
    reference: &'a [PathBuf],
) -> impl Iterator<Item = &'a PathBuf> {
    let recordings = train.iter().chain(holdout).chain(reference);
    std::iter::once(&args.robot).chain(recordings).chain(&args.reading.mapping)
}

/// Rejects a recording that is in both the training and the hold-out set.
fn not_twice(train: &[PathBuf], holdout: &[PathBuf]) -> Result<(), Failure> {
    match holdout.iter().find(|file| train.iter().any(|t| output::same_file(t, file))) {
        Some(file) => Err(Failure::new(
            "the same recording is used for training and hold-out",
            file.display(),
            Some("pass a recording of a different motion to --holdout"),
        )),
        None => Ok(()),
    }
}

/// The motion that the recorded efforts cause in simulation, with the model as it was and as it is; none
/// where one of the two cannot be simulated.
fn replayed(before: &ArmModel, after: &ArmModel, recordings: &[Recording]) -> Option<ReplayPair> {
    let joints = after.chain.joint_names();
    let cutoff_hz = armident_motion::common_cutoff_hz(recordings, &joints, None).ok()?;
    let motions = recordings::motions_with_effort(recordings, &joints, cutoff_hz).ok()?;
    let of = |model: &ArmModel| -> Option<ByJoint> {
        let moved = replay(&model.simulated().0, &motions).ok().filter(|m| m.windows > 0)?;
        let errors = moved.joints.iter().map(|j| j.position_rms);
        Some(joints.iter().map(ToString::to_string).zip(errors).collect())
    };
    Some(ReplayPair { window_s: REPLAY_WINDOW_S, before: of(before)?, after: of(after)? })
}
