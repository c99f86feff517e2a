//! Is a recording fit for purpose, and does its bookkeeping agree with the robot?
//!
//! | check | how |
//! | --- | --- |
//! | rate | cut-off that the motion asks for against the highest the rate allows |
//! | noise | spectrum above a quarter of the rate, brought through the low-pass and two derivatives |
//! | channel | likelihood of the joint's effort, its negative, a multiple, the effort less gravity; the limit of the drive |
//! | order | the same for every column on every joint, best assignment; efforts that fit no joint |
//! | delay | likelihood over shifts of the effort |
//! | excitation | standard errors of the constants from the recordings alone |
//!
//! Every verdict comes from a probability or a standard error, counting independent samples: of what is left
//! over, no more than the low-pass lets through, and no more than the motion has where it is not noise. A joint
//! whose efforts say little (friction and noise above the rigid body's) gets [`Verdict::CannotTell`].
//! Nothing is decided by how well the URDF fits: its numbers may be off by their size, and the arm may
//! carry a load it does not know.

mod channel;
mod delay;
mod excitation;
mod likelihood;
mod rows;
mod say;

use std::collections::BTreeMap;

pub use armident_motion::QualityReport;
use armident_motion::{Motion, RESTING_RANGE, quality};
use armident_numeric::NumericError;
use armident_recording::{Finding, Quantity, Recording};
use serde::Serialize;

pub use channel::{ChannelEvidence, ChannelKind};
pub use delay::Delay;
pub use excitation::ConstantCheck;

use crate::batch::BatchProblem;
use crate::minimal_set::MinimalSet;
use crate::unreported::unreported;
use armident_model::ArmModel;

/// Times the efforts are shifted before they are believed to be in their place.
const ALIGNMENTS: usize = 2;

/// Outcome of one check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing against it, and the recordings would show it.
    Ok,
    /// The recordings would not show it.
    CannotTell,
    /// More likely wrong than not, or of little use.
    Doubtful,
    /// Wrong beyond a thousand to one.
    Wrong,
}

/// A fault less likely than this is none, one more likely than its complement is one.
const SURE: f64 = 1e-3;

impl Verdict {
    /// On something that is right with this probability.
    fn of_probability(p: f64) -> Self {
        match p {
            p if p >= channel::TOLD => Self::Ok,
            p if p >= 0.5 => Self::CannotTell,
            p if p > SURE => Self::Doubtful,
            _ => Self::Wrong,
        }
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::CannotTell => "cannot tell",
            Self::Doubtful => "doubtful",
            Self::Wrong => "wrong",
        }
    }
}

/// What was checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Topic {
    /// Sample rate against the bandwidth of the motion.
    Rate,
    /// Noise of a channel.
    Noise,
    /// Which effort channel a column is.
    Channel,
    /// Which joint each effort column belongs to.
    Order,
    /// Delay between effort and motion.
    Delay,
    /// Whether the motion determines the constants.
    Excitation,
    /// What the samples show without a model.
    Quality,
}

impl Topic {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Noise => "noise",
            Self::Channel => "effort channel",
            Self::Order => "joint order",
            Self::Delay => "delay",
            Self::Excitation => "excitation",
            Self::Quality => "quality",
        }
    }
}

/// One check with its verdict.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What was checked.
    pub topic: Topic,
    /// The joint; none for the robot as a whole.
    pub joint: Option<String>,
    /// The verdict.
    pub verdict: Verdict,
    /// The number it rests on.
    pub value: Option<f64>,
    /// Unit of the number.
    pub unit: &'static str,
    /// 95 % interval of the number.
    pub interval_95: Option<[f64; 2]>,
    /// One sentence.
    pub message: String,
    /// What to do.
    pub advice: Option<String>,
}

/// Everything that was checked.
#[derive(Debug, Clone)]
pub struct RecordingCheck {
    /// Checks, robot-wide ones first, then joint by joint.
    pub checks: Vec<Check>,
    /// What the samples say about each joint's effort column, in the order of the chain.
    pub channels: Vec<ChannelEvidence>,
    /// Per joint, the joint whose column most likely holds its effort.
    pub order: Vec<usize>,
    /// The delay; none where none stands out.
    pub delay: Option<Delay>,
    /// How well each constant is determined.
    pub constants: Vec<ConstantCheck>,
    /// Rank of the recordings alone, of so many unknowns.
    pub rank: (usize, usize),
    /// Timing, noise and steps of each recording.
    pub quality: Vec<QualityReport>,
    /// What is doubtful between recordings.
    pub differences: Vec<Finding>,
}

impl RecordingCheck {
    /// The worst verdict.
    pub fn verdict(&self) -> Verdict {
        self.checks.iter().map(|c| c.verdict).max().unwrap_or(Verdict::Ok)
    }
}

