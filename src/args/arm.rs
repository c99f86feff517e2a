//! Arguments of the commands that need a model of the arm but no recording.

use std::path::PathBuf;

use armident_commands::{MotionFormat, NoiseLevel};
use armident_excitation::Part;
use armident_recording::Formats;
use clap::{Args, ValueEnum};

use super::value::{
    motion_formats, parse_amplitude, parse_effect, parse_named_number, parse_pair, parse_positive,
    parse_rate, parse_seconds, parse_sigma, parts,
};
use super::{ChainArgs, OutputArgs, ReadingArgs};

/// Names of the formats of recordings: `CSV, MCAP, Parquet`.
fn formats() -> String {
    Formats::standard().names().join(", ")
}

/// Help of the recordings of a command.
pub(super) fn recordings() -> String {
    format!("Recordings ({}) or folders of them", formats())
}

/// Help of the one recording of a command.
pub(super) fn one_recording() -> String {
    format!("Recording ({})", formats())
}

/// Extensions of the formats that are written: `.csv, .mcap, .npz`.
pub(super) fn written_extensions() -> String {
    format!(".{}", Formats::standard().written_extensions().join(", ."))
}

/// Print an arm's driving-axis frames and minimal parameter set
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident params urdf/stanford.urdf
  armident params robot.urdf --tip left_tool0 --lock torso_lift_joint=0.2
  armident params robot.urdf --gravity 0,6.94,-6.94 --json minimal.json     (mounted on a 45 deg slope)")]
pub(crate) struct ParamsArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Plan single-joint identification experiments (Algorithm 2)
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident plan urdf/stanford.urdf -o plan/
  armident plan robot.urdf -o plan/ --amplitude 0.3 --coulomb joint_2=4.5 --dither 0.004,3

Writes plan/plan.json and one trajectory CSV per experiment, within the joints' position, speed and
effort limits. Record them on the arm, put the recordings next to a copy of plan.json, and run
`armident identify robot.urdf FOLDER`.")]
pub(crate) struct PlanArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    /// Output folder for plan.json and the trajectories
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output_folder: PathBuf,
    /// Amplitude of rotational joints [rad]
    #[arg(long, default_value_t = std::f64::consts::FRAC_PI_6, value_parser = parse_amplitude)]
    pub(crate) amplitude: f64,
    /// Amplitude of translational joints [m]
    #[arg(long, default_value_t = 0.15, value_parser = parse_amplitude)]
    pub(crate) amplitude_m: f64,
    /// Bandwidth of the critically damped step [1/s]; reduced to meet joint limits
    #[arg(long, default_value_t = 10.0, value_parser = parse_sigma)]
    pub(crate) sigma: f64,
    /// Sample rate of the trajectories [Hz]
    #[arg(long, default_value_t = 200.0, value_parser = parse_rate)]
    pub(crate) rate_hz: f64,
    /// Known Coulomb level of a joint [N m or N]; repeatable
    #[arg(long, value_name = "JOINT=LEVEL", value_parser = parse_named_number)]
    pub(crate) coulomb: Vec<(String, f64)>,
    /// Dither the observed joint: amplitude [rad or m] and frequency [Hz]
    #[arg(long, value_name = "AMPLITUDE,HZ", value_parser = parse_pair)]
    pub(crate) dither: Option<(f64, f64)>,
    /// Random seed
    #[arg(long, default_value_t = 1992)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Design the motions of an identification, with the standard errors they will give
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident excite urdf/panda.urdf -o suite/
  armident excite robot.urdf -o suite/ --limits limits.toml --seconds 30 --budget 60
  armident excite robot.urdf -o suite/ --only train,validation
  armident excite robot.urdf -o suite/ --given log.csv
  armident excite robot.urdf -o suite/ --keep-out cell.toml --format csv,ros2
  armident excite robot.urdf -o suite/ --for diagnosis.json

Writes a CSV file for each motion (position, velocity and acceleration of every joint) and suite.toml,
their list in the order of recording. All motions begin and end at rest and keep to the limits of
position, speed, acceleration, jerk and effort between samples too. Boxes, cylinders and spheres of the
URDF keep 10 mm apart and out of the regions of --keep-out; meshes are not considered. Rehearsals follow the
same paths at a fifth of the speed: watch them.

