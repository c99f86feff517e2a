//! Arguments of every command.

use std::path::PathBuf;

use armident_ident::Method;
use clap::{Args, Parser, Subcommand, ValueEnum};

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
pub(crate) enum PriorArg {
    /// every number of a link is right to its own size
    Urdf,
    /// nothing: the recordings alone
    None,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CouplingArg {
    /// where stretches of the recordings that are left out of a fit show it clearly
    Auto,
    /// every joint has its own
    None,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodArg {
    /// least squares, every row alike
    Ols,
    /// joints weighted by their noise
    Wls,
    /// weighted, samples that are off count for less (Huber)
    Irls,
    /// weighted, with the simulated arm for instruments; tests least squares against it
    Iv,
}

impl MethodArg {
    pub(crate) fn method(self) -> Method {
        match self {
            Self::Ols => Method::Ols,
            Self::Wls => Method::Wls,
            Self::Irls => Method::Irls,
            Self::Iv => Method::Iv,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FailOn {
    /// a warning was given
    Warning,
}

/// Print an arm's driving-axis frames and its minimal inertia set
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident params urdf/stanford.urdf
  armident params robot.urdf --tip left_tool0 --lock torso_lift_joint=0.2
  armident params robot.urdf --gravity 0,6.94,-6.94 --json minimal.json     (mounted on a 45 deg slope)")]
pub(crate) struct ParamsArgs {
    /// URDF, or a model written by identify
    pub(crate) robot: PathBuf,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Plan the experiments of Algorithm 2: one joint moves, the others are held
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident plan urdf/stanford.urdf -o plan/
  armident plan robot.urdf -o plan/ --amplitude 0.3 --coulomb joint_2=4.5 --dither 0.004,3

Writes plan/plan.json and one trajectory CSV per experiment, inside the joints' position, speed and
effort limits. Record them on the arm, put the recordings beside a copy of plan.json, and run
`armident identify robot.urdf FOLDER`.")]
pub(crate) struct PlanArgs {
    /// URDF, or a model written by identify
    pub(crate) robot: PathBuf,
    /// Folder to write plan.json and the trajectories to
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output_folder: PathBuf,
    /// Amplitude of rotational joints, rad
    #[arg(long, default_value_t = std::f64::consts::FRAC_PI_6, value_parser = parse_amplitude)]
    pub(crate) amplitude: f64,
    /// Amplitude of translational joints, m
    #[arg(long, default_value_t = 0.15, value_parser = parse_amplitude)]
    pub(crate) amplitude_m: f64,
    /// Quickness of the critically damped step, 1/s; lowered where limits ask for it
    #[arg(long, default_value_t = 10.0, value_parser = parse_sigma)]
    pub(crate) sigma: f64,
    /// Samples per second of the trajectories
    #[arg(long, default_value_t = 200.0, value_parser = parse_rate)]
    pub(crate) rate_hz: f64,
    /// Known Coulomb level of a joint, N m or N; repeat for more joints
    #[arg(long, value_name = "JOINT=LEVEL", value_parser = parse_named_number)]
    pub(crate) coulomb: Vec<(String, f64)>,
    /// Keep the observed joint moving a little: amplitude (rad or m) and frequency (Hz)
    #[arg(long, value_name = "AMPLITUDE,HZ", value_parser = parse_pair)]
    pub(crate) dither: Option<(f64, f64)>,
    /// Seed of the configurations tried
    #[arg(long, default_value_t = 1992)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Direction {
    /// motion in, exact efforts out
    Inverse,
    /// efforts in, motion out
    Forward,
}

/// Simulate recordings: of a plan's experiments, or of any trajectory
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident simulate urdf/stanford.urdf plan/ -o runs/
  armident simulate robot.urdf motion.csv -o run.csv --torque-noise 0.1 --encoder-bits 19 --seed 7
  armident simulate robot.urdf motion.csv -o run.csv --effect coulomb_friction:joint_2=4.5
  armident simulate robot.urdf efforts.csv -o run.csv --direction forward

Without --encoder-bits the exact accelerations are written too, and identify uses them.")]
pub(crate) struct SimulateArgs {
    /// URDF, or a model written by identify
    pub(crate) robot: PathBuf,
    /// Folder of a plan, or trajectory files (CSV, MCAP, Parquet)
    #[arg(required = true)]
    pub(crate) trajectories: Vec<PathBuf>,
    /// Folder to write to, or a file when one trajectory is given (.csv, .mcap, .parquet)
    #[arg(short, long, value_name = "PATH")]
    pub(crate) output_path: PathBuf,
    /// Which way to simulate
    #[arg(long, value_enum, default_value_t = Direction::Inverse)]
    pub(crate) direction: Direction,
    /// Standard deviation of white effort noise, N m or N; with % relative to each joint's effort
    #[arg(long, value_name = "SIGMA", value_parser = parse_noise, allow_negative_numbers = true)]
    pub(crate) torque_noise: Option<Noise>,
    /// Quantise positions to this many bits per turn (or metre)
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(4..=40))]
    pub(crate) encoder_bits: Option<u32>,
    /// Resample to this rate first
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) rate_hz: Option<f64>,
    /// Put an effect on a joint; repeat for more
    #[arg(long, value_name = "EFFECT:JOINT=P1[,P2..]", value_parser = parse_effect)]
    pub(crate) effect: Vec<armident_effects::EffectOnJoint>,
    /// Seed of the noise
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Estimate an arm's inertia constants and joint friction from recordings
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident identify urdf/stanford.urdf runs/                           (Algorithm 2: runs/ has a plan.json)
  armident identify urdf/ur10.urdf day1.csv day2.csv --holdout day3.csv
  armident identify robot.urdf logs/ --cutoff-hz 8 --save-model model.json --json result.json
  armident identify robot.urdf empty.csv heavy.csv --payload file=heavy.csv,mass=2.0,com=0:0:0.05

A folder with plan.json selects Algorithm 2; anything else is fitted by robust least squares of the
minimal set, viscous and Coulomb friction, offset and rotor inertia of every joint. Velocity and
acceleration come from the position, low-passed forward and backward (4th-order Butterworth), unless
accelerations are recorded. Where motor currents are recorded in the place of efforts (<joint>/current),
the gains of the drives are found with them: their ratios from any motion, their size from a known load.")]
pub(crate) struct IdentifyArgs {
    /// URDF, or a model written by identify
    pub(crate) robot: PathBuf,
    /// Recordings (CSV, MCAP, Parquet) or folders of them
    #[arg(required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// Recordings kept out of the fit, to judge it
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub(crate) holdout: Vec<PathBuf>,
    /// Cut-off of the low-pass, Hz [default: from the spectrum of the motion]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) cutoff_hz: Option<f64>,
    /// How ordinary motion is fitted; no matter with a plan
    #[arg(long, value_name = "METHOD", default_value = "irls")]
    pub(crate) method: MethodArg,
    /// Leave each recording out once, and judge the fit to the others on it
    #[arg(long)]
    pub(crate) cross_validate: bool,
    /// What is believed of the links before the recordings; no matter with a plan
    #[arg(long, value_name = "WHAT", default_value = "urdf")]
    pub(crate) prior: PriorArg,
    /// Load of known mass on the last link in one of the recordings: file=F,mass=KG and, where known,
    /// com=X:Y:Z in the frame of the last moving link, m, and com_error=M; repeat for more
    #[arg(long, value_name = "file=F,mass=KG[,..]", value_parser = parse_payload)]
    pub(crate) payload: Vec<PayloadArg>,
    /// Transmissions that neighbouring joints share; no matter with a plan
    #[arg(long, value_name = "WHEN", default_value = "auto")]
    pub(crate) coupling: CouplingArg,
    /// Keep the estimate as it is, also where no real links and friction have it
    #[arg(long)]
    pub(crate) raw_estimate: bool,
    /// Write the model found, for predict and simulate
    #[arg(long, value_name = "FILE")]
    pub(crate) save_model: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) page: PageArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Tell whether recordings are fit for purpose, and whether their bookkeeping agrees with the robot
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident check urdf/ur10.urdf day1.csv
  armident check robot.urdf logs/ --json check.json --fail-on warning

Sample rate against the motion, noise of every channel, what each effort column is (the joint's effort,
its negative, another unit or the motor side of a gear, without gravity, another joint's), delay between
effort and motion, and which constants the recordings determine. Each is ok, doubtful, wrong, or cannot
be told; wrong ones are warnings. Currents and voltages are taken where there are no efforts.")]
pub(crate) struct CheckArgs {
    /// URDF, or a model written by identify
    pub(crate) robot: PathBuf,
    /// Recordings (CSV) or folders of them
    #[arg(required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// Cut-off of the low-pass, Hz [default: from the spectrum of the motion]
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

/// Say what physics the model leaves out, and prove it on recordings kept back
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident diagnose robot.urdf train_1.csv train_2.csv --holdout holdout.csv
  armident diagnose robot.urdf logs/ --holdout last.csv --json out.json --save-model model.json
  armident diagnose robot.urdf after.csv --reference before.csv      (what changed?)
  armident predict model.json motion.csv -o predicted.csv            (what the recordings would show)

Every law of the effect library is tried on every joint, with the inertias of all links refitted beside
it; what is named is material against the noise of the recordings. The hold-out is never fitted.")]
pub(crate) struct DiagnoseArgs {
    /// URDF, or a model written by identify
    pub(crate) robot: PathBuf,
    /// Recordings (CSV) or folders of them
    #[arg(required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// Recordings kept out of the fit, to prove it
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub(crate) holdout: Vec<PathBuf>,
    /// Recordings of the same arm before something changed: only the difference to them is diagnosed
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub(crate) reference: Vec<PathBuf>,
    /// Write the model with what was found, for predict and simulate
    #[arg(long, value_name = "FILE")]
    pub(crate) save_model: Option<PathBuf>,
    /// Where recordings cannot tell effects apart: write the motion that would, next_motion.csv, into
    /// this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) next_motion: Option<PathBuf>,
    /// Also try this many wrong terms and say how many would have been believed
    #[arg(long, value_name = "N", conflicts_with = "reference")]
    pub(crate) placebo: Option<usize>,
    /// Do not simulate the hold-out from its recorded efforts
    #[arg(long)]
    pub(crate) no_replay: bool,
    /// Diagnose although columns look wrong (another unit, sign or joint)
    #[arg(long)]
    pub(crate) trust_columns: bool,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) page: PageArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Judge a model on recordings it was not fitted to
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident validate model.json day3.csv
  armident validate urdf/ur10.urdf day3.csv --cutoff-hz 8 --predictions predicted.csv

Effort error per joint, on the low-passed effort and on the effort as recorded; share of samples inside
the model's 95 % band; whether the residual is white; and forward replay: the recorded efforts drive the
simulated arm through windows of half a second, before (URDF) and after (model).")]
pub(crate) struct ValidateArgs {
    /// Model written by identify, or a URDF
    pub(crate) robot: PathBuf,
    /// Recordings (CSV, MCAP, Parquet) or folders of them
    #[arg(required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// Cut-off of the low-pass, Hz [default: the model's, or else from the spectrum of the motion]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) cutoff_hz: Option<f64>,
    /// Write the predicted effort of every sample (one recording only)
    #[arg(long, value_name = "FILE")]
    pub(crate) predictions: Option<PathBuf>,
    /// Leave forward replay out
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

/// Predict the effort of every joint for every sample of a motion
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident predict model.json motion.csv -o predicted.csv
  armident predict urdf/ur10.urdf motion.csv -o - --cutoff-hz 8")]
pub(crate) struct PredictArgs {
    /// URDF, or a model written by identify
    pub(crate) robot: PathBuf,
    /// Motion (CSV, MCAP, Parquet) with the positions of the joints
    pub(crate) motion: PathBuf,
    /// File to write the columns t and JOINT/effort to, as CSV unless it ends in .mcap or .parquet; - is
    /// stdout
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output_file: PathBuf,
    /// Cut-off of the low-pass, Hz [default: the model's, or else from the spectrum of the motion]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) cutoff_hz: Option<f64>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatArg {
    /// links, limits, damping and friction
    Urdf,
    /// the same for MuJoCo, with armature, gravity and motors
    Mjcf,
}

/// Write a model as URDF or MJCF, for controllers and simulators
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident export model.json -o robot.urdf
  armident export model.json -o robot.xml           (MJCF, for MuJoCo)
  armident export urdf/panda.urdf -o - --format mjcf

The chain with its links, limits and what the format holds of the joints' effects; what it cannot hold
is said. Shapes and meshes are left out.")]
pub(crate) struct ExportArgs {
    /// Model written by identify, or a URDF
    pub(crate) robot: PathBuf,
    /// File to write; .urdf or .xml tells the format, - is stdout
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output_file: PathBuf,
    /// The format, where the name of the file does not tell it
    #[arg(long, value_enum)]
    pub(crate) format: Option<FormatArg>,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Write the result of a command as one self-contained HTML page
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident diagnose robot.urdf train.csv --json result.json --traces
  armident report result.json -o report.html

The page opens in any browser, without a network. Charts of efforts and residuals need --traces in the
command that wrote the result; check, identify, validate, diagnose and challenge write the same page at once with
--report.")]
pub(crate) struct ReportArgs {
    /// JSON written by --json of any command
    pub(crate) result: PathBuf,
    /// File to write; - is stdout
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output_file: PathBuf,
}

/// Do the steps of an analysis that a file lists
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident run                          (armident.toml of this folder)
  armident run ur5/armident.toml --only diagnose
  armident run --dry-run                (print the command of every step)

A file of two steps; paths are relative to it, and the keys of a step are the options of its command:

  [defaults]                            # taken by every step whose command has them
  robot = \"urdf/ur5.urdf\"

  [[step]]
  command = \"check\"
  recordings = [\"train.csv\"]
  fail-on = \"warning\"

  [[step]]
  command = \"diagnose\"
  recordings = [\"train.csv\"]
  holdout = [\"holdout.csv\"]
  save-model = \"found.json\"
  report = \"report.html\"

All steps are read before the first is done. The first that fails ends the run with its exit code.")]
pub(crate) struct RunArgs {
    /// File of the steps
    #[arg(default_value = "armident.toml")]
    pub(crate) file: PathBuf,
    /// Do this step alone, by its `name` or else its command; repeat for more
    #[arg(long, value_name = "STEP")]
    pub(crate) only: Vec<String>,
    /// Print the command of every step and do nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Do not say which step is being done
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// Show the whole story on a simulated arm: concealed physics, its diagnosis, a report
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident demo
  armident demo -o demo --seed 3

Writes ur5.urdf, train.csv, holdout.csv, model.json and report.html to the folder.")]
pub(crate) struct DemoArgs {
    /// Folder to write to, new or of an earlier demo
    #[arg(short, long, value_name = "FOLDER", default_value = "armident-demo")]
    pub(crate) output_folder: PathBuf,
    /// Seed of the noise
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}

/// Print the completions of a shell
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident completions bash > ~/.local/share/bash-completion/completions/armident
  armident completions zsh > ~/.zfunc/_armident")]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

/// Write manual pages
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident man -o man && man -l man/armident-diagnose.1")]
pub(crate) struct ManArgs {
    /// Folder to write armident.1 and a page a command to
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output_folder: PathBuf,
}

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
  armident challenge --study nulls --seed 2026                          (a table in Markdown)
  armident challenge --cases 48 --seed 7 --report board.html            (the scoreboard as a page)
  armident challenge --score cases/cases cases/results                  (results of another program)

Every case is simulated in closed loop by a robot of which the diagnosis knows only the believed URDF
and two training recordings; the hold-out and the exam are predicted before the answer is opened.")]
pub(crate) struct ChallengeArgs {
    /// How many cases [default: 24; of a study 200 nulls, 2 for each cell of power, 24 perturbed, 96 mixed]
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

/// Level of effort noise.
#[derive(Clone, Copy)]
pub(crate) enum Noise {
    /// N m or N.
    Absolute(f64),
    /// Share of each joint's effort variation.
    Relative(f64),
}

fn parse_number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("`{text}` is not a finite number")),
    }
}

fn parse_positive(text: &str) -> Result<f64, String> {
    match parse_number(text)? {
        x if x > 0.0 => Ok(x),
        x => Err(format!("must be above zero, found {x}")),
    }
}

fn parse_within(text: &str, low: f64, high: f64) -> Result<f64, String> {
    match parse_number(text)? {
        x if (low..=high).contains(&x) => Ok(x),
        x => Err(format!("must lie between {low} and {high}, found {x}")),
    }
}

fn parse_amplitude(text: &str) -> Result<f64, String> {
    parse_within(text, 1e-3, 10.0)
}

/// Slower steps last for minutes, quicker ones are impacts.
fn parse_sigma(text: &str) -> Result<f64, String> {
    parse_within(text, 0.2, 200.0)
}

fn parse_rate(text: &str) -> Result<f64, String> {
    parse_within(text, 10.0, 20_000.0)
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

/// A name that no effect has, and the one that may be meant.
fn no_effect(text: &str, more: &[&'static str]) -> String {
    /// Similarity by Jaro and Winkler, 0 to 1, which weighs the beginning.
    const SIMILAR: f64 = 0.85;
    let slugs = armident_effects::LIBRARY.iter().map(|e| e.law().slug).chain(more.iter().copied());
    let known: Vec<&str> = slugs.collect();
    let near = known
        .iter()
        .map(|slug| (strsim::jaro_winkler(text, slug), slug))
        .filter(|(similarity, _)| *similarity > SIMILAR)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let meant = near.map_or_else(String::new, |(_, slug)| format!("; did you mean {slug}?"));
    format!("there is no effect `{text}`{meant} (there are {})", known.join(", "))
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

fn parse_named_number(text: &str) -> Result<(String, f64), String> {
    let (name, value) =
        text.rsplit_once('=').ok_or_else(|| format!("expected JOINT=VALUE, found `{text}`"))?;
    Ok((name.to_owned(), parse_number(value)?))
}

fn parse_numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(parse_number).collect()
}

fn parse_vector(text: &str) -> Result<[f64; 3], String> {
    let numbers = parse_numbers(text)?;
    <[f64; 3]>::try_from(numbers)
        .map_err(|n| format!("expected three numbers X,Y,Z, found {}", n.len()))
}

fn parse_pair(text: &str) -> Result<(f64, f64), String> {
    match parse_numbers(text)?[..] {
        [a, f] if a > 0.0 && f > 0.0 => Ok((a, f)),
        [_, _] => Err("amplitude and frequency must be above zero".to_owned()),
        _ => Err("expected AMPLITUDE,HZ, for example 0.004,3".to_owned()),
    }
}

/// A load in one of the recordings, not yet checked against anything.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PayloadArg {
    pub(crate) file: PathBuf,
    pub(crate) mass_kg: f64,
    pub(crate) com_m: Option<[f64; 3]>,
    pub(crate) com_error_m: f64,
}

fn parse_payload(text: &str) -> Result<PayloadArg, String> {
    let form = "expected file=F,mass=KG[,com=X:Y:Z][,com_error=M], for example \
                file=heavy.csv,mass=2,com=0:0:0.05";
    let (mut file, mut mass_kg, mut com_m, mut com_error_m) = (None, None, None, 0.0);
    for part in text.split(',') {
        let (key, value) = part.split_once('=').ok_or(form)?;
        match key.trim() {
            "file" => file = Some(PathBuf::from(value)),
            "mass" => mass_kg = Some(parse_number(value)?),
            "com" => {
                let numbers: Vec<f64> =
                    value.split(':').map(parse_number).collect::<Result<_, _>>()?;
                let found = numbers.len();
                let com: [f64; 3] = numbers
                    .try_into()
                    .map_err(|_| format!("com takes three numbers X:Y:Z, found {found}"))?;
                com_m = Some(com);
            }
            "com_error" => com_error_m = parse_number(value)?,
            other => return Err(format!("there is no `{other}`; {form}")),
        }
    }
    let (Some(file), Some(mass_kg)) = (file, mass_kg) else { return Err(form.to_owned()) };
    Ok(PayloadArg { file, mass_kg, com_m, com_error_m })
}

fn parse_noise(text: &str) -> Result<Noise, String> {
    let (number, relative) = match text.strip_suffix('%') {
        Some(number) => (number, true),
        None => (text, false),
    };
    let level = parse_number(number)?;
    if level < 0.0 {
        return Err(format!("must not be negative, found {level}"));
    }
    Ok(if relative { Noise::Relative(level / 100.0) } else { Noise::Absolute(level) })
}

fn parse_effect(text: &str) -> Result<armident_effects::EffectOnJoint, String> {
    let form = "expected EFFECT:JOINT=P1[,P2..], for example coulomb_friction:joint_2=4.5";
    let (effect, rest) = text.split_once(':').ok_or(form)?;
    let (joint, numbers) = rest.rsplit_once('=').ok_or(form)?;
    if armident_effects::effect(effect).is_none() {
        return Err(no_effect(effect, &[]));
    }
    let on_joint = armident_effects::EffectOnJoint::new(effect, joint, parse_numbers(numbers)?);
    on_joint.resolve().map_err(|e| e.to_string())?;
    Ok(on_joint)
}
