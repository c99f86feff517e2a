//! `armident identify`.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use armident_commands::{
    CardFiles, CardOptions, Failure, GivenRobot, Identified, IdentifyOptions, PayloadOn,
    PlannedRecordings, card_files, card_paths, has_commands_only, identify, identify_planned,
    identify_servos, plan_in, split_recordings,
};
use armident_ident::{Stage, StructureSearch};
use armident_recording::Recording;

use super::recordings;
use crate::args::{CouplingArg, IdentifyArgs, PayloadArg, PriorArg, ViscousArg};
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, page, robot};

pub(crate) fn run(args: &IdentifyArgs) -> Result<Outcome, Failure> {
    // a folder without recordings is refused below, where it is known whether it holds a plan
    let files = split_recordings(&args.recordings, &args.holdout).unwrap_or_default();
    let read = files.training.iter().chain(&files.holdout);
    let inputs = read.clone().chain([&args.robot]).map(PathBuf::as_path);
    let card = args.card.card.as_deref().map(card_paths).transpose()?;
    let of_card = card.iter().flatten().map(Some);
    let others = [args.output.json.as_ref(), args.save_model.as_ref(), args.page.report.as_ref()];
    output::protect(inputs, others.into_iter().chain(of_card))?;
    args.page.check()?;
    let with_plan: Vec<PathBuf> = args.recordings.iter().filter_map(|p| plan_in(p)).collect();
    let found = match &with_plan[..] {
        [] => {
            let files = split_recordings(&args.recordings, &args.holdout)?;
            let read = |paths: &[PathBuf]| recordings::read_all(paths, &args.reading, &args.output);
            let (train, holdout) = (read(&files.training)?, read(&files.holdout)?);
            let robot = robot::open(&args.robot, &args.chain)?;
            if has_commands_only(&robot, &train)? {
                return by_commands(args, &robot, &train, &holdout);
            }
            batch(args, &robot, train, holdout)?
        }
        [plan] if args.recordings.len() == 1 => by_algorithm2(args, plan)?,
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
        found.model.save(path).map_err(|error| Failure::unwritable(path, &error))?;
    }
    output::say_all(&args.output, "note", &[&files.notes[..], &found.report.notes].concat());
    if let Some(path) = &args.card.card {
        let files = CardFiles {
            robot: Some(args.robot.as_path()),
            mapping: args.reading.mapping.as_deref(),
            plan: with_plan.first().map(PathBuf::as_path),
        };
        write_card(args, &found, files, path)?;
    }
    let used = [&args.robot].into_iter().chain(read);
    let used = used.chain(&args.reading.mapping).chain(&with_plan);
    let drawing = page::drawn(&args.page, used, || found.drawing())?;
    let report = &found.report;
    let (text, warnings) = (report.text(output::bars()), &report.warnings);
    page::write_result(&args.page, &args.output, &text, report, warnings, drawing.as_ref())
}

/// The model card and its JSON.
fn write_card(
    args: &IdentifyArgs,
    found: &Identified,
    files: CardFiles<'_>,
    path: &Path,
) -> Result<(), Failure> {
    let options = CardOptions { serial: args.card.serial.clone(), date: args.card.date.clone() };
    let written = card_files(&found.card(files, &options), path)?;
    for (path, text) in &written {
        output::write_file(path, text.as_bytes())?;
    }
    Ok(())
}

fn options(args: &IdentifyArgs) -> IdentifyOptions {
    let payload = |given: &PayloadArg| PayloadOn {
        file: given.file.clone(),
        mass_kg: given.mass_kg,
        com_m: given.com_m,
        com_error_m: given.com_error_m,
    };
    IdentifyOptions {
        cutoff_hz: args.cutoff_hz,
        estimator: args.method,
        cross_validate: args.cross_validate,
        prior: args.prior == PriorArg::Urdf,
        payloads: args.payload.iter().map(payload).collect(),
        search: StructureSearch {
            couplings: args.coupling == CouplingArg::Auto,
            sublinear: args.viscous == ViscousArg::Auto,
        },
        raw_estimate: args.raw_estimate,
    }
}

/// Commands without efforts, by the positions that follow.
fn by_commands(
    args: &IdentifyArgs,
    robot: &GivenRobot,
    train: &[Recording],
    holdout: &[Recording],
) -> Result<Outcome, Failure> {
    if args.page.report.is_some() || args.page.traces || args.card.card.is_some() {
        return Err(Failure::new(
            "no page of an identification from commands",
            "--report, --traces, --card",
            Some("omit the option, or use --json FILE"),
        ));
    }
    let progress = Progress::of(&args.output, "fitting");
    let found = identify_servos(robot, train, holdout, &args.servo_gain)?;
    drop(progress);
    if let Some(path) = &args.save_model {
        found.model.save(path).map_err(|error| Failure::unwritable(path, &error))?;
    }
    output::say_all(&args.output, "note", &found.report.notes);
    let text = found.report.text(output::bars());
    output::write_result(&args.output, &text, &found.report, &found.report.warnings)
}

/// Ordinary motion, by the batch fit.
fn batch(
    args: &IdentifyArgs,
    robot: &GivenRobot,
    train: Vec<Recording>,
    holdout: Vec<Recording>,
) -> Result<Identified, Failure> {
    if !args.servo_gain.is_empty() {
        return Err(Failure::new(
            "gains of position controllers beside recordings with efforts or without commands",
            "--servo-gain",
            Some("omit the option"),
        ));
    }
    let stage = Mutex::new(None);
    let progress = |next: Stage| {
        if let Ok(mut current) = stage.lock() {
            // the line of the stage before goes away first
            drop(current.take());
            *current = Some(Progress::of(&args.output, in_words(next)));
        }
    };
    identify(robot, train, holdout, &options(args), &progress)
}

/// Planned experiments, by Algorithm 2.
fn by_algorithm2(args: &IdentifyArgs, plan: &Path) -> Result<Identified, Failure> {
    let planned = PlannedRecordings::of(plan)?;
    let robot = robot::open(&args.robot, &args.chain)?;
    let read = recordings::read_all(&planned.files, &args.reading, &args.output)?;
    identify_planned(&robot, &planned, read, &options(args))
}

fn in_words(stage: Stage) -> &'static str {
    match stage {
        Stage::Motions => "filtering recordings",
        Stage::Structure => "selecting model structure",
        Stage::Fit => "fitting",
        Stage::Projection => "projecting to consistent links",
    }
}
