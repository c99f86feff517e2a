//! `armident diagnose`.

use std::path::PathBuf;

use armident_commands::{
    DiagnoseOptions, DiagnoseRecordings, Failure, GivenRobot, diagnose, diagnose_servos, expand,
    has_commands_only, split_recordings,
};
use armident_recording::Recording;

use super::recordings;
use crate::args::DiagnoseArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, page, robot};

/// The files of the command line.
struct Files {
    training: Vec<PathBuf>,
    holdout: Vec<PathBuf>,
    reference: Vec<PathBuf>,
    next_motion: Option<PathBuf>,
    notes: Vec<String>,
}

impl Files {
    /// Expands folders, and checks that nothing is overwritten that is read.
    fn of(args: &DiagnoseArgs) -> Result<Self, Failure> {
        let split = split_recordings(&args.recordings, &args.holdout)?;
        let files = Self {
            training: split.training,
            holdout: split.holdout,
            notes: split.notes,
            reference: expand(&args.reference)?,
            next_motion: args.next_motion.as_ref().map(|folder| folder.join("next_motion.csv")),
        };
        let recorded = files.training.iter().chain(&files.holdout).chain(&files.reference);
        let inputs = recorded.chain([&args.robot]).map(PathBuf::as_path);
        let outputs = [
            args.output.json.as_ref(),
            args.save_model.as_ref(),
            args.mcap.as_ref(),
            files.next_motion.as_ref(),
            args.page.report.as_ref(),
        ];
        output::protect(inputs, outputs)?;
        args.page.check()?;
        recordings::check_mcap(args.mcap.as_ref())?;
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
    output::say_all(&args.output, "note", &files.notes);
    let read = |files: &[PathBuf]| recordings::read_all(files, &args.reading, &args.output);
    let training = read(&files.training)?;
    let (holdout, reference) = (read(&files.holdout)?, read(&files.reference)?);
    let robot = robot::open(&args.robot, &args.chain)?;
    if has_commands_only(&robot, &training)? {
        return by_commands(args, &robot, [&training, &holdout], files.used(args).collect());
    }
    if !args.servo_gain.is_empty() {
        return Err(Failure::new(
            "gains of position controllers beside recordings with efforts or without commands",
            "--servo-gain",
            Some("omit the option"),
        ));
    }
    let recordings =
        DiagnoseRecordings { training: &training, holdout: &holdout, reference: &reference };
    let options = DiagnoseOptions {
        trust_columns: args.trust_columns,
        placebo: args.placebo,
        no_replay: args.no_replay,
        next_motion: files.next_motion.as_deref(),
    };
    let progress = Progress::of(&args.output, "diagnosing");
    let found = diagnose(&robot, recordings, &options)?;
    drop(progress);
    if let (Some(path), Some(model)) = (&args.save_model, found.model()) {
        model.save(path).map_err(|error| Failure::unwritable(path, &error))?;
    }
    if let (Some(path), Some(_)) = (&files.next_motion, found.model()) {
        if let Some(folder) = path.parent() {
            output::create_folder(folder)?;
        }
        if let Some(motion) = &found.next_motion {
            output::write_file(path, &recordings::encoded(motion, path, &args.output)?)?;
        }
    }
    if let Some(path) = &args.mcap {
        recordings::write_mcap(path, found.mcap()?, &args.output)?;
    }
    let drawing = page::drawn(&args.page, files.used(args), || found.drawing())?;
    let report = &found.report;
    let (text, warnings) = (report.text(output::bars()), &report.warnings);
    page::write_result(&args.page, &args.output, &text, report, warnings, drawing.as_ref())
}

/// Commands without efforts: what lies between them and the positions.
fn by_commands(
    args: &DiagnoseArgs,
    robot: &GivenRobot,
    [training, holdout]: [&[Recording]; 2],
    used: Vec<&PathBuf>,
) -> Result<Outcome, Failure> {
    let needs_efforts = [
        (!args.reference.is_empty(), "--reference"),
        (args.next_motion.is_some(), "--next-motion"),
        (args.placebo.is_some(), "--placebo"),
        (args.mcap.is_some(), "--mcap"),
    ];
    if let Some((_, option)) = needs_efforts.iter().find(|(is_given, _)| *is_given) {
        return Err(Failure::new(
            "not available for recordings of commands without efforts",
            option,
            Some("omit the option, or add <joint>/effort"),
        ));
    }
    let progress = Progress::of(&args.output, "diagnosing");
    let found = diagnose_servos(robot, training, holdout, &args.servo_gain)?;
    drop(progress);
    if let Some(path) = &args.save_model {
        found.model.save(path).map_err(|error| Failure::unwritable(path, &error))?;
    }
    let drawing = page::drawn(&args.page, used, || found.drawing(training, holdout))?;
    let report = &found.report;
    let (text, warnings) = (report.text(output::bars()), &report.warnings);
    page::write_result(&args.page, &args.output, &text, report, warnings, drawing.as_ref())
}

/// A recording cannot be fitted and held out.
fn not_twice(train: &[PathBuf], holdout: &[PathBuf]) -> Result<(), Failure> {
    match holdout.iter().find(|file| train.iter().any(|t| armident_commands::same_file(t, file))) {
        Some(file) => Err(Failure::new(
            "the same recording is used for training and hold-out",
            file.display(),
            Some("pass a recording of a different motion to --holdout"),
        )),
        None => Ok(()),
    }
}
