//! One recording as the diagnosis sees it.

use std::f64::consts::TAU;

use armident_numeric::{Cholesky, dot};
use armident_recording::{
    CUTOFF_SHARE_BOUND, EvenGrid, Quantity, Recording, RecordingError, ZeroPhaseLowPass,
    differentiate,
};

use crate::band::Band;
use crate::noise::{Noise, noise_of};

/// Cut-off of the low-pass of positions before they are differentiated \[Hz\], well above the band:
/// columns with signs and products are formed from it and only then filtered.
const KINEMATICS_HZ: f64 = 25.0;
const KINEMATICS_ORDER: usize = 4;
/// A speed below this many standard deviations of its noise has no sign...
const SIGN_DEVIATIONS: f64 = 5.0;
/// ... nor one below this share of the root mean square speed.
const SIGN_SHARE: f64 = 0.002;
/// A joint sticks below this share of the root mean square speed...
const STICK_SHARE: f64 = 0.006;
/// ... if it stays there this long \[s\].
const STICK_S: f64 = 0.03;
/// A joint rests while its recorded position stays within this many standard deviations of its noise...
const SAME_PLACE_DEVIATIONS: f64 = 6.0;
/// ... or of this many steps of its encoder...
const SAME_PLACE_STEPS: f64 = 1.5;
/// ... this long \[s\], where at its accelerations so far around \[s\] it would have gone this many times as
/// far.
const REST_S: f64 = 0.015;
const AROUND_S: f64 = 0.05;
const FAR: f64 = 5.0;
/// Share of the acceleration noise from the position that is clearly better.
const CLEARLY_BETTER: f64 = 0.5;
/// Share of the acceleration's noise in it from which on it matters.
const MATTERS: f64 = 0.02;
/// A recorded velocity that is off by more than this says something else than the position; and by that
/// much later, or by that share of a sample \[s\].
const SAME_SCALE: f64 = 0.05;
const NO_LAG_S: f64 = 1e-3;
const NO_LAG_SAMPLES: f64 = 0.05;
/// Friction fades to nothing in this time \[s\] when a joint stops and goes on the same way.
const DIP_S: f64 = 0.04;
/// Samples of all recordings together from which on a search takes fewer...
const SEARCHED_SAMPLES: usize = 12_000;
/// ... but not fewer than so many a second: ten times the cut-off of the kinematics, 25 times that of the band.
const SEARCHED_HZ: f64 = 250.0;

/// Channels of the joints of a chain on an even grid, joint-major.
#[derive(Debug, Clone)]
pub(crate) struct Signals {
    pub(crate) source: String,
    pub(crate) rate_hz: f64,
    /// before it was thinned
    pub(crate) recorded_hz: f64,
    /// since the first sample
    pub(crate) time_s: Vec<f64>,
    pub(crate) recorded_position: Vec<Vec<f64>>,
    pub(crate) position: Vec<Vec<f64>>,
    pub(crate) velocity: Vec<Vec<f64>>,
    pub(crate) acceleration: Vec<Vec<f64>>,
    pub(crate) direction: Vec<Vec<f64>>,
    pub(crate) stuck: Vec<Vec<bool>>,
    /// empty for a joint whose effort is not recorded
    pub(crate) effort: Vec<Vec<f64>>,
    /// noise of the effort of one recorded sample, and in the band \[N m or N\]
    pub(crate) effort_noise: Vec<f64>,
    pub(crate) effort_noise_in_band: Vec<f64>,
    /// noise of the acceleration in the band \[rad/s2 or m/s2\]
    pub(crate) acceleration_noise: Vec<f64>,
    pub(crate) band: Band,
}

/// Noise of a recorded velocity \[rad/s or m/s\] and of its derivative in the band.
#[derive(Debug, Clone, Copy)]
struct VelocityNoise {
    deviation: f64,
    acceleration_in_band: f64,
}

impl Signals {
    /// At every sample.
    ///
    /// # Errors
    /// A joint without position, or a recording that is mostly gaps.
    pub(crate) fn new(recording: &Recording, joints: &[String]) -> Result<Self, RecordingError> {
        let grid = EvenGrid::new(&recording.time_s, &recording.source)?;
        Self::on(&grid, recording, joints)
    }

