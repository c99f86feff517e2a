//! Arguments of the commands that take recordings.

use std::path::PathBuf;

use armident_ident::estimators::Estimator;
use clap::{Args, ValueEnum};

use super::arm::{one_recording, recordings, written_extensions};
use super::value::{
    PayloadArg, estimators, parse_file_gain, parse_payload, parse_positive, parse_probability,
};
use super::{CardArgs, ChainArgs, OutputArgs, PageArgs, ReadingArgs};

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PriorArg {
    /// Gaussian about the URDF, scale estimated from the recordings
    Urdf,
    /// no prior
    None,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CouplingArg {
    /// if cross-validation clearly supports it
    Auto,
    /// independent joints
    None,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ViscousArg {
    /// sublinear where the recordings clearly support it
    Auto,
    /// proportional to speed, as URDF and MJCF require
    Linear,
}

/// Estimate inertia and friction parameters from recordings
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident identify urdf/stanford.urdf runs/                           (Algorithm 2: runs/ contains plan.json)
  armident identify urdf/ur10.urdf day1.csv day2.csv --holdout day3.csv
  armident identify robot.urdf logs/ --cutoff-hz 8 --save-model model.json --json result.json
  armident identify robot.urdf empty.csv heavy.csv --payload file=heavy.csv,mass=2.0,com=0:0:0.05

A folder with plan.json selects Algorithm 2. All other recordings are fitted by robust least squares:
the minimal set, and viscous friction, Coulomb friction, offset and rotor inertia of every joint.
Velocity and acceleration are differentiated from the position with a zero-phase low-pass (4th-order
Butterworth), unless accelerations are recorded. If motor currents are recorded instead of efforts
(<joint>/current), the drive gains are also estimated: their ratios from any motion, their scale from a
known payload. If commands are recorded (<joint>/command) and no efforts, the position controllers are
estimated, with friction and weight, from the positions that follow.")]
pub(crate) struct IdentifyArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
    pub(crate) recordings: Vec<PathBuf>,
    /// Hold-out recordings, for validation
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub(crate) holdout: Vec<PathBuf>,
    /// Low-pass cut-off frequency [Hz] [default: from the motion's spectrum]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) cutoff_hz: Option<f64>,
    /// Estimator (ignored with a plan)
    #[arg(long, value_name = "METHOD", default_value = "irls", value_parser = estimators())]
    pub(crate) method: &'static dyn Estimator,
    /// Leave-one-recording-out cross-validation
    #[arg(long)]
    pub(crate) cross_validate: bool,
    /// Prior on link inertias (ignored with a plan)
    #[arg(long, value_name = "WHAT", default_value = "urdf")]
    pub(crate) prior: PriorArg,
    /// Known payload in a recording: file=F,mass=KG[,com=X:Y:Z][,com_error=M]; com in the last moving
    /// link's frame [m]; repeatable
    #[arg(long, value_name = "file=F,mass=KG[,..]", value_parser = parse_payload)]
    pub(crate) payload: Vec<PayloadArg>,
    /// Transmissions shared by neighbouring joints (ignored with a plan)
    #[arg(long, value_name = "WHEN", default_value = "auto")]
    pub(crate) coupling: CouplingArg,
    /// Viscous friction of the joints (ignored with a plan)
    #[arg(long, value_name = "HOW", default_value = "auto")]
    pub(crate) viscous: ViscousArg,
    /// Gain of the position controllers in a recording of commands, over the gain that is 1 in the others;
    /// repeatable
    #[arg(long, value_name = "FILE=RATIO", value_parser = parse_file_gain)]
    pub(crate) servo_gain: Vec<(PathBuf, f64)>,
    /// Skip the projection to physically consistent parameters
    #[arg(long)]
    pub(crate) raw_estimate: bool,
    /// Write the identified model, for predict, simulate and export
    #[arg(long, value_name = "FILE")]
    pub(crate) save_model: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) card: CardArgs,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) page: PageArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Show what a log holds: format, joints, rate, quality, and the mapping that its names suggest
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident info log.csv
  armident info log.csv --robot robot.urdf --write-mapping mapping.toml
  armident diagnose robot.urdf log.csv --mapping mapping.toml

