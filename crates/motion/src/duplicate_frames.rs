//! Frames that repeat the one before them while the arm moves.
//!
//! A logger that asks at its own rate gets a frame twice now and then. Either the frame is old and the motion goes on
//! unseen, so that the next one is two steps ahead: then the repetition is left out. Or a frame was put in to fill up a
//! rate, as in films, and the next one is one step ahead: then the clock stood. Read as it is, either is a jump of all
//! speeds by half or whole, which no arm can do.

use armident_numeric::order_statistic;
use armident_recording::{Action, QualityIssue, QualityIssueKind, Recording, Span, percent};

/// Frames before and after in which the arm must move steadily.
const STEADY: usize = 3;
/// Two successive steps of a steady motion differ by less than this share.
const SAME_STEP: f64 = 0.3;
/// Steps ahead after a repetition: up to the first one the clock stood, from the second on the frame was old.
const CLOCK_STOOD: f64 = 1.25;
const WAS_OLD: f64 = 1.6;
/// Share of the frames above which repetitions are how the recording was made, and no exception.
const MOST: f64 = 0.1;

/// What a repetition means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// The motion went on: the frame is not used.
    Old,
    /// The motion stood, and so did the clock.
    Inserted,
    /// Neither is clear.
    Unknown,
}

/// The repetitions of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RepeatedFrames {
    /// increasing
    pub(crate) frames: Vec<usize>,
    pub(crate) meaning: Meaning,
}

impl RepeatedFrames {
    /// None where no frame repeats in motion.
    pub(crate) fn of(recording: &Recording) -> Option<Self> {
        let channels: Vec<&[f64]> =
            recording.joints.iter().flat_map(|j| j.channels().map(|(_, values)| values)).collect();
        let positions: Vec<&[f64]> =
            recording.joints.iter().filter_map(|joint| joint.position.as_deref()).collect();
        let n = recording.len();
        let repeats = |k: usize| channels.iter().all(|values| values[k] == values[k - 1]);
        let mut frames = Vec::new();
        let mut ahead = Vec::new();
        for k in STEADY + 1..n.saturating_sub(STEADY + 1) {
            if repeats(k)
                && let Some(steps) = steps_ahead(&positions, k)
            {
                frames.push(k);
                ahead.push(steps);
            }
        }
        if frames.is_empty() || frames.len() as f64 > MOST * n as f64 {
            return None;
        }
        let middle = ahead.len() / 2;
        let meaning = match order_statistic(&mut ahead, middle)? {
            steps if steps < CLOCK_STOOD => Meaning::Inserted,
            steps if steps > WAS_OLD => Meaning::Old,
            _ => Meaning::Unknown,
        };
        Some(Self { frames, meaning })
    }

    /// The clock of the motion, a time for every frame, and the frames that are used; none where the stamps are used as
    /// they are.
    pub(crate) fn clock(&self, time_s: &[f64]) -> Option<(Vec<f64>, Vec<usize>)> {
        if self.meaning == Meaning::Unknown {
            return None;
        }
        let is_repeated = |k: &usize| self.frames.binary_search(k).is_ok();
        let used = (0..time_s.len()).filter(|k| !is_repeated(k)).collect();
        let mut stood_s = 0.0;
        let clock = (0..time_s.len())
            .map(|k| {
                if self.meaning == Meaning::Inserted && is_repeated(&k) {
                    stood_s += time_s[k] - time_s[k - 1];
                }
                time_s[k] - stood_s
            })
            .collect();
        Some((clock, used))
    }

    /// The finding on them.
    pub(crate) fn finding(&self, time_s: &[f64]) -> QualityIssue {
        let share = self.frames.len() as f64 / time_s.len() as f64;
        let action = match self.meaning {
            Meaning::Unknown => Action::Kept,
            _ => Action::Repaired,
        };
        let mut finding = QualityIssue::of_stamps(QualityIssueKind::RepeatedFrames, action, share);
        let runs: Vec<(usize, usize)> = self.frames.iter().map(|k| (*k, *k)).collect();
        finding.spans = Span::of_runs(time_s, &runs);
        let action = match self.meaning {
            Meaning::Old => "dropped (the next frame is two periods ahead)",
            Meaning::Inserted => "clock pause removed (the next frame is one period ahead)",
            Meaning::Unknown => "kept (ambiguous)",
        };
        finding.message = format!(
            "{} duplicate frames while the arm moves ({}); {action}",
            percent(share),
            Span::describe(&finding.spans)
        );
        finding
    }
}

