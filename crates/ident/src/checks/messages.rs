//! From numbers to verdicts and sentences.

use armident_kinematics::{DrivingAxisJoint, JointKind};
use armident_model::ArmModel;
use armident_motion::{
    CUTOFF_OVER_EDGE, HIGHEST_CUTOFF_SHARE, Motion, QualityReport, RESTING_RANGE,
};
use armident_recording::{Action, QualityIssue, QualityIssueKind, Quantity};

use super::channel::{ChannelEvidence, ChannelKind, Channels, LARGEST_LOG_GAIN};
use super::delay::Delay;
use super::excitation::{ConstantCheck, activity};
use super::verdict::{Check, SURE, Topic, Verdict};

/// `2 ln` of the likelihood ratio above which a delay is wrong: a thousand to one, with a prior of
/// one delay in a hundred recordings.
const DELAY_EVIDENCE: f64 = 23.0;
/// Share of the squared residual that a delay must explain to matter.
const DELAY_MATTERS: f64 = 0.5;
/// Noise above this share of the signal is doubtful.
const NOISY: f64 = 0.1;
/// Recorded effort over the URDF's effort limit above which its unit is doubtful.
const BEYOND_LIMIT: f64 = 3.0;
/// Reductions of usual gears of arms.
const GEARS: [f64; 9] = [30.0, 50.0, 80.0, 100.0, 101.0, 120.0, 121.0, 160.0, 161.0];
/// Rarer of both directions, as a share of the moving time, below which friction and offset are collinear.
const ONE_WAY: f64 = 0.05;

fn robot_wide(topic: Topic, verdict: Verdict, message: String) -> Check {
    Check {
        topic,
        joint: None,
        verdict,
        value: None,
        unit: "",
        interval_95: None,
        message,
        advice: None,
    }
}

/// At most four digits, for sentences.
fn short(x: f64) -> String {
    digits(x, 4)
}

