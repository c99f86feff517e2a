//! Sensors, clocks and files: what is recorded of an exact motion.

use std::f64::consts::TAU;

use armident_effects::Draw;
use armident_recording::{JointChannels, Recording};

use crate::arms::excitation::CONTROL_HZ;
use crate::cases::exact_motion::{Exact, rms};
use crate::cases::recording_faults::RecordingFaults;
use crate::contract::truth::VelocityTruth;
use crate::random::RandomStream;

/// Sensors of a case.
pub(crate) struct Sensing {
    /// Standard deviation of the effort noise \[N m or N\].
    pub(crate) sigma: Vec<f64>,
    /// `c` of the kernel `[c, 1 - 2c, c]` of the effort noise.
    pub(crate) colour: f64,
    /// Encoder counts \[rad or m\].
    pub(crate) count: Vec<f64>,
    /// The velocity channel, if there is one.
    pub(crate) velocity: Option<VelocityTruth>,
    /// Largest time constant of a filter in the effort channel \[s\].
    pub(crate) effort_lag_s: f64,
    /// Standard deviation of the sample instants over the step.
    pub(crate) jitter: f64,
    /// Share of samples that are lost.
    pub(crate) lost: f64,
}

impl Sensing {
    /// Sensors behind a logger with these faults: coarse efforts are noise too, and stamps of reception are of even samples.
    pub(crate) fn with_faults(&mut self, faults: &RecordingFaults) {
        for (sigma, step) in self.sigma.iter_mut().zip(faults.effort_step.iter().flatten()) {
            *sigma = sigma.hypot(step / 12_f64.sqrt());
        }
        if faults.received {
            self.jitter = 0.0;
        }
        self.effort_lag_s = 0.0;
    }
}

/// The instants of a recording.
pub(crate) fn instants(
    rate_hz: f64,
    duration_s: f64,
    sensing: &Sensing,
    random: &mut RandomStream,
) -> Vec<f64> {
    let step_s = 1.0 / rate_hz;
    let count = (duration_s * rate_hz).round() as usize;
    let mut kept = Vec::with_capacity(count);
    let mut burst = 0_usize;
    for k in 0..count {
        // jitter of a few sigma never reorders samples
        let off = (sensing.jitter * random.normal()).clamp(-0.4, 0.4);
        let at = round_to(((k as f64 + off) * step_s).max(0.0), 1e-5);
        // lost alone or in short bursts, as many as asked for on average
        if burst > 0 {
            burst -= 1;
            continue;
        }
        if k > 5 && random.chance(sensing.lost / 1.6) {
            burst = if random.chance(0.3) { 1 + random.index(3) } else { 0 };
            continue;
        }
        if kept.last().is_none_or(|last| at > *last) {
            kept.push(at);
        }
    }
    kept
}

/// The recording that these sensors take.
pub(crate) fn record(
    moved: &Recording,
    exact: &Exact,
    sensing: &Sensing,
    effort: &Efforts<'_>,
    name: &str,
    random: &mut RandomStream,
) -> Result<Recording, armident_recording::RecordingError> {
    let mut joints = Vec::new();
    for (j, joint) in moved.joints.iter().enumerate() {
        let count = sensing.count[j];
        let position: Vec<f64> =
            exact.position[j].iter().map(|q| round_to((q / count).round() * count, 1e-5)).collect();
        let velocity = sensing.velocity.as_ref().map(|channel| {
            let values = match channel.cutoff_hz {
                Some(cutoff_hz) => {
                    let position = joint.position.as_deref().unwrap_or_default();
                    let lagged = causal_velocity(position, count, cutoff_hz);
                    exact.time_s.iter().map(|t| at_cycle(&lagged, *t)).collect()
                }
                None => {
                    let share = channel.fraction_of_rms.unwrap_or_default();
                    let sigma = share * rms(&exact.velocity[j]);
                    exact.velocity[j]
                        .iter()
                        .map(|v| v + sigma * random.normal())
                        .collect::<Vec<_>>()
                }
            };
            values.iter().map(|v| round_to(*v, 1e-3)).collect()
        });
        let lagged = lag(&exact.time_s, &effort.exact[j], effort.lag_s);
        // what coarse efforts add comes by rounding them
        let step = effort.faults.effort_step.as_ref().map_or(0.0, |steps| steps[j]);
        let sigma = (sensing.sigma[j].powi(2) - step.powi(2) / 12.0).max(0.0).sqrt();
        let noise = coloured(exact.time_s.len(), sigma, sensing.colour, random);
        let digit = 10_f64.powf((0.1 * sensing.sigma[j]).log10().floor());
        let mut noisy: Vec<f64> = lagged
            .iter()
            .zip(noise)
            .map(|(effort, noise)| round_to(effort + noise, digit))
            .collect();
        effort.faults.of_efforts((effort.file, j), sensing.sigma[j], &mut noisy, random);
        joints.push(JointChannels {
            position: Some(position),
            velocity,
            effort: Some(noisy),
            ..JointChannels::new(&joint.name)
        });
    }
    let stamps = effort.faults.stamps(&exact.time_s, random);
    let kept: Vec<usize> = (0..stamps.len())
        .filter(|&k| !effort.faults.is_missing(effort.file, exact.time_s[k]))
        .collect();
    let of = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&k| values[k]).collect() };
    for joint in &mut joints {
        for channel in [&mut joint.position, &mut joint.velocity, &mut joint.effort] {
            *channel = channel.as_deref().map(of);
        }
    }
    Recording::new(name, of(&stamps), joints)
}

