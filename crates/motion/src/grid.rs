//! From uneven stamps to an even grid and back.

use armident_recording::{
    BRIDGED_STEPS, Fault, Gap, Interpolation, Quantity, Recording, RecordingError, Timing,
};

use crate::duplicate_frames::RepeatedFrames;
use crate::held_efforts::HeldEfforts;
use crate::sampling_clock::SamplingClock;
use crate::stuck::saturated;

/// Grid samples per recorded sample above which a recording is mostly gap.
const MOST_GRID_SAMPLES: f64 = 2.0;

/// The even grid of a recording, and the way back to its stamps.
#[derive(Debug, Clone, PartialEq)]
pub struct EvenGrid {
    timing: Timing,
    rate_hz: f64,
    stamps_s: Vec<f64>,
    time_s: Vec<f64>,
    /// Absent where the stamps are even already.
    ways: Option<(Interpolation, Interpolation)>,
    /// samples that are used, where some are not
    used: Option<Vec<usize>>,
    /// where the stamps are those of reception
    clock: Option<SamplingClock>,
    /// times in which efforts are not what was measured
    unmeasured: Vec<Unmeasured>,
}

/// A time in which the values on the grid are no measurements, on the clock of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Unmeasured {
    from_s: f64,
    to_s: f64,
    /// Positions are lacking as well: what is filtered is wrong before and after it.
    is_gap: bool,
}

/// Largest share of a recording in saturation that is left out: above, the limit is how the arm was driven.
const SATURATED_SHARE: f64 = 0.1;

impl EvenGrid {
    /// From the first to the last stamp, at the median rate to within half a step in the whole
    /// duration, so that the grid ends on the last stamp. Even stamps are their own grid.
    ///
    /// # Errors
    /// Fewer stamps than half of what the duration holds. `source` names the recording.
    pub fn new(stamps_s: &[f64], source: &str) -> Result<Self, RecordingError> {
        let timing = Timing::of(stamps_s);
        let stamps_s = stamps_s.to_vec();
        if timing.is_even {
            let (rate_hz, time_s) = (timing.rate_hz, stamps_s.clone());
            return Ok(Self {
                timing,
                rate_hz,
                stamps_s,
                time_s,
                ways: None,
                used: None,
                clock: None,
                unmeasured: Vec::new(),
            });
        }
        let steps = (timing.duration_s / timing.median_step_s).round().max(1.0);
        let samples = stamps_s.len();
        if steps > MOST_GRID_SAMPLES * samples as f64 {
            let fault =
                Fault::MostlyGaps { gaps: timing.gaps.len(), samples, expected: steps as usize };
            return Err(RecordingError::new(fault, source).in_column("t"));
        }
        let (rate_hz, first_s) = (steps / timing.duration_s, stamps_s[0]);
        let time_s: Vec<f64> = (0..=steps as usize)
            .map(|k| first_s + timing.duration_s * (k as f64 / steps))
            .collect();
        let there = Interpolation::new(&stamps_s, &time_s, BRIDGED_STEPS * timing.median_step_s);
        let back = Interpolation::new(&time_s, &stamps_s, f64::INFINITY);
        let ways = Some((there, back));
        let unmeasured = long_gaps(&timing);
        Ok(Self { timing, rate_hz, stamps_s, time_s, ways, used: None, clock: None, unmeasured })
    }

