//! From numbers to verdicts and sentences.

use armident_kinematics::{DrivingAxisJoint, JointKind};
use armident_model::ArmModel;
use armident_motion::{
    CUTOFF_OVER_EDGE, HIGHEST_CUTOFF_SHARE, Motion, QualityReport, RESTING_RANGE,
};
use armident_recording::{Action, QualityIssue, QualityIssueKind, Quantity};

use super::arm_likelihood::Meaning;
use super::channel::{ChannelEvidence, ChannelKind, Channels};
use super::computed::BesideRigid;
use super::delay::{Delay, LookAlike};
use super::effort_clock::EffortClock;
use super::effort_low_pass::EffortLowPass;
use super::excitation::{ConstantCheck, activity};
use super::explanations::Explained;
use super::link_errors::LARGEST_LOG_GAIN;
use super::link_length::{FrameLength, LinkLength};
use super::rows;
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
/// Share of the squared effort beside friction that the rigid body must explain for a verdict on sign and unit: half, or more
/// is left than explained. The same share of the whole shows friction.
const SHOWS: f64 = 0.5;
/// Share of a column that remains where nothing of a joint's motion is in it.
const FITS_NOTHING: f64 = 0.7;
/// Angle beyond which gravity is that of another mounting \[degrees\]: a base that stands on a slope, or was screwed on
/// carelessly, is tilted by less, and a diagnosis finds that.
const MOUNTED_DEG: f64 = 15.0;
/// Reductions of usual gears of arms.
const GEARS: [f64; 9] = [30.0, 50.0, 80.0, 100.0, 101.0, 120.0, 121.0, 160.0, 161.0];
/// Rarer of both directions, as a share of the moving time, below which friction and offset are collinear.
const ONE_WAY: f64 = 0.05;

