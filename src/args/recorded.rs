//! Arguments of the commands that recordings go into.

use std::path::PathBuf;

use armident_ident::Method;
use clap::{Args, ValueEnum};

use super::arm::recordings;
use super::value::{PayloadArg, parse_payload, parse_positive};
use super::{ChainArgs, OutputArgs, PageArgs, ReadingArgs};

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
pub(crate) enum ViscousArg {
    /// growing more slowly than the speed where the recordings clearly show it
    Auto,
    /// proportional to the speed: what a URDF or MJCF can hold
    Linear,
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
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
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
    /// Viscous friction of the joints; no matter with a plan
    #[arg(long, value_name = "HOW", default_value = "auto")]
    pub(crate) viscous: ViscousArg,
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
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
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
    /// URDF, or a model written by identify or diagnose
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
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
    /// Model written by identify or diagnose, or a URDF
    pub(crate) robot: PathBuf,
    #[arg(required = true, help = recordings())]
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
