//! From uneven stamps to an even grid and back.

use armident_recording::{BRIDGED_STEPS, Fault, Interpolation, Recording, RecordingError, Timing};

use crate::duplicate_frames::RepeatedFrames;
use crate::held_efforts::HeldEfforts;
use crate::sampling_clock::SamplingClock;

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
}

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
        Ok(Self { timing, rate_hz, stamps_s, time_s, ways, used: None, clock: None })
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
        let held = HeldEfforts::of(recording).map(|held| held.renewed);
        let (clock_s, used) = match (of_motion, held) {
            (Some((clock_s, used)), None) => (clock_s, Some(used)),
            (_, Some(renewed)) => (instants_s.clone(), Some(renewed)),
            (None, None) if clock.is_some() => (instants_s.clone(), None),
            (None, None) => return Self::new(stamps_s, &recording.source),
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
        Ok(Self { stamps_s, ways, used, clock, ..grid })
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

#[cfg(test)]
mod tests {
    use super::*;

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