limits.toml holds what differs from the URDF, in rad, m, s, N m and N:
  [elbow]
  lower = -2.0
  upper = 2.0
  velocity = 1.5
  acceleration = 5.0
  jerk = 50.0
  effort = 60.0
  noise = 0.1        (standard deviation of one recorded effort)

cell.toml holds boxes and planes in m, in the axes of the base link:
  [table]
  centre = [0.5, 0.0, -0.05]
  size = [1.0, 1.0, 0.1]
  rpy = [0.0, 0.0, 0.0]     (optional, rad)
  [wall]
  point = [0.0, -0.6, 0.0]
  normal = [0.0, 1.0, 0.0]  (to the side where the arm moves)")]
pub(crate) struct ExciteArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    /// Output folder for suite.toml and the motions
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output_folder: PathBuf,
    /// Limits of joints that differ from those of the URDF (TOML)
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// Boxes and planes that the arm keeps out of (TOML)
    #[arg(long, value_name = "FILE")]
    pub(crate) keep_out: Option<PathBuf>,
    /// Diagnosis (JSON): a motion that separates its findings from their alternatives
    #[arg(long = "for", value_name = "DIAGNOSIS.json")]
    pub(crate) diagnosis: Option<PathBuf>,
    /// Formats of the motions
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', default_value = "csv", value_parser = motion_formats())]
    pub(crate) format: Vec<MotionFormat>,
    /// Recordings that exist already: the training motion adds most to these
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub(crate) given: Vec<PathBuf>,
    /// Length of the training motion [s]
    #[arg(long, default_value_t = 20.0, value_parser = parse_positive)]
    pub(crate) seconds: f64,
    /// Time for the search [s]
    #[arg(long, value_name = "SECONDS", default_value_t = 30.0, value_parser = parse_seconds)]
    pub(crate) budget: f64,
    /// Sample rate of the motions [Hz]
    #[arg(long, default_value_t = 100.0, value_parser = parse_rate)]
    pub(crate) rate_hz: f64,
    /// Design these parts alone
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = parts())]
    pub(crate) only: Vec<Part>,
    /// Random seed
    #[arg(long, default_value_t = 1992)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Direction {
    /// motion to efforts
    Inverse,
    /// efforts to motion
    Forward,
}

/// Simulate recordings from planned experiments or given trajectories
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident simulate urdf/stanford.urdf plan/ -o runs/
  armident simulate robot.urdf motion.csv -o run.csv --torque-noise 0.1 --encoder-bits 19 --seed 7
  armident simulate robot.urdf motion.csv -o run.csv --effect coulomb_friction:joint_2=4.5
  armident simulate robot.urdf efforts.csv -o run.csv --direction forward

Without --encoder-bits the exact accelerations are also written, and identify uses them.")]
pub(crate) struct SimulateArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = format!("Folder of a plan, or trajectory files ({})", formats()))]
    pub(crate) trajectories: Vec<PathBuf>,
    #[arg(short, long, value_name = "PATH", help = format!(
        "Output folder, or output file for one trajectory ({})", written_extensions()
    ))]
    pub(crate) output_path: PathBuf,
    /// Direction
    #[arg(long, value_enum, default_value_t = Direction::Inverse)]
    pub(crate) direction: Direction,
    /// Standard deviation of white effort noise [N m or N], or with % relative to each joint's effort
    #[arg(long, value_name = "SIGMA", allow_negative_numbers = true)]
    pub(crate) torque_noise: Option<NoiseLevel>,
    /// Quantise positions to this many bits per turn (or metre)
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(4..=40))]
    pub(crate) encoder_bits: Option<u32>,
    /// Resample to this rate first [Hz]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) rate_hz: Option<f64>,
    /// Add an effect to a joint; repeatable
    #[arg(long, value_name = "EFFECT:JOINT=P1[,P2..]", value_parser = parse_effect)]
    pub(crate) effect: Vec<armident_effects::EffectOnJoint>,
    /// Random seed of the noise
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Predict joint efforts for a motion, or the motion for commands
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident predict model.json motion.csv -o predicted.csv
  armident predict urdf/ur10.urdf motion.csv -o - --cutoff-hz 8
  armident predict model.json commands.csv -o predicted.csv --closed-loop

