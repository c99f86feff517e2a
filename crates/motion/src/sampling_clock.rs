//! The regular clock behind stamps of reception.
//!
//! A drive samples at a regular rate; a logger that stamps each row when it arrives adds the time that the row was on its way:
//! never less than the fastest row takes, unevenly more, and rows that waited in a queue arrive together. Such stamps as
//! sampling instants turn every movement into noise of speed times lateness. Here the index of each sample and the
//! sampling period are recovered from the lower envelope of the stamps, and the positions decide: of the two clocks, the
//! one on which neighbouring samples predict each other better is that of the motion.

use std::f64::consts::TAU;

use armident_numeric::{order_statistic, range};
use armident_recording::{Action, QualityIssue, QualityIssueKind, Recording, Timing, percent};

/// Fewest samples from which a clock is recovered: the period is known to a thousandth then.
const FEWEST: usize = 64;
/// Jitter of the stamps, as a share of the period, below which either clock is as good: a tenth of a per cent of the step
/// is the rounding of a log.
const SMALLEST_JITTER: f64 = 1e-3;
/// Samples of the first windows in which the period is looked for, and how far from the median step: lateness moves the
/// median by a few per cent.
const FIRST_WINDOW: usize = 32;
const OFF_MEDIAN: f64 = 0.08;
/// Trials per resolution (one over the length) of a window.
const TRIALS: f64 = 8.0;
/// Most windows looked at on each level.
const MOST_WINDOWS: usize = 64;
/// Share of the stamps that are earliest against the clock: these rows were hardly late, and define it.
const EARLIEST_SHARE: f64 = 0.4;
/// Rounds of the regression on the earliest stamps.
const ROUNDS: usize = 5;
/// Share of the stamps before the envelope: outliers.
const BEFORE_SHARE: f64 = 0.02;
/// A stamp so much of a period before a sampling instant still belongs to it: the envelope is not known better at first.
const EARLY: f64 = 0.2;
/// The clock differs from the stamps by at least so much of a period, else it changes nothing.
const LEAST_DIFFERENCE: f64 = 0.01;
/// Share of the samples with the largest speeds, which show the clock.
const FAST_SHARE: f64 = 0.25;
/// The samples must predict each other so much better on the clock than on the stamps. Of jittered sampling instants the
/// ratio is above 1; without a difference it is 1 to within a few per cent.
const CLEARLY_BETTER: f64 = 0.8;

/// Sampling instants of a recording whose stamps are those of reception.
#[derive(Debug, Clone, PartialEq)]
pub struct SamplingClock {
    /// Sampling instant of each row \[s\], on the earliest stamps: no row is later than its stamp, apart from rounding.
    pub instants_s: Vec<f64>,
    /// Samples per second.
    pub rate_hz: f64,
    /// Largest lateness of a stamp \[s\].
    pub largest_lateness_s: f64,
    /// Samples without a row between the first and the last.
    pub lost: usize,
}

impl SamplingClock {
    /// None where the stamps are even, or where the positions do not show that a regular clock is better.
    pub fn of(recording: &Recording) -> Option<Self> {
        let timing = Timing::of(&recording.time_s);
        if timing.is_even || timing.jitter < SMALLEST_JITTER {
            return None;
        }
        let clock = Self::behind(&recording.time_s, timing.median_step_s)?;
        let positions: Vec<&[f64]> =
            recording.joints.iter().filter_map(|joint| joint.position.as_deref()).collect();
        let ratio = roughness_ratio(&positions, &clock.instants_s, &recording.time_s)?;
        (ratio < CLEARLY_BETTER).then_some(clock)
    }

