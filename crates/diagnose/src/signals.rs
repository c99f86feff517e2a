//! One recording as the diagnosis sees it.

use std::f64::consts::TAU;

use armident_numeric::dot;
use armident_recording::{
    CUTOFF_SHARE_BOUND, Continuation, EvenGrid, Quantity, Recording, RecordingError,
    ZeroPhaseLowPass, differentiate,
};
use rayon::prelude::*;

use crate::band::Band;
use crate::noise::{Noise, noise_of};
use crate::stops::{
    Channels, SmoothMotion, directions_and_stops, held, least_step, stands_at_ends, starts_at_rest,
};

/// Cut-off of the low-pass of positions before they are differentiated \[Hz\], well above the band:
/// columns with signs and products are formed from it and only then filtered.
const KINEMATICS_HZ: f64 = 25.0;
const KINEMATICS_ORDER: usize = 4;
/// Share of the acceleration noise from the position that is clearly better.
const CLEARLY_BETTER: f64 = 0.5;
/// Share of the acceleration's noise in it from which on it matters.
const MATTERS: f64 = 0.02;
/// A recorded velocity that is off by more than this says something else than the position; and by that
/// much later, or by that share of a sample \[s\].
const SAME_SCALE: f64 = 0.05;
const NO_LAG_S: f64 = 1e-3;
const NO_LAG_SAMPLES: f64 = 0.05;
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
    /// how these go on past the ends of the recording
    pub(crate) goes_on: Vec<Continuation>,
    /// whether the arm stands there
    pub(crate) stands: [bool; 2],
    /// whether the arm rests at the first sample, however suddenly it moves then
    pub(crate) starts_at_rest: bool,
    pub(crate) position: Vec<Vec<f64>>,
    pub(crate) velocity: Vec<Vec<f64>>,
    pub(crate) acceleration: Vec<Vec<f64>>,
    /// the same with the jumps where the joint stops, and as its drive answers it: [`held`]
    pub(crate) own_acceleration: Vec<Vec<f64>>,
    pub(crate) held_acceleration: Vec<Vec<f64>>,
    pub(crate) direction: Vec<Vec<f64>>,
    pub(crate) stuck: Vec<Vec<bool>>,
    /// stretches in which a joint stays where it is, `[start, end)`
    pub(crate) rests: Vec<Vec<(usize, usize)>>,
    /// empty for a joint whose effort is not recorded
    pub(crate) effort: Vec<Vec<f64>>,
    /// what of the recorded effort is known and no longer in `effort`
    pub(crate) taken: Vec<Vec<f64>>,
    /// noise of the effort of one recorded sample, and in the band \[N m or N\]
    pub(crate) effort_noise: Vec<f64>,
    pub(crate) effort_noise_in_band: Vec<f64>,
    /// noise of the acceleration in the band \[rad/s2 or m/s2\]
    pub(crate) acceleration_noise: Vec<f64>,
    pub(crate) band: Band,
    /// below which all is compared, if the rate allows it
    band_hz: f64,
}

/// Noise of a recorded velocity \[rad/s or m/s\] and of its derivative in the band.
#[derive(Debug, Clone, Copy)]
struct VelocityNoise {
    deviation: f64,
    acceleration_in_band: f64,
}

impl Signals {
    /// At every sample, to be compared below this frequency.
    ///
    /// # Errors
    /// A joint without position, or a recording that is mostly gaps.
    pub(crate) fn below(
        recording: &Recording,
        joints: &[String],
        band_hz: f64,
    ) -> Result<Self, RecordingError> {
        let grid = EvenGrid::of(recording)?;
        Self::on(&grid, recording, joints, band_hz)
    }

