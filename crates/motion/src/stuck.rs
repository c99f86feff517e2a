//! Steps of quantised channels, and values that repeat: stuck or saturated.

use std::cell::LazyCell;

use armident_numeric::{extremes, order_statistic, range};
use armident_recording::{
    Action, JointChannels, QualityIssue, QualityIssueKind, Quantity, Span, Timing, percent,
};

/// Range of positions below which a joint counts as resting \[rad or m\].
pub const RESTING_RANGE: f64 = 1e-3;
/// Shortest repetition that can be stuck \[s\]: slower updates than 10 Hz are a fault as well.
const STUCK_S: f64 = 0.1;
/// Fewest samples of a repetition that can be stuck.
const STUCK_SAMPLES: usize = 20;
/// A joint moves if its position changes by so many of its steps.
const MOVES_STEPS: f64 = 20.0;
/// Position and velocity contradict each other from this on \[rad or m\]: well above what play and
/// bent sensors make.
const LEAST_CONTRADICTION: f64 = 0.01;
/// A position that was held jumps by so many of its larger steps when it is let go.
const JUMP_STEPS: f64 = 5.0;
/// A joint whose encoder changes by no more of its steps rests.
const RESTING_STEPS: f64 = 2.0;
/// Fewest equal values of a flat top.
const FLAT_SAMPLES: usize = 5;
/// The signal runs into a limit with at least so many steps in one sample. A parabola that stays
/// within one step for five samples drops by 9/4 of it one sample further, rounded by 3 steps.
const ENTRY_STEPS: f64 = 3.5;
/// Share of a joint's range within which it rests: in five samples of a kilohertz a joint of a radian at a tenth of its
/// speed comes farther.
const AT_REST_SHARE: f64 = 1e-4;
/// Flat tops are reported from 3 of them on, or from one of this many samples.
const LONG_FLAT_SAMPLES: usize = 10;
const FEWEST_FLATS: usize = 3;
/// Share of the samples that must be at levels that others are at.
const REVISITED_SHARE: f64 = 0.1;
/// Share of the differences that must be whole multiples of the step.
const ON_STEPS_SHARE: f64 = 0.95;
/// How far a multiple may be from a whole one.
const OFF_STEP: f64 = 0.1;

/// The step in which values are quantised; none if they are finer than can be seen.
pub fn quantisation_step(values: &[f64]) -> Option<f64> {
    let mut levels = values.to_vec();
    levels.sort_unstable_by(f64::total_cmp);
    let (first, last) = (*levels.first()?, *levels.last()?);
    // levels that differ by less are one, rounded when they were written
    let resolution = 1e-6 * (last - first).max(first.abs()).max(last.abs());
    let mut differences: Vec<f64> = Vec::new();
    let mut level = first;
    for value in levels {
        if value - level > resolution {
            differences.push(value - level);
            level = value;
        }
    }
    // a ramp has even steps too, but comes to every level once
    let revisited = values.len().saturating_sub(differences.len() + 1);
    if differences.len() < 3 || (revisited as f64) < REVISITED_SHARE * values.len() as f64 {
        return None;
    }
    let mut sorted = differences.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let small = sorted[sorted.len() / 10];
    let near = || sorted.iter().filter(|d| (0.8..1.2).contains(&(*d / small)));
    let guess = near().sum::<f64>() / near().count() as f64;
    let multiples = differences.iter().map(|d| (d / guess).round());
    let total: f64 = multiples.clone().sum();
    let step = differences.iter().sum::<f64>() / total;
    let fits = |d: &&f64| {
        let multiple = *d / step;
        multiple > 0.5 && (multiple - multiple.round()).abs() < OFF_STEP
    };
    let on_steps = differences.iter().filter(fits).count() as f64;
    (step.is_finite() && on_steps >= ON_STEPS_SHARE * differences.len() as f64).then_some(step)
}

/// First and last sample of each run of equal values, if it has at least so many.
fn repetitions(values: &[f64], fewest: usize) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut from = 0;
    for k in 1..=values.len() {
        if k == values.len() || values[k] != values[from] {
            if k - from >= fewest {
                runs.push((from, k - 1));
            }
            from = k;
        }
    }
    runs
}

fn samples_in(runs: &[(usize, usize)]) -> usize {
    runs.iter().map(|(from, to)| to - from + 1).sum()
}

