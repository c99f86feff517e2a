//! Efforts that a driver renews at a lower rate than the rows of the log.
//!
//! Between two renewals an effort is old: compared with the motion of its row it lags by up to a whole period, which looks like
//! a memory of the joint. Only the rows in which efforts are renewed show something of them.

use armident_numeric::order_statistic;
use armident_recording::{
    Action, JointChannels, QualityIssue, QualityIssueKind, Quantity, Recording,
};

/// Rows per renewal from which on it is material: below, an effort is not older than the half of a row on average.
const LEAST_HELD: f64 = 1.5;
/// Fewest renewals.
const FEWEST: usize = 20;
/// Share of the renewals that come after the usual number of rows. Of channels that repeat because they are coarse it is
/// about a half.
const REGULAR_SHARE: f64 = 0.9;
/// The usual number of rows is met to one from so many on: the driver's clock is not that of the log.
const LOOSE: f64 = 4.0;
/// Share of the renewals in which a joint of them all (the median) has another value: one driver renews all.
const TOGETHER_SHARE: f64 = 0.5;
/// A coarse channel on a slope changes by one count at a time. The changes of a held one are larger than this many of its
/// smallest in at least half of the renewals.
const COUNTS: f64 = 1.5;
const COUNT_SHARE: f64 = 0.5;

/// The rows of a recording in which held efforts are renewed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeldEfforts {
    /// increasing
    pub(crate) renewed: Vec<usize>,
    rows: usize,
    duration_s: f64,
}

impl HeldEfforts {
    /// None where efforts are renewed in every row, or unevenly.
    pub(crate) fn of(recording: &Recording) -> Option<Self> {
        let efforts: Vec<&[f64]> = recording.joints.iter().filter_map(drive).collect();
        let changes = |k: usize| efforts.iter().filter(|e| e[k] != e[k - 1]).count();
        let n = recording.len();
        let renewed: Vec<usize> = (1..n).filter(|k| changes(*k) > 0).collect();
        if renewed.len() < FEWEST {
            return None;
        }
        let gaps: Vec<usize> = renewed.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // the mean of what is usual: rests without noise are long
        let mut sorted = gaps.clone();
        sorted.sort_unstable();
        let median = sorted[sorted.len() / 2];
        let near: Vec<usize> = sorted.iter().copied().filter(|gap| *gap <= 2 * median).collect();
        let usual = near.iter().sum::<usize>() as f64 / near.len() as f64;
        let slack = if usual >= LOOSE { 1.0 } else { 0.0 };
        let (least, largest) = (usual.floor() - slack, usual.ceil() + slack);
        let regular = gaps.iter().filter(|gap| (least..=largest).contains(&(**gap as f64))).count();
        if usual < LEAST_HELD || (regular as f64) < REGULAR_SHARE * gaps.len() as f64 {
            return None;
        }
        let mut together: Vec<f64> = (efforts.iter())
            .map(|effort| {
                let own = renewed.iter().filter(|k| effort[**k] != effort[**k - 1]).count();
                own as f64 / renewed.len() as f64
            })
            .collect();
        let middle = together.len() / 2;
        let is_one_driver = order_statistic(&mut together, middle)? >= TOGETHER_SHARE;
        let is_large = |effort: &&[f64]| {
            let step = |k: &usize| (effort[*k] - effort[*k - 1]).abs();
            let steps: Vec<f64> = renewed.iter().map(step).filter(|step| *step > 0.0).collect();
            let smallest = steps.iter().copied().fold(f64::MAX, f64::min);
            let large = steps.iter().filter(|step| **step > COUNTS * smallest).count();
            large as f64 >= COUNT_SHARE * renewed.len() as f64
        };
        let duration_s = recording.time_s[n - 1] - recording.time_s[0];
        (is_one_driver && efforts.iter().any(is_large)).then_some(Self {
            renewed,
            rows: n,
            duration_s,
        })
    }

    /// The recording in the rows in which efforts are renewed.
    pub(crate) fn only_renewed(&self, recording: &Recording) -> Recording {
        let rows = |values: &[f64]| self.renewed.iter().map(|k| values[*k]).collect::<Vec<f64>>();
        let mut renewed = recording.clone();
        renewed.time_s = rows(&recording.time_s);
        for joint in &mut renewed.joints {
            for quantity in Quantity::ALL {
                let channel = joint.channel_mut(quantity);
                *channel = channel.as_deref().map(rows);
            }
        }
        renewed
    }