    /// On the grid of the recording.
    ///
    /// # Errors
    /// A joint without position.
    pub(crate) fn on(
        grid: &EvenGrid,
        recording: &Recording,
        joints: &[String],
    ) -> Result<Self, RecordingError> {
        recording.check()?;
        let rate_hz = grid.rate_hz();
        let start_s = grid.time_s().first().copied().unwrap_or_default();
        let time_s: Vec<f64> = grid.time_s().iter().map(|t| t - start_s).collect();
        let on_grid = |joint: &String, quantity| {
            let channel = recording.joint(joint).and_then(|j| j.channel(quantity));
            channel.map(|values| grid.resample(values)).unwrap_or_default()
        };
        let recorded_position: Vec<Vec<f64>> = joints
            .iter()
            .map(|j| on_grid(j, Quantity::Position))
            .map(|q| if q.is_empty() { vec![0.0; time_s.len()] } else { q })
            .collect();
        let effort: Vec<Vec<f64>> = joints.iter().map(|j| on_grid(j, Quantity::Effort)).collect();
        let recorded_velocity: Vec<Vec<f64>> =
            joints.iter().map(|j| on_grid(j, Quantity::Velocity)).collect();
        let low_pass = kinematics_filter(rate_hz)?;
        let mut signals = Self {
            source: recording.source.clone(),
            rate_hz,
            recorded_hz: rate_hz,
            band: Band::new(rate_hz, time_s.len()),
            effort_noise: Vec::new(),
            effort_noise_in_band: Vec::new(),
            acceleration_noise: Vec::new(),
            position: Vec::new(),
            time_s,
            recorded_position,
            velocity: Vec::new(),
            acceleration: Vec::new(),
            direction: Vec::new(),
            stuck: Vec::new(),
            effort,
        };
        for effort in &signals.effort {
            let noise = noise_of(effort, rate_hz);
            let gain = signals.band.noise_gain(noise.colour);
            signals.effort_noise.push(noise.deviation);
            signals.effort_noise_in_band.push(noise.deviation * gain.sqrt());
        }
        for (j, recorded) in recorded_velocity.iter().enumerate() {
            let inner = |values: &[f64], margin: usize| {
                values[margin..margin + signals.time_s.len()].to_vec()
            };
            let (position, margin) = extended(&signals.recorded_position[j], rate_hz);
            let position = low_pass.filter(&position);
            let mut velocity = differentiate(&position, rate_hz);
            let mut acceleration = inner(&differentiate(&velocity, rate_hz), margin);
            velocity = inner(&velocity, margin);
            let of_position = noise_of(&signals.recorded_position[j], rate_hz);
            let mut noise = of_position.deviation * signals.kinematics_gain(1);
            let mut acceleration_noise = signals.in_band(&of_position, 2);
            if !recorded.is_empty()
                && let Some(of_recorded) = signals.better_velocity(recorded, &velocity)
            {
                let (extended, margin) = extended(recorded, rate_hz);
                let smooth = low_pass.filter(&extended);
                acceleration = inner(&differentiate(&smooth, rate_hz), margin);
                velocity = inner(&smooth, margin);
                noise = of_recorded.deviation * signals.kinematics_gain(0);
                acceleration_noise = of_recorded.acceleration_in_band;
            }
            signals.acceleration_noise.push(acceleration_noise);
            signals.position.push(inner(&position, margin));
            signals.acceleration.push(acceleration);
            let (direction, mut stuck) = directions_and_stops(&velocity, noise, rate_hz);
            let acceleration = &signals.acceleration[j];
            // a joint that mostly stands still has no noise to tell its encoder's step by
            let resolution = (SAME_PLACE_DEVIATIONS * of_position.deviation)
                .max(SAME_PLACE_STEPS * least_step(&signals.recorded_position[j]));
            for (start, end) in
                rests(&signals.recorded_position[j], acceleration, resolution, rate_hz)
            {
                stuck[start..end].fill(true);
            }
            signals.velocity.push(velocity);
            signals.direction.push(direction);
            signals.stuck.push(stuck);
        }
        Ok(signals)
    }

    pub(crate) fn len(&self) -> usize {
        self.time_s.len()
    }

