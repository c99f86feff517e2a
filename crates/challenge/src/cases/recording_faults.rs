//! Faults of the recordings of hard cases: what loggers and drives do to samples.
//!
//! Magnitudes are those of recordings in public reports: rates of 40 to 125 Hz, stamps of reception up to 3 ms late, effort
//! clocks that differ by 50 to 200 ppm, drive filters of 5 to 15 Hz.

use std::f64::consts::TAU;

use armident_effects::Draw;

use crate::random::RandomStream;

/// Sample rates of hard cases \[Hz\].
pub(crate) const RATES_HZ: [f64; 4] = [40.0, 62.5, 100.0, 125.0];
/// Latest reception after the sample \[s\], share of rows that wait for the next ones, and the time between such rows \[s\].
const LATEST_S: f64 = 3e-3;
const QUEUED: f64 = 0.02;
const QUEUE_STEP_S: f64 = 1e-4;
/// Sizes of spikes over the noise, and the share of the samples.
const SPIKES: [f64; 2] = [8.0, 50.0];
const SPIKE_SHARE: f64 = 0.005;

/// Faults of the recordings of one case.
#[derive(Debug, Clone, Default)]
pub(crate) struct RecordingFaults {
    /// Stamps are those of reception.
    pub(crate) received: bool,
    /// By which share the clock of the efforts is fast.
    pub(crate) effort_clock: f64,
    /// Cut-off of the drive's filter \[Hz\]; none without.
    pub(crate) low_pass_hz: Option<f64>,
    /// Step of each joint's efforts \[N m or N\]; none without.
    pub(crate) effort_step: Option<Vec<f64>>,
    /// Training recording, joint and quantile at which its efforts are clipped.
    pub(crate) clipped: Option<(usize, usize, f64)>,
    /// Share of the efforts that are spikes.
    pub(crate) spikes: f64,
    /// Training recording, start and length of a gap \[s\].
    pub(crate) gap: Option<(usize, f64, f64)>,
}

impl RecordingFaults {
    /// At least one fault, mostly two or three.
    pub(crate) fn draw(
        training: usize,
        range: &[f64],
        duration_s: f64,
        random: &mut RandomStream,
    ) -> Self {
        let mut faults = Self::default();
        let first = random.index(7);
        for which in 0..7 {
            if which != first && !random.chance(0.25) {
                continue;
            }
            let file = random.index(training);
            match which {
                0 => faults.received = true,
                1 => {
                    let sign = if random.chance(0.5) { 1.0 } else { -1.0 };
                    faults.effort_clock = sign * random.between(50e-6, 200e-6);
                }
                2 => faults.low_pass_hz = Some(random.between(5.0, 15.0)),
                3 => {
                    let share = random.between(0.005, 0.01);
                    faults.effort_step = Some(range.iter().map(|range| share * range).collect());
                }
                4 => {
                    let joint = random.index(range.len());
                    faults.clipped = Some((file, joint, random.between(0.955, 0.985)));
                }
                5 => faults.spikes = SPIKE_SHARE,
                _ => faults.gap = Some((file, random.between(0.3, 0.7) * duration_s, 1.0)),
            }
        }
        faults
    }

    /// These faults without stamps of reception and gaps.
    pub(crate) fn without_clocks(&self) -> Self {
        Self { received: false, gap: None, ..self.clone() }
    }

    /// Time constant of the drive's filter \[s\]; 0 without.
    pub(crate) fn low_pass_s(&self) -> f64 {
        self.low_pass_hz.map_or(0.0, |hz| 1.0 / (TAU * hz))
    }

    /// Names of these faults in truth and tables.
    pub(crate) fn names(&self) -> Vec<String> {
        let all = [
            (self.received, "stamps"),
            (self.effort_clock != 0.0, "clock"),
            (self.low_pass_hz.is_some(), "low_pass"),
            (self.effort_step.is_some(), "quantised"),
            (self.clipped.is_some(), "saturated"),
            (self.spikes > 0.0, "outliers"),
            (self.gap.is_some(), "gap"),
        ];
        all.into_iter().filter(|(is_there, _)| *is_there).map(|(_, name)| name.to_owned()).collect()
    }

    /// Stamps of reception of regular samples: late, and in a queue now and then.
    pub(crate) fn stamps(&self, time_s: &[f64], random: &mut RandomStream) -> Vec<f64> {
        if !self.received {
            return time_s.to_vec();
        }
        let mut received: Vec<f64> =
            time_s.iter().map(|t| t + LATEST_S * random.uniform().powi(2)).collect();
        for k in (0..received.len().saturating_sub(3)).rev() {
            if random.chance(QUEUED) {
                let emptied = received[k + 2];
                received[k] = emptied - 2.0 * QUEUE_STEP_S;
                received[k + 1] = emptied - QUEUE_STEP_S;
            }
        }
        for k in 1..received.len() {
            received[k] = received[k].max(received[k - 1] + QUEUE_STEP_S);
        }
        received.iter().map(|t| (t * 1e5).round() / 1e5).collect()
    }

    /// What the channel of a joint in recording `file` (of `train_1`, `train_2`, `holdout`, `exam`) makes of efforts.
    pub(crate) fn of_efforts(
        &self,
        (file, joint): (usize, usize),
        sigma: f64,
        efforts: &mut [f64],
        random: &mut RandomStream,
    ) {
        const EXAM: usize = 3;
        if self.spikes > 0.0 && file != EXAM {
            for effort in efforts.iter_mut() {
                if random.chance(self.spikes) {
                    let sign = if random.chance(0.5) { 1.0 } else { -1.0 };
                    *effort += sign * sigma * random.between(SPIKES[0], SPIKES[1]);
                }
            }
        }
        if let Some((_, _, quantile)) = self.clipped.filter(|(f, j, _)| (*f, *j) == (file, joint)) {
            let mut sizes: Vec<f64> = efforts.iter().map(|effort| effort.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let limit = sizes[((sizes.len() - 1) as f64 * quantile) as usize];
            efforts.iter_mut().for_each(|effort| *effort = effort.clamp(-limit, limit));
        }
        if let Some(steps) = &self.effort_step {
            efforts.iter_mut().for_each(|e| *e = (*e / steps[joint]).round() * steps[joint]);
        }
    }

    /// Whether a sample of a recording is in its gap.
    pub(crate) fn is_missing(&self, file: usize, time_s: f64) -> bool {
        let inside = |(f, from, length): (usize, f64, f64)| {
            f == file && (from..from + length).contains(&time_s)
        };
        self.gap.is_some_and(inside)
    }
}
