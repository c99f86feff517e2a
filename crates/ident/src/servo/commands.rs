//! Whether a column of commands is what its header states, and how far the position is behind it.
//!
//! Method: least squares of the position on the command moved by each lag, with a gain and an offset of each recording, or of blocks of
//! time where recordings are few. Their lags of the smallest residual have a median and its interval; recordings in which these three
//! leave much of the position have none. It is the lag that one reads off a plot, with what dry friction adds to it; the parameters
//! of the controller are separate.
//!
//! References: none beyond least squares.

use armident_inference::median_with_interval_95;
use armident_numeric::dot;
use armident_recording::Quantity;

use super::error::{CommandFault, ServoError};
use super::joint_data::JointData;
use super::request::ServoRequest;

/// Longest lag that is tried \[s\].
pub(super) const LONGEST_LAG_S: f64 = 0.5;
/// Fewest blocks: of so many the range is a 95 % interval of their median.
const FEWEST_BLOCKS: usize = 6;
/// Share of its variance that the position may have beside gain, offset and lag: where it has more, friction holds the joint in most
/// of the motion, and its lag means little.
const NOT_FOLLOWED: f64 = 0.05;

/// Lag of the position behind the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// Median over the recordings \[s\].
    pub value_s: f64,
    /// 95 % interval of the median \[s\].
    pub interval_95: Option<[f64; 2]>,
}

fn range(values: &[f64]) -> f64 {
    armident_numeric::range(values)
}

/// Refuses commands that are something else.
pub(super) fn check(data: &[JointData], joint: &str) -> Result<(), ServoError> {
    let fault = |fault, source: &str| {
        let (source_name, joint) = (source.to_owned(), joint.to_owned());
        Err(ServoError::Command { fault, source_name, joint })
    };
    if data.iter().all(|d| range(&d.command) <= d.resolution) {
        let source = data.first().map_or("", |d| d.source.as_str());
        return fault(CommandFault::Constant, source);
    }
    for d in data {
        let moves = range(&d.position) > 8.0 * d.resolution;
        let error = |c: &f64, q: &f64| (c - q).abs();
        let furthest = d.command.iter().zip(&d.position).map(|(c, q)| error(c, q));
        if moves && furthest.fold(0.0, f64::max) < 0.5 * d.resolution {
            return fault(CommandFault::Position, &d.source);
        }
        // a position of its command in another unit is a small part of it, in size and in range; friction takes a part of the
        // range, and an offset a part of the size, but not of both
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
        let ratio = (largest(&d.command) / largest(&d.position))
            .min(range(&d.command) / range(&d.position));
        let (deg, ticks) = if d.kind.is_rotational() {
            (180.0 / std::f64::consts::PI, 4096.0 / std::f64::consts::TAU)
        } else {
            (1000.0, f64::INFINITY)
        };
        // half way between two units, in logarithms
        if moves && ratio > (deg * ticks).sqrt() {
            return fault(CommandFault::Ticks, &d.source);
        }
        if moves && ratio > deg.sqrt() {
            return fault(CommandFault::OtherUnit, &d.source);
        }
    }
    Ok(())
}

/// Commands at other times, on lines.
fn delayed(d: &JointData, lag_s: f64) -> Vec<f64> {
    let last = d.time_s.len() - 1;
    let at = |t: f64| {
        let after = d.time_s.partition_point(|stamp| *stamp <= t).clamp(1, last);
        let (from, to) = (d.time_s[after - 1], d.time_s[after]);
        let share = ((t - from) / (to - from)).clamp(0.0, 1.0);
        d.command[after - 1] + share * (d.command[after] - d.command[after - 1])
    };
    d.time_s.iter().map(|t| at(t - lag_s)).collect()
}

fn about_mean(x: &[f64]) -> Vec<f64> {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    x.iter().map(|x| x - mean).collect()
}

/// Sum of squares of the position that an offset and the command do not explain, in a part of a recording.
fn residual_squares(command: &[f64], position: &[f64]) -> f64 {
    let (command, position) = (about_mean(command), about_mean(position));
    let total = dot(&position, &position);
    let size = dot(&command, &command);
    // a command that is constant explains nothing
    if size > 0.0 { total - dot(&command, &position).powi(2) / size } else { total }
}

