//! Whether an arm stands where a recording starts, and where it ends.

use crate::ZeroPhaseLowPass;

use super::Channels;
use super::local_polynomial::{Fit, Sample};

/// An arm stands at an end of a recording where so much of its motion there \[s\], smoothed with so much around \[s\],
/// says so by twice this logarithm of the likelihood.
const END_S: f64 = 0.03;
const ROUND_END_S: f64 = 1.0;
const CLEAR: f64 = 10.0;
/// First positions of a recording that tell whether it starts at rest: through so many \[s\], and through so few, a cubic
/// is laid. A speed of this share of the usual one is none.
const ONSET_S: f64 = 0.06;
const LEAST_ONSET: usize = 6;
const STILL_SHARE: f64 = 5e-3;

impl Channels<'_> {
    /// Twice the logarithm of how much likelier the motion at the ends of the recording is of a joint that stands there,
    /// which goes on as its mirror image, than of one that is in motion. `noise` is that of the position.
    fn stands_by(&self, low_pass: &ZeroPhaseLowPass, noise: f64) -> [f64; 2] {
        if noise <= 0.0 {
            return [0.0; 2];
        }
        let n = self.position.len();
        let near = ((END_S * self.rate_hz).ceil() as usize).min(n);
        let part = (ROUND_END_S * self.rate_hz).ceil() as usize;
        [0, 1].map(|end| {
            let from = [0, n.saturating_sub(part)][end];
            let position = &self.position[from..(from + part).min(n)];
            let misfit = |stands: bool| -> f64 {
                let stands = [stands && end == 0, stands && end == 1];
                let smooth = Self { position, velocity: None, stands, ..*self }.smooth(low_pass);
                let first = [0, position.len() - near][end];
                let off = |t: usize| (smooth.position[t] - position[t]) / noise;
                (first..first + near).map(|t| off(t).powi(2)).sum()
            };
            misfit(false) - misfit(true)
        })
    }

    /// Twice the logarithm of how much likelier the first positions are of a joint that starts at rest than of one whose
    /// speed there is as usual in the recording. `noise` is that of the position.
    fn starts_at_rest_by(&self, noise: f64) -> f64 {
        let near = ((ONSET_S * self.rate_hz).round() as usize).max(LEAST_ONSET + 1);
        if noise <= 0.0 || self.position.len() <= 2 * near {
            return 0.0;
        }
        let way = |(a, b): (&f64, &f64)| ((b - a) * self.rate_hz / near as f64).powi(2);
        let later = &self.position[near..];
        let usual = self.position.iter().zip(later).map(way).sum::<f64>() / later.len() as f64;
        let by = |samples: usize| -> Option<f64> {
            let Onset { speed, variance, left } =
                Onset::of(&self.position[..samples], self.rate_hz)?;
            // what a cubic does not follow of the motion counts as noise
            let still = noise.powi(2).max(left) * variance + STILL_SHARE.powi(2) * usual;
            let [resting, moving] =
                [still, still + usual].map(|v: f64| -v.ln() - speed.powi(2) / v);
            Some(resting - moving)
        };
        // a light joint is off at once: little of its start is smooth
        [near, LEAST_ONSET].into_iter().filter_map(by).fold(f64::MIN, f64::max)
    }
}

/// Whether the arm stands at the ends of a recording, as it does where its drives are switched on: all its joints
/// together say so clearly. `noises` are those of the positions.
pub(crate) fn stands_at_ends(
    joints: &[Channels<'_>],
    noises: &[f64],
    low_pass: &ZeroPhaseLowPass,
) -> [bool; 2] {
    let mut sums = [0.0; 2];
    for (joint, noise) in joints.iter().zip(noises) {
        for (sum, x) in sums.iter_mut().zip(joint.stands_by(low_pass, *noise)) {
            *sum += x;
        }
    }
    sums.map(|sum| sum > CLEAR)
}

/// Whether an arm starts to move at the first sample or rests there: all its joints together say so clearly, also where
/// they are off so suddenly that their motion is none of joints that [stand](stands_at_ends). `noises` are those of the
/// positions.
pub(crate) fn starts_at_rest(joints: &[Channels<'_>], noises: &[f64]) -> bool {
    let by = joints.iter().zip(noises).map(|(joint, noise)| joint.starts_at_rest_by(*noise));
    by.sum::<f64>() > CLEAR
}

/// Speed of a motion at its first sample.
struct Onset {
    speed: f64,
    /// of the speed, for positions of variance 1
    variance: f64,
    /// variance of the positions about the cubic
    left: f64,
}

impl Onset {
    /// Of the cubic through some positions.
    fn of(positions: &[f64], rate_hz: f64) -> Option<Self> {
        let samples = positions.len() as f64;
        let sample = |k: usize| -> Sample<4> {
            let x = k as f64 / samples;
            let terms = [1.0, x, x * x, x * x * x];
            Sample { weight: 1.0, terms, value: positions[k] - positions[0] }
        };
        let cubic = Fit::of(&(0..positions.len()).map(sample).collect::<Vec<_>>())?;
        let per_second = rate_hz / samples;
        Some(Self {
            speed: cubic.coefficients[1] * per_second,
            variance: cubic.variances[1] * per_second.powi(2),
            left: cubic.left / (samples - cubic.coefficients.len() as f64),
        })
    }
}
