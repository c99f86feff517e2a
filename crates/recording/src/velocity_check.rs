//! Recorded velocity against differentiated position: detects wrong units, signs and delays.
//!
//! Over short windows, the change of the position is compared with the integral of the velocity.
//! That needs neither a filter nor even stamps, and quantisation averages out.

use armident_numeric::range;
use rayon::prelude::*;

use crate::finding::{Action, QualityIssue, QualityIssueKind};
use crate::quantity::Quantity;
use crate::recording::{JointChannels, Recording};
use crate::timing::{GAP_STEPS, Timing};

/// Length of a window \[s\]: long compared with encoder steps, short compared with the motion.
const WINDOW_S: f64 = 0.05;
/// Fewest steps in a window.
const FEWEST_STEPS: usize = 4;
/// Fewest windows for a conclusion.
const FEWEST_WINDOWS: usize = 40;
/// Most windows compared, spread over a long recording.
const MOST_WINDOWS: usize = 4000;
/// Smallest travel for a conclusion \[rad or m\].
const LEAST_TRAVEL: f64 = 0.05;
/// Correlation above which a scale is accepted.
const CORRELATED: f64 = 0.95;
/// Correlation below which velocity and position disagree; noisy velocities of slow joints reach
/// 0.6.
const UNRELATED: f64 = 0.5;
/// Relative tolerance of a scale of 1 or of a unit; sensors are calibrated better.
const TOLERANCE: f64 = 0.08;
/// Longest delay searched \[s\], and in samples; some drives filter over 0.2 s.
const LONGEST_LAG_S: f64 = 0.3;
const LONGEST_LAG: usize = 64;

/// Units that explain a ratio of velocity to differentiated position.
struct Unit {
    scale: f64,
    /// Unit of the position, if the position is wrong.
    position: Option<&'static str>,
    velocity: &'static str,
}

/// Ratios of velocity to differentiated position for confused units.
const UNITS: [Unit; 6] = [
    Unit { scale: 57.295_779_513, position: None, velocity: "deg/s" },
    Unit { scale: 1.0 / 57.295_779_513, position: Some("deg"), velocity: "rad/s" },
    Unit { scale: 1e3, position: None, velocity: "mm/s" },
    Unit { scale: 1e-3, position: Some("mm"), velocity: "m/s" },
    Unit { scale: 9.549_296_585, position: None, velocity: "rpm" },
    Unit { scale: 0.159_154_943, position: None, velocity: "turn/s" },
];

/// Velocity as `scale` times the differentiated position, delayed by `delay_s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Comparison {
    pub(crate) scale: f64,
    pub(crate) correlation: f64,
    pub(crate) delay_s: f64,
    /// Delay in median steps.
    pub(crate) delay_steps: f64,
}

/// Sums of products of both over all windows, the velocity `lag` samples later.
fn correlate(
    time_s: &[f64],
    position: &[f64],
    travelled: &[f64],
    steps: usize,
    lag: isize,
    margin: usize,
    longest_step_s: f64,
) -> Option<(f64, f64)> {
    let n = time_s.len();
    let (mut sum, mut of_position, mut of_velocity, mut windows) = (0.0, 0.0, 0.0, 0);
    let stride = (steps / 2).max(n / MOST_WINDOWS).max(1);
    for from in (margin..n.saturating_sub(margin + steps)).step_by(stride) {
        let to = from + steps;
        // skip windows over gaps
        if time_s[to] - time_s[from]
            > longest_step_s + (steps - 1) as f64 * longest_step_s / GAP_STEPS
        {
            continue;
        }
        let change = position[to] - position[from];
        let shifted = |k: usize| travelled[k.saturating_add_signed(lag)];
        let integral = shifted(to) - shifted(from);
        sum += change * integral;
        of_position += change * change;
        of_velocity += integral * integral;
        windows += 1;
    }
    let is_conclusive = windows >= FEWEST_WINDOWS && of_position > 0.0 && of_velocity > 0.0;
    let (scale, correlation) = (sum / of_position, sum / (of_position * of_velocity).sqrt());
    (is_conclusive && scale.is_finite() && correlation.is_finite()).then_some((scale, correlation))
}

