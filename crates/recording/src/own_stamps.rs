//! Channels whose values stand in rows of their own stamps: several publishers in one file.

use crate::interpolation::{BRIDGED_STEPS, Interpolation};
use crate::limits::{MIN_SAMPLES, MISSING_RUN, MISSING_SHARE};
use crate::timing::Timing;

/// Longest run of rows without a value of a channel, over the usual one, at which the others are still rows of another
/// publisher and no failure of this one.
const LONGEST_RUN: usize = 4;
/// Share of the rows of one publisher that have no value of another.
const MOSTLY: f64 = 0.5;
/// Share of the rows in which two channels must both have or both lack a value to be of one publisher.
const SAME_PUBLISHER: f64 = 0.98;

/// Rows of positions over those of efforts from which on the latter are kept: their values at more stamps are no more
/// measurements.
const SLOWER: f64 = 1.5;

/// A channel before the rows are merged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cells<'a> {
    pub(crate) is_position: bool,
    /// an effort, or the current or voltage of a drive
    pub(crate) is_drive: bool,
    /// NaN where there is none.
    pub(crate) values: &'a [f64],
}

/// Rows of one publisher, with the values of the others at their stamps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Merged {
    /// A channel of the publisher whose rows are kept: that of most positions, or of efforts that come much less often.
    pub(crate) base: usize,
    /// The rows that are kept, within the span of the other channels.
    pub(crate) rows: Vec<usize>,
    /// Channels of other publishers, and their values at the rows that are kept.
    pub(crate) interpolated: Vec<(usize, Vec<f64>)>,
}

impl Merged {
    /// None if all channels are of one publisher, or if values are missing otherwise.
    pub(crate) fn of(time_s: &[f64], channels: &[Cells<'_>]) -> Option<Self> {
        let n = time_s.len();
        let lacks = |cells: &Cells<'_>, rows: &[usize]| {
            let missing = rows.iter().filter(|k| cells.values[**k].is_nan()).count();
            missing as f64 > MISSING_SHARE * rows.len() as f64
        };
        let all: Vec<usize> = (0..n).collect();
        if !channels.iter().any(|cells| lacks(cells, &all)) {
            return None;
        }
        let base = base(channels)?;
        let rows: Vec<usize> = (0..n).filter(|k| !channels[base].values[*k].is_nan()).collect();
        let others: Vec<usize> =
            (0..channels.len()).filter(|c| lacks(&channels[*c], &rows)).collect();
        // rows without any value are those of other topics
        let is_blank = |k: usize| channels.iter().all(|cells| cells.values[k].is_nan());
        let is_kept = |k: &usize| !channels[base].values[*k].is_nan();
        if others.is_empty() && (rows.len() == n || !(0..n).all(|k| is_kept(&k) || is_blank(k))) {
            return None;
        }
        let mut series = Vec::with_capacity(others.len());
        for channel in others {
            let values = channels[channel].values;
            let own: Vec<usize> = (0..n).filter(|k| !values[*k].is_nan()).collect();
            // rows of two publishers are rarely the same, or one of them comes less often
            let missing = rows.iter().filter(|k| values[**k].is_nan()).count();
            let is_other = missing as f64 >= MOSTLY * rows.len() as f64;
            if !is_other || !is_regular(&own) {
                return None;
            }
            let stamps: Vec<f64> = own.iter().map(|k| time_s[*k]).collect();
            series.push((channel, own, stamps));
        }
        let first_s = series.iter().map(|(_, _, stamps)| stamps[0]).fold(f64::MIN, f64::max);
        let last_s =
            series.iter().map(|(_, _, stamps)| stamps[stamps.len() - 1]).fold(f64::MAX, f64::min);
        let rows: Vec<usize> =
            rows.into_iter().filter(|k| (first_s..=last_s).contains(&time_s[*k])).collect();
        let kept_s: Vec<f64> = rows.iter().map(|k| time_s[*k]).collect();
        let interpolated = (series.into_iter())
            .map(|(channel, own, stamps)| {
                let longest_s = BRIDGED_STEPS * Timing::of(&stamps).median_step_s;
                let values: Vec<f64> = own.iter().map(|k| channels[channel].values[*k]).collect();
                (channel, Interpolation::new(&stamps, &kept_s, longest_s).apply(&values))
            })
            .collect();
        Some(Self { base, rows, interpolated })
    }
}

