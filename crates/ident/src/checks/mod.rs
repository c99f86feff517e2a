//! Input checks: are the columns of a recording what their headers state, and are they good enough for a fit?
//!
//! | check | how |
//! | --- | --- |
//! | rate | cut-off that the motion requires against the highest that the rate allows |
//! | noise | spectrum above a quarter of the rate, through the low-pass and two derivatives |
//! | channel | likelihood of the joint's effort, its negative, a multiple, the effort without gravity; the effort limit |
//! | order | the same for every column on every joint, best assignment; efforts that fit no joint |
//! | geometry | likelihood over the distance of two axes, all inertial constants free |
//! | delay | likelihood over shifts of the effort, and over time constants of a low-pass |
//! | excitation | standard errors of the constants from the recordings alone |
//!
//! Verdicts follow from posterior probabilities or standard errors, using the effective sample size of the residual: at
//! most what the low-pass passes, and at most that of the motion where the residual is not noise. A joint whose efforts
//! are dominated by friction and noise is inconclusive ([`Verdict::Inconclusive`]). How well the URDF fits decides nothing:
//! its parameters may be wrong by their size, and the arm may carry an unknown load.

mod arm_columns;
mod arm_likelihood;
mod assignment;
mod channel;
mod columns;
mod computed;
mod delay;
mod effort_clock;
mod effort_low_pass;
mod excitation;
mod explanations;
mod gravity;
mod lag;
mod likelihood;
mod likelihood_top;
mod link_errors;
mod link_length;
mod messages;
mod rows;
mod timing;
mod verdict;

use std::collections::BTreeMap;

use armident_dynamics::RigidArm;
use armident_model::ArmModel;
pub use armident_motion::QualityReport;
use armident_motion::{Motion, RESTING_RANGE, quality};
use armident_numeric::NumericError;
use armident_recording::{QualityIssue, Quantity, Recording};

pub use channel::{ChannelEvidence, ChannelKind};
pub use delay::Delay;
pub use effort_clock::EffortClock;
pub use effort_low_pass::{EffortLowPass, LowPassOrDelay};
pub use excitation::ConstantCheck;
pub use gravity::GravityDirectionFound;
pub use link_length::{FrameLength, LinkLength};
pub use verdict::{Check, Topic, Verdict};

use arm_likelihood::JointFacts;
use columns::Alone;
use computed::BesideRigid;
use timing::{EffortTiming, Efforts};

use crate::calibration::dead_zone_shares;
use crate::minimal_set::MinimalSet;
use crate::regression::BatchProblem;