    /// That of a recording, by the clock of its motion: [that of the samples](SamplingClock) where the stamps are those of
    /// reception, and where frames repeat while the arm moves, that without the repetitions. Of efforts that are renewed in
    /// some rows only, these rows are used. The way back still leads to every frame and the stamps stay as recorded.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(recording: &Recording) -> Result<Self, RecordingError> {
        let stamps_s = &recording.time_s;
        let clock = SamplingClock::of(recording);
        let instants_s = clock.as_ref().map_or(stamps_s, |clock| &clock.instants_s);
        let repeated = RepeatedFrames::of(recording);
        let of_motion = repeated.and_then(|repeated| repeated.clock(instants_s));
        let held = HeldEfforts::of(recording);
        let saturated = match &held {
            Some(held) => {
                let renewed_s: Vec<f64> = held.renewed.iter().map(|k| instants_s[*k]).collect();
                saturated_times(&held.only_renewed(recording), &renewed_s)
            }
            None => saturated_times(recording, instants_s),
        };
        let held = held.map(|held| held.renewed);
        let (clock_s, used) = match (of_motion, held) {
            (Some((clock_s, used)), None) => (clock_s, Some(used)),
            (_, Some(renewed)) => (instants_s.clone(), Some(renewed)),
            (None, None) if clock.is_some() => (instants_s.clone(), None),
            (None, None) => {
                let mut grid = Self::new(stamps_s, &recording.source)?;
                grid.unmeasured.extend(saturated);
                return Ok(grid);
            }
        };
        let used_s: Vec<f64> = match &used {
            Some(used) => used.iter().map(|k| clock_s[*k]).collect(),
            None => clock_s.clone(),
        };
        let grid = Self::new(&used_s, &recording.source)?;
        let there = match grid.ways {
            Some((there, _)) => there,
            None => Interpolation::new(&used_s, &grid.time_s, f64::INFINITY),
        };
        let back = Interpolation::new(&grid.time_s, &clock_s, f64::INFINITY);
        let (stamps_s, ways) = (stamps_s.clone(), Some((there, back)));
        let mut unmeasured = grid.unmeasured;
        unmeasured.extend(saturated);
        Ok(Self { stamps_s, ways, used, clock, unmeasured, ..grid })
    }

    /// Intervals on the clock of the grid \[s\] in which efforts are not what was measured, so that no row there is to be
    /// fitted: gaps that are interpolated linearly, with so much before and after as a filter of them smears (`smear_s`), and
    /// efforts in saturation.
    pub fn unmeasured_s(&self, smear_s: f64) -> Vec<(f64, f64)> {
        let smeared = |of: &Unmeasured| {
            let smear_s = if of.is_gap { smear_s } else { 0.0 };
            (of.from_s - smear_s, of.to_s + smear_s)
        };
        self.unmeasured.iter().map(smeared).collect()
    }

    /// The clock of the samples, where the stamps are those of reception.
    pub fn sampling_clock(&self) -> Option<&SamplingClock> {
        self.clock.as_ref()
    }

    /// Values at the stamps brought to the grid; unchanged where the stamps are even.
    pub fn resample(&self, at_stamps: &[f64]) -> Vec<f64> {
        let used: Option<Vec<f64>> =
            self.used.as_ref().map(|used| used.iter().map(|k| at_stamps[*k]).collect());
        let at_stamps = used.as_deref().unwrap_or(at_stamps);
        match &self.ways {
            Some((there, _)) => there.apply(at_stamps),
            None => at_stamps.to_vec(),
        }
    }

    /// Values on the grid brought back to the stamps; unchanged where the stamps are even.
    pub fn at_stamps(&self, on_grid: &[f64]) -> Vec<f64> {
        match &self.ways {
            Some((_, back)) => back.apply(on_grid),
            None => on_grid.to_vec(),
        }
    }

    /// How even the stamps are.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// Samples per second of the grid.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Times of the grid \[s\].
    pub fn time_s(&self) -> &[f64] {
        &self.time_s
    }

    /// The original stamps \[s\].
    pub fn stamps_s(&self) -> &[f64] {
        &self.stamps_s
    }
}

/// Gaps that no cubic bridges.
fn long_gaps(timing: &Timing) -> Vec<Unmeasured> {
    let is_long = |gap: &&Gap| gap.length_s > BRIDGED_STEPS * timing.median_step_s;
    let time =
        |gap: &Gap| Unmeasured { from_s: gap.at_s, to_s: gap.at_s + gap.length_s, is_gap: true };
    timing.gaps.iter().filter(is_long).map(time).collect()
}