    /// With samples left out where there are more than a search needs: each law is formed at every sample
    /// hundreds of times, and all is compared in the band. Efforts, directions and positions as recorded become
    /// means around the samples that remain, motions are below the rate already; noise stays what it was found to be
    /// at every sample.
    pub(crate) fn thinned(mut self, of_all: usize) -> Self {
        let most = (self.rate_hz / SEARCHED_HZ).floor() as usize;
        let step = of_all.div_ceil(SEARCHED_SAMPLES).min(most);
        if step < 2 {
            return self;
        }
        let motions = [&mut self.position, &mut self.velocity, &mut self.acceleration];
        for values in motions.into_iter().flatten() {
            *values = every(step, values);
        }
        // directions jump, as efforts do
        let jumping = [&mut self.recorded_position, &mut self.direction, &mut self.effort];
        for values in jumping.into_iter().flatten() {
            *values = means(step, values);
        }
        for stuck in &mut self.stuck {
            *stuck = every(step, stuck);
        }
        self.time_s = every(step, &self.time_s);
        self.rate_hz /= step as f64;
        self.band = Band::new(self.rate_hz, self.time_s.len());
        self
    }

    /// Standard deviation of the `order`-th derivative of the low-passed position, for white noise of
    /// deviation 1 on the position, before the band.
    fn kinematics_gain(&self, order: i32) -> f64 {
        const POINTS: usize = 400;
        let power = |k: usize| {
            let f = (k as f64 + 0.5) / POINTS as f64 * 0.5 * self.rate_hz;
            kinematics_power(f, order)
        };
        ((0..POINTS).map(power).sum::<f64>() / POINTS as f64).sqrt()
    }

    /// Noise in the band of the `order`-th derivative of a channel.
    fn in_band(&self, channel: &Noise, order: i32) -> f64 {
        channel.deviation * self.band.mean_power(|f| kinematics_power(f, order)).sqrt()
    }

    /// Noise of a recorded velocity and of its derivative in the band, if that is clearly less than from
    /// the position (clocks that jitter, coarse encoders) and if the two say the same of the motion: most
    /// recorded velocities lag.
    fn better_velocity(&self, recorded: &[f64], derived: &[f64]) -> Option<VelocityNoise> {
        let noise = noise_of(recorded, self.rate_hz);
        let rates = [recorded, derived].map(|v| self.band.rows(&differentiate(v, self.rate_hz)));
        // two measurements of one motion, each with noise of its own
        let both = dot(&rates[0], &rates[1]);
        let [of_recorded, of_derived] = rates.each_ref().map(|r| dot(r, r) - both);
        let matters = of_derived > MATTERS.powi(2) * both;
        if noise.deviation <= 0.0 || !matters || of_recorded > CLEARLY_BETTER.powi(2) * of_derived {
            return None;
        }
        // recorded = scale (derived - lag d(derived)/dt), in the band
        let recorded = self.band.rows(recorded);
        let speed = self.band.rows(derived);
        let rate = self.band.rows(&differentiate(derived, self.rate_hz));
        let (ss, sr, rr) = (dot(&speed, &speed), dot(&speed, &rate), dot(&rate, &rate));
        let (ys, yr) = (dot(&recorded, &speed), dot(&recorded, &rate));
        let determinant = ss * rr - sr * sr;
        if determinant <= 0.0 {
            return None;
        }
        let scale = (ys * rr - yr * sr) / determinant;
        let lag_s = (ys * sr - yr * ss) / determinant;
        let no_lag_s = NO_LAG_S.max(NO_LAG_SAMPLES / self.rate_hz);
        let same = (scale - 1.0).abs() < SAME_SCALE && lag_s.abs() < no_lag_s;
        let in_band = (of_recorded.max(0.0) / recorded.len().max(1) as f64).sqrt();
        let white = self.in_band(&noise, 1);
        same.then_some(VelocityNoise {
            deviation: noise.deviation,
            acceleration_in_band: in_band.max(white),
        })
    }
}

/// `|K|² ω^(2 order)` of the zero-phase low-pass (its magnitude counts twice).
fn kinematics_power(f_hz: f64, order: i32) -> f64 {
    let magnitude = 1.0 / (1.0 + (f_hz / KINEMATICS_HZ).powi(2 * KINEMATICS_ORDER as i32));
    magnitude * magnitude * (TAU * f_hz).powi(2 * order)
}

pub(crate) fn kinematics_filter(rate_hz: f64) -> Result<ZeroPhaseLowPass, RecordingError> {
    low_pass(KINEMATICS_HZ, rate_hz)
}

/// A low-pass of this cut-off, or of the highest that the rate allows.
pub(crate) fn low_pass(cutoff_hz: f64, rate_hz: f64) -> Result<ZeroPhaseLowPass, RecordingError> {
    let highest_hz = 0.9 * CUTOFF_SHARE_BOUND * rate_hz;
    ZeroPhaseLowPass::new(KINEMATICS_ORDER, cutoff_hz.min(highest_hz), rate_hz)
}