/// The efforts of a recording and what its channel does to them.
pub(crate) struct Efforts<'a> {
    /// At the instants at which they are sampled.
    pub(crate) exact: &'a [Vec<f64>],
    /// Time constant of a filter \[s\].
    pub(crate) lag_s: f64,
    pub(crate) faults: &'a RecordingFaults,
    /// Place of the recording in `FILES`.
    pub(crate) file: usize,
}

/// First-order lag of a channel.
pub(crate) fn lag(time_s: &[f64], values: &[f64], constant_s: f64) -> Vec<f64> {
    if constant_s <= 0.0 {
        return values.to_vec();
    }
    // of a line the lag is the value one time constant before, up to what decays
    let mut state = values[0];
    let mut lagged = vec![state];
    for k in 1..values.len() {
        let h = time_s[k] - time_s[k - 1];
        let slope = (values[k] - values[k - 1]) / h;
        let decay = (-h / constant_s).exp();
        let steady = |at: f64| at - slope * constant_s;
        state = steady(values[k]) + (state - steady(values[k - 1])) * decay;
        lagged.push(state);
    }
    lagged
}

/// Noise of this deviation through the kernel `[c, 1 - 2c, c]`.
fn coloured(count: usize, sigma: f64, colour: f64, random: &mut RandomStream) -> Vec<f64> {
    let white: Vec<f64> = (0..count + 2).map(|_| random.normal()).collect();
    let middle = 1.0 - 2.0 * colour;
    let size = (middle * middle + 2.0 * colour * colour).sqrt();
    let one = |k: usize| colour * (white[k] + white[k + 2]) + middle * white[k + 1];
    (0..count).map(|k| sigma * one(k) / size).collect()
}

/// The controller's velocity: differences of the encoder through a second-order low-pass.
fn causal_velocity(position: &[f64], count: f64, cutoff_hz: f64) -> Vec<f64> {
    let h = 1.0 / CONTROL_HZ;
    // bilinear Butterworth
    let k = (std::f64::consts::PI * cutoff_hz * h).tan();
    let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * k + k * k);
    let b = k * k * norm;
    let (a1, a2) =
        (2.0 * (k * k - 1.0) * norm, (1.0 - std::f64::consts::SQRT_2 * k + k * k) * norm);
    let encoder = |k: usize| (position[k] / count).round() * count;
    let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
    (0..position.len())
        .map(|k| {
            let difference = if k > 0 { (encoder(k) - encoder(k - 1)) / h } else { 0.0 };
            let filtered = b * (difference + 2.0 * x[0] + x[1]) - a1 * y[0] - a2 * y[1];
            (x, y) = ([difference, x[0]], [filtered, y[0]]);
            filtered
        })
        .collect()
}

fn at_cycle(values: &[f64], t: f64) -> f64 {
    values[((t * CONTROL_HZ).floor() as usize).min(values.len() - 1)]
}

/// Encoder count of `2^bits` per turn, or of a spindle of 10 mm a turn.
pub(crate) fn encoder_count(bits: u32, rotational: bool) -> f64 {
    let turn = if rotational { TAU } else { 0.2 };
    turn / 2_f64.powi(bits as i32)
}

/// To a decimal digit, exactly as it is written.
fn round_to(value: f64, digit: f64) -> f64 {
    let scale = (1.0 / digit).round();
    if scale >= 1.0 { (value * scale).round() / scale } else { (value / digit).round() * digit }
}
