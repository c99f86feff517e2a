//! `armident challenge`.

use std::io::IsTerminal;
use std::path::PathBuf;

use armident_challenge::{
    Arm, CaseKind, CaseSeries, ChallengeError, CommandSeries, Order, Outcome as Sat, Scoreboard,
    SeriesKind, Spread, Study, run as serve, score_cases,
};
use armident_page::{Drawing, Provenance};
use indicatif::{ProgressBar, ProgressStyle};

use crate::args::{ChallengeArgs, ChallengeFailOn, KindArg, OutputArgs, PageArgs, StudyArg};
use crate::failure::Outcome;
use crate::{output, page};
use armident_commands::Failure;

/// Default number of cases, and of the study of commands.
const CASES: u64 = 24;
const COMMAND_CASES: u64 = 60;

pub(crate) fn run(args: &ChallengeArgs) -> Result<Outcome, Failure> {
    pages(args).check()?;
    let to = OutputArgs { json: args.json.clone(), quiet: args.quiet, fail_on: None };
    if let [cases, results] = &args.score[..] {
        let board = score_cases(cases, results).map_err(|error| failure(&error))?;
        write(args, &to, &board.text(), &board)?;
        return Ok(judged(args, &board));
    }
    if args.study == Some(StudyArg::Commands) {
        return from_commands(args, &to);
    }
    let study = args.study.and_then(StudyArg::study);
    let orders = match study {
        Some(study) => study_orders(args, study)?,
        None => chosen(args, series(args)?.orders())?,
    };
    if let Some(folder) = &args.keep {
        output::create_folder(folder)?;
    }
    let sat = with_progress(args, &orders)?;
    if sat.iter().all(|sat| sat.score.is_none()) {
        return Err(Failure::new(
            "no case could be generated: the effects are not detectable on any arm tried",
            args.robot.as_deref().unwrap_or("--effect, --margin"),
            Some(
                "give its links masses and inertias (`armident params` lists those without), or choose other effects",
            ),
        ));
    }
    let board = Scoreboard::new(sat.iter().filter_map(|sat| sat.score.clone()).collect());
    let text = match study {
        Some(study) => study.text(&orders, &sat),
        None => board.text(),
    };
    output::say_all(&to, "note", &notes(&orders, &sat));
    write(args, &to, &text, &board)?;
    Ok(judged(args, &board))
}

fn failure(error: &ChallengeError) -> Failure {
    Failure::new(error, error.place(), error.hint())
}

/// Writes the scoreboard, and its page if requested.
fn write(
    args: &ChallengeArgs,
    to: &OutputArgs,
    text: &str,
    board: &Scoreboard,
) -> Result<Outcome, Failure> {
    let pages = pages(args);
    let drawing = pages.wanted().then(|| {
        let provenance = page::provenance(&pages, []);
        let seed = args.score.is_empty().then_some(args.seed);
        Drawing { provenance: Provenance { seed, ..provenance }, ..Drawing::default() }
    });
    page::write_result(&pages, to, text, board, &[], drawing.as_ref())
}

fn pages(args: &ChallengeArgs) -> PageArgs {
    PageArgs { report: args.report.clone(), traces: false, command: args.command.clone() }
}

/// Arms without efforts: five nulls to three cases.
fn from_commands(args: &ChallengeArgs, to: &OutputArgs) -> Result<Outcome, Failure> {
    if args.kind.is_some() || args.keep.is_some() || args.report.is_some() {
        return Err(Failure::new(
            "this study makes its own cases in memory and a table",
            "--kind, --keep, --report",
            Some("omit these options; --json writes the scores"),
        ));
    }
    let cases = args.cases.unwrap_or(COMMAND_CASES);
    let series = CommandSeries { cases, nulls: (5 * cases).div_ceil(3), seed: args.seed };
    let bar = progress_bar(args, cases + series.nulls);
    let board = series.run(&|| bar.inc(1)).map_err(|error| failure(&error))?;
    bar.finish_and_clear();
    output::write_result(to, &board.text(), &board, &[])?;
    let named = board.cases.iter().flat_map(|case| &case.effects).filter(|e| e.is_named).count();
    let failed = args.fail_on.iter().any(|condition| match condition {
        ChallengeFailOn::FalseAlarm => board.false_alarms().count > 0,
        ChallengeFailOn::NamedBelow(least) => named < *least,
    });
    Ok(if failed { Outcome::FailedOnRequest } else { Outcome::Done })
}

impl StudyArg {
    /// None for the study of arms without efforts, whose cases are of their own form.
    fn study(self) -> Option<Study> {
        Some(match self {
            Self::Nulls => Study::Nulls,
            Self::Power => Study::Power,
            Self::Perturbed => Study::Perturbed,
            Self::Mixed => Study::Mixed,
            Self::Hard => Study::Hard,
            Self::Change => Study::Change,
            Self::Commands => return None,
        })
    }
}

