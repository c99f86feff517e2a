//! One recording as the diagnosis sees it.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use crate::{EndExtension, EvenGrid, differentiate};
use armident_numeric::dot;
use armident_recording::{Quantity, Recording, RecordingError};
use rayon::prelude::*;

use crate::compare_band::Band;
use crate::decimate::{
    every, kinematics_cutoff_hz, kinematics_filter, kinematics_power, later, means,
};
use crate::noise_spectrum::{Noise, noise_of};
use crate::standstill::{
    Channels, CoupledJump, SmearedStep, SmoothMotion, Standstill, coupled_jumps_of,
    directions_and_stops, held, least_step, quantisation, stands_at_ends, starts_at_rest,
};

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
pub struct BandMotion {
    /// Where the recording comes from.
    pub source: String,
    /// Samples per second of the grid.
    pub rate_hz: f64,
    /// Samples per second before decimation.
    pub recorded_hz: f64,
    /// Times since the first sample \[s\].
    pub time_s: Vec<f64>,
    /// Positions on the grid, not filtered \[rad or m\].
    pub recorded_position: Vec<Vec<f64>>,
    /// How these go on past the ends of the recording.
    pub extensions: Vec<EndExtension>,
    /// Whether the arm is at rest at the first and at the last sample.
    pub stands: [bool; 2],
    /// Whether the arm rests at the first sample, however suddenly it moves then.
    pub starts_at_rest: bool,
    /// Low-passed positions \[rad or m\].
    pub position: Vec<Vec<f64>>,
    /// Their derivatives \[rad/s or m/s\].
    pub velocity: Vec<Vec<f64>>,
    /// Their second derivatives \[rad/s² or m/s²\].
    pub acceleration: Vec<Vec<f64>>,
    /// The same with the jumps where the joint stops.
    pub own_acceleration: Vec<Vec<f64>>,
    /// The same as the drive answers it: during a dwell it goes from that of before to none.
    pub actuator_acceleration: Vec<Vec<f64>>,
    /// Sign of the velocity, between -1 and 1 where a joint reverses within a sample or rests.
    pub direction: Vec<Vec<f64>>,
    /// Whether the joint rests at a sample.
    pub stuck: Vec<Vec<bool>>,
    /// Standstills of each joint, in the order of time.
    pub standstills: Vec<Vec<Standstill>>,
    /// accelerations of the other joints where one stops
    coupled_jumps: Vec<Vec<CoupledJump>>,
    smeared_step: Arc<SmearedStep>,
    /// Efforts on the grid \[N m or N\]; empty for a joint whose effort is not recorded.
    pub effort: Vec<Vec<f64>>,
    /// Known part of the recorded effort, no longer in `effort` \[N m or N\].
    pub known_effort: Vec<Vec<f64>>,
    /// Temperature of the drives on the grid \[°C\]; empty where it is not recorded.
    pub temperature_c: Vec<Vec<f64>>,
    /// Noise of the effort of one recorded sample \[N m or N\].
    pub effort_noise: Vec<f64>,
    /// Noise of the effort in the band \[N m or N\].
    pub effort_noise_in_band: Vec<f64>,
    /// Noise of the acceleration in the band \[rad/s² or m/s²\].
    pub acceleration_noise: Vec<f64>,
    /// The band in which efforts are compared.
    pub band: Band,
    /// below which all is compared, if the rate allows it
    pub(crate) band_hz: f64,
}

/// Noise of a recorded velocity \[rad/s or m/s\] and of its derivative in the band.
#[derive(Debug, Clone, Copy)]
struct VelocityNoise {
    deviation: f64,
    acceleration_in_band: f64,
}