/// Values continued at both ends along a polynomial through the samples there, or held where the joint
/// rests: a recording that ends in motion then has speed and acceleration up to its end. Gives the
/// number of samples added at an end.
pub(crate) fn extended(values: &[f64], rate_hz: f64) -> (Vec<f64>, usize) {
    // some periods of the low-pass of the kinematics, and what a polynomial follows of a motion
    const MARGIN_S: f64 = 0.12;
    const FITTED_S: f64 = 0.25;
    const FEWEST: usize = 20;
    let margin = (MARGIN_S * rate_hz).round() as usize;
    let fitted = ((FITTED_S * rate_hz).round() as usize).max(FEWEST).min(values.len());
    let start: Vec<f64> = values[..fitted].iter().rev().copied().collect();
    let before = continued(&start, margin);
    let after = continued(&values[values.len() - fitted..], margin);
    let all = before.iter().rev().chain(values).chain(&after).copied().collect();
    (all, margin)
}

/// The next values of a series by its least-squares quartic; its last value where the last tenth does
/// not move.
fn continued(values: &[f64], count: usize) -> Vec<f64> {
    const TERMS: usize = 5;
    let n = values.len();
    let last = values[n - 1];
    if n < 2 * TERMS || values[n - (n / 10).max(3)..].iter().all(|x| *x == last) {
        return vec![last; count];
    }
    // time from the last sample, in lengths of the series
    let powers =
        |k: f64| -> [f64; TERMS] { std::array::from_fn(|p| (k / n as f64).powi(p as i32)) };
    let rows: Vec<[f64; TERMS]> = (0..n).map(|k| powers(k as f64 - (n - 1) as f64)).collect();
    let product = |a: usize, b: usize| rows.iter().map(|r| r[a] * r[b]).sum::<f64>();
    let rhs: Vec<f64> =
        (0..TERMS).map(|a| rows.iter().zip(values).map(|(r, x)| r[a] * x).sum()).collect();
    let Some(cholesky) = Cholesky::of(TERMS, product) else { return vec![last; count] };
    let c = cholesky.solve(&rhs);
    (1..=count).map(|k| c.iter().zip(powers(k as f64)).map(|(c, p)| c * p).sum()).collect()
}

/// Direction of motion, bridged where the speed has no sure sign, and where the joint sticks.
///
/// Between two directions the friction of a stopped joint goes from one level to the other, and a line
/// is the best guess; between two equal ones it gives way in between.
fn directions_and_stops(velocity: &[f64], noise: f64, rate_hz: f64) -> (Vec<f64>, Vec<bool>) {
    let n = velocity.len();
    let rms = (velocity.iter().map(|v| v * v).sum::<f64>() / n.max(1) as f64).sqrt();
    let threshold = (SIGN_DEVIATIONS * noise).max(SIGN_SHARE * rms);
    let mut direction: Vec<f64> =
        velocity.iter().map(|v| if v.abs() >= threshold { v.signum() } else { 0.0 }).collect();
    let dip = (DIP_S * rate_hz).max(1.0);
    for (start, end) in spells(velocity, threshold) {
        let before = if start == 0 { 0.0 } else { direction[start - 1] };
        let after = if end == n { 0.0 } else { direction[end] };
        let length = (end - start + 1) as f64;
        for t in start..end {
            let (from_start, to_end) = ((t - start + 1) as f64, (end - t) as f64);
            let by_line = before + (after - before) * from_start / length;
            let fading =
                before * (1.0 - from_start / dip).max(0.0) + after * (1.0 - to_end / dip).max(0.0);
            direction[t] = if before * after < 0.0 { by_line } else { fading.clamp(-1.0, 1.0) };
        }
    }
    let mut stuck = vec![false; n];
    for (start, end) in spells(velocity, threshold.max(STICK_SHARE * rms)) {
        if (end - start) as f64 >= STICK_S * rate_hz {
            stuck[start..end].fill(true);
        }
    }
    (direction, stuck)
}