/// Channels of a joint that repeat a value although the joint moves.
pub(crate) fn stuck(time_s: &[f64], timing: &Timing, joint: &JointChannels) -> Vec<QualityIssue> {
    let Some(position) = joint.position.as_deref() else { return Vec::new() };
    let fewest = ((STUCK_S / timing.median_step_s).ceil() as usize).max(STUCK_SAMPLES);
    // steps take a sorted copy of the channel, and are mostly not needed
    let moved = LazyCell::new(|| {
        let step = quantisation_step(position).unwrap_or(0.0);
        (MOVES_STEPS * step).max(RESTING_RANGE)
    });
    let mut findings = Vec::new();
    for (quantity, values) in joint.channels() {
        let mut runs = repetitions(values, fewest);
        if runs.is_empty() {
            continue;
        }
        let moved = *moved;
        match quantity {
            Quantity::Position => retain_still(&mut runs, time_s, joint, moved),
            Quantity::Velocity => {
                let resolution = quantisation_step(values).unwrap_or(0.0);
                runs.retain(|&(from, to)| {
                    // the position that a constant velocity would lead to is missed
                    let missed = (from..=to).map(|k| {
                        let expected = values[from] * (time_s[k] - time_s[from]);
                        (position[k] - position[from] - expected).abs()
                    });
                    let explained = resolution * (time_s[to] - time_s[from]);
                    missed.fold(0.0, f64::max) > moved.max(LEAST_CONTRADICTION) + explained
                });
            }
            Quantity::Effort | Quantity::Current | Quantity::Voltage => {
                let [smallest, largest] = extremes(values.iter().copied());
                runs.retain(|&(from, to)| {
                    // at an end of the range it is saturated rather than stuck
                    let at_an_end = largest > smallest
                        && values[from] != 0.0
                        && (values[from] == largest || values[from] == smallest);
                    !at_an_end && range(&position[from..=to]) > moved
                });
            }
            _ => runs.clear(),
        }
        if runs.is_empty() {
            continue;
        }
        let share = samples_in(&runs) as f64 / values.len() as f64;
        let spans = Span::of_runs(time_s, &runs);
        let repeats = if runs.iter().all(|(from, _)| values[*from] == 0.0) {
            "is exactly 0"
        } else {
            "constant"
        };
        let message = format!(
            "{repeats} in {} of the samples while the joint moves: {}",
            percent(share),
            Span::describe(&spans)
        );
        let advice = match quantity {
            Quantity::Position | Quantity::Velocity => {
                "possible causes: sensor or bus failure. Cut these intervals"
            }
            _ => {
                "possible causes: drive off, channel not recorded, coarse resolution. Cut these \
                 intervals, or lock the joint"
            }
        };
        findings.push(
            QualityIssue::of_channel(
                QualityIssueKind::Stuck,
                Action::Kept,
                &joint.name,
                quantity,
                share,
            )
            .at(spans)
            .with_message(message)
            .with_advice(advice),
        );
    }
    findings
}

/// Keeps intervals of constant position with non-zero velocity, or that end in a jump.
fn retain_still(runs: &mut Vec<(usize, usize)>, time_s: &[f64], joint: &JointChannels, moved: f64) {
    let Some(position) = joint.position.as_deref() else { return runs.clear() };
    let moved = moved.max(LEAST_CONTRADICTION);
    let velocity = joint.velocity.as_deref();
    // a velocity at rest may be off by its step for long
    let resolution = LazyCell::new(|| velocity.and_then(quantisation_step).unwrap_or(0.0));
    let usual = LazyCell::new(|| {
        let mut steps: Vec<f64> =
            position.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        let place = steps.len() * 99 / 100;
        order_statistic(&mut steps, place).unwrap_or(0.0)
    });
    runs.retain(|&(from, to)| {
        let contradicted = velocity.is_some_and(|velocity| {
            // a filtered velocity goes on for a while after the joint has stopped
            let middle = (from + to) / 2;
            let steps = (middle..to)
                .map(|k| 0.5 * (velocity[k] + velocity[k + 1]) * (time_s[k + 1] - time_s[k]));
            let explained = *resolution * (time_s[to] - time_s[middle]);
            steps.sum::<f64>().abs() > moved + explained
        });
        let jump = position.get(to + 1).map_or(0.0, |next| (next - position[to]).abs());
        contradicted || jump > moved.max(JUMP_STEPS * *usual)
    });
}

