//! `armident diagnose`.

use std::path::PathBuf;

use armident_diagnose::{
    DiagnoseError, DiagnoseRequest, Diagnosis, NextMotion, WrongColumns, diagnose,
};
use armident_ident::validation::{REPLAY_WINDOW_S, replay};
use armident_model::{ArmModel, PreparedRecording};
use armident_motion::common_cutoff_hz;
use armident_page::RecordingRole;
use armident_recording::Recording;
use armident_report::{ByJoint, DiagnoseInputs, DiagnoseReport, Fits, ReplayPair};

use super::recordings;
use crate::args::DiagnoseArgs;
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use crate::{output, page, robot};

/// The files of the command line.
struct Files {
    training: Vec<PathBuf>,
    holdout: Vec<PathBuf>,
    reference: Vec<PathBuf>,
    next_motion: Option<PathBuf>,
}

impl Files {
    /// Expands folders, and checks that nothing is overwritten that is read.
    fn of(args: &DiagnoseArgs) -> Result<Self, Failure> {
        let files = Self {
            training: recordings::expand(&args.recordings)?,
            holdout: recordings::expand(&args.holdout)?,
            reference: recordings::expand(&args.reference)?,
            next_motion: args.next_motion.as_ref().map(|folder| folder.join("next_motion.csv")),
        };
        let recorded = files.training.iter().chain(&files.holdout).chain(&files.reference);
        let inputs = recorded.chain([&args.robot]).map(PathBuf::as_path);
        let outputs = [
            args.output.json.as_ref(),
            args.save_model.as_ref(),
            files.next_motion.as_ref(),
            args.page.report.as_ref(),
        ];
        output::protect(inputs, outputs)?;
        args.page.check()?;
        not_twice(&files.training, &files.holdout)?;
        Ok(files)
    }

    /// All that a diagnosis is made of.
    fn used<'a>(&'a self, args: &'a DiagnoseArgs) -> impl Iterator<Item = &'a PathBuf> {
        let recordings = self.training.iter().chain(&self.holdout).chain(&self.reference);
        std::iter::once(&args.robot).chain(recordings).chain(&args.reading.mapping)
    }
}

pub(crate) fn run(args: &DiagnoseArgs) -> Result<Outcome, Failure> {
    let files = Files::of(args)?;
    let read = |files: &[PathBuf]| recordings::read_all(files, &args.reading, &args.output);
    let training = read(&files.training)?;
    let (holdout, reference) = (read(&files.holdout)?, read(&files.reference)?);
    let names = recordings::joints_with_position(&training);
    let model = robot::load(&args.robot, &args.chain, Some(&names))?;
    let request = DiagnoseRequest {
        model: &model,
        recordings: &training,
        reference: &reference,
        holdout: &holdout,
        trust_columns: args.trust_columns,
        placebo_terms: args.placebo,
    };
    let sources = |recordings: &[Recording]| recordings.iter().map(|r| r.source.clone()).collect();
    let inputs = DiagnoseInputs {
        recordings: sources(&training),
        holdout_recordings: sources(&holdout),
        reference_recordings: sources(&reference),
        beyond_a_model: request.is_beyond_a_model(),
        warnings: model.chain.warnings.iter().map(ToString::to_string).collect(),
    };
    let progress = Progress::of(&args.output, "diagnosing");
    let found = diagnose(&request);
    drop(progress);
    match found {
        Ok(diagnosis) => write_diagnosis(args, &files, inputs, &diagnosis),
        Err(DiagnoseError::WrongColumns(wrong)) => {
            write_failed_checks(args, &files, inputs, &model, &wrong)
        }
        Err(error) => Err(error.into()),
    }
}

