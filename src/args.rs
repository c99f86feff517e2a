//! Command-line arguments.

// the doc comments of arguments are their help texts, in which [rad] is a unit
#![allow(rustdoc::broken_intra_doc_links)]

mod arm;
mod around;
mod challenge;
mod recorded;
mod value;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

pub(crate) use arm::{
    Direction, ExciteArgs, ExportArgs, FormatArg, ParamsArgs, PlanArgs, PredictArgs, SimulateArgs,
};
pub(crate) use around::{CompletionsArgs, DemoArgs, ManArgs, ReportArgs, RunArgs};
pub(crate) use challenge::{ChallengeArgs, ChallengeFailOn, KindArg, StudyArg};
pub(crate) use recorded::{
    AccumulateArgs, CheckArgs, ConvertArgs, CouplingArg, DiagnoseArgs, FleetArgs, IdentifyArgs,
    InfoArgs, MergeArgs, PriorArg, ValidateArgs, ViscousArg,
};
pub(crate) use value::PayloadArg;
use value::{parse_named_number, parse_positive, parse_vector};

/// Identification and diagnosis of serial robot arms
#[derive(Parser)]
#[command(
    version,
    max_term_width = 100,
    after_help = "\
Start here:
  armident demo                                            a complete example
  armident params   urdf/stanford.urdf                     minimal parameter set of an arm
  armident info     log.csv                                show what a log holds
  armident check    urdf/ur10.urdf log.csv                 check a recording
  armident identify urdf/ur10.urdf log.csv                 estimate parameters
  armident diagnose urdf/ur10.urdf log.csv                 find missing effects
  armident run                                             run armident.toml

Recordings are CSV files with a column `t` [s] and columns <joint>/position, /velocity,
/acceleration, /effort (rad, m, N m, N), NumPy, MATLAB and Parquet files of such columns, or bags of
ROS with joint states; info shows what a log with other names holds. Exit codes: 0 result written, 1 failed, 2 usage error, 3 condition of --fail-on met."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    Params(ParamsArgs),
    Plan(PlanArgs),
    Excite(ExciteArgs),
    Simulate(SimulateArgs),
    Info(InfoArgs),
    Convert(ConvertArgs),
    Check(CheckArgs),
    Identify(IdentifyArgs),
    Diagnose(DiagnoseArgs),
    Accumulate(AccumulateArgs),
    Merge(MergeArgs),
    Fleet(FleetArgs),
    Validate(ValidateArgs),
    Predict(PredictArgs),
    Export(ExportArgs),
    Report(ReportArgs),
    Run(RunArgs),
    Demo(DemoArgs),
    Completions(CompletionsArgs),
    Man(ManArgs),
    Challenge(ChallengeArgs),
}

/// Part of the robot that is the arm.
#[derive(Args, Default)]
#[command(next_help_heading = "Chain")]
pub(crate) struct ChainArgs {
    /// First link of the chain [default: the root of the URDF]
    #[arg(long, value_name = "LINK")]
    pub(crate) base: Option<String>,
    /// Last link of the chain [default: the tip that contains the recorded joints, else the path
    /// with the most movable joints]
    #[arg(long, value_name = "LINK")]
    pub(crate) tip: Option<String>,
    /// Lock a joint at a position [rad or m]; repeatable
    #[arg(long, value_name = "JOINT=VALUE", value_parser = parse_named_number)]
    pub(crate) lock: Vec<(String, f64)>,
    /// Gravity in the base link frame [m/s2] [default: 0,0,-9.81]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, allow_hyphen_values = true)]
    pub(crate) gravity: Option<[f64; 3]>,
    /// Snap URDF joint angles within this tolerance [rad] to multiples of pi/12; use 2e-3 for angles
    /// rounded to 1.57
    #[arg(long, value_name = "RAD", default_value_t = 1e-4, value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) snap_rpy: f64,
}

/// Options for reading recordings.
#[derive(Args, Default)]
#[command(next_help_heading = "Recordings")]
pub(crate) struct ReadingArgs {
    /// TOML file that maps columns to joints, quantities and units (docs/mapping.md)
    #[arg(long, value_name = "FILE")]
    pub(crate) mapping: Option<PathBuf>,
    /// Topic of the joints in bags of ROS [default: the only one with joint states, else /joint_states]
    #[arg(long, value_name = "TOPIC")]
    pub(crate) topic: Option<String>,
}

/// Options for writing results.
#[derive(Args, Default)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    /// Write the result as JSON; - for stdout (replaces the text)
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Exit with code 3 if this occurs
    #[arg(long, value_name = "WHAT")]
    pub(crate) fail_on: Option<FailOn>,
    /// Print only errors to stderr
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// Options for the HTML page of a result.
#[derive(Args, Default)]
#[command(next_help_heading = "Report")]
pub(crate) struct PageArgs {
    /// Write an HTML report (self-contained, with charts)
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Include chart data in the JSON, for `armident report`
    #[arg(long, requires = "json")]
    pub(crate) traces: bool,
    /// The command shown on the page, if it differs from this one
    #[arg(skip)]
    pub(crate) command: Option<Vec<String>>,
}

/// Options of the model card.
#[derive(Args, Default)]
#[command(next_help_heading = "Model card")]
pub(crate) struct CardArgs {
    /// Write the model card (HTML, with its JSON beside it): values, errors, unit, date, digests of files
    #[arg(long, value_name = "FILE.html")]
    pub(crate) card: Option<PathBuf>,
    /// Serial number of the arm, on the card
    #[arg(long, value_name = "TEXT", requires = "card")]
    pub(crate) serial: Option<String>,
    /// Date of the recordings, on the card [default: of their stamps, where these count from 1970]
    #[arg(long, value_name = "DATE", requires = "card")]
    pub(crate) date: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FailOn {
    /// any warning
    Warning,
}