/// Drive channels with flat tops.
pub(crate) fn saturated(time_s: &[f64], joint: &JointChannels) -> Vec<QualityIssue> {
    let drives = joint.channels().filter(|(quantity, _)| quantity.is_of_drive());
    let found = drives.filter_map(|(quantity, values)| {
        let mut runs = flat_tops(values);
        // at rest an effort may be constant
        if let Some(position) = joint.position.as_deref().filter(|_| !runs.is_empty()) {
            let step = quantisation_step(position).unwrap_or(0.0);
            let still = (RESTING_STEPS * step).max(AT_REST_SHARE * range(position));
            runs.retain(|&(from, to)| range(&position[from..=to]) > still);
        }
        let is_long = runs.iter().any(|(from, to)| to - from + 1 >= LONG_FLAT_SAMPLES);
        if runs.len() < FEWEST_FLATS && !is_long {
            return None;
        }
        let share = samples_in(&runs) as f64 / values.len() as f64;
        let spans = Span::of_runs(time_s, &runs);
        let [smallest, largest] = extremes(values.iter().copied());
        let limits: Vec<String> = [largest, smallest]
            .into_iter()
            .filter(|limit| runs.iter().any(|(from, _)| values[*from] == *limit))
            .map(|limit| limit.to_string())
            .collect();
        let message = format!(
            "at its limit of {} in {} of the samples: {}",
            limits.join(" and "),
            percent(share),
            Span::describe(&spans)
        );
        let advice =
            "saturated: the true value is larger. Cut these intervals, or move more gently";
        let finding = QualityIssue::of_channel(
            QualityIssueKind::Saturated,
            Action::Kept,
            &joint.name,
            quantity,
            share,
        );
        Some(finding.at(spans).with_message(message).with_advice(advice))
    });
    found.collect()
}

fn flat_tops(values: &[f64]) -> Vec<(usize, usize)> {
    let [smallest, largest] = extremes(values.iter().copied());
    let mut runs = repetitions(values, FLAT_SAMPLES);
    // zero is where a drive that is off rests
    runs.retain(|&(from, _)| {
        values[from] != 0.0 && (values[from] == largest || values[from] == smallest)
    });
    if runs.is_empty() {
        return runs;
    }
    let mut steps: Vec<f64> = values
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|step| *step > 0.0)
        .collect();
    let place = steps.len() / 20;
    let Some(smallest_step) = order_statistic(&mut steps, place) else { return Vec::new() };
    let step = quantisation_step(values).unwrap_or(smallest_step);
    let is_run_into = |&(from, to): &(usize, usize)| {
        let entry = from.checked_sub(1).map_or(0.0, |k| (values[k] - values[from]).abs());
        let exit = values.get(to + 1).map_or(0.0, |next| (next - values[to]).abs());
        entry.max(exit) >= ENTRY_STEPS * step
    };
    let limits: Vec<f64> =
        runs.iter().filter(|run| is_run_into(run)).map(|(from, _)| values[*from]).collect();
    runs.retain(|(from, _)| limits.contains(&values[*from]));
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(n: usize, amplitude: f64, step: f64) -> Vec<f64> {
        (0..n)
            .map(|k| {
                let x = amplitude * (0.013 * k as f64).sin();
                if step > 0.0 { (x / step).round() * step } else { x }
            })
            .collect()
    }

    #[test]
    fn steps_are_found_where_there_are_some() {
        for step in [1e-3, 1.534e-3, 0.02] {
            let found = quantisation_step(&sine(3000, 0.9, step)).unwrap();
            assert!((found / step - 1.0).abs() < 1e-3, "{found} for {step}");
        }
        for (values, what) in [
            (sine(3000, 0.9, 0.0), "smooth"),
            (sine(3000, 0.9, 1e-5), "finer than the samples"),
            (vec![1.0; 50], "constant"),
            (vec![], "nothing"),
            ((0..3000).map(|k| 0.01 * f64::from(k)).collect(), "ramp"),
            ((0..3000).map(|k| (f64::from(k % 700)).sqrt()).collect(), "uneven levels"),
        ] {
            assert_eq!(quantisation_step(&values), None, "{what}");
        }
    }

    #[test]
    fn smooth_peaks_are_no_flat_tops() {
        for step in [0.0, 1e-3, 0.05] {
            assert!(flat_tops(&sine(3000, 1.0, step)).is_empty(), "{step}");
        }
        let clipped: Vec<f64> = sine(3000, 1.0, 1e-3).iter().map(|x| x.clamp(-0.8, 0.7)).collect();
        let runs = flat_tops(&clipped);
        assert!(runs.len() >= 10, "{}", runs.len());
        let share = samples_in(&runs) as f64 / 3000.0;
        assert!((share - 0.45).abs() < 0.05, "{share}");
    }
}