fn write_diagnosis(
    args: &DiagnoseArgs,
    files: &Files,
    inputs: DiagnoseInputs,
    diagnosis: &Diagnosis,
) -> Result<Outcome, Failure> {
    if let Some(path) = &args.save_model {
        diagnosis.model.save(path).map_err(|error| Failure::unwritable(path, &error))?;
    }
    let training = diagnosis.prepared(&diagnosis.recordings)?;
    let holdout = diagnosis.prepared(&diagnosis.holdout)?;
    let errors =
        |of: &[PreparedRecording<'_>]| (!of.is_empty()).then(|| diagnosis.errors(of)).transpose();
    let fits = Fits::of(errors(&training)?, errors(&holdout)?);
    let warnings = inputs.warnings.clone();
    let report = DiagnoseReport::new(&diagnosis.model.chain, diagnosis, inputs, fits)
        .with_holdout_tests(diagnosis.whiteness(&holdout)?, replayed(args, diagnosis))
        .with_next_motion(args.next_motion.is_some(), next_motion(args, files, diagnosis)?);
    let drawing = if args.page.wanted() {
        let mut drawing = page::of_diagnosis(diagnosis, &training, &holdout)?;
        drawing.provenance = page::provenance(&args.page, files.used(args));
        Some(drawing)
    } else {
        None
    };
    let text = report.text(output::bars());
    page::write_result(&args.page, &args.output, &text, &report, &warnings, drawing.as_ref())
}

/// Without a diagnosis: efforts beside those of the given model show what the columns are.
fn write_failed_checks(
    args: &DiagnoseArgs,
    files: &Files,
    inputs: DiagnoseInputs,
    model: &ArmModel,
    wrong: &WrongColumns,
) -> Result<Outcome, Failure> {
    let warnings = inputs.warnings.clone();
    let report = DiagnoseReport::of_failed_checks(&model.chain, &wrong.input_checks, inputs);
    let joints = model.chain.joint_names();
    let cutoff_hz = common_cutoff_hz(&wrong.recordings, &joints, None)?;
    let models: [(&str, &ArmModel); 1] = [("given", model)];
    let recorded = [(wrong.recordings.as_slice(), RecordingRole::Training)];
    let used = files.training.iter().chain([&args.robot]).chain(&args.reading.mapping);
    let drawing = page::of_models(&args.page, &model.chain, &models, &recorded, cutoff_hz, used)?;
    let text = report.text(output::bars());
    page::write_result(&args.page, &args.output, &text, &report, &warnings, drawing.as_ref())
}

/// The file and the motion that separates findings from their alternatives, where it is asked for and exists.
fn next_motion(
    args: &DiagnoseArgs,
    files: &Files,
    diagnosis: &Diagnosis,
) -> Result<Option<(String, NextMotion)>, Failure> {
    let Some(path) = &files.next_motion else { return Ok(None) };
    if let Some(folder) = path.parent() {
        output::create_folder(folder)?;
    }
    let next = diagnosis.next_motion()?;
    if let Some(next) = &next {
        output::write_file(path, &recordings::encoded(&next.motion, path, &args.output)?)?;
    }
    Ok(next.map(|next| (path.display().to_string(), next)))
}

/// A recording cannot be fitted and held out.
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

/// Forward replay of the hold-out with the given model and the diagnosed one; none where one of the two cannot be
/// simulated.
fn replayed(args: &DiagnoseArgs, diagnosis: &Diagnosis) -> Option<ReplayPair> {
    if diagnosis.holdout.is_empty() || args.no_replay {
        return None;
    }
    let joints = diagnosis.model.chain.joint_names();
    let cutoff_hz = common_cutoff_hz(&diagnosis.holdout, &joints, None).ok()?;
    let motions = recordings::motions_with_effort(&diagnosis.holdout, &joints, cutoff_hz).ok()?;
    let of = |model: &ArmModel| -> Option<ByJoint> {
        let moved = replay(&model.simulated().0, &motions).ok().filter(|m| m.windows > 0)?;
        let errors = moved.joints.iter().map(|j| j.position_rms);
        Some(joints.iter().map(ToString::to_string).zip(errors).collect())
    };
    let (before, after) = (of(&diagnosis.believed)?, of(&diagnosis.model)?);
    Some(ReplayPair { window_s: REPLAY_WINDOW_S, before, after })
}