fn robot_wide(topic: Topic, verdict: Verdict, message: String) -> Check {
    Check::of(topic, None, verdict, message)
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

pub(super) fn link_length(found: &LinkLength, names: &[&str]) -> Check {
    let [low, high] = found.interval_95_m;
    let (joint, before) = (names[found.joint], names[found.joint - 1]);
    let along = match found.along {
        FrameLength::Normal => "along the common normal",
        FrameLength::Offset => "along its own axis",
    };
    let message = format!(
        "the axis of {joint} is {} m from that of {before} ({along}; 95 % interval {} to {} m), in the robot file {} m, with which \
         the residual of {} is {:.2} times as large whatever the inertias of the links are",
        digits(found.length_m, 3),
        digits(low, 3),
        digits(high, 3),
        digits(found.given_m, 3),
        names[found.shown_by],
        1.0 / found.residual_ratio,
    );
    let advice = format!(
        "measure it, and correct the origin of joint {joint} in the robot file; diagnose takes it into account"
    );
    Check {
        value: Some(found.length_m),
        unit: "m",
        interval_95: Some(found.interval_95_m),
        advice: Some(advice),
        ..robot_wide(Topic::Geometry, Verdict::Wrong, message)
    }
}

pub(super) fn low_pass(found: &EffortLowPass) -> Check {
    let [low, high] = found.interval_95_s;
    let message = format!(
        "efforts come through a low-pass of {} Hz (time constant {:.1} ms, 95 % interval {:.1} to {:.1} ms): late, and smaller in fast \
         motion",
        digits(found.cutoff_hz(), 2),
        1e3 * found.time_constant_s,
        1e3 * low,
        1e3 * high
    );
    let advice = "diagnose takes it into account; for identify, record efforts that the drive does not filter, or motions slow beside it";
    Check {
        value: Some(found.time_constant_s),
        unit: "s",
        interval_95: Some(found.interval_95_s),
        advice: Some(advice.to_owned()),
        ..robot_wide(Topic::Delay, Verdict::Doubtful, message)
    }
}

pub(super) fn effort_clock(found: &EffortClock, motions: &[Motion]) -> Check {
    let [low, high] = found.interval_95;
    let longest_s = (motions.iter())
        .filter_map(|m| Some(m.time_s.last()? - m.time_s.first()?))
        .fold(0.0, f64::max);
    let message = format!(
        "the clock of the efforts is {} by {:.0} ppm (95 % interval {:.0} to {:.0} ppm): {:.1} ms after {longest_s:.0} s",
        if found.drift > 0.0 { "fast" } else { "slow" },
        1e6 * found.drift.abs(),
        1e6 * low.abs().min(high.abs()),
        1e6 * low.abs().max(high.abs()),
        1e3 * found.drift.abs() * longest_s,
    );
    let advice = "diagnose takes it into account; for identify, stamp efforts and positions by one clock, or keep recordings short";
    Check {
        value: Some(found.drift),
        interval_95: Some(found.interval_95),
        advice: Some(advice.to_owned()),
        ..robot_wide(Topic::Clock, Verdict::Doubtful, message)
    }
}

pub(super) fn delay(
    delay: Option<&Delay>,
    look_alike: Option<LookAlike>,
    motions: &[Motion],
) -> Check {
    let step_s = motions.iter().map(|m| 1.0 / m.rate_hz).fold(0.0, f64::max);
    let Some(found) = delay else {
        let message = "delay not identifiable from this motion".to_owned();
        let advice = "excite several frequencies, faster".to_owned();
        return Check {
            advice: Some(advice),
            unit: "s",
            ..robot_wide(Topic::Delay, Verdict::Inconclusive, message)
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
        Verdict::Inconclusive
    } else {
        Verdict::Ok
    };
    // late by a low-pass is late too
    let verdict = match look_alike {
        None | Some(LookAlike::LowPass(_)) => verdict,
        Some(_) => verdict.min(Verdict::Inconclusive),
    };
    let rival = match look_alike {
        None => String::new(),
        Some(LookAlike::Presliding) => {
            "; friction that builds up after each reversal explains as much: no case against the clocks".to_owned()
        }
        Some(LookAlike::OtherCutoff { cutoff_hz, delay_s }) => format!(
            "; below {} Hz it is {:.1} ms: no delay of clocks, which is the same at any cut-off",
            digits(cutoff_hz, 3),
            1e3 * delay_s
        ),
        Some(LookAlike::LowPass(time_constant_s)) => format!(
            "; a low-pass of {} Hz in the drives explains as much",
            digits(1.0 / (std::f64::consts::TAU * time_constant_s), 2)
        ),
        Some(LookAlike::Held(held_s)) => format!(
            "; effort samples are held for {:.0} ms, and come late by half of it",
            1e3 * held_s
        ),
    };
    let message = format!(
        "effort lag {:.1} ms (95 % interval {:.1} to {:.1} ms); ignoring it makes the residual {:.0} % larger{rival}",
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
        Verdict::Inconclusive if matches!(look_alike, None | Some(LookAlike::LowPass(_))) => {
            Some("excite several frequencies, faster".to_owned())
        }
        Verdict::Inconclusive | Verdict::Ok => None,
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
/// `is_judged`: joints whose efforts, not currents, magnitudes or constants, are recorded.
pub(super) fn other_motion(channels: &Channels, is_judged: &[bool]) -> Option<Check> {
    let is_missing = |c: &ChannelEvidence| {
        c.as_labelled() == Verdict::Wrong && is_absent(c) && c.residual_share > FITS_NOTHING
    };
    let pairs = channels.evidence.iter().zip(is_judged);
    let all: Vec<&ChannelEvidence> = pairs.filter(|(_, e)| **e).map(|(c, _)| c).collect();
    let none_fits = all.len() > 1 && all.iter().all(|c| c.as_labelled() != Verdict::Ok);
    (none_fits && all.into_iter().any(is_missing)).then(|| Check {
        advice: Some("check that efforts and positions come from one run and one clock".to_owned()),
        ..robot_wide(
            Topic::Order,
            Verdict::Wrong,
            "no effort column matches the rigid-body effort of its joint: efforts and positions are from different motions".to_owned(),
        )
    })
}

/// What a column holds.
#[derive(Clone, Copy)]
pub(super) struct Column {
    /// What is recorded instead of an effort.
    pub(super) signal: Option<Quantity>,
    /// Whether it has a dead zone.
    pub(super) has_dead_zone: bool,
    /// Kind of the joint.
    pub(super) kind: JointKind,
}

/// Name of a mounting at an angle to the given one.
fn mounting(angle_deg: f64) -> String {
    match angle_deg {
        a if a > 170.0 => "the arm hangs upside down, as from a ceiling".to_owned(),
        a if (80.0..100.0).contains(&a) => {
            "the arm is mounted on its side, as on a wall".to_owned()
        }
        a => format!("the base is tilted by {} degrees", digits(a, 3)),
    }
}

/// Where gravity points, if not where it was given.
pub(super) fn gravity(explained: &Explained) -> Option<Check> {
    let found = explained.direction.as_ref()?;
    let option = found.option();
    let [low, high] = found.interval_95_deg;
    let verdict = if found.angle_deg > MOUNTED_DEG { Verdict::Wrong } else { Verdict::Doubtful };
    let message = format!(
        "gravity points another way than given: along ({}) m/s2 in the base frame, {} degrees off (95 % interval {} to {}); \
         {}",
        option.replace(',', ", "),
        digits(found.angle_deg, 4),
        digits(low, 4),
        digits(high, 4),
        mounting(found.angle_deg)
    );
    Some(Check {
        value: Some(found.angle_deg),
        unit: "degrees",
        interval_95: Some(found.interval_95_deg),
        advice: Some(format!("pass --gravity {option}")),
        ..robot_wide(Topic::Gravity, verdict, message)
    })
}

/// Joints whose columns are those of others, position and effort.
pub(super) fn exchanged(explained: &Explained, names: &[&str]) -> Check {
    let source = &explained.map.source;
    let moved: Vec<usize> = (0..source.len()).filter(|&j| source[j] != j).collect();
    let pairs: Vec<String> = (moved.iter())
        .filter(|&&j| source[source[j]] == j && j < source[j])
        .map(|&j| format!("{} and {} are exchanged", names[j], names[source[j]]))
        .collect();
    let rings: Vec<String> = (moved.iter())
        .filter(|&&j| source[source[j]] != j)
        .map(|&j| format!("the columns of {} hold {}", names[source[j]], names[j]))
        .collect();
    let all = [pairs, rings].concat().join(", ");
    let columns: Vec<String> =
        moved.iter().map(|&j| format!("{} to joint {}", names[source[j]], names[j])).collect();
    Check {
        value: Some(explained.as_labelled),
        unit: "probability",
        advice: Some(format!(
            "assign the columns in a mapping file (position, velocity and effort): {}",
            columns.join(", ")
        )),
        ..robot_wide(Topic::Order, Verdict::Wrong, format!("{all}, position and effort"))
    }
}

/// Efforts of all joints that no sensor measured.
pub(super) fn computed(beside: &[BesideRigid]) -> Option<Check> {
    if beside.is_empty() || !beside.iter().all(BesideRigid::is_computed) {
        return None;
    }
    let most = |of: fn(&BesideRigid) -> f64| 100.0 * beside.iter().map(of).fold(0.0, f64::max);
    let (friction, residual) = (most(|b| b.friction), most(|b| b.residual));
    Some(Check {
        value: Some(residual),
        unit: "% of the effort",
        advice: Some(
            "record what the drives or sensors measure, not the target effort or the output of a model".to_owned(),
        ),
        ..robot_wide(
            Topic::Quality,
            Verdict::Doubtful,
            format!(
                "efforts look computed by a model (target or command), not measured: no friction on any joint (at most {} % of \
                 the effort), and rigid links leave {} %",
                digits(friction, 2),
                digits(residual, 2)
            ),
        )
    })
}

/// A joint that counts the other way, with position and effort.
pub(super) fn joint_sign(explained: &Explained, joint: usize, names: &[&str]) -> Option<Check> {
    (explained.map.sign[joint] < 0.0).then(|| Check {
        joint: Some(names[joint].to_owned()),
        value: Some(explained.as_labelled),
        unit: "probability",
        advice: Some(
            "set sign = -1 on its position, velocity and effort in a mapping file, or turn the axis in the URDF"
                .to_owned(),
        ),
        ..robot_wide(
            Topic::JointSign,
            Verdict::Wrong,
            "counts the other way than its axis in the URDF: position and effort both have the other sign"
                .to_owned(),
        )
    })
}

/// An effort column that is one number.
pub(super) fn constant(name: &str, value: f64, moves: bool, kind: JointKind) -> Check {
    let newton = if kind.is_rotational() { "N m" } else { "N" };
    let number = if value == 0.0 {
        "exactly 0".to_owned()
    } else {
        format!("always {} {newton}", short(value))
    };
    let (verdict, message) = if moves {
        (
            Verdict::Wrong,
            format!("is {number} throughout while the joint moves: no sensor, or none read"),
        )
    } else {
        (Verdict::Doubtful, format!("is {number} throughout: constant, and the joint rests"))
    };
    Check {
        joint: Some(name.to_owned()),
        value: Some(value),
        unit: "N m or N",
        advice: Some(
            "leave the column out of the file: the other joints are used without it".to_owned(),
        ),
        ..robot_wide(Topic::Channel, verdict, message)
    }
}

/// An effort column without a sign; `all`: as those of all joints.
pub(super) fn magnitude(name: &str, side: f64, returns: usize, all: bool) -> Check {
    let beyond = if side > 0.0 { "below" } else { "above" };
    let verdict = if all { Verdict::Wrong } else { Verdict::Doubtful };
    Check {
        joint: Some(name.to_owned()),
        value: Some(returns as f64),
        unit: "returns to zero",
        advice: Some(
            "record the signed effort or current; of a position servo the sign is that of command minus position"
                .to_owned(),
        ),
        ..robot_wide(
            Topic::Channel,
            verdict,
            format!(
                "a magnitude without sign: never {beyond} zero though the joint reverses{}",
                match returns {
                    0 => ", as all columns of the arm".to_owned(),
                    _ => format!(", and {returns} times back to it"),
                }
            ),
        )
    }
}

/// A column as the joint's effort.
pub(super) fn channel(
    channels: &Channels,
    joint: usize,
    names: &[&str],
    column: Column,
    explained: &Explained,
) -> Check {
    let Column { signal, has_dead_zone, kind } = column;
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
        return base(Verdict::Inconclusive, message, None);
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
            base(Verdict::Inconclusive, message, None)
        };
    }
    let verdict = found.as_labelled();
    if matches!(verdict, Verdict::Ok) {
        return base(verdict, format!("matches the URDF, {gain}"), None);
    }
    let absent = is_absent(found);
    let backwards = flipped + other_flipped > 1.0 - SURE;
    let is_friction = found.friction_share > SHOWS;
    if absent && backwards && is_friction && verdict == Verdict::Wrong {
        let message = format!(
            "sign flipped: friction would drive the joint; the rigid-body effort is not visible \
             (expected standard deviation {} {newton})",
            short(found.urdf_sd)
        );
        let advice = "set sign = -1 in a mapping file".to_owned();
        return base(verdict, message, Some(advice));
    }
    // gravity is taken off the whole arm or not at all: of one joint something else carries it
    let carried = without_gravity > 0.5 && !explained.gravity_is_taken_off;
    if carried {
        let message = format!(
            "less gravity than the URDF's links have on this joint: a spring or counterbalance, or other masses; {gain}"
        );
        return base(Verdict::Inconclusive, message, None);
    }
    // a sign or unit that the arm as a whole does not ask for is none
    let meaning = explained.meaning[explained.map.source[joint]];
    // no spring turns friction round
    let turned = backwards && found.friction_flipped > -SURE.ln();
    if meaning == Meaning::Compliant && verdict != Verdict::Ok && !turned {
        let message = format!(
            "the URDF's links and a spring or counterbalance on this joint explain it better than another sign or unit; {gain}"
        );
        return base(Verdict::Inconclusive, message, None);
    }
    let is_off = explained.gravity_is_taken_off && without_gravity > 0.5;
    if is_off {
        let message = "gravity is already compensated".to_owned();
        let advice = "log uncompensated efforts, or pass --gravity 0,0,0".to_owned();
        return base(verdict, message, Some(advice));
    }
    // the column itself shows its sign and unit where its gain is known to a factor of two, and the URDF's effort at a gain of 1
    // would stand above the residual
    let is_known = low * high > 0.0 && f64::max(high / low, low / high) < 2.0;
    let would_stand = is_known && found.urdf_sd > found.residual_rms;
    let shows = found.urdf_share > SHOWS || would_stand || (is_friction && backwards);
    let agrees = meaning == Meaning::Multiple || turned || absent || is_known;
    let verdict = if shows && agrees { verdict } else { verdict.min(Verdict::Inconclusive) };
    // of a joint that swings freely, or of links with other lengths, friction is all that is left
    if absent && verdict == Verdict::Wrong && found.residual_share > FITS_NOTHING {
        let message = format!(
            "does not contain the rigid-body effort (expected standard deviation {} {newton}), nor anything else that follows \
             from this joint's motion",
            short(found.urdf_sd)
        );
        let advice = "check whether the column is a friction estimate, a command, or another joint"
            .to_owned();
        return base(Verdict::Doubtful, message, Some(advice));
    }
    if absent && verdict == Verdict::Wrong {
        let message = format!(
            "cannot tell: the efforts (standard deviation {} {newton}) are friction, next to {} {newton} that the URDF's links \
             ask for; the joint swings freely, or these are other links",
            short(found.sd),
            short(found.urdf_sd)
        );
        return base(Verdict::Inconclusive, message, None);
    }
    let verdict = if absent { Verdict::Inconclusive } else { verdict };
    if matches!(verdict, Verdict::Inconclusive) && found.urdf_share > SHOWS {
        let message = format!("fits the URDF, but other signs and units are not excluded; {gain}");
        return base(verdict, message, None);
    }
    if matches!(verdict, Verdict::Inconclusive) {
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
    let share = motions.iter().map(Motion::independent_share).fold(0.0, f64::max);
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
        let all: Vec<&[f64]> =
            motions.iter().filter_map(|m| Some(m.effort.as_ref()?[joint].as_slice())).collect();
        let of_signal = sigma * share.sqrt() / rows::deviation(&all);
        checks.push(noise(
            format!("effort {} {newton}", scientific(sigma)),
            (sigma, step),
            "N m or N",
            (of_signal, "signal"),
            "move this joint more, or longer",
        ));
    }
    let moving = activity(motions, joint).range >= RESTING_RANGE;
    let of_acceleration = rows::acceleration_noise(reports, motions, joint, name);
    if let Some(((sigma, step), share)) =
        worst(Quantity::Position).zip(of_acceleration).filter(|_| moving)
    {
        checks.push(noise(
            format!("position {} {metre}", scientific(sigma)),
            (sigma, step),
            "rad or m",
            (share, "acceleration"),
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

pub(super) fn excitation(constants: &[ConstantCheck], rank: usize, parameters: usize) -> Check {
    let count = |verdict| constants.iter().filter(|c| c.verdict == verdict).count();
    let (well, hardly, not) =
        (count(Verdict::Ok), count(Verdict::Doubtful), count(Verdict::Inconclusive));
    let verdict = if hardly + not == 0 { Verdict::Ok } else { Verdict::Doubtful };
    let message = format!(
        "{well} of {} constants well determined (standard error below 10 % of size), {hardly} poorly, {not} not; \
         rank {rank} of {parameters}",
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
