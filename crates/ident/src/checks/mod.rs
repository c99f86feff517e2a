//! Input checks: are the columns of a recording what their headers say, and are they good enough for a fit?
//!
//! | check | how |
//! | --- | --- |
//! | rate | cut-off that the motion requires against the highest that the rate allows |
//! | noise | spectrum above a quarter of the rate, through the low-pass and two derivatives |
//! | channel | likelihood of the joint's effort, its negative, a multiple, the effort without gravity; the effort limit |
//! | order | the same for every column on every joint, best assignment; efforts that fit no joint |
//! | delay | likelihood over shifts of the effort |
//! | excitation | standard errors of the constants from the recordings alone |
//!
//! Verdicts follow from posterior probabilities or standard errors, using the effective sample size of the residual: at
//! most what the low-pass passes, and at most that of the motion where the residual is not noise. A joint whose efforts
//! are dominated by friction and noise is inconclusive ([`Verdict::CannotTell`]). How well the URDF fits decides nothing:
//! its parameters may be wrong by their size, and the arm may carry an unknown load.

mod assignment;
mod channel;
mod delay;
mod excitation;
mod likelihood;
mod messages;
mod rows;
mod verdict;

use std::collections::BTreeMap;

use armident_model::ArmModel;
pub use armident_motion::QualityReport;
use armident_motion::{Motion, RESTING_RANGE, quality};
use armident_numeric::NumericError;
use armident_recording::{QualityIssue, Quantity, Recording};

pub use channel::{ChannelEvidence, ChannelKind};
pub use delay::Delay;
pub use excitation::ConstantCheck;
pub use verdict::{Check, Topic, Verdict};

use crate::calibration::dead_zone_shares;
use crate::minimal_set::MinimalSet;
use crate::regression::BatchProblem;

/// Times the efforts are shifted by the remaining delay.
const ALIGNMENTS: usize = 2;

/// Everything that was checked.
#[derive(Debug, Clone)]
pub struct RecordingCheck {
    /// Checks, robot-wide ones first, then joint by joint.
    pub checks: Vec<Check>,
    /// Evidence about each joint's effort column, in the order of the chain.
    pub channels: Vec<ChannelEvidence>,
    /// Per joint, the joint whose column most likely holds its effort.
    pub order: Vec<usize>,
    /// The delay; none where the likelihood has no maximum.
    pub delay: Option<Delay>,
    /// How well each constant is determined.
    pub constants: Vec<ConstantCheck>,
    /// Rank of the recordings alone, of so many unknowns.
    pub rank: (usize, usize),
    /// Timing, noise and steps of each recording.
    pub quality: Vec<QualityReport>,
    /// What is doubtful between recordings.
    pub differences: Vec<QualityIssue>,
}

impl RecordingCheck {
    /// The worst verdict.
    pub fn verdict(&self) -> Verdict {
        self.checks.iter().map(|c| c.verdict).max().unwrap_or(Verdict::Ok)
    }
}

/// The recordings with currents, or else voltages, instead of missing efforts, and which joints that
/// concerns. Columns of one joint keep their name and unit for the checks.
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

/// A recording without joints that are not the arm's: the speed of a gripper is no information about the arm.
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
    problem.choose_reversal_speeds(&motions.iter().collect::<Vec<_>>())?;
    let names = model.chain.joint_names();
    let own: Vec<Recording> = recordings.iter().map(|r| of_joints(r, &names)).collect();
    let quality: Vec<QualityReport> = own.iter().map(quality).collect();
    let noise = rows::noise_in_band(&names, motions, &quality);
    let mut rows = rows::accumulate(&problem, &arm, motions, &noise)?;
    let mut delay = delay::delay(&rows);
    // a delay distorts friction at its reversals: once more with the efforts shifted back
    let mut aligned = motions.to_vec();
    for _ in 0..ALIGNMENTS {
        let Some(so_far) = delay.clone().filter(Delay::excludes_zero) else { break };
        aligned = motions.iter().map(|m| rows::with_effort_from(m, so_far.delay_s)).collect();
        problem.choose_reversal_speeds(&aligned.iter().collect::<Vec<_>>())?;
        rows = rows::accumulate(&problem, &arm, &aligned, &noise)?;
        let Some(rest) = delay::delay(&rows) else { break };
        delay = Some(so_far.and_then(&rest));
    }
    let moves = |j: usize| excitation::activity(motions, j).range >= RESTING_RANGE;
    let shares = dead_zone_shares(recordings, &names);
    let with_dead_zone: Vec<&str> =
        names.iter().zip(&shares).filter(|(_, share)| share.is_some()).map(|(n, _)| *n).collect();
    let alive: Vec<bool> = (0..names.len()).map(|j| shares[j].is_none() && moves(j)).collect();
    let channels = channel::channels(&problem, &rows, &alive)?;
    let (constants, rank) = excitation::excitation(&problem, &names, &rows, &aligned)?;
    let differences = armident_motion::differences(&own);

    let is_effort: Vec<bool> = names.iter().map(|name| !signals.contains_key(*name)).collect();
    let mut checks = messages::quality(&quality, &differences, &with_dead_zone);
    checks.extend(messages::rate(&quality, motions));
    checks.push(messages::delay(delay.as_ref(), motions));
    checks.push(messages::order(&channels, &names));
    checks.extend(messages::other_motion(&channels, &is_effort));
    checks.push(messages::excitation(&constants, rank, problem.terms.len()));
    for (j, name) in names.iter().enumerate() {
        let (signal, has_dead_zone) = (signals.get(*name).copied(), shares[j].is_some());
        let joint = &model.chain.joints[j];
        checks.push(messages::channel(&channels, j, &names, signal, has_dead_zone, joint.kind));
        if is_effort[j] {
            checks.extend(messages::beyond_limit(motions, j, model));
        }
        checks.extend(messages::noise(&quality, motions, j, joint));
        checks.extend(messages::motion(motions, j, name));
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