    /// On the grid of the recording.
    ///
    /// # Errors
    /// A joint without position.
    pub(crate) fn on(
        grid: &EvenGrid,
        recording: &Recording,
        joints: &[String],
        band_hz: f64,
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
        let steps: Vec<f64> = joints
            .iter()
            .map(|j| recording.joint(j).and_then(|j| j.channel(Quantity::Position)))
            .map(|position| position.map_or(0.0, least_step))
            .collect();
        let effort: Vec<Vec<f64>> = joints.iter().map(|j| on_grid(j, Quantity::Effort)).collect();
        let recorded_velocity: Vec<Vec<f64>> =
            joints.iter().map(|j| on_grid(j, Quantity::Velocity)).collect();
        let low_pass = kinematics_filter(rate_hz)?;
        let mut signals = Self {
            source: recording.source.clone(),
            rate_hz,
            recorded_hz: rate_hz,
            band: Band::new(rate_hz, time_s.len(), band_hz),
            band_hz,
            effort_noise: Vec::new(),
            effort_noise_in_band: Vec::new(),
            acceleration_noise: Vec::new(),
            position: Vec::new(),
            time_s,
            recorded_position,
            goes_on: Vec::new(),
            stands: [false; 2],
            starts_at_rest: false,
            velocity: Vec::new(),
            acceleration: Vec::new(),
            direction: Vec::new(),
            stuck: Vec::new(),
            rests: Vec::new(),
            own_acceleration: Vec::new(),
            held_acceleration: Vec::new(),
            taken: effort.iter().map(|e| vec![0.0; e.len()]).collect(),
            effort,
        };
        for effort in &signals.effort {
            let noise = noise_of(effort, rate_hz);
            let gain = signals.band.noise_gain(noise.colour);
            signals.effort_noise.push(noise.deviation);
            signals.effort_noise_in_band.push(noise.deviation * gain.sqrt());
        }
        let positions = signals.recorded_position.clone();
        let of_positions: Vec<Noise> = positions.iter().map(|q| noise_of(q, rate_hz)).collect();
        let mut joints: Vec<Channels<'_>> = (positions.par_iter().zip(&steps))
            .map(|(position, &step)| Channels {
                position,
                velocity: None,
                step,
                rate_hz,
                goes_on: [Continuation::of(position, 2, &low_pass); 2],
                stands: [false; 2],
            })
            .collect();
        let noises: Vec<f64> = of_positions.iter().map(|noise| noise.deviation).collect();
        let stands = stands_at_ends(&joints, &noises, &low_pass);
        signals.stands = stands;
        signals.starts_at_rest = stands[0] || starts_at_rest(&joints, &noises);
        for (j, channels) in joints.iter_mut().enumerate() {
            let (recorded, of_position) = (&recorded_velocity[j], &of_positions[j]);
            let mut noise = of_position.deviation * signals.kinematics_gain(1);
            let mut acceleration_noise = signals.in_band(of_position, 2);
            channels.stands = stands;
            let mut motion = channels.smooth(&low_pass);
            if !recorded.is_empty()
                && let Some(of_recorded) = signals.better_velocity(recorded, &motion.velocity)
            {
                channels.velocity = Some(recorded);
                channels.goes_on[1] = Continuation::of(recorded, 1, &low_pass);
                motion = channels.smooth(&low_pass);
                noise = of_recorded.deviation * signals.kinematics_gain(0);
                acceleration_noise = of_recorded.acceleration_in_band;
            }
            signals.acceleration_noise.push(acceleration_noise);
            signals.goes_on.push(channels.goes_on[0]);
            let rests = channels.rests(&motion.acceleration, of_position.deviation);
            // where a joint stops its neighbours' accelerations jump as well, and are smeared: to them it is as smeared
            signals.acceleration.push(motion.acceleration.clone());
            let SmoothMotion { position, velocity, acceleration } =
                channels.smooth_between(&rests, &low_pass, motion);
            let (direction, stuck) =
                directions_and_stops(&velocity, &acceleration, &rests, noise, rate_hz);
            signals.position.push(position);
            signals.held_acceleration.push(held(&acceleration, &rests, rate_hz));
            signals.own_acceleration.push(acceleration);
            signals.rests.push(rests);
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
        let motions = [
            &mut self.position,
            &mut self.velocity,
            &mut self.acceleration,
            &mut self.own_acceleration,
            &mut self.held_acceleration,
        ];
        for values in motions.into_iter().flatten() {
            *values = every(step, values);
        }
        // directions jump, as efforts do
        let jumping =
            [&mut self.recorded_position, &mut self.direction, &mut self.effort, &mut self.taken];
        for values in jumping.into_iter().flatten() {
            *values = means(step, values);
        }
        for stuck in &mut self.stuck {
            *stuck = every(step, stuck);
        }
        for rests in &mut self.rests {
            for (start, end) in rests.iter_mut() {
                (*start, *end) = (start.div_ceil(step), end.div_ceil(step));
            }
            rests.retain(|(start, end)| start < end);
        }
        self.time_s = every(step, &self.time_s);
        self.rate_hz /= step as f64;
        self.band = Band::new(self.rate_hz, self.time_s.len(), self.band_hz);
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

impl Signals {
    /// The efforts as they were before a delay \[s\]: at every instant, what is recorded that much
    /// later.
    pub(crate) fn effort_before(&self, delay_s: f64) -> Vec<Vec<f64>> {
        // what was recorded is late, what is known is not
        let before = |(all, taken): (Vec<f64>, &Vec<f64>)| {
            let before = later(&all, delay_s * self.rate_hz);
            before.iter().zip(taken).map(|(e, taken)| e - taken).collect()
        };
        self.with_taken(self.effort.clone()).into_iter().zip(&self.taken).map(before).collect()
    }

    /// Efforts with what was taken out of the recorded ones.
    pub(crate) fn with_taken(&self, mut effort: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        for (effort, taken) in effort.iter_mut().zip(&self.taken) {
            effort.iter_mut().zip(taken).for_each(|(e, taken)| *e += taken);
        }
        effort
    }

    /// The same with a known part of the efforts taken out.
    pub(crate) fn without(mut self, known: Vec<Vec<f64>>) -> Self {
        for ((effort, taken), known) in self.effort.iter_mut().zip(&mut self.taken).zip(known) {
            for ((effort, taken), known) in effort.iter_mut().zip(taken).zip(known) {
                *effort -= known;
                *taken += known;
            }
        }
        self
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
    use super::{SEARCHED_SAMPLES, Signals, means};
    use crate::band::BAND_HZ;
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
        let all = Signals::below(&recording, &joints, BAND_HZ).unwrap();
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
}
