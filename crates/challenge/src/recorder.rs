//! Sensors, clocks and files: what is recorded of an exact motion.

use std::f64::consts::TAU;

use armident_recording::{JointChannels, Recording};

use crate::excitation::CONTROL_HZ;
use crate::random::Draw;
use crate::truth::VelocityTruth;

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

/// An exact motion at the instants of a recording; joint-major.
pub(crate) struct Exact {
    pub(crate) time_s: Vec<f64>,
    pub(crate) position: Vec<Vec<f64>>,
    pub(crate) velocity: Vec<Vec<f64>>,
    pub(crate) acceleration: Vec<Vec<f64>>,
    /// As its channel shows it without lag and noise.
    pub(crate) effort: Vec<Vec<f64>>,
}

/// The instants of a recording.
pub(crate) fn instants(
    rate_hz: f64,
    duration_s: f64,
    sensing: &Sensing,
    random: &mut Draw,
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

/// The motion at these instants; efforts that are held for a control cycle count for its middle.
pub(crate) fn exact_at(moved: &Recording, instants: &[f64]) -> Exact {
    let column = |pick: fn(&JointChannels) -> &Option<Vec<f64>>| -> Vec<&[f64]> {
        moved.joints.iter().map(|joint| pick(joint).as_deref().unwrap_or_default()).collect()
    };
    let (q, v) = (column(|j| &j.position), column(|j| &j.velocity));
    let u = column(|j| &j.effort);
    let last = moved.len() - 2;
    let place = |t: f64| {
        let k = ((t * CONTROL_HZ).floor().max(0.0) as usize).min(last);
        (k, t * CONTROL_HZ - k as f64)
    };
    let h = 1.0 / CONTROL_HZ;
    let each = |f: &dyn Fn(usize, usize, f64) -> f64| -> Vec<Vec<f64>> {
        (0..q.len())
            .map(|j| {
                let at = |t: &f64| {
                    let (k, share) = place(*t);
                    f(j, k, share)
                };
                instants.iter().map(at).collect()
            })
            .collect()
    };
    let line = |x: &[f64], k: usize, share: f64| x[k] + share * (x[k + 1] - x[k]);
    Exact {
        time_s: instants.to_vec(),
        position: each(&|j, k, s| {
            let (r, x) = (1.0 - s, q[j]);
            x[k] * r * r * (1.0 + 2.0 * s)
                + x[k + 1] * s * s * (1.0 + 2.0 * r)
                + h * s * r * (v[j][k] * r - v[j][k + 1] * s)
        }),
        velocity: each(&|j, k, share| line(v[j], k, share)),
        // that of a whole cycle, as the effort
        acceleration: each(&|j, k, share| {
            let x = |k: usize| (v[j][k + 1] - v[j][k]) / h;
            let (before, share) = about_middles(k, share);
            let before = before.min(last - 1);
            x(before) + share * (x(before + 1) - x(before))
        }),
        effort: each(&|j, k, share| {
            let (before, share) = about_middles(k, share);
            line(u[j], before, share)
        }),
    }
}

/// Place between the middles of control cycles of a place between their starts.
fn about_middles(k: usize, share: f64) -> (usize, f64) {
    if share >= 0.5 || k == 0 { (k, share - 0.5) } else { (k - 1, share + 0.5) }
}

/// The recording that these sensors take.
pub(crate) fn record(
    moved: &Recording,
    exact: &Exact,
    sensing: &Sensing,
    effort_lag_s: f64,
    name: &str,
    random: &mut Draw,
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
        let lagged = lag(&exact.time_s, &exact.effort[j], effort_lag_s);
        let noise = coloured(exact.time_s.len(), sensing.sigma[j], sensing.colour, random);
        let digit = 10_f64.powf((0.1 * sensing.sigma[j]).log10().floor());
        let effort = lagged
            .iter()
            .zip(noise)
            .map(|(effort, noise)| round_to(effort + noise, digit))
            .collect();
        joints.push(JointChannels {
            position: Some(position),
            velocity,
            effort: Some(effort),
            ..JointChannels::new(&joint.name)
        });
    }
    Recording::new(name, exact.time_s.clone(), joints)
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
fn coloured(count: usize, sigma: f64, colour: f64, random: &mut Draw) -> Vec<f64> {
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

pub(crate) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// To a decimal digit, exactly as it is written.
fn round_to(value: f64, digit: f64) -> f64 {
    let scale = (1.0 / digit).round();
    if scale >= 1.0 { (value * scale).round() / scale } else { (value / digit).round() * digit }
}