Names such as actual_q_0, joint1.pos or tau_1 are guessed. Where a name has two meanings the guess is
unsure: the mapping file states why, and you decide. With --robot, numbered joints get the names of
the arm in its order.")]
pub(crate) struct InfoArgs {
    #[arg(required = true, help = recordings())]
    pub(crate) recordings: Vec<PathBuf>,
    /// URDF or model that names numbered joints
    #[arg(long, value_name = "FILE")]
    pub(crate) robot: Option<PathBuf>,
    /// Write the guessed mapping of the first recording, for --mapping of other commands
    #[arg(long, value_name = "FILE", conflicts_with = "mapping")]
    pub(crate) write_mapping: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Convert a log to a file with standard names and SI units
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident convert run.mcap run.csv
  armident convert log.mat log.npz --mapping mapping.toml

Columns are `t` and <joint>/<quantity>. What the output format cannot hold is listed.")]
pub(crate) struct ConvertArgs {
    #[arg(help = one_recording())]
    pub(crate) recording: PathBuf,
    #[arg(help = format!("Output file ({})", written_extensions()))]
    pub(crate) output_file: PathBuf,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Check recordings: signs, units, order, delay, noise and excitation
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident check urdf/ur10.urdf day1.csv
  armident check robot.urdf logs/ --json check.json --fail-on warning

Checks sample rate, noise, effort columns (sign, unit, gear side, gravity, joint), delay and
excitation. Each verdict is ok, inconclusive, doubtful or wrong; wrong verdicts are warnings. Currents
and voltages are accepted in place of efforts.")]
pub(crate) struct CheckArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
    pub(crate) recordings: Vec<PathBuf>,
    /// Low-pass cut-off frequency [Hz] [default: from the motion's spectrum]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) cutoff_hz: Option<f64>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) page: PageArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Find effects missing from a model and confirm them on hold-out recordings
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident diagnose robot.urdf train_1.csv train_2.csv --holdout holdout.csv
  armident diagnose robot.urdf logs/ --holdout last.csv --json out.json --save-model model.json
  armident diagnose robot.urdf after.csv --reference before.csv      (changes since before.csv)
  armident predict model.json motion.csv -o predicted.csv            (with all findings)

Every effect in the library is tested on every joint while all link inertias are refitted. A finding
must be material against the recording noise and lower the cross-validated error. The hold-out is
never fitted.")]
pub(crate) struct DiagnoseArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
    pub(crate) recordings: Vec<PathBuf>,
    /// Hold-out recordings, for confirmation
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub(crate) holdout: Vec<PathBuf>,
    /// Earlier recordings of the same arm; report only changes since then
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub(crate) reference: Vec<PathBuf>,
    /// Write the diagnosed model, for predict, simulate and export
    #[arg(long, value_name = "FILE")]
    pub(crate) save_model: Option<PathBuf>,
    /// Write a motion that separates indistinguishable effects to DIR/next_motion.csv
    #[arg(long, value_name = "DIR")]
    pub(crate) next_motion: Option<PathBuf>,
    /// Write recordings with predicted efforts, residuals and findings as topics of MCAP
    #[arg(long, value_name = "FILE")]
    pub(crate) mcap: Option<PathBuf>,
    /// Run a placebo test with N wrong terms
    #[arg(long, value_name = "N", conflicts_with = "reference")]
    pub(crate) placebo: Option<usize>,
    /// Skip forward replay
    #[arg(long)]
    pub(crate) no_replay: bool,
    /// Use columns that fail the input checks
    #[arg(long)]
    pub(crate) trust_columns: bool,
    /// Gain of the position controllers in a recording of commands, over the gain that is 1 in the others;
    /// repeatable
    #[arg(long, value_name = "FILE=RATIO", value_parser = parse_file_gain)]
    pub(crate) servo_gain: Vec<(PathBuf, f64)>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) page: PageArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Reduce recordings to states: small, merged in any order
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident accumulate robot.urdf logs/ -o states.jsonl
  armident accumulate robot.urdf day2/ -o day2.jsonl --cutoff-hz 8

A state is the triangle of the least-squares rows of each joint, one line of JSON a recording, or rows of a
table where the file is named .parquet. An output file that exists is continued: recordings that it holds are
not read again, so that an interrupted run can be repeated. Recordings that cannot be used are set aside with the reason. The columns are the
minimal set and the friction of each joint.")]
pub(crate) struct AccumulateArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
    pub(crate) recordings: Vec<PathBuf>,
    /// File of states, continued where it exists
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output_file: PathBuf,
    /// Low-pass cut-off frequency [Hz], the same for all recordings that are merged
    #[arg(long, value_name = "HZ", default_value_t = 5.0, value_parser = parse_positive)]
    pub(crate) cutoff_hz: f64,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Identify an arm from the states of its recordings
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident merge robot.urdf states.jsonl --save-model model.json
  armident merge robot.urdf monday.jsonl tuesday.jsonl

The parameters are those of a weighted least-squares fit to all recordings at the common cut-off, however
they were dealt out. Robust weights of single samples need the recordings: use identify for these.
States of another arm are set aside with the reason.")]
pub(crate) struct MergeArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    /// Files of states
    #[arg(required = true)]
    pub(crate) states: Vec<PathBuf>,
    /// Write the identified model, for predict, simulate and export
    #[arg(long, value_name = "FILE")]
    pub(crate) save_model: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Follow the robots of a fleet over their recordings: trends, changes and outliers
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident fleet robot.urdf states.jsonl --report fleet.html
  armident fleet robot.urdf logs/ --states states.jsonl --robot-of '{robot}/*.csv' --json fleet.json
  armident fleet robot.urdf logs/ --states states.parquet --robot-of column:robot

Reports for each robot how its parameters move from recording to recording, and where friction of a joint
or a body on a link changed. Recordings are reduced to the file of --states first, which a later run
continues. Files and states that cannot be used are set aside with the reason.")]
pub(crate) struct FleetArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    /// Files of states, recordings, and folders of both
    #[arg(required = true)]
    pub(crate) inputs: Vec<PathBuf>,
    /// Which robot a recording is of: pattern of the end of its path, or column:NAME [default: its folder]
    #[arg(long, value_name = "PATTERN")]
    pub(crate) robot_of: Option<String>,
    /// File of states that recordings are reduced to, continued where it exists
    #[arg(long, value_name = "FILE")]
    pub(crate) states: Option<PathBuf>,
    /// Low-pass cut-off frequency of recordings [Hz]
    #[arg(long, value_name = "HZ", default_value_t = 5.0, value_parser = parse_positive)]
    pub(crate) cutoff_hz: f64,
    /// Probability that a robot that does not change has a change reported
    #[arg(long, value_name = "P", default_value_t = 0.01, value_parser = parse_probability)]
    pub(crate) false_alarm_rate: f64,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) page: PageArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Evaluate a model on hold-out recordings
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident validate model.json day3.csv
  armident validate urdf/ur10.urdf day3.csv --cutoff-hz 8 --predictions predicted.csv

Reports the effort error per joint (low-passed and unfiltered), coverage of the 95 % band, residual
whiteness, and forward replay: recorded efforts drive the simulated arm in windows of 0.5 s, with the
URDF and with the model.")]
pub(crate) struct ValidateArgs {
    /// Model written by identify or diagnose, or a URDF
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
    pub(crate) recordings: Vec<PathBuf>,
    /// Low-pass cut-off frequency [Hz] [default: the model's, else from the motion's spectrum]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) cutoff_hz: Option<f64>,
    /// Write the predicted effort of every sample (only with one recording)
    #[arg(long, value_name = "FILE")]
    pub(crate) predictions: Option<PathBuf>,
    /// Write recordings with predicted efforts and residuals as topics of MCAP
    #[arg(long, value_name = "FILE")]
    pub(crate) mcap: Option<PathBuf>,
    /// Gain of the position controllers in a recording of commands, over the gain of the model; repeatable
    #[arg(long, value_name = "FILE=RATIO", value_parser = parse_file_gain)]
    pub(crate) servo_gain: Vec<(PathBuf, f64)>,
    /// Skip forward replay
    #[arg(long)]
    pub(crate) no_replay: bool,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) page: PageArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}
