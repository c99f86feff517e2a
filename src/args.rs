//! Arguments of every command.

mod arm;
mod around;
mod challenge;
mod recorded;
mod value;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

pub(crate) use arm::{
    Direction, ExportArgs, FormatArg, ParamsArgs, PlanArgs, PredictArgs, SimulateArgs,
};
pub(crate) use around::{CompletionsArgs, DemoArgs, ManArgs, ReportArgs, RunArgs};
pub(crate) use challenge::{ChallengeArgs, ChallengeFailOn, KindArg, StudyArg};
pub(crate) use recorded::{
    CheckArgs, CouplingArg, DiagnoseArgs, IdentifyArgs, PriorArg, ValidateArgs, ViscousArg,
};
pub(crate) use value::Noise;
use value::{parse_named_number, parse_positive, parse_vector};

/// Minimal inertia sets, identification and diagnosis of serial robot arms.
#[derive(Parser)]
#[command(
    version,
    max_term_width = 100,
    after_help = "\
Start here:
  armident demo                                            the whole story on a simulated arm
  armident params   urdf/stanford.urdf                     what can be known about this arm
  armident check    urdf/ur10.urdf log.csv                 is this recording fit for it
  armident identify urdf/ur10.urdf log.csv                 what does this recording say about it
  armident diagnose urdf/ur10.urdf log.csv                 what does the model leave out
  armident run                                             the steps of armident.toml

Recordings are CSV files with a column `t` [s] and columns <joint>/position, /velocity,
/acceleration, /effort (rad, m, N m, N), Parquet files of such columns, or MCAP files of ROS 2 joint
states. Exit codes: 0 the result was written, 1 it failed,
2 the command line is wrong, 3 what --fail-on names has happened."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    Params(ParamsArgs),
    Plan(PlanArgs),
    Simulate(SimulateArgs),
    Check(CheckArgs),
    Identify(IdentifyArgs),
    Diagnose(DiagnoseArgs),
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

/// Which part of the robot is the arm.
#[derive(Args, Default)]
#[command(next_help_heading = "The chain")]
pub(crate) struct ChainArgs {
    /// First link of the chain [default: the root of the URDF]
    #[arg(long, value_name = "LINK")]
    pub(crate) base: Option<String>,
    /// Last link of the chain [default: through the recorded joints, or else the path with most
    /// movable joints]
    #[arg(long, value_name = "LINK")]
    pub(crate) tip: Option<String>,
    /// Freeze a joint at a position, rad or m; repeat for more joints
    #[arg(long, value_name = "JOINT=VALUE", value_parser = parse_named_number)]
    pub(crate) lock: Vec<(String, f64)>,
    /// Gravity in the base link frame, m/s2 [default: 0,0,-9.81]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, allow_hyphen_values = true)]
    pub(crate) gravity: Option<[f64; 3]>,
    /// Take joint angles of the URDF within this distance of a multiple of pi/12 as that multiple,
    /// rad; 2e-3 also catches 1.57 and 3.14
    #[arg(long, value_name = "RAD", default_value_t = 1e-4, value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) snap_rpy: f64,
}

/// How recordings are read.
#[derive(Args, Default)]
#[command(next_help_heading = "Recordings")]
pub(crate) struct ReadingArgs {
    /// TOML file that says which column is which joint, quantity and unit (docs/mapping.md)
    #[arg(long, value_name = "FILE")]
    pub(crate) mapping: Option<PathBuf>,
    /// Topic of the joint states in MCAP files [default: the only one, or /joint_states]
    #[arg(long, value_name = "TOPIC")]
    pub(crate) topic: Option<String>,
}

/// Where results go.
#[derive(Args, Default)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    /// Write the result as JSON to a file; - is stdout, in the place of the text
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Exit with code 3 when this has happened
    #[arg(long, value_name = "WHAT")]
    pub(crate) fail_on: Option<FailOn>,
    /// Say nothing on stderr but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// The page of a result.
#[derive(Args, Default)]
#[command(next_help_heading = "Report")]
pub(crate) struct PageArgs {
    /// Write the result as one self-contained HTML page with charts
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Put what a page draws into the JSON too, for `armident report`
    #[arg(long, requires = "json")]
    pub(crate) traces: bool,
    /// The command to name on the page, where it is not this one
    #[arg(skip)]
    pub(crate) command: Option<Vec<String>>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FailOn {
    /// a warning was given
    Warning,
}