/// How many steps the arm is ahead after a frame that repeats; none unless some joint moves steadily around it.
fn steps_ahead(positions: &[&[f64]], frame: usize) -> Option<f64> {
    let (mut ahead, mut usual) = (0.0, 0.0);
    for position in positions {
        let step = |k: usize| position[k] - position[k - 1];
        let before: Vec<f64> = (frame - STEADY..frame).map(step).collect();
        let after: Vec<f64> = (frame + 2..frame + 2 + STEADY - 1).map(step).collect();
        let is_steady = |steps: &[f64]| {
            steps.windows(2).all(|s| (s[1] - s[0]).abs() < SAME_STEP * s[0].abs() && s[0] != 0.0)
        };
        if !is_steady(&before) || !is_steady(&after) {
            continue;
        }
        let mean = 0.5 * (before[STEADY - 1] + after[0]);
        // what turns around here says nothing
        if mean * before[0] <= 0.0 || mean * after[0] <= 0.0 {
            continue;
        }
        ahead += step(frame + 1).abs();
        usual += mean.abs();
    }
    (usual > 0.0).then(|| ahead / usual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::EvenGrid;
    use armident_recording::JointChannels;

    const STEP_S: f64 = 0.02;

    fn motion(t: f64) -> f64 {
        0.8 * (1.3 * t).sin()
    }

    /// Frames at these times of the motion, stamped evenly.
    fn recorded(times: &[f64]) -> Recording {
        let mut joint = JointChannels::new("a");
        joint.position = Some(times.iter().map(|t| motion(*t)).collect());
        joint.effort = Some(times.iter().map(|t| (2.0 * t).cos()).collect());
        let stamps = (0..times.len()).map(|k| k as f64 * STEP_S).collect();
        Recording::new("made", stamps, vec![joint]).unwrap()
    }

    /// Largest second difference of the position on the even grid.
    fn roughness(recording: &Recording) -> f64 {
        let grid = EvenGrid::of(recording).unwrap();
        let position = grid.resample(recording.joints[0].position.as_ref().unwrap());
        let second = |q: &[f64]| (q[2] - 2.0 * q[1] + q[0]).abs();
        position.windows(3).map(second).fold(0.0, f64::max)
    }

    #[test]
    fn a_clock_that_stood_and_frames_that_are_old() {
        let even: Vec<f64> = (0..200).map(|k| f64::from(k) * STEP_S).collect();
        let smooth = roughness(&recorded(&even));
        assert!(RepeatedFrames::of(&recorded(&even)).is_none());
        let mut inserted = even.clone();
        inserted.insert(40, even[39]);
        inserted.insert(90, inserted[89]);
        let mut old = even.clone();
        (old[40], old[90]) = (even[39], even[89]);
        for (times, meaning) in [(inserted, Meaning::Inserted), (old, Meaning::Old)] {
            let recording = recorded(&times);
            let found = RepeatedFrames::of(&recording).unwrap();
            assert_eq!((found.frames.as_slice(), found.meaning), (&[40, 90][..], meaning));
            assert!(
                found.finding(&recording.time_s).message.contains("2 times, first at t = 0.800 s")
            );
            assert!(roughness(&recording) < 1.5 * smooth, "{meaning:?}");
            // every frame gets its value back
            let grid = EvenGrid::of(&recording).unwrap();
            let position = recording.joints[0].position.as_ref().unwrap();
            let back = grid.at_stamps(&grid.resample(position));
            assert_eq!(back.len(), position.len());
            let off = |k: usize| (back[k] - position[k]).abs();
            let repeated = |k: &usize| meaning == Meaning::Old && [40, 90].contains(k);
            let largest = (0..back.len()).filter(|k| !repeated(k)).map(off).fold(0.0, f64::max);
            assert!(largest < 1e-4, "{meaning:?}: {largest}");
            assert_eq!(grid.stamps_s(), recording.time_s);
        }
    }

    /// Rest, coarse encoders and logs that hold every sample twice are no exceptions.
    #[test]
    fn what_repeats_anyway_is_left_alone() {
        let held: Vec<f64> = (0..200).map(|k| f64::from(k / 2) * STEP_S).collect();
        assert!(RepeatedFrames::of(&recorded(&held)).is_none());
        let resting: Vec<f64> = (0..200).map(|k| f64::from(k.min(100)) * STEP_S).collect();
        assert!(RepeatedFrames::of(&recorded(&resting)).is_none());
        let mut coarse = recorded(&held);
        coarse.joints[0].effort = None;
        let position = coarse.joints[0].position.as_mut().unwrap();
        position.iter_mut().for_each(|q| *q = (*q / 0.03).round() * 0.03);
        assert!(RepeatedFrames::of(&coarse).is_none());
    }
}
