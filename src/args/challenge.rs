//! Arguments of `armident challenge`.

use std::path::PathBuf;

use super::value::{no_effect, parse_within};
use clap::{Args, ValueEnum};

/// Kind of a case.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum KindArg {
    /// one or two effects on an otherwise exact arm, clean recordings
    Clean,
    /// friction on every joint, errors of every inertial, uneven clocks and lost samples as well
    Field,
    /// no effect: exact, with inertial errors, with baseline friction, with both
    Null,
    /// clean and field alternating
    Mixed,
    /// field arms with up to four effects, slow recordings with more faults, standstills
    Hard,
    /// field arms recorded before and after a hidden change, some with friction changed by warm-up
    Change,
}

/// Studies, each a table.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StudyArg {
    /// false alarm rate
    Nulls,
    /// detection power against effect size
    Power,
    /// laws that deviate from the library
    Perturbed,
    /// clean and field cases alternating
    Mixed,
    /// several effects, poor recordings
    Hard,
    /// changes between two sets of recordings of one arm
    Change,
    /// arms without efforts: commands and positions, and five nulls to three cases
    Commands,
}

/// Condition that ends a challenge with exit code 3.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum ChallengeFailOn {
    /// A finding in a null case.
    FalseAlarm,
    /// Fewer (effect, location) pairs found than this.
    NamedBelow(usize),
}

/// Score the diagnosis on simulated arms with hidden effects
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident challenge --cases 24 --seed 7                                (clean and field cases alternating)
  armident challenge --cases 20 --seed 7 --kind null --fail-on false-alarm
  armident challenge --cases 4 --seed 7 --kind field --effect backlash --robot urdf/ur5.urdf --keep cases/
  armident challenge --cases 24 --seed 7 --only 5 --keep one/           (only the fifth of 24)
  armident challenge --cases 20 --seed 7 --kind change                  (changes between recordings)
  armident challenge --study nulls --seed 2026                          (a table in Markdown)
  armident challenge --study commands --cases 12 --seed 7               (arms without efforts)
  armident challenge --cases 48 --seed 7 --report board.html            (scoreboard as an HTML page)
  armident challenge --score cases/cases cases/results                  (results of another program)

Every case is simulated in closed loop. The diagnosis receives only the given URDF and the training
recordings; the hold-out and the exam are predicted before the truth is read.")]
pub(crate) struct ChallengeArgs {
    /// Number of cases [default: 24; studies: 200 nulls, 2 per cell of power, 24 perturbed, 96 mixed,
    /// 40 changes, 60 of commands]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub(crate) cases: Option<u64>,
    /// Random seed
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Kind of the cases [default: mixed; clean with --effect and in the power study]
    #[arg(long, value_enum)]
    pub(crate) kind: Option<KindArg>,
    /// Hide this effect in every case, or `unlisted`; repeatable [default: all in turn]
    #[arg(long, value_name = "EFFECT", value_parser = parse_slug)]
    pub(crate) effect: Vec<String>,
    /// Name of a bundled arm, or a URDF [default: random bundled arms]
    #[arg(long, value_name = "ARM")]
    pub(crate) robot: Option<String>,
    /// Hide variants of laws: smooth Coulomb friction, another hysteresis, another ripple
    #[arg(long, conflicts_with = "effect")]
    pub(crate) perturbed: bool,
    /// Effect size: RMS effort beyond rigid body and baseline friction, in noise levels [default:
    /// random, 1.9 to 11]
    #[arg(long, value_name = "RATIO", value_parser = parse_margin)]
    pub(crate) margin: Option<f64>,
    /// Run only this case, counted from 1; repeatable
    #[arg(long, value_name = "NUMBER", conflicts_with = "study")]
    pub(crate) only: Vec<usize>,
    /// Write the cases to DIR/cases and the results of the diagnosis to DIR/results
    #[arg(long, value_name = "DIR")]
    pub(crate) keep: Option<PathBuf>,
    /// Run a study and print its table in Markdown
    #[arg(long, value_enum, conflicts_with_all = ["effect", "robot", "perturbed", "margin"])]
    pub(crate) study: Option<StudyArg>,
    /// Only score a folder of results (CASE/out.json, CASE/predicted.csv) against a folder of cases
    #[arg(long, num_args = 2, value_names = ["CASES", "RESULTS"],
        conflicts_with_all = ["cases", "seed", "kind", "effect", "robot", "perturbed", "margin", "only", "keep", "study"])]
    pub(crate) score: Vec<PathBuf>,
    /// Write the scoreboard as JSON; - for stdout (replaces the text)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) json: Option<PathBuf>,
    /// Write an HTML report (self-contained, with charts)
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(crate) report: Option<PathBuf>,
    /// The command shown on the page, if it differs from this one
    #[arg(skip)]
    pub(crate) command: Option<Vec<String>>,
    /// Exit with code 3 on `false-alarm` (a finding in a null case), or `named-below=N` (fewer than N
    /// effects found); repeatable
    #[arg(long, value_name = "WHAT", value_parser = parse_challenge_fail_on, help_heading = "Output")]
    pub(crate) fail_on: Vec<ChallengeFailOn>,
    /// Print only errors to stderr
    #[arg(long, short, help_heading = "Output")]
    pub(crate) quiet: bool,
}

/// Parses an effect size; below 0.1 an effect is hidden in the noise, above 100 it is obvious.
fn parse_margin(text: &str) -> Result<f64, String> {
    parse_within(text, 0.1, 100.0)
}

fn parse_slug(text: &str) -> Result<String, String> {
    let known = text == "unlisted" || armident_effects::effect(text).is_some();
    if known {
        return Ok(text.to_owned());
    }
    Err(no_effect(text, &["unlisted"]))
}

fn parse_challenge_fail_on(text: &str) -> Result<ChallengeFailOn, String> {
    let form = "expected false-alarm or named-below=N";
    match text.split_once('=') {
        None if text == "false-alarm" => Ok(ChallengeFailOn::FalseAlarm),
        Some(("named-below", number)) => {
            number.parse().map(ChallengeFailOn::NamedBelow).map_err(|_| form.to_owned())
        }
        _ => Err(form.to_owned()),
    }
}