/// The recordings with currents, or else voltages, in the place of efforts that are not there, and which
/// joints that concerns. Columns of one joint keep their name and unit for the checks.
pub fn with_drive_signals(
    recordings: &[Recording],
) -> (Vec<Recording>, BTreeMap<String, Quantity>) {
    let mut filled = recordings.to_vec();
    let mut signals = BTreeMap::new();
    for joint in filled.iter_mut().flat_map(|recording| &mut recording.joints) {
        if joint.effort.is_some() {
            continue;
        }
        for quantity in [Quantity::Current, Quantity::Voltage] {
            if let Some(values) = joint.channel(quantity) {
                joint.effort = Some(values.to_vec());
                signals.insert(joint.name.clone(), quantity);
                break;
            }
        }
    }
    (filled, signals)
}

/// A recording without joints that are not the arm's: how fast a gripper moves says nothing of the arm.
fn of_joints(recording: &Recording, names: &[&str]) -> Recording {
    let is_own = |joint: &str| names.contains(&joint);
    let mut own = recording.clone();
    own.joints.retain(|joint| is_own(&joint.name));
    own.findings.retain(|finding| finding.joint.as_deref().is_none_or(is_own));
    own
}

/// Checks recordings against a robot.
///
/// `motions` are those of `recordings`, of all joints of the model and with efforts; `signals` names
/// the joints whose "effort" is a current or voltage ([`with_drive_signals`]).
///
/// # Errors
/// [`NumericError`] when a number is not finite.
pub fn check(
    model: &ArmModel,
    recordings: &[Recording],
    motions: &[Motion],
    signals: &BTreeMap<String, Quantity>,
) -> Result<RecordingCheck, NumericError> {
    let arm = model.rigid_arm();
    let set = MinimalSet::of(&arm)?;
    let mut problem = BatchProblem::new(&arm, &set);
    problem.choose_turning_speeds(&motions.iter().collect::<Vec<_>>())?;
    let names = model.chain.joint_names();
    let own: Vec<Recording> = recordings.iter().map(|r| of_joints(r, &names)).collect();
    let quality: Vec<QualityReport> = own.iter().map(quality).collect();
    let noise = rows::noise_in_band(&names, motions, &quality);
    let mut rows = rows::accumulate(&problem, &arm, motions, &noise)?;
    let mut delay = delay::delay(&rows);
    // friction bends where the delay puts its reversals: once more with the efforts in their place
    let mut aligned = motions.to_vec();
    for _ in 0..ALIGNMENTS {
        let Some(so_far) = delay.clone().filter(Delay::excludes_zero) else { break };
        aligned = motions.iter().map(|m| rows::with_effort_from(m, so_far.delay_s)).collect();
        problem.choose_turning_speeds(&aligned.iter().collect::<Vec<_>>())?;
        rows = rows::accumulate(&problem, &arm, &aligned, &noise)?;
        let Some(rest) = delay::delay(&rows) else { break };
        delay = Some(so_far.and_then(&rest));
    }
    let moves = |j: usize| excitation::activity(motions, j).range >= RESTING_RANGE;
    let shares = unreported(recordings, &names);
    let unreported: Vec<&str> =
        names.iter().zip(&shares).filter(|(_, share)| share.is_some()).map(|(n, _)| *n).collect();
    let alive: Vec<bool> = (0..names.len()).map(|j| shares[j].is_none() && moves(j)).collect();
    let channels = channel::channels(&problem, &rows, &alive)?;
    let (constants, rank) = excitation::excitation(&problem, &names, &rows, &aligned)?;
    let differences = armident_motion::differences(&own);

    let is_effort: Vec<bool> = names.iter().map(|name| !signals.contains_key(*name)).collect();
    let mut checks = say::quality(&quality, &differences, &unreported);
    checks.extend(say::rate(&quality, motions));
    checks.push(say::delay(delay.as_ref(), motions));
    checks.push(say::order(&channels, &names));
    checks.extend(say::other_motion(&channels, &is_effort));
    checks.push(say::excitation(&constants, rank, problem.terms.len()));
    for (j, name) in names.iter().enumerate() {
        let (signal, is_unreported) = (signals.get(*name).copied(), shares[j].is_some());
        checks.push(say::channel(&channels, j, &names, signal, is_unreported));
        if is_effort[j] {
            checks.extend(say::beyond_limit(motions, j, model));
        }
        checks.extend(say::noise(&quality, motions, j, name));
        checks.extend(say::motion(motions, j, name));
    }
    Ok(RecordingCheck {
        checks,
        channels: channels.evidence,
        order: channels.order,
        delay,
        constants,
        rank: (rank, problem.terms.len()),
        quality,
        differences,
    })
}