/// Compares the two channels of a joint, given the median step of the stamps `step_s` \[s\]; none
/// if the joint is at rest or the recording is short.
pub(crate) fn compare(
    time_s: &[f64],
    step_s: f64,
    position: &[f64],
    velocity: &[f64],
) -> Option<Comparison> {
    if step_s <= 0.0 || range(position) < LEAST_TRAVEL {
        return None;
    }
    let steps = ((WINDOW_S / step_s).round() as usize).max(FEWEST_STEPS);
    let mut travelled = vec![0.0; time_s.len()];
    for k in 1..time_s.len() {
        let mean = 0.5 * (velocity[k] + velocity[k - 1]);
        travelled[k] = travelled[k - 1] + mean * (time_s[k] - time_s[k - 1]);
    }
    let margin = ((LONGEST_LAG_S / step_s) as usize).min(LONGEST_LAG).min(time_s.len() / 10);
    let at = |lag| correlate(time_s, position, &travelled, steps, lag, margin, GAP_STEPS * step_s);
    let longest = margin as isize;
    let mut best: Option<(isize, f64, f64)> = None;
    for lag in -longest..=longest {
        let (scale, correlation) = at(lag)?;
        if best.is_none_or(|(_, _, so_far)| correlation.abs() > so_far.abs()) {
            best = Some((lag, scale, correlation));
        }
    }
    let (lag, scale, correlation) = best?;
    // the correlation is a parabola near its top
    let mut delay_steps = lag as f64;
    if lag.abs() < longest {
        let (before, after) = (at(lag - 1)?.1.abs(), at(lag + 1)?.1.abs());
        let curvature = before - 2.0 * correlation.abs() + after;
        if curvature < 0.0 {
            delay_steps += 0.5 * (before - after) / curvature;
        }
    }
    Some(Comparison { scale, correlation, delay_s: delay_steps * step_s, delay_steps })
}

fn of_joint(time_s: &[f64], step_s: f64, joint: &JointChannels) -> Option<Comparison> {
    compare(time_s, step_s, joint.position.as_deref()?, joint.velocity.as_deref()?)
}

fn is_near(found: f64, expected: f64) -> bool {
    (found / expected - 1.0).abs() < TOLERANCE
}

/// A defect that refuses the recording: velocities show that positions are in another unit, or
/// recorded derivatives that would be used contradict the positions.
pub(crate) fn refusal(
    recording: &Recording,
    timing: &Timing,
    by_mapping: bool,
) -> Option<QualityIssue> {
    let step_s = timing.median_step_s;
    recording.joints.par_iter().find_map_first(|joint| {
        let found = of_joint(&recording.time_s, step_s, joint)?;
        if found.correlation.abs() < CORRELATED {
            return None;
        }
        let refused = |kind, quantity| {
            QualityIssue::of_channel(kind, Action::Refused, &joint.name, quantity, 1.0)
        };
        let how = if by_mapping { "in the mapping file" } else { "in a mapping file" };
        let unit = UNITS.iter().find(|unit| is_near(found.scale.abs(), unit.scale));
        if let Some((unit, position)) = unit.and_then(|unit| Some((unit, unit.position?))) {
            let message = format!(
                "position appears to be in {position} and velocity in {}: velocity is {:.3e} times \
                 the differentiated position (correlation {:.3})",
                unit.velocity,
                found.scale.abs(),
                found.correlation.abs()
            );
            let finding = refused(QualityIssueKind::SuspectedUnit, Quantity::Position);
            let advice = format!("set unit = \"{position}\" for the position {how}");
            return Some(finding.with_message(message).with_advice(advice));
        }
        // recorded derivatives are used where both are there: then they must be right
        joint.acceleration.as_ref()?;
        let (kind, what) = match unit {
            Some(unit) => (QualityIssueKind::VelocityScale, format!("appears to be in {}", unit.velocity)),
            None if is_near(found.scale, -1.0) => {
                (QualityIssueKind::VelocitySign, "has the opposite sign".to_owned())
            }
            None => return None,
        };
        let message = format!(
            "velocity {what}: {:.3} times the differentiated position (correlation {:.3}); it would \
             be used, because accelerations are recorded too",
            found.scale,
            found.correlation.abs()
        );
        let advice = format!(
            "set its unit or sign {how}, or remove the accelerations: then both are differentiated \
             from position"
        );
        Some(refused(kind, Quantity::Velocity).with_message(message).with_advice(advice))
    })
}

/// Findings on velocities that are not used: missing ones, and those that contradict the
/// differentiated position.
pub fn findings(recording: &Recording, timing: &Timing) -> Vec<QualityIssue> {
    let lacking: Vec<&str> = recording
        .joints
        .iter()
        .filter(|joint| joint.position.is_some() && joint.velocity.is_none())
        .map(|joint| joint.name.as_str())
        .collect();
    let mut findings = Vec::new();
    if !lacking.is_empty() {
        let share = lacking.len() as f64 / recording.joints.len() as f64;
        let message = format!(
            "no velocity columns ({}); velocities are differentiated from position",
            lacking.join(", ")
        );
        let finding =
            QualityIssue::of_stamps(QualityIssueKind::MissingVelocity, Action::Kept, share);
        findings.push(finding.with_message(message));
    }
    let of_joints = recording.joints.par_iter();
    let found =
        of_joints.filter_map(|joint| finding_of(&recording.time_s, timing.median_step_s, joint));
    findings.extend(found.collect::<Vec<_>>());
    findings
}