/// Stretches in which a joint stays at one place though at its accelerations around it would have left: the
/// rests of stick and slip, too short to be seen in a filtered velocity.
fn rests(
    position: &[f64],
    acceleration: &[f64],
    resolution: f64,
    rate_hz: f64,
) -> Vec<(usize, usize)> {
    let least = (REST_S * rate_hz).ceil().max(4.0) as usize;
    let around = (AROUND_S * rate_hz).round() as usize;
    let n = position.len();
    let mut found = Vec::new();
    let mut start = 0;
    while start + least <= n {
        let (mut low, mut high) = (position[start], position[start]);
        let mut end = start;
        while end < n {
            low = low.min(position[end]);
            high = high.max(position[end]);
            if high - low > resolution {
                break;
            }
            end += 1;
        }
        if end - start < least {
            start += 1;
            continue;
        }
        let near = &acceleration[start.saturating_sub(around)..(end + around).min(n)];
        let square = near.iter().map(|a| a * a).sum::<f64>() / near.len() as f64;
        // turning back at that acceleration in the middle of the stretch
        let turned = square.sqrt() * ((end - start) as f64 / rate_hz).powi(2) / 8.0;
        if turned > FAR * resolution {
            found.push((start, end));
        }
        start = end;
    }
    found
}

fn every<T: Copy>(step: usize, values: &[T]) -> Vec<T> {
    values.iter().copied().step_by(step).collect()
}

/// Every so many samples the mean of as many around it, the outermost by half where the number is even;
/// of fewer at the ends, so that a line stays a line.
fn means(step: usize, values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let outer = if step.is_multiple_of(2) { 0.5 } else { 1.0 };
    let mean = |t: usize| {
        let half = (step / 2).min(t).min(last - t);
        if half == 0 {
            return values[t];
        }
        let inner: f64 = values[t + 1 - half..t + half].iter().sum();
        let weight = (2 * half - 1) as f64 + 2.0 * outer;
        (inner + outer * (values[t - half] + values[t + half])) / weight
    };
    (0..values.len()).step_by(step).map(mean).collect()
}

/// The least that successive samples differ by, if they do.
fn least_step(position: &[f64]) -> f64 {
    let steps = position.windows(2).map(|p| (p[1] - p[0]).abs()).filter(|step| *step > 0.0);
    steps.reduce(f64::min).unwrap_or(0.0)
}

/// Stretches of samples with a speed below a threshold.
fn spells(velocity: &[f64], threshold: f64) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for (t, v) in velocity.iter().enumerate() {
        match (v.abs() < threshold || threshold == 0.0, start) {
            (true, None) => start = Some(t),
            (false, Some(from)) => {
                found.push((from, t));
                start = None;
            }
            _ => {}
        }
    }
    found.extend(start.map(|from| (from, velocity.len())));
    found
}

impl Signals {
    /// The efforts as they were before a delay \[s\]: at every instant, what is recorded that much
    /// later.
    pub(crate) fn effort_before(&self, delay_s: f64) -> Vec<Vec<f64>> {
        self.effort.iter().map(|e| later(e, delay_s * self.rate_hz)).collect()
    }
}