    /// The finding on them.
    pub(crate) fn finding(&self) -> QualityIssue {
        let rows = self.rows as f64;
        let span = self.renewed[self.renewed.len() - 1] - self.renewed[0];
        let every = span as f64 / (self.renewed.len() - 1) as f64;
        let rows_hz = (rows - 1.0) / self.duration_s;
        let message = format!(
            "efforts are renewed in one of {:.1} rows only ({:.1} Hz, rows at {:.1} Hz) and held between; only these rows are used",
            every,
            rows_hz / every,
            rows_hz
        );
        let share = 1.0 - self.renewed.len() as f64 / rows;
        QualityIssue::of_stamps(QualityIssueKind::HeldEfforts, Action::Repaired, share)
            .with_message(message)
            .with_advice("let the driver read efforts as often as positions")
    }
}

/// The effort of a joint, or the signal of its drive.
fn drive(joint: &JointChannels) -> Option<&[f64]> {
    joint.effort.as_deref().or(joint.current.as_deref()).or(joint.voltage.as_deref())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::EvenGrid;

    /// Uniform deviates around 0.
    fn uniform(n: usize) -> Vec<f64> {
        let mut state = 11_u64;
        (0..n)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
            })
            .collect()
    }

    /// Two joints at 50 Hz whose efforts are those of these rows, in counts of so much.
    fn recording(row_of: impl Fn(usize) -> usize, count: f64) -> Recording {
        let n = 1000;
        let noise = uniform(2 * n);
        let time_s: Vec<f64> = (0..n).map(|k| 0.02 * k as f64).collect();
        let joint = |j: usize| {
            let mut joint = JointChannels::new(["a", "b"][j]);
            joint.position = Some(time_s.iter().map(|t| ((1.0 + j as f64) * t).sin()).collect());
            let effort =
                |k: usize| 5.0 * (1.3 * time_s[k] + j as f64).cos() + 0.1 * noise[j * n + k];
            let rounded = |e: f64| if count > 0.0 { (e / count).round() * count } else { e };
            joint.effort = Some((0..n).map(|k| rounded(effort(row_of(k)))).collect());
            joint
        };
        Recording::new("made", time_s.clone(), vec![joint(0), joint(1)]).unwrap()
    }

    #[test]
    fn renewed_rows_are_found_and_used() {
        for (held, text) in [
            (25, "one of 25.0 rows"),
            (6, "one of 6.0 rows only (8.3 Hz, rows at 50.0 Hz)"),
            (2, "one of 2.0 rows"),
        ] {
            let recording = recording(|k| k / held * held, 1e-3);
            let found = HeldEfforts::of(&recording).unwrap();
            assert_eq!(found.renewed[..2], [held, 2 * held]);
            let message = found.finding().message;
            assert!(message.contains(text), "{message}");
            let grid = EvenGrid::of(&recording).unwrap();
            assert!((grid.rate_hz() * held as f64 / 50.0 - 1.0).abs() < 1e-6, "{}", grid.rate_hz());
            assert_eq!(grid.stamps_s(), recording.time_s);
            assert!(grid.unmeasured_s(0.0).is_empty());
            let found = crate::findings(&recording);
            let kinds = [QualityIssueKind::Stuck, QualityIssueKind::Saturated];
            assert!(!found.iter().any(|finding| kinds.contains(&finding.kind)), "{found:?}");
            let position = recording.joints[0].position.as_ref().unwrap();
            let back = grid.at_stamps(&grid.resample(position));
            let off = |k: usize| (back[k] - position[k]).abs();
            assert!(held > 6 || (held..990).map(off).fold(0.0, f64::max) < 1e-4);
        }
        // 50 Hz rows of a driver at 20 Hz
        let uneven = recording(|k| (k as f64 / 2.5).floor() as usize * 5 / 2, 0.0);
        assert!(HeldEfforts::of(&uneven).is_some());
    }

    #[test]
    fn coarse_resting_and_renewed_efforts_are_not_held() {
        for count in [0.0, 0.05, 0.3, 1.0] {
            assert_eq!(HeldEfforts::of(&recording(|k| k, count)), None, "{count}");
        }
        assert_eq!(HeldEfforts::of(&recording(|k| k.min(100), 0.0)), None);
        assert_eq!(HeldEfforts::of(&recording(|_| 0, 0.0)), None);
        // a ramp in counts
        let mut ramp = recording(|k| k, 0.0);
        for joint in &mut ramp.joints {
            joint.effort = Some((0..1000).map(|k| f64::from(k / 10)).collect());
        }
        assert_eq!(HeldEfforts::of(&ramp), None);
    }
}