/// Times in which the effort of some joint is in saturation; none if that is most of the recording.
fn saturated_times(recording: &Recording, clock_s: &[f64]) -> Vec<Unmeasured> {
    let of_joint = |joint| {
        saturated(clock_s, joint).into_iter().filter(|f| f.quantity == Some(Quantity::Effort))
    };
    let spans = recording.joints.iter().flat_map(of_joint).flat_map(|finding| finding.spans);
    let times: Vec<Unmeasured> = spans
        .map(|span| Unmeasured { from_s: span.from_s, to_s: span.to_s, is_gap: false })
        .collect();
    let total_s: f64 = times.iter().map(|time| time.to_s - time.from_s).sum();
    let duration_s = clock_s.last().zip(clock_s.first()).map_or(0.0, |(last, first)| last - first);
    if total_s > SATURATED_SHARE * duration_s { Vec::new() } else { times }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armident_recording::JointChannels;

    fn cubic(t: f64) -> f64 {
        0.4 - t + 0.8 * t * t - 0.3 * t * t * t
    }

    /// About 100 Hz, jittered by a tenth of the step.
    fn jittered(n: i32) -> Vec<f64> {
        (0..n).map(|k| f64::from(k) * 0.01 + 1e-3 * f64::from(k * 7919 % 13 - 6) / 6.0).collect()
    }

    #[test]
    fn cubics_go_there_and_back_exactly() {
        let mut stamps = jittered(300);
        stamps.drain(50..56);
        stamps.drain(100..101);
        let grid = EvenGrid::new(&stamps, "x").unwrap();
        assert!((grid.rate_hz() - 100.0).abs() < 4.0, "{}", grid.rate_hz());
        assert_eq!(grid.time_s()[0], stamps[0]);
        assert!((grid.time_s()[grid.time_s().len() - 1] - stamps[stamps.len() - 1]).abs() < 1e-12);
        let at_stamps: Vec<f64> = stamps.iter().map(|t| cubic(*t)).collect();
        let on_grid = grid.resample(&at_stamps);
        for (got, t) in on_grid.iter().zip(grid.time_s()) {
            assert!((got - cubic(*t)).abs() < 1e-12);
        }
        for (got, want) in grid.at_stamps(&on_grid).iter().zip(&at_stamps) {
            assert!((got - want).abs() < 1e-12);
        }
    }

    #[test]
    fn long_gaps_are_lines_and_nothing_reaches_across() {
        let mut stamps = jittered(300);
        let gap = 100..140;
        stamps.drain(gap);
        // a step hidden in the gap
        let values: Vec<f64> = stamps.iter().map(|t| if *t < 1.2 { 1.0 } else { 3.0 }).collect();
        let grid = EvenGrid::new(&stamps, "x").unwrap();
        let (before_s, after_s) = (stamps[99], stamps[100]);
        for (got, t) in grid.resample(&values).iter().zip(grid.time_s()) {
            let line = 1.0 + 2.0 * ((t - before_s) / (after_s - before_s)).clamp(0.0, 1.0);
            assert!((got - line).abs() < 1e-12, "{t}: {got} {line}");
        }
    }

    #[test]
    fn gaps_and_saturation_are_not_measured() {
        let time_s: Vec<f64> =
            (0..900).filter(|k| !(300..390).contains(k)).map(|k| f64::from(k) * 0.01).collect();
        let mut joint = JointChannels::new("a");
        joint.position = Some(time_s.iter().map(|t| (2.0 * t).sin()).collect());
        joint.effort = Some(time_s.iter().map(|t| (9.0 * (2.0 * t).sin()).min(8.8)).collect());
        let grid = EvenGrid::of(&Recording::new("x", time_s.clone(), vec![joint.clone()]).unwrap());
        let times = grid.unwrap().unmeasured_s(0.1);
        assert_eq!(times.len(), 4, "{times:?}");
        assert!((times[0].0 - 2.89).abs() < 1e-9 && (times[0].1 - 4.0).abs() < 1e-9, "{times:?}");
        // clipped where the sine is above 8.8/9, which is 0.1 s to either side of each crest
        assert!((times[1].0 - 0.68).abs() < 0.02 && (times[1].1 - 0.89).abs() < 0.02, "{times:?}");
        // a joint at rest with a constant effort is not saturated
        joint.position = Some(time_s.iter().map(|t| (2.0 * t).sin().min(0.9)).collect());
        let grid = EvenGrid::of(&Recording::new("x", time_s, vec![joint]).unwrap()).unwrap();
        assert_eq!(grid.unmeasured_s(0.1).len(), 1);
    }

    #[test]
    fn even_recordings_pass_unchanged() {
        let stamps: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.002).collect();
        let grid = EvenGrid::new(&stamps, "x").unwrap();
        let values: Vec<f64> = stamps.iter().map(|t| (t * 1e3).sin()).collect();
        assert_eq!(grid.resample(&values), values);
        assert_eq!(grid.at_stamps(&values), values);
        assert_eq!(grid.time_s(), stamps);
    }

    #[test]
    fn mostly_gaps_are_refused() {
        let stamps: Vec<f64> =
            (0..50).map(|k| f64::from(k) * 0.01 + f64::from(k / 25) * 1e7).collect();
        let error = EvenGrid::new(&stamps, "x.csv").unwrap_err();
        let message = error.to_string();
        assert!(message.starts_with("50 of "), "{message}");
        assert!(message.ends_with(" expected samples present (1 gap)"), "{message}");
        assert_eq!(error.place(), "x.csv, column `t`");
    }
}
