//! Arguments of `armident challenge`.

use std::path::PathBuf;

use super::value::{no_effect, parse_within};
use clap::{Args, ValueEnum};

/// Kinds of cases.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum KindArg {
    /// one or two effects on an otherwise exact arm, clean recordings
    Clean,
    /// friction on every joint, errors of every inertial, uneven clocks and lost samples as well
    Field,
    /// no effect: exact, with inertial errors, with everyday friction, with both
    Null,
    /// clean and field in turn
    Mixed,
    /// field arms before and after: what is concealed came between, and friction that warmth changes
    Change,
}

/// Questions that a table answers.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StudyArg {
    /// how often something is found where nothing is
    Nulls,
    /// how large an effect must be to be named
    Power,
    /// laws that are not quite those of the library
    Perturbed,
    /// clean and field cases in turn
    Mixed,
    /// what changed between two sets of recordings of one arm
    Change,
}

/// What makes a challenge end with code 3.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum ChallengeFailOn {
    /// A null in which something is found.
    FalseAlarm,
    /// Fewer pairs named than this.
    NamedBelow(usize),
}

/// Conceal effects in simulated recordings, diagnose them unseen, and score what is said
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident challenge --cases 24 --seed 7                                (clean and field cases in turn)
  armident challenge --cases 20 --seed 7 --kind null --fail-on false-alarm
  armident challenge --cases 4 --seed 7 --kind field --effect backlash --robot urdf/ur5.urdf --keep cases/
  armident challenge --cases 24 --seed 7 --only 5 --keep one/           (the fifth of 24 alone)
  armident challenge --cases 20 --seed 7 --kind change                  (what changed since before?)
  armident challenge --study nulls --seed 2026                          (a table in Markdown)
  armident challenge --cases 48 --seed 7 --report board.html            (the scoreboard as a page)
  armident challenge --score cases/cases cases/results                  (results of another program)

Every case is simulated in closed loop by a robot of which the diagnosis knows only the believed URDF
and two training recordings; the hold-out and the exam are predicted before the answer is opened.")]
pub(crate) struct ChallengeArgs {
    /// How many cases [default: 24; of a study 200 nulls, 2 for each cell of power, 24 perturbed, 96 mixed, 40 changes]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub(crate) cases: Option<u64>,
    /// Everything that is left to chance follows from it
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Kind of the cases [default: mixed; clean with --effect and of the power study]
    #[arg(long, value_enum)]
    pub(crate) kind: Option<KindArg>,
    /// Conceal this effect in every case, or `unlisted`; repeat for several at once [default: all take
    /// turns]
    #[arg(long, value_name = "EFFECT", value_parser = parse_slug)]
    pub(crate) effect: Vec<String>,
    /// Name of a bundled arm, or a URDF [default: bundled arms by chance]
    #[arg(long, value_name = "ARM")]
    pub(crate) robot: Option<String>,
    /// Conceal variants of laws: smooth for sharp Coulomb friction, another hysteresis, another ripple
    #[arg(long, conflicts_with = "effect")]
    pub(crate) perturbed: bool,
    /// Size of every effect, in naming margins (RMS torque over noise beyond what the rigid body and plain
    /// friction explain) [default: by chance, 1.9 to 11]
    #[arg(long, value_name = "RATIO", value_parser = parse_margin)]
    pub(crate) margin: Option<f64>,
    /// Make this case of the series alone, counted from 1; repeat for more
    #[arg(long, value_name = "NUMBER", conflicts_with = "study")]
    pub(crate) only: Vec<usize>,
    /// Write the cases to DIR/cases and what the diagnosis hands in to DIR/results
    #[arg(long, value_name = "DIR")]
    pub(crate) keep: Option<PathBuf>,
    /// Run a study and print its table in Markdown
    #[arg(long, value_enum, conflicts_with_all = ["effect", "robot", "perturbed", "margin"])]
    pub(crate) study: Option<StudyArg>,
    /// Score a folder of results (CASE/out.json, CASE/predicted.csv) against a folder of cases, nothing else
    #[arg(long, num_args = 2, value_names = ["CASES", "RESULTS"],
        conflicts_with_all = ["cases", "seed", "kind", "effect", "robot", "perturbed", "margin", "only", "keep", "study"])]
    pub(crate) score: Vec<PathBuf>,
    /// Write the scoreboard as JSON to a file; - is stdout, in the place of the text
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) json: Option<PathBuf>,
    /// Write the scoreboard as one self-contained HTML page with charts
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub(crate) report: Option<PathBuf>,
    /// The command to name on the page, where it is not this one
    #[arg(skip)]
    pub(crate) command: Option<Vec<String>>,
    /// Exit with code 3 on `false-alarm` (something is found in a null), or `named-below=N` (fewer than
    /// N effects are named); repeat for both
    #[arg(long, value_name = "WHAT", value_parser = parse_challenge_fail_on, help_heading = "Output")]
    pub(crate) fail_on: Vec<ChallengeFailOn>,
    /// Say nothing on stderr but errors
    #[arg(long, short, help_heading = "Output")]
    pub(crate) quiet: bool,
}

/// Smaller ones are in the noise, larger ones need no tool.
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