fn lags(data: &[JointData]) -> Vec<f64> {
    let step_s = data.iter().map(|d| d.sample_s).fold(f64::INFINITY, f64::min) / 4.0;
    (0..=(LONGEST_LAG_S / step_s) as usize).map(|k| k as f64 * step_s).collect()
}

/// RMS error of the command itself with a gain, an offset and a lag that suit the recording best \[rad or m\].
pub(super) fn error_of_command(d: &JointData) -> f64 {
    let squares = lags(std::slice::from_ref(d));
    let squares = squares.iter().map(|lag| residual_squares(&delayed(d, *lag), &d.position));
    (squares.fold(f64::INFINITY, f64::min) / d.position.len() as f64).sqrt()
}

/// RMS of command minus position \[rad or m\].
pub(super) fn position_error(d: &JointData) -> f64 {
    let squares = d.command.iter().zip(&d.position).map(|(c, q)| (c - q).powi(2));
    (squares.sum::<f64>() / d.position.len() as f64).sqrt()
}

/// Median lag of the position behind the command; none where no command moves.
pub(super) fn lag(data: &[JointData]) -> Option<Lag> {
    let moves = |command: &[f64], d: &JointData| range(command) > 8.0 * d.resolution;
    let moving: Vec<&JointData> = data.iter().filter(|d| moves(&d.command, d)).collect();
    let parts = FEWEST_BLOCKS.div_ceil(moving.len().max(1));
    let of_recording = |d: &&JointData| -> Vec<f64> {
        let lags = lags(std::slice::from_ref(d));
        let commands: Vec<Vec<f64>> = lags.iter().map(|lag| delayed(d, *lag)).collect();
        let n = d.position.len();
        let blocks = (0..parts).map(|part| part * n / parts..(part + 1) * n / parts);
        let best = |of: std::ops::Range<usize>| -> Option<f64> {
            let position = &d.position[of.clone()];
            let left = |command: &Vec<f64>| residual_squares(&command[of.clone()], position);
            let squares: Vec<f64> = commands.iter().map(left).collect();
            let [least, _] = armident_numeric::extremes(squares.iter().copied());
            let about_mean = about_mean(position);
            let follows = least < NOT_FOLLOWED * dot(&about_mean, &about_mean);
            follows.then(|| Some(least_at(&squares)? * (lags[1] - lags[0])))?
        };
        blocks.filter(|of| moves(&d.command[of.clone()], d)).filter_map(best).collect()
    };
    let all: Vec<f64> = moving.iter().flat_map(of_recording).collect();
    let (value_s, interval_95) = median_with_interval_95(&all)?;
    Some(Lag { value_s, interval_95 })
}

/// Place of the least of some values, on the parabola through its neighbours; none at the last, beyond which it may be.
fn least_at(values: &[f64]) -> Option<f64> {
    let least = (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b]))?;
    if least == 0 {
        return Some(0.0);
    }
    let (a, b, c) = (values[least - 1], values[least], *values.get(least + 1)?);
    let curvature = a - 2.0 * b + c;
    Some(least as f64 + if curvature > 0.0 { 0.5 * (a - c) / curvature } else { 0.0 })
}

/// Joints whose current is never negative although command minus position has both signs for a tenth of the samples each.
pub(super) fn magnitudes(request: &ServoRequest<'_>, joints: &[&str]) -> Vec<String> {
    let is_magnitude = |joint: &&&str| {
        let (mut below, mut both, mut samples) = (0, [0_usize; 2], 0);
        for recording in request.train {
            let Some(channels) = recording.joint(joint) else { continue };
            let of = |quantity| channels.channel(quantity);
            let (Some(i), Some(c), Some(q)) =
                (of(Quantity::Current), of(Quantity::Command), of(Quantity::Position))
            else {
                return false;
            };
            below += i.iter().filter(|x| **x < 0.0).count();
            for (c, q) in c.iter().zip(q) {
                both[usize::from(c > q)] += 1;
                samples += 1;
            }
        }
        samples > 0 && below == 0 && both.iter().all(|count| 10 * count > samples)
    };
    joints.iter().filter(is_magnitude).map(|joint| (*joint).to_owned()).collect()
}