fn study_orders(args: &ChallengeArgs, study: Study) -> Result<Vec<Order>, Failure> {
    let kind = match (study, args.kind) {
        (Study::Power, Some(KindArg::Field)) => CaseKind::Field,
        (Study::Power, None | Some(KindArg::Clean)) | (_, None) => CaseKind::Clean,
        _ => {
            return Err(Failure::new(
                "this study defines its own kinds of cases",
                "--kind",
                Some("omit --kind; only the power study accepts clean or field"),
            ));
        }
    };
    Ok(study.orders(args.cases.unwrap_or(study.default_cases()), args.seed, kind))
}

fn series(args: &ChallengeArgs) -> Result<CaseSeries, Failure> {
    let kind = match args.kind {
        Some(KindArg::Clean) => SeriesKind::Clean,
        Some(KindArg::Field) => SeriesKind::Field,
        Some(KindArg::Null) => SeriesKind::Null,
        Some(KindArg::Mixed) => SeriesKind::Mixed,
        Some(KindArg::Hard) => SeriesKind::Hard,
        Some(KindArg::Change) => SeriesKind::Change,
        None if args.effect.is_empty() => SeriesKind::Mixed,
        None => SeriesKind::Clean,
    };
    if kind == SeriesKind::Null && !args.effect.is_empty() {
        return Err(Failure::new(
            "a null case has no hidden effect",
            "--effect, --kind null",
            Some("omit one of the two options"),
        ));
    }
    Ok(CaseSeries {
        cases: args.cases.unwrap_or(CASES),
        seed: args.seed,
        kind,
        effects: args.effect.clone(),
        arm: args.robot.as_deref().map(arm).transpose()?,
        perturbed: args.perturbed,
        margin: args.margin,
    })
}

/// A bundled arm, or the arm of a URDF file.
fn arm(given: &str) -> Result<Arm, Failure> {
    if let Some(arm) = Arm::named(given) {
        return Ok(arm);
    }
    let path = PathBuf::from(given);
    let urdf = std::fs::read_to_string(&path).map_err(|error| {
        let names: Vec<String> = Arm::all().into_iter().map(|arm| arm.name).collect();
        Failure::new(
            format!("cannot read: {error}"),
            given,
            Some(format!("pass a URDF, or one of {}", names.join(", "))),
        )
    })?;
    let stem = path.file_stem().map_or(given.into(), |stem| stem.to_string_lossy());
    Ok(Arm { name: stem.into_owned(), urdf })
}

/// The cases of `--only`.
fn chosen(args: &ChallengeArgs, orders: Vec<Order>) -> Result<Vec<Order>, Failure> {
    if let Some(number) = args.only.iter().find(|k| !(1..=orders.len()).contains(k)) {
        return Err(Failure::new(
            format!("case {number} is out of range (1 to {})", orders.len()),
            "--only",
            Some("choose a number from 1 to --cases"),
        ));
    }
    let wanted = |k: usize| args.only.is_empty() || args.only.contains(&(k + 1));
    Ok(orders.into_iter().enumerate().filter(|(k, _)| wanted(*k)).map(|(_, order)| order).collect())
}

fn progress_bar(args: &ChallengeArgs, cases: u64) -> ProgressBar {
    let bar = if args.quiet || !std::io::stderr().is_terminal() {
        ProgressBar::hidden()
    } else {
        let form = ProgressStyle::with_template("{bar:30} {pos} of {len} cases, {eta} left");
        ProgressBar::new(cases).with_style(form.unwrap_or_else(|_| ProgressStyle::default_bar()))
    };
    bar.tick();
    bar
}

fn with_progress(args: &ChallengeArgs, orders: &[Order]) -> Result<Vec<Sat>, Failure> {
    let bar = progress_bar(args, orders.len() as u64);
    let sat = serve(orders, args.keep.as_deref(), &|| bar.inc(1));
    bar.finish_and_clear();
    sat.map_err(|error| failure(&error))
}

/// Notes on cases that could not be generated and on run times.
fn notes(orders: &[Order], sat: &[Sat]) -> Vec<String> {
    let mut notes = Vec::new();
    let unseen: Vec<String> = orders
        .iter()
        .zip(sat)
        .filter(|(_, sat)| sat.score.is_none())
        .map(|(order, _)| format!("{} ({})", order.name, order.effects.join(", ")))
        .collect();
    if !unseen.is_empty() {
        notes.push(format!(
            "not generated, the effects are not detectable on any arm tried: {}",
            unseen.join("; ")
        ));
    }
    let times = sat.iter().filter(|sat| sat.seconds > 0.0).map(|sat| sat.seconds);
    if let Some(times) = Spread::of(times) {
        notes.push(format!(
            "diagnosis time on one thread: median {:.1} s, maximum {:.1} s",
            times.median, times.largest
        ));
    }
    notes
}

fn judged(args: &ChallengeArgs, board: &Scoreboard) -> Outcome {
    let failed = args.fail_on.iter().any(|what| match what {
        ChallengeFailOn::FalseAlarm => board.groups.iter().any(|g| g.false_alarms.count > 0),
        ChallengeFailOn::NamedBelow(least) => {
            board.groups.iter().map(|g| g.recall.count).sum::<usize>() < *least
        }
    });
    if failed { Outcome::FailedOnRequest } else { Outcome::Done }
}