/// Everything that was checked.
#[derive(Debug, Clone)]
pub struct RecordingCheck {
    /// Checks, robot-wide ones first, then joint by joint.
    pub checks: Vec<Check>,
    /// Evidence about each joint's effort column, in the order of the chain.
    pub channels: Vec<ChannelEvidence>,
    /// Per joint, the joint whose column most likely holds its effort.
    pub order: Vec<usize>,
    /// Where gravity points; none where nothing shows that it is not as given.
    pub gravity: Option<GravityDirectionFound>,
    /// Per joint, the joint of the recordings that it is, with position and effort.
    pub recorded_as: Vec<usize>,
    /// Per joint, whether its position and effort count the other way.
    pub mirrored: Vec<bool>,
    /// The delay; none where the likelihood has no maximum.
    pub delay: Option<Delay>,
    /// The low-pass through which the efforts are reported; none where there is none that explains more than a delay.
    pub effort_low_pass: Option<EffortLowPass>,
    /// The clock of the efforts; none where it is that of the positions.
    pub effort_clock: Option<EffortClock>,
    /// A low-pass that explains the delay as well; none where the recordings separate them.
    pub low_pass_or_delay: Option<LowPassOrDelay>,
    /// A distance between two axes that is not the given one; none where the recordings contradict none.
    pub link_length: Option<LinkLength>,
    /// How well each constant is determined.
    pub constants: Vec<ConstantCheck>,
    /// Rank of the recordings alone, of so many parameters.
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

/// What the samples of recordings show without a model, as checks.
pub(crate) fn quality_checks(
    reports: &[QualityReport],
    differences: &[QualityIssue],
) -> Vec<Check> {
    messages::quality(reports, differences, &[])
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

/// The problem of an arm with the speeds at which friction reverses on these motions.
fn problem_of(arm: &RigidArm, motions: &[Motion]) -> Result<BatchProblem, NumericError> {
    let set = MinimalSet::of(arm)?;
    let mut problem = BatchProblem::new(arm, &set);
    problem.choose_reversal_speeds(&motions.iter().collect::<Vec<_>>())?;
    Ok(problem)
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
    let names = model.chain.joint_names();
    let own: Vec<Recording> = recordings.iter().map(|r| of_joints(r, &names)).collect();
    let quality: Vec<QualityReport> = own.iter().map(quality).collect();
    let shares = dead_zone_shares(recordings, &names);
    let alone = columns::alone(recordings, motions, &names);
    let is_mute: Vec<bool> =
        alone.iter().zip(&shares).map(|(a, s)| a.is_mute() || s.is_some()).collect();
    let mut noise = rows::noise_in_band(&names, motions, &quality);
    let mut arm = model.rigid_arm();
    let recorded = motions;
    let with_stand_ins: Vec<Motion> =
        motions.iter().map(|m| columns::with_stand_ins(m, &alone)).collect();
    let motions = with_stand_ins.as_slice();
    let problem = problem_of(&arm, motions)?;
    let facts = JointFacts {
        noise: noise.clone(),
        is_signal: names.iter().map(|name| signals.contains_key(*name)).collect(),
        is_mute: is_mute.clone(),
    };
    // what explains all columns comes before anything is reported of one
    let explained = explanations::explain(model, motions, &problem, &facts)?;
    let map = &explained.map;
    let mapped: Vec<Motion> = motions.iter().map(|m| map.motion(m)).collect();
    let motions = mapped.as_slice();
    arm.gravity_e0 = explained.gravity_e0;
    noise = map.source.iter().map(|&s| noise[s]).collect();
    let mut problem = problem_of(&arm, motions)?;
    let rows = rows::accumulate(&problem, &arm, motions, &noise)?;
    let is_silent: Vec<bool> = map.source.iter().map(|&s| is_mute[s]).collect();
    // a voltage is ahead of its effort by the back-EMF, and no measurement that a drive filters
    let is_filtered = !signals.values().any(|quantity| *quantity == Quantity::Voltage);
    let link_length = link_length::link_length(
        &problem,
        (motions, noise.as_slice()),
        (recordings, map),
        &rows,
        &is_silent,
    )?;
    let efforts = Efforts {
        motions,
        recordings,
        map,
        quality: &quality,
        names: &names,
        noise: &noise,
        is_silent: &is_silent,
        may_be_filtered: is_filtered,
    };
    let timing = EffortTiming::of(efforts, &mut problem, rows)?;
    let rows = timing.rows.as_slice();
    let motions = timing.motions.as_slice();
    let moves = |j: usize| excitation::activity(motions, j).range >= RESTING_RANGE;
    let with_dead_zone: Vec<&str> =
        names.iter().zip(&shares).filter(|(_, share)| share.is_some()).map(|(n, _)| *n).collect();
    let alive: Vec<bool> = (0..names.len()).map(|j| !is_silent[j] && moves(j)).collect();
    let mut channels = channel::channels(&problem, rows, &alive)?;
    let is_needed =
        channels.is_reordered() && map.is_as_labelled() && explained.direction.is_none();
    let confirmed = is_needed
        && explanations::order_explains(model, motions, &problem, &facts, &channels.order)?;
    channels.agree_with(&explained, confirmed);
    let is_constant: Vec<bool> =
        map.source.iter().map(|&s| matches!(alone[s], Alone::Constant(_))).collect();
    let (constants, rank) =
        excitation::excitation(&problem, &names, rows, &timing.aligned, &is_constant)?;
    let differences = armident_motion::differences(&own);
    let beside: Vec<BesideRigid> = (0..names.len())
        .filter(|&j| alive[j])
        .map(|j| {
            let name = names[map.source[j]];
            let noise = rows::recorded_noise(&quality, name, Quantity::Effort);
            BesideRigid::of(&problem, j, &rows[j], noise.unwrap_or(0.0))
        })
        .collect();

    let is_effort: Vec<bool> = names.iter().map(|name| !signals.contains_key(*name)).collect();
    let mut checks = messages::quality(&quality, &differences, &with_dead_zone);
    checks.extend(messages::rate(&quality, motions));
    checks.extend(messages::gravity(&explained));
    checks.extend(link_length.as_ref().map(|found| messages::link_length(found, &names)));
    checks.push(match &timing.low_pass {
        Some(found) => messages::low_pass(found),
        None => messages::delay(timing.delay.as_ref(), timing.look_alike, motions),
    });
    checks.extend(timing.clock.as_ref().map(|clock| messages::effort_clock(clock, motions)));
    checks.push(match map.joints_are_as_labelled() || map.source.is_sorted() {
        true => messages::order(&channels, &names),
        false => messages::exchanged(&explained, &names),
    });
    checks.extend(messages::computed(&beside));
    // a magnitude or a constant matches no rigid-body effort, whatever its motion
    let is_judged: Vec<bool> =
        (0..names.len()).map(|j| is_effort[j] && alone[j] == Alone::Sound).collect();
    checks.extend(messages::other_motion(&channels, &is_judged));
    checks.push(messages::excitation(&constants, rank, problem.terms.len()));
    for (j, name) in names.iter().enumerate() {
        let source = map.source[j];
        let (signal, has_dead_zone) =
            (signals.get(names[source]).copied(), shares[source].is_some());
        let joint = &model.chain.joints[j];
        checks.extend(messages::joint_sign(&explained, j, &names));
        checks.push(match alone[j] {
            Alone::Sound => {
                let column = messages::Column { signal, has_dead_zone, kind: joint.kind };
                messages::channel(&channels, j, &names, column, &explained)
            }
            Alone::Constant(value) => messages::constant(name, value, moves(j), joint.kind),
            Alone::Magnitude { side, returns } => {
                let all = !alone.contains(&Alone::Sound);
                messages::magnitude(name, side, returns, all)
            }
        });
        if is_effort[j] {
            checks.extend(messages::beyond_limit(recorded, j, model));
        }
        checks.extend(messages::noise(&quality, recorded, j, joint));
        checks.extend(messages::motion(motions, j, name));
    }
    Ok(RecordingCheck {
        checks,
        channels: channels.evidence,
        order: channels.order,
        gravity: explained.direction.clone(),
        recorded_as: map.source.clone(),
        mirrored: map.sign.iter().map(|sign| *sign < 0.0).collect(),
        delay: timing.delay,
        effort_low_pass: timing.low_pass,
        effort_clock: timing.clock,
        low_pass_or_delay: timing.low_pass_or_delay,
        link_length,
        constants,
        rank: (rank, problem.terms.len()),
        quality,
        differences,
    })
}