    /// The regular clock behind stamps with about this step \[s\], whatever they are.
    fn behind(stamps_s: &[f64], about_s: f64) -> Option<Self> {
        if stamps_s.len() < FEWEST {
            return None;
        }
        let start_s = stamps_s[0];
        let since: Vec<f64> = stamps_s.iter().map(|t| t - start_s).collect();
        let (mut step_s, mean_s) = period(&since, about_s)?;
        // the envelope lies before the mean of all
        let mut before: Vec<f64> = (since.iter())
            .map(|t| {
                let steps = (t - mean_s) / step_s;
                steps - steps.round()
            })
            .collect();
        let place = (BEFORE_SHARE * before.len() as f64) as usize;
        let mut first_s = mean_s + step_s * order_statistic(&mut before, place)?;
        let mut index = indices(&since, first_s, step_s);
        for _ in 0..ROUNDS {
            (first_s, step_s) = line_below(&since, &index, first_s, step_s)?;
            index = indices(&since, first_s, step_s);
        }
        let lateness = |k: usize| since[k] - first_s - step_s * index[k] as f64;
        let mut all: Vec<f64> = (0..since.len()).map(lateness).collect();
        let earliest_s = order_statistic(&mut all, place)?;
        let instants: Vec<f64> =
            (index.iter()).map(|k| start_s + first_s + earliest_s + step_s * *k as f64).collect();
        let late = || stamps_s.iter().zip(&instants).map(|(t, at)| t - at);
        let largest_lateness_s = late().fold(0.0, f64::max);
        if largest_lateness_s < LEAST_DIFFERENCE * step_s {
            return None;
        }
        let samples = index[index.len() - 1] - index[0] + 1;
        let lost = usize::try_from(samples).ok()?.saturating_sub(index.len());
        // more lost than there: this is no clock that a few rows are missing of
        if lost > index.len() {
            return None;
        }
        Some(Self { instants_s: instants, rate_hz: 1.0 / step_s, largest_lateness_s, lost })
    }

    /// The finding on stamps that are replaced.
    pub fn finding(&self) -> QualityIssue {
        let samples = self.instants_s.len();
        let share = self.lost as f64 / (self.lost + samples) as f64;
        let lost = match self.lost {
            0 => "no row is missing".to_owned(),
            1 => format!("1 row is missing ({})", percent(share)),
            lost => format!("{lost} rows are missing ({})", percent(share)),
        };
        let message = format!(
            "time stamps are those of reception, up to {:.1} ms late: positions are smoother on a regular clock of {:.2} Hz, which \
             is used; {lost}",
            1e3 * self.largest_lateness_s,
            self.rate_hz
        );
        QualityIssue::of_stamps(QualityIssueKind::LateStamps, Action::Repaired, 1.0)
            .with_message(message)
            .with_advice("record the stamps of the drive, or those of the message header")
    }
}

/// Period of which most stamps are whole multiples apart, and the mean remainder \[s\]: the frequency at which their phasors
/// add up, in windows that double.
fn period(since: &[f64], about_s: f64) -> Option<(f64, f64)> {
    let n = since.len();
    let phasors = |from: usize, to: usize, hz: f64| {
        since[from..to].iter().fold((0.0, 0.0), |(re, im), t| {
            let (sin, cos) = (TAU * hz * t).sin_cos();
            (re + cos, im + sin)
        })
    };
    let mut hz = 1.0 / about_s;
    let mut reach_hz = OFF_MEDIAN * hz;
    let mut window = FIRST_WINDOW;
    loop {
        let count = (n / window).max(1);
        let every = count.div_ceil(MOST_WINDOWS);
        let windows: Vec<(usize, usize)> = (0..count)
            .step_by(every)
            .map(|k| (k * window, ((k + 1) * window).min(n)))
            .filter(|(from, to)| to > from)
            .collect();
        let resolution_hz = 1.0 / (window as f64 * about_s);
        let trials = (TRIALS * reach_hz / resolution_hz).ceil() as i32;
        let strength = |hz: f64| {
            let power = |(from, to): &(usize, usize)| {
                let (re, im) = phasors(*from, *to, hz);
                re * re + im * im
            };
            windows.iter().map(power).sum::<f64>()
        };
        let best = (-trials..=trials)
            .map(|k| hz + f64::from(k) * resolution_hz / TRIALS)
            .map(|hz| (strength(hz), hz))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        hz = best.1;
        if window >= n {
            break;
        }
        reach_hz = 0.5 * resolution_hz;
        window = (2 * window).min(n);
    }
    let (re, im) = phasors(0, n, hz);
    let step_s = 1.0 / hz;
    (step_s.is_finite() && step_s > 0.0).then(|| (step_s, im.atan2(re) / TAU * step_s))
}

