//! How good a recording is: timing, noise, steps, bandwidth, and everything doubtful.

use rayon::prelude::*;
use serde::Serialize;

use crate::cutoff::{band_edge_hz, noise_sigma};
use crate::duplicate_frames::RepeatedFrames;
use crate::grid::EvenGrid;
use crate::held_efforts::HeldEfforts;
use crate::sampling_clock::SamplingClock;
use crate::stuck::{quantisation_step, saturated, stuck};
use armident_recording::{
    Action, JointChannels, QualityIssue, QualityIssueKind, Quantity, Recording, Span, Timing,
    percent, velocity_findings,
};

/// Positions beyond this are four turns; arms rarely do that, degrees always \[rad\].
const FAR_POSITION: f64 = 25.0;
/// Jitter that is reported, as a share of the step.
const SMALLEST_JITTER: f64 = 1e-3;
/// Rates of two recordings are the same within this share.
const SAME_RATE: f64 = 0.01;

/// What can be measured of a recording without a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QualityReport {
    /// Where the recording comes from.
    pub source: String,
    /// Number of samples.
    pub samples: usize,
    /// Rate, jitter and gaps of the stamps.
    pub timing: Timing,
    /// Each channel, in the order of the recording.
    pub channels: Vec<ChannelQuality>,
    /// What reading repaired, then everything else that is doubtful.
    pub findings: Vec<QualityIssue>,
}

/// What can be measured of one channel, in its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelQuality {
    /// The joint.
    pub joint: String,
    /// What is recorded.
    pub quantity: Quantity,
    /// Smallest value.
    pub smallest: f64,
    /// Largest value.
    pub largest: f64,
    /// Standard deviation of the white noise, from the spectrum above a quarter of the sample rate;
    /// of quantised values the step over √12 at least, once they move by several steps per sample.
    pub noise: Option<f64>,
    /// Step in which the values are quantised; none if none can be seen.
    pub step: Option<f64>,
    /// Of a position: frequency below which its motion lies \[Hz\], see [`band_edge_hz`].
    pub band_edge_hz: Option<f64>,
    /// Share of the samples in flat tops at the largest or smallest value.
    pub saturated_share: f64,
    /// Share of the samples that repeat a value although the joint moves.
    pub stuck_share: f64,
}

/// Measures a recording and lists what is doubtful in it.
///
/// The findings of reading come first. Thresholds, and why:
///
/// | finding | from | because |
/// |---|---|---|
/// | late stamps | neighbouring samples predict each other 20 % better on a regular clock | jittered sampling instants are better than any regular clock |
/// | held efforts | 1.5 rows per renewal, 90 % of the renewals after the usual number of rows | coarse efforts repeat unevenly |
/// | uneven stamps | 0.1 % of the step beyond the rounding of the stamps | below it resampling changes nothing |
/// | repeated frames | all channels of all joints equal the frame before, a joint moves steadily before and after | coarse encoders and rest repeat some channels |
/// | gap | 2.5 median steps | one lost sample with jitter is less |
/// | stuck | 20 samples and 0.1 s, the joint moves 20 steps of its encoder | shorter repetitions are rounding |
/// | saturated | 3 flat tops of 5 samples, or one of 10, one of them entered with 4 steps | a smooth peak of 5 samples is entered with 3 at most |
/// | velocity scale, sign | correlation 0.95, off by 8 % | sensors are calibrated better |
/// | velocity unrelated | correlation below 0.5 | noisy velocities of slow joints reach 0.6 |
/// | velocity delay | one sample | a sample is how well stamps are known |
/// | suspected unit | beyond 25 rad (four turns) | arms rarely do that, degrees always |
pub fn quality(recording: &Recording) -> QualityReport {
    // a recording that is mostly gaps has no grid, so no spectrum
    let grid = EvenGrid::of(recording).ok();
    let clock = grid.as_ref().and_then(EvenGrid::sampling_clock);
    let timing = timing_of(recording, clock);
    let findings = findings_at(recording, &timing, clock);
    let all: Vec<(&JointChannels, Quantity, &[f64])> = recording
        .joints
        .iter()
        .flat_map(|joint| joint.channels().map(move |(quantity, values)| (joint, quantity, values)))
        .collect();
    let channels = all
        .into_par_iter()
        .map(|(joint, quantity, values)| {
            of_channel(joint, quantity, values, grid.as_ref(), &findings)
        })
        .collect();
    let (source, samples) = (recording.source.clone(), recording.len());
    QualityReport { source, samples, timing, channels, findings }
}

