//! Whether a column of commands is what its header states, and how far the position is behind it.
//!
//! Method: least squares of the position on the command moved by each lag, with a gain, an offset and a side of the friction
//! band (the direction in which the command moved last) of each recording: without the last, a joint that is behind its command
//! because of dry friction looks late. The lag of the smallest residual, and its standard error by the jackknife over recordings or, of one recording, over blocks
//! of time.
//!
//! References: none beyond least squares.

use armident_inference::{FEWEST_BLOCKS, student_t_975, variance};
use armident_numeric::dot;
use armident_recording::Quantity;

use super::error::{CommandFault, ServoError};
use super::joint_data::JointData;
use super::request::ServoRequest;

/// Longest lag that is tried \[s\].
pub(super) const LONGEST_LAG_S: f64 = 0.5;
/// Share of its square below which a column is one of those before it.
const SAME: f64 = 1e-9;
/// Blocks of time of one recording.
const BLOCKS: usize = 8;

/// Lag of the position behind the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// \[s\].
    pub value_s: f64,
    /// 95 % interval \[s\]; none from fewer blocks than four.
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

/// Sum of squares of the position that an offset and these columns do not explain, in a part of a recording.
fn residual_squares<const N: usize>(columns: [&[f64]; N], position: &[f64]) -> f64 {
    let about_mean = |x: &[f64]| -> Vec<f64> {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        x.iter().map(|x| x - mean).collect()
    };
    let mut rest = about_mean(position);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns.map(about_mean) {
        let size = dot(&column, &column);
        let mut column = column;
        for other in &basis {
            subtract(&mut column, other);
        }
        // a command that is constant, or a direction that never changes, explains nothing
        if dot(&column, &column) > SAME * size.max(f64::EPSILON * column.len() as f64) {
            subtract(&mut rest, &column);
            basis.push(column);
        }
    }
    dot(&rest, &rest)
}

/// Leaves of `x` what is orthogonal to a column.
fn subtract(x: &mut [f64], column: &[f64]) {
    let share = dot(x, column) / dot(column, column);
    for (x, c) in x.iter_mut().zip(column) {
        *x -= share * c;
    }
}

/// Direction in which a command moved last, 0 before its first change.
fn directions(command: &[f64]) -> Vec<f64> {
    let mut last = 0.0;
    let mut before = command.first().copied().unwrap_or(0.0);
    let direction = |c: &f64| {
        if *c != before {
            last = (c - before).signum();
        }
        before = *c;
        last
    };
    command.iter().map(direction).collect()
}

fn lags(data: &[JointData]) -> Vec<f64> {
    let step_s = data.iter().map(|d| d.sample_s).fold(f64::INFINITY, f64::min) / 4.0;
    (0..=(LONGEST_LAG_S / step_s) as usize).map(|k| k as f64 * step_s).collect()
}

/// RMS error of the command itself with a gain, an offset and a lag that suit the recording best \[rad or m\].
pub(super) fn error_of_command(d: &JointData) -> f64 {
    let squares = lags(std::slice::from_ref(d));
    let squares = squares.iter().map(|lag| residual_squares([&delayed(d, *lag)], &d.position));
    (squares.fold(f64::INFINITY, f64::min) / d.position.len() as f64).sqrt()
}

/// RMS of command minus position \[rad or m\].
pub(super) fn position_error(d: &JointData) -> f64 {
    let squares = d.command.iter().zip(&d.position).map(|(c, q)| (c - q).powi(2));
    (squares.sum::<f64>() / d.position.len() as f64).sqrt()
}

/// Lag of the position behind the command in all recordings together; none where no command moves.
pub(super) fn lag(data: &[JointData]) -> Option<Lag> {
    let moving: Vec<&JointData> =
        data.iter().filter(|d| range(&d.command) > 8.0 * d.resolution).collect();
    if moving.is_empty() {
        return None;
    }
    let lags = lags(data);
    let parts = if moving.len() < FEWEST_BLOCKS { BLOCKS } else { 1 };
    // `[block][lag]`
    let mut blocks: Vec<Vec<f64>> = Vec::new();
    for d in &moving {
        let commands: Vec<[Vec<f64>; 2]> = (lags.iter().map(|lag| delayed(d, *lag)))
            .map(|command| [directions(&command), command])
            .collect();
        let n = d.position.len();
        for part in 0..parts {
            let of = part * n / parts..(part + 1) * n / parts;
            let squares = |[direction, command]: &[Vec<f64>; 2]| {
                let columns = [&command[of.clone()], &direction[of.clone()]];
                residual_squares(columns, &d.position[of.clone()])
            };
            blocks.push(commands.iter().map(squares).collect());
        }
    }
    let best = |without: Option<usize>| -> f64 {
        let total = |k: usize| -> f64 {
            let used = blocks.iter().enumerate().filter(|(b, _)| Some(*b) != without);
            used.map(|(_, block)| block[k]).sum()
        };
        let totals: Vec<f64> = (0..lags.len()).map(total).collect();
        let least = (0..lags.len()).min_by(|a, b| totals[*a].total_cmp(&totals[*b])).unwrap_or(0);
        // the parabola through the neighbours
        match least {
            k if k > 0 && k + 1 < lags.len() => {
                let (a, b, c) = (totals[k - 1], totals[k], totals[k + 1]);
                let curvature = a - 2.0 * b + c;
                let share = if curvature > 0.0 { 0.5 * (a - c) / curvature } else { 0.0 };
                lags[k] + share * (lags[1] - lags[0])
            }
            k => lags[k],
        }
    };
    let value_s = best(None);
    let interval_95 = (blocks.len() >= FEWEST_BLOCKS).then(|| {
        let left_out: Vec<f64> = (0..blocks.len()).map(|b| best(Some(b))).collect();
        let half = student_t_975((blocks.len() - 1) as f64) * variance(&left_out).sqrt();
        [(value_s - half).max(0.0), value_s + half]
    });
    Some(Lag { value_s, interval_95 })
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