/// Values `samples` later, by the cubic through four neighbours; held at the ends.
pub(crate) fn later(values: &[f64], samples: f64) -> Vec<f64> {
    if samples == 0.0 || values.is_empty() {
        return values.to_vec();
    }
    let whole = samples.floor();
    let x = samples - whole;
    let weights = [
        -x * (x - 1.0) * (x - 2.0) / 6.0,
        (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
        -(x + 1.0) * x * (x - 2.0) / 2.0,
        (x + 1.0) * x * (x - 1.0) / 6.0,
    ];
    let last = values.len() as i64 - 1;
    (0..=last)
        .map(|t| {
            let at = |k: i64| values[(t + whole as i64 + k).clamp(0, last) as usize];
            weights.iter().zip(-1..).map(|(w, k)| w * at(k)).sum()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{SEARCHED_SAMPLES, Signals, means, rests};
    use armident_recording::{JointChannels, Recording};

    /// What is compared in the band is the same of few samples as of all, friction that reverses among it; noise
    /// stays that of all.
    #[test]
    fn thinned_recordings_say_the_same_in_the_band() {
        let time: Vec<f64> = (0..13_000).map(|k| f64::from(k) / 1000.0).collect();
        let mut joint = JointChannels::new("a");
        let motion = |t: &f64| (2.0 * t).sin() + 0.3 * (11.0 * t).cos();
        joint.position = Some(time.iter().map(motion).collect());
        let rate = |t: &f64| 2.0 * (2.0 * t).cos() - 3.3 * (11.0 * t).sin();
        joint.effort = Some(time.iter().map(|t| rate(t).signum() + 4.0 * motion(t)).collect());
        let recording = Recording::new("made", time, vec![joint]).unwrap();
        let joints = ["a".to_owned()];
        let all = Signals::new(&recording, &joints).unwrap();
        let few = all.clone().thinned(recording.len());
        // just beyond the budget: half of them; and what is long enough goes down to 250 Hz
        assert_eq!(recording.len().div_ceil(SEARCHED_SAMPLES), 2);
        assert!((few.rate_hz - 500.0).abs() < 1e-9, "{}", few.rate_hz);
        assert!((all.clone().thinned(1_000_000).rate_hz - 250.0).abs() < 1e-9);
        assert!((all.clone().thinned(SEARCHED_SAMPLES).rate_hz - 1000.0).abs() < 1e-9);
        for few in [few, all.clone().thinned(1_000_000)] {
            let size =
                |rows: &[f64]| (armident_numeric::dot(rows, rows) / rows.len() as f64).sqrt();
            let channels = |s: &Signals| -> [Vec<f64>; 5] {
                [&s.position, &s.velocity, &s.acceleration, &s.direction, &s.effort]
                    .map(|channel| s.band.rows(&channel[0]))
            };
            for (few, all) in channels(&few).iter().zip(channels(&all)) {
                assert_eq!(few.len(), all.len());
                let off: Vec<f64> = few.iter().zip(&all).map(|(a, b)| a - b).collect();
                assert!(size(&off) < 2e-3 * size(&all), "{} of {}", size(&off), size(&all));
            }
            assert_eq!(few.effort_noise, all.effort_noise);
            assert_eq!(few.acceleration_noise, all.acceleration_noise);
        }
    }

    /// A line stays a line up to its ends; of what alternates with every sample nothing is left.
    #[test]
    fn means_around_the_samples_that_remain() {
        for step in [2, 3, 4, 5] {
            let line: Vec<f64> = (0..41).map(|k| 2.0 * f64::from(k) - 7.0).collect();
            let expected: Vec<f64> = line.iter().copied().step_by(step).collect();
            for (got, expected) in means(step, &line).iter().zip(&expected) {
                assert!((got - expected).abs() < 1e-12, "{step}: {got} {expected}");
            }
            let waves = (0..41).map(|k| (std::f64::consts::TAU * f64::from(k) / step as f64).cos());
            let left = means(step, &waves.collect::<Vec<_>>());
            let inner = &left[1..left.len() - 1];
            assert!(inner.iter().all(|x| x.abs() < 1e-12), "{step}: {inner:?}");
        }
        assert_eq!(means(4, &[]), Vec::<f64>::new());
        assert_eq!(means(4, &[3.0]), [3.0]);
    }

    /// Holds of 25 ms between slides of 60 ms are found; the smooth reversals of a sine are not rests.
    #[test]
    fn holds_between_slides_are_rests() {
        const RATE_HZ: f64 = 400.0;
        let slides = |t: f64| {
            let (cycle, phase) = ((t / 0.085).floor(), t % 0.085);
            let x = ((phase - 0.025) / 0.06).max(0.0);
            0.02 * (cycle + x * x * (3.0 - 2.0 * x))
        };
        let twice = |values: &[f64]| -> Vec<f64> {
            let second = |w: &[f64]| (w[2] - 2.0 * w[1] + w[0]) * RATE_HZ * RATE_HZ;
            let inner = values.windows(3).map(second);
            std::iter::once(0.0).chain(inner).chain([0.0]).collect()
        };
        let sampled = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (0..800).map(|k| of(f64::from(k) / RATE_HZ)).collect()
        };
        let position = sampled(&slides);
        let found = rests(&position, &twice(&position), 2e-5, RATE_HZ);
        // 2 s hold 23 of them; the first samples of a slide are still at the place
        assert!((20..=24).contains(&found.len()), "{found:?}");
        assert!(found.iter().all(|(start, end)| (8..=14).contains(&(end - start))), "{found:?}");
        let sine = sampled(&|t: f64| (3.0 * t).sin());
        assert_eq!(rests(&sine, &twice(&sine), 2e-5, RATE_HZ), []);
        // a joint at rest is none of stick and slip either
        assert_eq!(rests(&[0.5; 800], &[0.0; 800], 2e-5, RATE_HZ), []);
    }
}