/// Latest index of each stamp, all different: a sample cannot arrive before it is taken, nor two rows be one sample.
fn indices(since: &[f64], first_s: f64, step_s: f64) -> Vec<i64> {
    let mut next = i64::MAX;
    let mut index: Vec<i64> = (since.iter().rev())
        .map(|t| {
            next = (((t - first_s) / step_s + EARLY).floor() as i64).min(next - 1);
            next
        })
        .collect();
    index.reverse();
    index
}

/// Line through the earliest stamps over their index: time of index 0 and step \[s\].
fn line_below(since: &[f64], index: &[i64], first_s: f64, step_s: f64) -> Option<(f64, f64)> {
    let late = |k: usize| since[k] - first_s - step_s * index[k] as f64;
    let mut all: Vec<f64> = (0..since.len()).map(late).collect();
    let place = (EARLIEST_SHARE * all.len() as f64) as usize;
    let limit_s = order_statistic(&mut all, place)?;
    let used: Vec<usize> = (0..since.len()).filter(|k| late(*k) <= limit_s).collect();
    let count = used.len() as f64;
    let mean = used.iter().map(|k| index[*k] as f64).sum::<f64>() / count;
    let mean_late_s = used.iter().map(|k| late(*k)).sum::<f64>() / count;
    let (mut moment, mut square) = (0.0, 0.0);
    for k in used {
        let lever = index[k] as f64 - mean;
        moment += lever * (late(k) - mean_late_s);
        square += lever * lever;
    }
    if square <= 0.0 {
        return None;
    }
    let slope = moment / square;
    Some((first_s + mean_late_s - slope * mean, step_s + slope))
}

/// How much better neighbouring samples predict each other on one clock than on another, among the fastest samples; below 1
/// the first is better. None without motion.
fn roughness_ratio(positions: &[&[f64]], clock_s: &[f64], other_s: &[f64]) -> Option<f64> {
    let n = clock_s.len();
    let mut squares = [vec![0.0; n], vec![0.0; n]];
    let mut speed = vec![0.0; n];
    for position in positions {
        let [on_clock, on_other] = [clock_s, other_s].map(|time_s| unpredicted(position, time_s));
        // in units of the residual on both
        let mut sizes: Vec<f64> = (on_clock.iter().chain(&on_other)).map(|e| e.abs()).collect();
        let place = sizes.len() / 2;
        let unit = order_statistic(&mut sizes, place)?;
        if unit <= 0.0 || range(position) <= 0.0 {
            continue;
        }
        for k in 2..n - 2 {
            squares[0][k] += (on_clock[k] / unit).powi(2);
            squares[1][k] += (on_other[k] / unit).powi(2);
            speed[k] += ((position[k + 1] - position[k - 1]) / unit).abs();
        }
    }
    let place = ((1.0 - FAST_SHARE) * n as f64) as usize;
    let limit = order_statistic(&mut speed.clone(), place)?;
    if limit <= 0.0 {
        return None;
    }
    let median = |of: &[f64]| {
        let mut fast: Vec<f64> = (2..n - 2).filter(|k| speed[*k] >= limit).map(|k| of[k]).collect();
        let middle = fast.len() / 2;
        order_statistic(&mut fast, middle)
    };
    let [clock, other] = [median(&squares[0])?, median(&squares[1])?];
    (other > 0.0).then(|| (clock / other).sqrt())
}

/// Difference of each sample to the cubic through the two on either side, over the factor by which white noise of the
/// samples appears in it; 0 for the two at the ends.
fn unpredicted(values: &[f64], time_s: &[f64]) -> Vec<f64> {
    let n = values.len();
    let mut unpredicted = vec![0.0; n];
    for k in 2..n.saturating_sub(2) {
        let near = [k - 2, k - 1, k + 1, k + 2];
        let (mut predicted, mut noise) = (0.0, 1.0);
        for i in near {
            let weight: f64 = (near.iter().filter(|j| **j != i))
                .map(|j| (time_s[k] - time_s[*j]) / (time_s[i] - time_s[*j]))
                .product();
            predicted += weight * values[i];
            noise += weight * weight;
        }
        unpredicted[k] = (values[k] - predicted) / noise.sqrt();
    }
    unpredicted
}