impl BandMotion {
    /// At every sample, to be compared below this frequency.
    ///
    /// # Errors
    /// A joint without position, or a recording that is mostly gaps.
    pub fn below(
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
    pub fn on(
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
        let band = Band::new(rate_hz, time_s.len(), band_hz);
        // a cycle of the cut-off is what its kernel smears
        let unmeasured = grid.unmeasured_s(1.0 / band.cutoff_hz());
        let since_start = |(from_s, to_s): (f64, f64)| (from_s - start_s, to_s - start_s);
        let band = band.without(unmeasured.into_iter().map(since_start).collect());
        let mut signals = Self {
            source: recording.source.clone(),
            rate_hz,
            recorded_hz: rate_hz,
            band,
            band_hz,
            effort_noise: Vec::new(),
            effort_noise_in_band: Vec::new(),
            acceleration_noise: Vec::new(),
            position: Vec::new(),
            time_s,
            recorded_position,
            extensions: Vec::new(),
            stands: [false; 2],
            starts_at_rest: false,
            velocity: Vec::new(),
            acceleration: Vec::new(),
            direction: Vec::new(),
            stuck: Vec::new(),
            standstills: Vec::new(),
            coupled_jumps: Vec::new(),
            smeared_step: Arc::new(SmearedStep::of(kinematics_cutoff_hz(rate_hz))?),
            own_acceleration: Vec::new(),
            actuator_acceleration: Vec::new(),
            temperature_c: joints.iter().map(|j| on_grid(j, Quantity::Temperature)).collect(),
            known_effort: effort.iter().map(|e| vec![0.0; e.len()]).collect(),
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
                extensions: [EndExtension::of(position, 2, &low_pass); 2],
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
                channels.extensions[1] = EndExtension::of(recorded, 1, &low_pass);
                motion = channels.smooth(&low_pass);
                noise = of_recorded.deviation * signals.kinematics_gain(0);
                acceleration_noise = of_recorded.acceleration_in_band;
            }
            signals.acceleration_noise.push(acceleration_noise);
            signals.extensions.push(channels.extensions[0]);
            let stops = channels.stops(&motion, of_position.deviation, noise);
            // where a joint stops its neighbours' accelerations jump as well, and are smeared: to them it is as smeared
            signals.acceleration.push(motion.acceleration.clone());
            let SmoothMotion { position, velocity, acceleration } =
                channels.smooth_between(&stops, &low_pass, motion);
            let (direction, stuck) =
                directions_and_stops(&velocity, &acceleration, &stops, noise, rate_hz);
            signals.position.push(position);
            signals.actuator_acceleration.push(held(&acceleration, &stops, rate_hz));
            signals.own_acceleration.push(acceleration);
            signals.standstills.push(stops);
            signals.velocity.push(velocity);
            signals.direction.push(direction);
            signals.stuck.push(stuck);
        }
        let noises: Vec<f64> =
            noises.iter().zip(&steps).map(|(noise, step)| noise.max(quantisation(*step))).collect();
        let of_joint = |(j, stops): (usize, &Vec<Standstill>)| {
            coupled_jumps_of(stops, j, &positions, &noises, rate_hz)
        };
        signals.coupled_jumps = signals.standstills.par_iter().enumerate().map(of_joint).collect();
        Ok(signals)
    }