/// At most so many digits, without zeros at the end.
fn digits(x: f64, most: i32) -> String {
    let decimals = decimals(x, most);
    let text = format!("{x:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Decimals at which a number has so many digits.
fn decimals(x: f64, most: i32) -> usize {
    (most - 1 - x.abs().max(1e-300).log10().floor() as i32).clamp(0, 9) as usize
}

/// A gain with three digits and the ends of its interval with as many decimals, but two or three digits.
fn gain_and_interval(gain: f64, interval: [f64; 2]) -> (String, String) {
    let places = decimals(gain, 3);
    let [low, high] = interval.map(|end| {
        let places = places.max(decimals(end, 2)).min(decimals(end, 3));
        format!("{end:.places$}")
    });
    (format!("gain {gain:.places$}"), format!("95 % interval {low} to {high}"))
}

/// `dead`: joints whose effort columns have a dead zone.
pub(super) fn quality(
    reports: &[QualityReport],
    differences: &[QualityIssue],
    dead: &[&str],
) -> Vec<Check> {
    let is_dead = |finding: &QualityIssue| {
        finding.quantity == Some(Quantity::Effort)
            && finding.joint.as_deref().is_some_and(|joint| dead.contains(&joint))
    };
    let of = |source: Option<&str>, finding: &QualityIssue| {
        let verdict = match finding.kind {
            QualityIssueKind::SuspectedUnit => Verdict::Wrong,
            QualityIssueKind::Stuck if is_dead(finding) => Verdict::Wrong,
            QualityIssueKind::MissingVelocity
            | QualityIssueKind::UnevenStamps
            | QualityIssueKind::LateStamps
            | QualityIssueKind::EmptyColumns
            | QualityIssueKind::OwnStamps
            | QualityIssueKind::RatesDiffer
            | QualityIssueKind::VelocityDelay
            | QualityIssueKind::WrappedAngle => Verdict::Ok,
            QualityIssueKind::RepeatedFrames if finding.action == Action::Repaired => Verdict::Ok,
            _ => Verdict::Doubtful,
        };
        let message = match source {
            Some(source) if reports.len() > 1 => format!("{source}: {}", finding.message),
            _ => finding.message.clone(),
        };
        Check {
            joint: finding.joint.clone(),
            value: Some(finding.share),
            unit: "share of samples",
            advice: finding.advice.clone(),
            ..robot_wide(Topic::Quality, verdict, message)
        }
    };
    let own = reports.iter().flat_map(|r| r.findings.iter().map(|f| of(Some(&r.source), f)));
    own.chain(differences.iter().map(|f| of(None, f))).collect()
}

pub(super) fn rate(reports: &[QualityReport], motions: &[Motion]) -> Vec<Check> {
    reports
        .iter()
        .zip(motions)
        .map(|(report, motion)| {
            let edge_hz = report.channels.iter().filter_map(|c| c.band_edge_hz).fold(0.0, f64::max);
            let rate_hz = motion.rate_hz;
            if edge_hz == 0.0 {
                let message = format!("{}: no joint moves", report.source);
                return Check {
                    value: Some(rate_hz),
                    unit: "Hz",
                    advice: Some("move the joints".to_owned()),
                    ..robot_wide(Topic::Rate, Verdict::Doubtful, message)
                };
            }
            let room = HIGHEST_CUTOFF_SHARE * rate_hz / edge_hz;
            let verdict = if room >= CUTOFF_OVER_EDGE { Verdict::Ok } else { Verdict::Doubtful };
            let ratio = rate_hz / edge_hz;
            let message = format!(
                "{} Hz, {} times the motion bandwidth of {} Hz",
                short(rate_hz),
                digits(ratio, 3),
                digits(edge_hz, 3)
            );
            let advice = format!(
                "record at {:.0} Hz or more, or move more slowly",
                CUTOFF_OVER_EDGE / HIGHEST_CUTOFF_SHARE * edge_hz
            );
            Check {
                value: Some(ratio),
                unit: "samples per period of the band edge",
                advice: (verdict != Verdict::Ok).then_some(advice),
                ..robot_wide(Topic::Rate, verdict, message)
            }
        })
        .collect()
}

pub(super) fn delay(delay: Option<&Delay>, motions: &[Motion]) -> Check {
    let step_s = motions.iter().map(|m| 1.0 / m.rate_hz).fold(0.0, f64::max);
    let Some(found) = delay else {
        let message = "delay not identifiable from this motion".to_owned();
        let advice = "excite several frequencies, faster".to_owned();
        return Check {
            advice: Some(advice),
            unit: "s",
            ..robot_wide(Topic::Delay, Verdict::CannotTell, message)
        };
    };
    let [low, high] = found.interval_95_s;
    let half = 0.5 * (high - low);
    let excludes_zero = found.excludes_zero();
    let matters = found.residual_ratio.powi(2) < DELAY_MATTERS;
    let verdict = if excludes_zero && found.evidence > DELAY_EVIDENCE && matters {
        Verdict::Wrong
    } else if excludes_zero && found.delay_s.abs() > 0.5 * step_s {
        Verdict::Doubtful
    } else if half > 5.0 * step_s && !excludes_zero {
        Verdict::CannotTell
    } else {
        Verdict::Ok
    };
    let message = format!(
        "effort lag {:.1} ms (95 % interval {:.1} to {:.1} ms); ignoring it makes the residual {:.0} % larger",
        1e3 * found.delay_s,
        1e3 * low,
        1e3 * high,
        100.0 * (1.0 / found.residual_ratio - 1.0)
    );
    let advice = match verdict {
        Verdict::Wrong | Verdict::Doubtful => Some(format!(
            "shift the effort stamps by {:.1} ms, or time-stamp both channels at the source",
            -1e3 * found.delay_s
        )),
        Verdict::CannotTell => Some("excite several frequencies, faster".to_owned()),
        Verdict::Ok => None,
    };
    Check {
        value: Some(found.delay_s),
        unit: "s",
        interval_95: Some(found.interval_95_s),
        advice,
        ..robot_wide(Topic::Delay, verdict, message)
    }
}

pub(super) fn order(channels: &Channels, names: &[&str]) -> Check {
    let swapped: Vec<String> = (channels.order.iter().enumerate())
        .filter(|(j, k)| j != *k)
        .map(|(j, &k)| format!("column {} holds {}", names[k], names[j]))
        .collect();
    let p = channels.order_probability;
    let verdict = Verdict::of_probability(p);
    let message = if swapped.is_empty() {
        "each effort column fits its own joint best".to_owned()
    } else if verdict == Verdict::Wrong || verdict == Verdict::Doubtful {
        format!("effort columns are swapped: {}", swapped.join(", "))
    } else {
        format!("an alternative column order is equally likely: {}", swapped.join(", "))
    };
    let advice = matches!(verdict, Verdict::Wrong | Verdict::Doubtful)
        .then(|| "assign columns to joints in a mapping file".to_owned());
    let verdict = if swapped.is_empty() { Verdict::Ok } else { verdict };
    Check {
        value: Some(p),
        unit: "probability",
        advice,
        ..robot_wide(Topic::Order, verdict, message)
    }
}

/// Whether the URDF's effort is absent: the gain is at the end of the range.
fn is_absent(found: &ChannelEvidence) -> bool {
    let [low, high] = found.gain_95;
    low.abs().min(high.abs()) < 2.0 * (-LARGEST_LOG_GAIN).exp()
}

/// Efforts none of which is the joint's, some without the rigid-body effort: they are from another motion.
/// `is_effort`: joints whose efforts are recorded, not currents.
pub(super) fn other_motion(channels: &Channels, is_effort: &[bool]) -> Option<Check> {
    let is_missing = |c: &ChannelEvidence| c.as_said() == Verdict::Wrong && is_absent(c);
    let pairs = channels.evidence.iter().zip(is_effort);
    let all: Vec<&ChannelEvidence> = pairs.filter(|(_, e)| **e).map(|(c, _)| c).collect();
    let none_fits = all.len() > 1 && all.iter().all(|c| c.as_said() != Verdict::Ok);
    (none_fits && all.into_iter().any(is_missing)).then(|| Check {
        advice: Some("check that efforts and positions come from one run and one clock".to_owned()),
        ..robot_wide(
            Topic::Order,
            Verdict::Wrong,
            "no effort column matches the rigid-body effort of its joint: efforts and positions are from different motions".to_owned(),
        )
    })
}

/// `signal`: what is recorded instead of an effort; `has_dead_zone`: whether the column has one; `kind`: of the joint.
pub(super) fn channel(
    channels: &Channels,
    joint: usize,
    names: &[&str],
    signal: Option<Quantity>,
    has_dead_zone: bool,
    kind: JointKind,
) -> Check {
    let found = &channels.evidence[joint];
    let [low, high] = found.gain_95;
    let base = |verdict: Verdict, message: String, advice: Option<String>| Check {
        joint: Some(names[joint].to_owned()),
        value: Some(found.gain),
        unit: "recorded over joint effort",
        interval_95: Some(found.gain_95),
        advice,
        ..robot_wide(Topic::Channel, verdict, message)
    };
    let newton = if kind.is_rotational() { "N m" } else { "N" };
    let (gain, interval) = gain_and_interval(found.gain, found.gain_95);
    let flipped_gain = format!("sign flipped ({gain}, {interval})");
    let gain = format!("{gain} ({interval})");
    let moved = channels.order[joint];
    if moved != joint && channels.order_probability <= SURE {
        let message = format!(
            "holds another joint's effort; this joint's effort is in column {}",
            names[moved]
        );
        let advice = "swap the columns, by names in a mapping file".to_owned();
        return base(Verdict::Wrong, message, Some(advice));
    }
    if has_dead_zone {
        let message = format!("the column has a dead zone; {gain}");
        return base(Verdict::CannotTell, message, None);
    }
    let [_, flipped, other, other_flipped, without_gravity] = found.probability;
    if let Some(quantity) = signal {
        let known = high / low < 4.0 && low * high > 0.0;
        let message = format!("{quantity}, {gain} per {newton}");
        let advice = format!(
            "give its constant in a mapping file: one unit of {quantity} is {} to {} {newton} by the URDF",
            short((1.0 / low).min(1.0 / high)),
            short((1.0 / low).max(1.0 / high))
        );
        return if known {
            base(Verdict::Ok, message, Some(advice))
        } else {
            let message = format!("{quantity}, gain not identifiable from this motion; {gain}");
            base(Verdict::CannotTell, message, None)
        };
    }
    let verdict = found.as_said();
    if matches!(verdict, Verdict::Ok) {
        return base(verdict, format!("matches the URDF, {gain}"), None);
    }
    let absent = is_absent(found);
    let backwards = flipped + other_flipped > 1.0 - SURE;
    if absent && backwards && verdict == Verdict::Wrong {
        let message = format!(
            "sign flipped: friction would drive the joint; the rigid-body effort is not visible \
             (expected standard deviation {} {newton})",
            short(found.urdf_sd)
        );
        let advice = "set sign = -1 in a mapping file".to_owned();
        return base(verdict, message, Some(advice));
    }
    if absent && verdict == Verdict::Wrong {
        let message = format!(
            "does not contain the rigid-body effort (expected standard deviation {} {newton})",
            short(found.urdf_sd)
        );
        let advice = "check whether the column is a friction estimate, a command, or another joint"
            .to_owned();
        return base(verdict, message, Some(advice));
    }
    let verdict = if absent { Verdict::CannotTell } else { verdict };
    if matches!(verdict, Verdict::CannotTell) {
        let message = format!(
            "the rigid-body effort (standard deviation {} {newton}) is small compared with friction \
             and residual ({} {newton}); {gain}",
            short(found.urdf_sd),
            short(found.residual_rms)
        );
        return base(verdict, message, None);
    }
    let kinds = [
        (flipped, ChannelKind::SignFlipped),
        (other, ChannelKind::OtherGain),
        (other_flipped, ChannelKind::OtherGainFlipped),
        (without_gravity, ChannelKind::WithoutGravity),
    ];
    let most = kinds.iter().max_by(|a, b| a.0.total_cmp(&b.0)).map(|k| k.1);
    let (message, advice) = match most {
        Some(ChannelKind::SignFlipped) => {
            (flipped_gain, "set sign = -1 in a mapping file, or flip the joint axis".to_owned())
        }
        Some(ChannelKind::WithoutGravity) => (
            "gravity is already compensated".to_owned(),
            "log uncompensated efforts, or pass --gravity 0,0,0".to_owned(),
        ),
        _ => {
            let flip = if found.gain < 0.0 { ", and sign flipped" } else { "" };
            let (least, most) = (low.abs().min(high.abs()), low.abs().max(high.abs()));
            let gears: Vec<String> = GEARS
                .iter()
                .filter(|&&n| n * least <= 1.0 && n * most >= 1.0)
                .map(|n| format!("{n:.0}:1"))
                .collect();
            let gear = if gears.is_empty() {
                String::new()
            } else {
                format!(", consistent with the motor side of a {} gear", gears.join(" or "))
            };
            (
                format!("another unit{flip}: {gain}{gear}"),
                format!(
                    "multiply by {} to {} in a mapping file (gear_ratio or current gain)",
                    digits((1.0 / low).min(1.0 / high), 3),
                    digits((1.0 / low).max(1.0 / high), 3)
                ),
            )
        }
    };
    base(verdict, message, Some(advice))
}

/// An effort far beyond the joint's limit.
pub(super) fn beyond_limit(motions: &[Motion], joint: usize, model: &ArmModel) -> Option<Check> {
    let of = &model.chain.joints[joint];
    let limit = of.limits.effort.filter(|limit| *limit > 0.0)?;
    let efforts = motions.iter().filter_map(|m| m.effort_filtered.as_ref());
    let largest =
        efforts.flat_map(|effort| &effort[joint]).fold(0.0_f64, |so_far, e| so_far.max(e.abs()));
    let ratio = largest / limit;
    let newton = if of.kind.is_rotational() { "N m" } else { "N" };
    (ratio > BEYOND_LIMIT).then(|| Check {
        joint: Some(of.name.clone()),
        value: Some(ratio),
        unit: "recorded over largest effort",
        advice: Some(
            "check the unit: current or drive counts? set it in a mapping file".to_owned(),
        ),
        ..robot_wide(
            Topic::Channel,
            Verdict::Doubtful,
            format!(
                "reaches {}, {} times the URDF effort limit of {} {newton}",
                short(largest),
                short((10.0 * ratio).round() / 10.0),
                short(limit)
            ),
        )
    })
}

pub(super) fn noise(
    reports: &[QualityReport],
    motions: &[Motion],
    joint: usize,
    of: &DrivingAxisJoint,
) -> Vec<Check> {
    let name = of.name.as_str();
    let [newton, metre] = if of.kind.is_rotational() { ["N m", "rad"] } else { ["N", "m"] };
    let worst = |quantity: Quantity| {
        reports
            .iter()
            .flat_map(|r| &r.channels)
            .filter(|c| c.joint == name && c.quantity == quantity)
            .filter_map(|c| Some((c.noise?, c.step)))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let stepped = |step: Option<f64>| {
        step.map_or(String::new(), |step| format!(", quantisation {}", scientific(step)))
    };
    let rms = |pick: &dyn Fn(&Motion) -> &[f64]| {
        let all: Vec<f64> = motions.iter().flat_map(|m| pick(m).to_vec()).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        (all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt()
    };
    let (rate_hz, cutoff_hz, share) =
        motions.iter().fold((f64::INFINITY, 0.0, 0.0), |so_far, m| {
            let cutoff_hz = m.filter.as_ref().map_or(0.5 * m.rate_hz, |f| f.cutoff_hz());
            let (rate, cutoff, share): (f64, f64, f64) = so_far;
            (rate.min(m.rate_hz), cutoff.max(cutoff_hz), share.max(m.independent_share()))
        });
    let exact = motions.iter().any(|m| m.filter.is_none());
    let noise = |level: String, (sigma, step), unit, (share, of): (f64, &str), advice: &str| {
        let noisy = share > NOISY;
        let message = format!(
            "{level}{} ({:.1} % of the {of} after the low-pass)",
            stepped(step),
            100.0 * share
        );
        Check {
            joint: Some(name.to_owned()),
            value: Some(sigma),
            unit,
            advice: noisy.then(|| advice.to_owned()),
            ..robot_wide(Topic::Noise, if noisy { Verdict::Doubtful } else { Verdict::Ok }, message)
        }
    };
    let mut checks = Vec::new();
    if let Some((sigma, step)) = worst(Quantity::Effort) {
        let of_signal =
            sigma * share.sqrt() / rms(&|m| m.effort.as_ref().map_or(&[], |e| &e[joint]));
        checks.push(noise(
            format!("effort {} {newton}", scientific(sigma)),
            (sigma, step),
            "N m or N",
            (of_signal, "signal"),
            "move this joint more, or longer",
        ));
    }
    let moving = activity(motions, joint).range >= RESTING_RANGE;
    if let Some((sigma, step)) = worst(Quantity::Position).filter(|_| moving && !exact) {
        // white noise up to the cut-off, differentiated twice
        let omega = std::f64::consts::TAU * cutoff_hz;
        let of_acceleration = sigma * omega * omega * (2.0 * cutoff_hz / (5.0 * rate_hz)).sqrt();
        let of_signal = of_acceleration / rms(&|m| &m.acceleration[joint]);
        checks.push(noise(
            format!("position {} {metre}", scientific(sigma)),
            (sigma, step),
            "rad or m",
            (of_signal, "acceleration"),
            "accelerate more, or lower --cutoff-hz",
        ));
    }
    checks
}

fn scientific(x: f64) -> String {
    if (1e-3..1e4).contains(&x.abs()) || x == 0.0 { digits(x, 2) } else { format!("{x:.1e}") }
}

/// Whether the motion of one joint is enough for its parameters.
pub(super) fn motion(motions: &[Motion], joint: usize, name: &str) -> Option<Check> {
    let found = activity(motions, joint);
    let (message, advice) = if found.range < RESTING_RANGE {
        (
            "does not move: its parameters are not identifiable".to_owned(),
            "move this joint".to_owned(),
        )
    } else if found.rarer_direction < ONE_WAY {
        (
            format!(
                "moves almost only in one direction ({:.0} % the other): friction and offset are collinear",
                100.0 * found.rarer_direction
            ),
            "move it back and forth".to_owned(),
        )
    } else {
        return None;
    };
    Some(Check {
        joint: Some(name.to_owned()),
        value: Some(found.range),
        unit: "rad or m of travel",
        advice: Some(advice),
        ..robot_wide(Topic::Excitation, Verdict::Doubtful, message)
    })
}

pub(super) fn excitation(constants: &[ConstantCheck], rank: usize, unknowns: usize) -> Check {
    let count = |verdict| constants.iter().filter(|c| c.verdict == verdict).count();
    let (well, hardly, not) =
        (count(Verdict::Ok), count(Verdict::Doubtful), count(Verdict::CannotTell));
    let verdict = if hardly + not == 0 { Verdict::Ok } else { Verdict::Doubtful };
    let message = format!(
        "{well} of {} constants well determined (standard error below 10 % of size), {hardly} poorly, {not} not; \
         rank {rank} of {unknowns}",
        constants.len()
    );
    let advice = (verdict != Verdict::Ok)
        .then(|| "see the table below; `armident plan` generates exciting motions".to_owned());
    Check {
        value: Some(well as f64),
        unit: "constants",
        advice,
        ..robot_wide(Topic::Excitation, verdict, message)
    }
}