/// The channel in whose rows most positions stand, of several the one with most rows.
fn base(channels: &[Cells<'_>]) -> Option<usize> {
    let agree = |a: &Cells<'_>, b: &Cells<'_>| {
        let pairs = a.values.iter().zip(b.values);
        let same = pairs.filter(|(x, y)| x.is_nan() == y.is_nan()).count();
        same as f64 >= SAME_PUBLISHER * a.values.len() as f64
    };
    let rank = |c: &usize| {
        let own = &channels[*c];
        let together = channels.iter().filter(|other| other.is_position && agree(own, other));
        let rows = own.values.iter().filter(|value| !value.is_nan()).count();
        (together.count(), rows, std::cmp::Reverse(*c))
    };
    let base = (0..channels.len()).filter(|c| channels[*c].is_position).max_by_key(rank)?;
    // positions between samples are known better than efforts, which have noise and jump
    let rows = |c: &usize| channels[*c].values.iter().filter(|value| !value.is_nan()).count();
    let drives = (0..channels.len()).filter(|c| channels[*c].is_drive);
    let slowest = drives.min_by_key(rows);
    Some(slowest.filter(|c| SLOWER * rows(c) as f64 <= rows(&base) as f64).unwrap_or(base))
}

/// Whether the rows without a value come about as regularly as those of another publisher.
fn is_regular(own: &[usize]) -> bool {
    if own.len() < MIN_SAMPLES {
        return false;
    }
    let mut runs: Vec<usize> = own.windows(2).map(|pair| pair[1] - pair[0] - 1).collect();
    runs.sort_unstable();
    let usual = runs[runs.len() / 2].max(1);
    runs[runs.len() - 1] <= (LONGEST_RUN * usual).max(MISSING_RUN)
}

/// Which rows with equal stamps are one, of cells that do not contradict each other: for each row, the first of its stamp.
pub(crate) fn one_stamp_one_row(time_s: &[f64], channels: &[&[f64]]) -> Vec<usize> {
    let mut first: Vec<usize> = (0..time_s.len()).collect();
    for k in 1..time_s.len() {
        let before = first[k - 1];
        let in_rows = before..k;
        let is_free =
            |values: &&[f64]| values[k].is_nan() || in_rows.clone().all(|row| values[row].is_nan());
        if time_s[k] == time_s[before] && channels.iter().all(is_free) {
            first[k] = before;
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f64 = f64::NAN;

    /// Stamps and cells of two publishers: positions at 50 Hz, efforts every so many of them, 3.7 ms later.
    fn rows(every: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (mut time_s, mut position, mut effort) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..400 {
            let t = 0.02 * f64::from(k);
            time_s.push(t);
            position.push((1.3 * t).sin());
            effort.push(NONE);
            if (k as usize).is_multiple_of(every) {
                time_s.push(t + 0.0037);
                position.push(NONE);
                effort.push((1.3 * (t + 0.0037)).cos());
            }
        }
        (time_s, position, effort)
    }

    fn cells<'a>(position: &'a [f64], effort: &'a [f64]) -> [Cells<'a>; 2] {
        [
            Cells { is_position: true, is_drive: false, values: position },
            Cells { is_position: false, is_drive: true, values: effort },
        ]
    }

    #[test]
    fn channels_meet_on_the_stamps_of_positions() {
        let (time_s, position, effort) = rows(1);
        let merged = Merged::of(&time_s, &cells(&position, &effort)).unwrap();
        assert!(merged.rows.len() >= 396 && merged.rows.iter().all(|k| !position[*k].is_nan()));
        let [(1, values)] = &merged.interpolated[..] else { panic!("{:?}", merged.interpolated) };
        for (k, effort) in merged.rows.iter().zip(values) {
            assert!((effort - (1.3 * time_s[*k]).cos()).abs() < 1e-5);
        }
    }

    #[test]
    fn channels_meet_on_the_stamps_of_slow_efforts() {
        let (time_s, position, effort) = rows(3);
        let merged = Merged::of(&time_s, &cells(&position, &effort)).unwrap();
        assert!(merged.rows.len() >= 132 && merged.rows.iter().all(|k| !effort[*k].is_nan()));
        let [(0, values)] = &merged.interpolated[..] else { panic!("{:?}", merged.interpolated) };
        for (k, position) in merged.rows.iter().zip(values) {
            assert!((position - (1.3 * time_s[*k]).sin()).abs() < 1e-6);
        }
    }

    #[test]
    fn other_missing_values_are_no_publisher() {
        let (time_s, position, effort) = rows(1);
        let whole: Vec<f64> = time_s.iter().map(|t| t.sin()).collect();
        assert_eq!(Merged::of(&time_s, &cells(&whole, &whole)), None);
        // a second without effort
        let mut failing = whole.clone();
        failing[300..350].fill(NONE);
        assert_eq!(Merged::of(&time_s, &cells(&whole, &failing)), None);
        let mut broken = effort.clone();
        broken[300..350].fill(NONE);
        assert_eq!(Merged::of(&time_s, &cells(&position, &broken)), None);
    }

    #[test]
    fn rows_of_one_stamp_are_one() {
        let (a, b) = ([1.0, NONE, 2.0, NONE, 3.0, 4.0], [NONE, 5.0, NONE, 6.0, NONE, NONE]);
        let time_s = [0.0, 0.0, 1.0, 2.0, 3.0, 3.0];
        assert_eq!(one_stamp_one_row(&time_s, &[&a, &b]), [0, 0, 2, 3, 4, 5]);
    }
}