/// What [`quality`] finds doubtful, without the measures of the channels: a fraction of its time.
pub fn findings(recording: &Recording) -> Vec<QualityIssue> {
    let clock = SamplingClock::of(recording);
    findings_at(recording, &timing_of(recording, clock.as_ref()), clock.as_ref())
}

/// That of the samples.
fn timing_of(recording: &Recording, clock: Option<&SamplingClock>) -> Timing {
    Timing::of(clock.map_or(&recording.time_s, |clock| &clock.instants_s))
}

/// Share of the samples in which the effort of each joint repeats a value although the joint moves; 0 of joints
/// that are not recorded.
pub fn stuck_effort_shares(recording: &Recording, joints: &[&str]) -> Vec<f64> {
    let timing = Timing::of(&recording.time_s);
    let of_joint = |name: &&str| {
        let joint = recording.joints.iter().find(|joint| joint.name == **name);
        let found = joint.map(|joint| stuck(&recording.time_s, &timing, joint)).unwrap_or_default();
        let effort = found.iter().find(|finding| finding.quantity == Some(Quantity::Effort));
        effort.map_or(0.0, |finding| finding.share)
    };
    joints.par_iter().map(of_joint).collect()
}

fn findings_at(
    recording: &Recording,
    timing: &Timing,
    clock: Option<&SamplingClock>,
) -> Vec<QualityIssue> {
    let mut findings = recording.findings.clone();
    findings.extend(clock.map(SamplingClock::finding));
    findings.extend(of_stamps(timing, recording.len(), clock.is_some()));
    let held = HeldEfforts::of(recording);
    findings.extend(held.as_ref().map(HeldEfforts::finding));
    let repeated = RepeatedFrames::of(recording);
    findings.extend(repeated.map(|repeated| repeated.finding(&recording.time_s)));
    findings.extend(recording.joints.iter().filter_map(far_position));
    findings.extend(velocity_findings(recording, timing));
    let of_joint = |joint: &JointChannels| stuck(&recording.time_s, timing, joint);
    let mut of_joints: Vec<Vec<QualityIssue>> = recording.joints.par_iter().map(of_joint).collect();
    // held values repeat: whether a limit does only renewed ones show
    let renewed = held.as_ref().map(|held| held.only_renewed(recording));
    let measured = renewed.as_ref().unwrap_or(recording);
    of_joints.par_iter_mut().zip(&measured.joints).for_each(|(of_joint, joint)| {
        of_joint.extend(saturated(&measured.time_s, joint));
    });
    let is_held = |finding: &QualityIssue| {
        held.is_some()
            && finding.kind == QualityIssueKind::Stuck
            && finding.quantity.is_some_and(Quantity::is_of_drive)
    };
    findings.extend(of_joints.into_iter().flatten().filter(|finding| !is_held(finding)));
    findings
}

fn of_channel(
    joint: &JointChannels,
    quantity: Quantity,
    values: &[f64],
    grid: Option<&EvenGrid>,
    findings: &[QualityIssue],
) -> ChannelQuality {
    let share = |kind| {
        let of_this = |finding: &&QualityIssue| {
            finding.kind == kind
                && finding.quantity == Some(quantity)
                && finding.joint.as_deref() == Some(joint.name.as_str())
        };
        findings.iter().find(of_this).map_or(0.0, |finding| finding.share)
    };
    let even = grid.map(|grid| (grid.resample(values), grid.rate_hz()));
    let band_edge_hz = even
        .as_ref()
        .filter(|_| quantity == Quantity::Position)
        .and_then(|(even, rate_hz)| band_edge_hz(even, *rate_hz));
    ChannelQuality {
        joint: joint.name.clone(),
        quantity,
        smallest: values.iter().copied().fold(f64::MAX, f64::min),
        largest: values.iter().copied().fold(f64::MIN, f64::max),
        noise: even.as_ref().and_then(|(even, _)| noise_sigma(even)),
        step: quantisation_step(values),
        band_edge_hz,
        saturated_share: share(QualityIssueKind::Saturated),
        stuck_share: share(QualityIssueKind::Stuck),
    }
}