    /// Accelerations of all joints as they are on one of them: its own and, where it stops, the others' jump. While it rests
    /// they are what its drive answers if that is asked for (`held`).
    pub fn accelerations_on(&self, row: usize, held: bool) -> Cow<'_, [Vec<f64>]> {
        if self.standstills[row].is_empty() {
            return Cow::Borrowed(&self.acceleration);
        }
        let own = if held { &self.actuator_acceleration } else { &self.own_acceleration };
        let mut all = self.acceleration.clone();
        all[row].clone_from(&own[row]);
        for reaction in &self.coupled_jumps[row] {
            reaction.restore(&mut all, held, &self.smeared_step, self.rate_hz);
        }
        Cow::Owned(all)
    }

    /// Samples at which a joint rests.
    pub fn dwells_of(&self, joint: usize) -> impl Iterator<Item = Range<usize>> {
        let lasting = self.standstills[joint].iter().filter(|stop| stop.is_dwell(self.rate_hz));
        lasting.map(|stop| {
            let (start, end) = stop.samples();
            start.min(self.len())..end.min(self.len())
        })
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Whether a joint rests somewhere.
    pub fn has_dwell(&self, joint: usize) -> bool {
        self.standstills[joint].iter().any(|stop| stop.is_dwell(self.rate_hz))
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// With samples left out where there are more than a search needs: each law is formed at every sample
    /// hundreds of times, and all is compared in the band. Efforts, directions and positions as recorded become
    /// means around the samples that remain, motions are below the rate already; noise stays what it was found to be
    /// at every sample.
    pub fn thinned(mut self, of_all: usize) -> Self {
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
            &mut self.actuator_acceleration,
            &mut self.temperature_c,
        ];
        for values in motions.into_iter().flatten() {
            *values = every(step, values);
        }
        // directions jump, as efforts do
        let jumping = [
            &mut self.recorded_position,
            &mut self.direction,
            &mut self.effort,
            &mut self.known_effort,
        ];
        for values in jumping.into_iter().flatten() {
            *values = means(step, values);
        }
        for stuck in &mut self.stuck {
            *stuck = every(step, stuck);
        }
        for stop in self.standstills.iter_mut().flatten() {
            *stop = stop.thinned(step);
        }
        for reaction in self.coupled_jumps.iter_mut().flatten() {
            *reaction = reaction.thinned(step);
        }
        self.time_s = every(step, &self.time_s);
        self.rate_hz /= step as f64;
        let left_out_s = self.band.left_out_s().to_vec();
        self.band = Band::new(self.rate_hz, self.time_s.len(), self.band_hz).without(left_out_s);
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

impl BandMotion {
    /// The efforts as they were before a delay \[s\]: at every instant, what is recorded that much
    /// later.
    pub fn effort_before(&self, delay_s: f64) -> Vec<Vec<f64>> {
        // what was recorded is late, what is known is not
        let before = |(all, known_effort): (Vec<f64>, &Vec<f64>)| {
            let before = later(&all, delay_s * self.rate_hz);
            before.iter().zip(known_effort).map(|(e, known_effort)| e - known_effort).collect()
        };
        self.with_known_effort(self.effort.clone())
            .into_iter()
            .zip(&self.known_effort)
            .map(before)
            .collect()
    }

    /// Efforts with the known ones added again.
    pub fn with_known_effort(&self, mut effort: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        for (effort, known_effort) in effort.iter_mut().zip(&self.known_effort) {
            effort.iter_mut().zip(known_effort).for_each(|(e, known_effort)| *e += known_effort);
        }
        effort
    }

    /// The same with a known part of the efforts subtracted.
    pub fn without(mut self, known: Vec<Vec<f64>>) -> Self {
        for ((effort, known_effort), known) in
            self.effort.iter_mut().zip(&mut self.known_effort).zip(known)
        {
            for ((effort, known_effort), known) in effort.iter_mut().zip(known_effort).zip(known) {
                *effort -= known;
                *known_effort += known;
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::{BandMotion, SEARCHED_SAMPLES};
    use crate::compare_band::BAND_HZ;
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
        let all = BandMotion::below(&recording, &joints, BAND_HZ).unwrap();
        let few = all.clone().thinned(recording.len());
        // just beyond the budget: half of them; and what is long enough goes down to 250 Hz
        assert_eq!(recording.len().div_ceil(SEARCHED_SAMPLES), 2);
        assert!((few.rate_hz - 500.0).abs() < 1e-9, "{}", few.rate_hz);
        assert!((all.clone().thinned(1_000_000).rate_hz - 250.0).abs() < 1e-9);
        assert!((all.clone().thinned(SEARCHED_SAMPLES).rate_hz - 1000.0).abs() < 1e-9);
        for few in [few, all.clone().thinned(1_000_000)] {
            let size =
                |rows: &[f64]| (armident_numeric::dot(rows, rows) / rows.len() as f64).sqrt();
            let channels = |s: &BandMotion| -> [Vec<f64>; 5] {
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
}