fn finding_of(time_s: &[f64], step_s: f64, joint: &JointChannels) -> Option<QualityIssue> {
    let kept =
        |kind| QualityIssue::of_channel(kind, Action::Kept, &joint.name, Quantity::Velocity, 1.0);
    let found = of_joint(time_s, step_s, joint)?;
    let (scale, correlation) = (found.scale, found.correlation);
    const NOT_USED: &str = "not used";
    if correlation.abs() < UNRELATED {
        let message = format!(
            "disagrees with the differentiated position (correlation {correlation:.2}); {NOT_USED}"
        );
        return Some(kept(QualityIssueKind::VelocityMismatch).with_message(message));
    }
    if correlation.abs() < CORRELATED {
        return None;
    }
    if is_near(scale, -1.0) {
        let message = format!("sign is opposite to the differentiated position; {NOT_USED}");
        let advice = "set sign = -1 for it in a mapping file to use it";
        return Some(
            kept(QualityIssueKind::VelocitySign).with_message(message).with_advice(advice),
        );
    }
    if !is_near(scale, 1.0) {
        let unit = UNITS.iter().find(|unit| is_near(scale.abs(), unit.scale));
        let cause = unit.map_or("motor side or another unit", |unit| unit.velocity);
        let message =
            format!("{scale:.4} times the differentiated position (probably {cause}); {NOT_USED}");
        let advice = "set its unit, or the gear ratio, in a mapping file to use it";
        return Some(
            kept(QualityIssueKind::VelocityScale).with_message(message).with_advice(advice),
        );
    }
    if found.delay_steps.abs() < 1.0 {
        return None;
    }
    let verb = if found.delay_s > 0.0 { "lags" } else { "leads" };
    let message = format!(
        "{verb} the differentiated position by {:.1} ms ({:.1} samples); {NOT_USED}",
        1e3 * found.delay_s.abs(),
        found.delay_steps.abs()
    );
    Some(kept(QualityIssueKind::VelocityDelay).with_message(message))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 200.0;

    /// Two sines, in steps of 1 mrad; the velocity `lag` samples later, in steps of 0.02 rad/s.
    fn swing(lag: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let time_s: Vec<f64> = (0..2000).map(|k| f64::from(k) / RATE_HZ).collect();
        let position = |t: f64| 0.8 * (2.0 * t).sin() + 0.1 * (9.0 * t).sin();
        let velocity = |t: f64| 1.6 * (2.0 * t).cos() + 0.9 * (9.0 * t).cos();
        let rounded = |value: f64, step: f64| (value / step).round() * step;
        (
            time_s.clone(),
            time_s.iter().map(|t| rounded(position(*t), 1e-3)).collect(),
            time_s.iter().map(|t| rounded(velocity(*t - lag / RATE_HZ), 0.02)).collect(),
        )
    }

    #[test]
    fn comparison_finds_scale_sign_and_delay() {
        for (factor, lag) in [(1.0, 0.0), (57.3, 0.0), (-1.0, 0.0), (1.0, 3.0), (-0.5, 5.5)] {
            let (time_s, position, mut velocity) = swing(lag);
            velocity.iter_mut().for_each(|v| *v *= factor);
            let found = compare(&time_s, 1.0 / RATE_HZ, &position, &velocity).unwrap();
            assert!((found.scale / factor - 1.0).abs() < 0.01, "{found:?}");
            assert!((found.delay_steps - lag).abs() < 0.2, "{found:?} for {lag}");
            assert!(found.correlation.abs() > 0.99);
        }
    }

    #[test]
    fn short_or_resting_channels_are_inconclusive() {
        let (time_s, position, velocity) = swing(0.0);
        assert!(compare(&time_s[..60], 1.0 / RATE_HZ, &position[..60], &velocity[..60]).is_none());
        assert!(compare(&time_s, 1.0 / RATE_HZ, &vec![0.3; 2000], &velocity).is_none());
        assert!(compare(&time_s, 1.0 / RATE_HZ, &position, &vec![0.0; 2000]).is_none());
        let huge = vec![1e300; 2000];
        assert!(compare(&time_s, 1.0 / RATE_HZ, &huge, &huge).is_none());
    }
}