/// Jitter and gaps.
fn of_stamps(timing: &Timing, samples: usize, of_clock: bool) -> Vec<QualityIssue> {
    let mut findings = Vec::new();
    if !of_clock && !timing.is_even && timing.jitter > SMALLEST_JITTER {
        let message = format!(
            "uneven time stamps (period {:.3} ms, jitter {}); resampled",
            1e3 * timing.median_step_s,
            percent(timing.jitter)
        );
        let finding = QualityIssue::of_stamps(QualityIssueKind::UnevenStamps, Action::Kept, 1.0);
        findings.push(finding.with_message(message));
    }
    if !timing.gaps.is_empty() {
        let lost_s: f64 = timing.gaps.iter().map(|gap| gap.length_s - timing.median_step_s).sum();
        let lost = (lost_s / timing.median_step_s).round();
        let share = lost / (lost + samples as f64);
        let spans: Vec<Span> = timing
            .gaps
            .iter()
            .map(|gap| Span { from_s: gap.at_s, to_s: gap.at_s + gap.length_s })
            .collect();
        let longest_s = timing.gaps.iter().fold(0.0_f64, |longest, gap| longest.max(gap.length_s));
        let message = format!(
            "about {lost:.0} samples missing ({}), longest gap {:.1} ms: {}; interpolated",
            percent(share),
            1e3 * longest_s,
            Span::describe(&spans)
        );
        let finding = QualityIssue::of_stamps(QualityIssueKind::Gap, Action::Kept, share);
        let advice = "long gaps are interpolated linearly; split the file there";
        findings.push(finding.at(spans).with_message(message).with_advice(advice));
    }
    findings
}

fn far_position(joint: &JointChannels) -> Option<QualityIssue> {
    let position = joint.position.as_deref()?;
    let farthest = position.iter().fold(0.0_f64, |farthest, x| farthest.max(x.abs()));
    if farthest <= FAR_POSITION {
        return None;
    }
    let message = format!("reaches {farthest:.1}, probably degrees or millimetres");
    let finding = QualityIssue::of_channel(
        QualityIssueKind::SuspectedUnit,
        Action::Kept,
        &joint.name,
        Quantity::Position,
        1.0,
    );
    let advice = "set its unit in a mapping file: unit = \"deg\" or \"mm\"";
    Some(finding.with_message(message).with_advice(advice))
}

/// What differs between recordings that are used together: sample rates, joints, channels. The
/// order of the joints does not matter.
pub fn differences(recordings: &[Recording]) -> Vec<QualityIssue> {
    let Some((first, others)) = recordings.split_first() else { return Vec::new() };
    let mut findings = Vec::new();
    let rate = |recording: &Recording| Timing::of(&recording.time_s).rate_hz;
    let of_first = rate(first);
    let deviates = |recording: &&Recording| (rate(recording) / of_first - 1.0).abs() > SAME_RATE;
    let odd: Vec<&Recording> = others.iter().filter(deviates).collect();
    if !odd.is_empty() {
        let list: Vec<String> = odd
            .iter()
            .map(|recording| format!("{:.1} Hz in {}", rate(recording), recording.source))
            .collect();
        let message = format!(
            "sample rates differ (supported): {of_first:.1} Hz in {}, {}",
            first.source,
            list.join(", ")
        );
        let share = odd.len() as f64 / recordings.len() as f64;
        let finding = QualityIssue::of_stamps(QualityIssueKind::RatesDiffer, Action::Kept, share);
        findings.push(finding.with_message(message));
    }
    let mut channels: Vec<(&str, Quantity)> = Vec::new();
    for joint in recordings.iter().flat_map(|recording| &recording.joints) {
        for (quantity, _) in joint.channels() {
            if !channels.contains(&(joint.name.as_str(), quantity)) {
                channels.push((&joint.name, quantity));
            }
        }
    }
    for (joint, quantity) in channels {
        let lacks = |recording: &&Recording| {
            recording.joint(joint).is_none_or(|joint| joint.channel(quantity).is_none())
        };
        let lacking: Vec<&str> =
            recordings.iter().filter(lacks).map(|recording| recording.source.as_str()).collect();
        if lacking.is_empty() {
            continue;
        }
        let share = lacking.len() as f64 / recordings.len() as f64;
        let message = format!("missing in {}", lacking.join(", "));
        let finding = QualityIssue::of_channel(
            QualityIssueKind::ChannelsDiffer,
            Action::Kept,
            joint,
            quantity,
            share,
        );
        findings.push(finding.with_message(message));
    }
    findings
}