In closed loop the position controllers of the model follow <joint>/command, from the first
<joint>/position where there is one.")]
pub(crate) struct PredictArgs {
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(help = format!("Motion ({}) with the joint positions", formats()))]
    pub(crate) motion: PathBuf,
    #[arg(short, long, value_name = "FILE", help = format!(
        "Output file with columns t and JOINT/effort, or JOINT/position in closed loop ({}); - for CSV on stdout", written_extensions()
    ))]
    pub(crate) output_file: PathBuf,
    /// Low-pass cut-off frequency [Hz] [default: the model's, else from the motion's spectrum]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub(crate) cutoff_hz: Option<f64>,
    /// Predict positions from commands with the position controllers of the model
    #[arg(long, conflicts_with = "cutoff_hz")]
    pub(crate) closed_loop: bool,
    /// Gain of the controllers over that of the model
    #[arg(long, value_name = "RATIO", default_value = "1", value_parser = parse_positive, requires = "closed_loop")]
    pub(crate) servo_gain: f64,
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
    /// MuJoCo format: also armature, gravity and motors
    Mjcf,
    /// SDFormat for Drake: also rotor inertia
    DrakeSdf,
    /// actuators of Isaac Lab, as Python source
    #[value(name = "isaaclab")]
    IsaacLab,
    /// USD overlay: masses, rotor inertia and friction
    Usd,
    /// C99 source and header for a controller
    C,
}

/// Export a model to a simulator (URDF, MJCF, SDFormat, USD, Isaac Lab) or a controller (C)
#[derive(Args)]
#[command(after_help = "\
Examples:
  armident export model.json -o robot.urdf
  armident export model.json -o robot.xml           (MJCF, for MuJoCo)
  armident export model.json -o robot.sdf           (Drake)
  armident export model.json -o robot.usda          (overlay of the robot's USD)
  armident export model.json -o actuators.py        (Isaac Lab)
  armident export model.json -o robot.c             (C99, with its header beside it)
  armident export model.json -o robot.c --false-alarms-per-hour 1 --without-contact day1.csv --holdout day2.csv
  armident export urdf/panda.urdf -o - --format mjcf

URDF, MJCF and SDFormat hold the chain with its links, limits and the joint effects that the format
supports; shapes and meshes are omitted. USD is an overlay of the robot's own USD: masses, rotor inertia
and friction. C holds inverse dynamics, gravity and friction feed-forward, the inertia
matrix and a momentum observer, without allocation and without a library but libm. Unsupported effects
are listed.")]
pub(crate) struct ExportArgs {
    /// Model written by identify or diagnose, or a URDF
    pub(crate) robot: PathBuf,
    /// Output file (.urdf, .xml for MJCF, .sdf, .usda, .py for Isaac Lab, or .c); - for stdout
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output_file: PathBuf,
    /// Output format [default: from the extension]
    #[arg(long, visible_alias = "to", value_enum)]
    pub(crate) format: Option<FormatArg>,
    /// Thresholds of the momentum observer for this rate of false alarms of the whole arm (C)
    #[arg(long, value_name = "RATE", value_parser = parse_positive, requires = "without_contact")]
    pub(crate) false_alarms_per_hour: Option<f64>,
    /// Recordings of ordinary motion without contact, for the thresholds
    #[arg(long, value_name = "FILE", num_args = 1.., requires = "false_alarms_per_hour")]
    pub(crate) without_contact: Vec<PathBuf>,
    /// Other recordings without contact, on which the thresholds are tried
    #[arg(long, value_name = "FILE", num_args = 1.., requires = "false_alarms_per_hour")]
    pub(crate) holdout: Vec<PathBuf>,
    /// Gain of the observer [1/s] [default: 30, at most a tenth of the rate of the recordings]
    #[arg(long, value_name = "GAIN", value_parser = parse_positive, requires = "false_alarms_per_hour")]
    pub(crate) observer_gain: Option<f64>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) chain: ChainArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}