#[cfg(test)]
mod tests {
    use super::*;
    use armident_recording::JointChannels;

    /// Uniform deviates in 0..1 from a fixed congruential sequence.
    struct Uniform(u64);

    impl Uniform {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (self.0 >> 33) as f64 / (1_u64 << 31) as f64
        }
    }

    /// A swing sampled at these instants and stamped otherwise.
    fn recording(instants_s: &[f64], stamps_s: Vec<f64>) -> Recording {
        let mut joint = JointChannels::new("a");
        let motion = |t: &f64| 0.8 * (1.3 * t).sin() + 0.2 * (4.1 * t).cos();
        let rounded = |q: f64| (q / 1e-5).round() * 1e-5;
        joint.position = Some(instants_s.iter().map(|t| rounded(motion(t))).collect());
        Recording::new("made", stamps_s, vec![joint]).unwrap()
    }

    /// Instants at a rate with one sample in 150 lost, and their reception: late by up to so much, queues emptied.
    fn received(rate_hz: f64, latest_s: f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = Uniform(7);
        let instants: Vec<f64> =
            (0..1500).filter(|k| k % 150 != 77).map(|k| 0.4 + f64::from(k) / rate_hz).collect();
        let mut stamps: Vec<f64> = instants.iter().map(|t| t + latest_s * random.next()).collect();
        for queue in (100..stamps.len() - 10).step_by(237) {
            for k in 0..3 {
                stamps[queue + k] = stamps[queue + 3] - 1e-4 * (3 - k) as f64;
            }
        }
        let rounded = stamps.iter().map(|t| (t / 1e-5).round() * 1e-5).collect();
        (instants, rounded)
    }

    #[test]
    fn late_stamps_give_the_clock_of_the_samples() {
        for (rate_hz, latest_s) in [(125.0, 3e-3), (100.0, 3e-3), (40.0, 3e-3), (250.0, 2e-3)] {
            let (instants, stamps) = received(rate_hz, latest_s);
            let clock = SamplingClock::of(&recording(&instants, stamps)).unwrap();
            assert!((clock.rate_hz / rate_hz - 1.0).abs() < 1e-5, "{}", clock.rate_hz);
            assert_eq!(clock.lost, 10);
            let off: Vec<f64> =
                clock.instants_s.iter().zip(&instants).map(|(a, b)| a - b).collect();
            let largest = off.iter().copied().fold(f64::MIN, f64::max);
            let smallest = off.iter().copied().fold(f64::MAX, f64::min);
            assert!(largest - smallest < 1e-4, "{rate_hz}: {smallest} {largest}");
            let text = clock.finding().message;
            assert!(text.contains("10 rows are missing (0.7 %)"), "{text}");
        }
    }

    #[test]
    fn jittered_instants_stay() {
        for jitter in [0.05, 0.1, 0.2] {
            let mut random = Uniform(3);
            let instants: Vec<f64> = (0..1500)
                .filter(|k| k % 150 != 77)
                .map(|k| 0.01 * (f64::from(k) + jitter * (random.next() - 0.5)))
                .collect();
            assert_eq!(SamplingClock::of(&recording(&instants, instants.clone())), None);
        }
    }

    #[test]
    fn arms_at_rest_and_even_stamps_show_no_clock() {
        let (instants, stamps) = received(100.0, 3e-3);
        let mut resting = recording(&instants, stamps);
        resting.joints[0].position = Some(vec![0.3; instants.len()]);
        assert_eq!(SamplingClock::of(&resting), None);
        let even: Vec<f64> = (0..500).map(|k| 0.01 * f64::from(k)).collect();
        assert_eq!(SamplingClock::of(&recording(&even, even.clone())), None);
        assert_eq!(SamplingClock::of(&recording(&even[..20], even[..20].to_vec())), None);
    }
}
