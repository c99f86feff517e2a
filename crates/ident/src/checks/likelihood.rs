//! How likely a recorded channel is under a relation to the joint's effort.
//!
//! ```text
//! channel = b (Y x - c g) + φ p + noise,   x ~ N(x₀, Σ),   p flat,   noise of unknown level
//! ```
//!
//! `b` is the gain (1 for the joint's effort, -1 with the sign flipped, 1/N on the motor side), `c` is 1
//! if gravity `g` is compensated. The constants `x` have a Gaussian prior about the URDF's with covariance `Σ` from errors
//! of every parameter of a link, and of a load; so a URDF that is wrong by its size is no evidence against a channel. `x` and
//! `p` are integrated out in closed form: rows reduced to a triangle, friction columns first, then
//! `A = R Σ^(1/2) = U S Vᵀ`, after which every `b` costs one pass over the singular values.

use armident_numeric::{AccumulatedQr, Mat, NumericError, ThinSvd};
use statrs::distribution::{ContinuousCDF, Normal};

use super::rows::ChannelRows;

/// Steps of the search for the noise level, golden sections of its logarithm over the
/// [possible range](SMALLEST_NOISE): 1e-5 of it is left.
const NOISE_STEPS: usize = 24;
/// Relative size below which a friction column is collinear with the others.
const DEPENDENT: f64 = 1e-6;
/// Smallest noise level, as a share of the channel.
const SMALLEST_NOISE: f64 = 1e-9;

/// The relation between a channel and the effort of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Relation {
    /// `b`.
    pub(super) gain: f64,
    /// `c = 1`.
    pub(super) without_gravity: bool,
}

/// Rows of one joint against its prior, ready for any channel.
pub(super) struct JointModel {
    /// friction block of the triangle and its part over the constants times `Σ^(1/2)`
    friction: Mat<f64>,
    friction_of_spread: Mat<f64>,
    friction_of_mean: Vec<f64>,
    svd: ThinSvd,
    /// `Uᵀ R x₀`
    mean: Vec<f64>,
    gravity: Vec<f64>,
    efforts: Vec<Vec<f64>>,
    /// positions within the friction block of parameters that are not negative
    dissipative: Vec<usize>,
    /// rows of the friction block and of the constants' block
    blocks: (usize, usize),
    samples: f64,
}

impl JointModel {
    /// `friction` and `constants` are positions among the joint's terms; `spread` the columns of
    /// `Σ^(1/2)` and `mean` the values `x₀`, of these constants; `dissipative` are positions within
    /// `friction` of parameters that cannot be negative.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub(super) fn new(
        rows: &ChannelRows,
        friction: &[usize],
        constants: &[usize],
        dissipative: Vec<usize>,
        spread: &[Vec<f64>],
        mean: &[f64],
    ) -> Result<Self, NumericError> {
        let triangle: &AccumulatedQr = &rows.triangle;
        let efforts = (0..rows.joints).map(|k| rows.effort_of(k));
        let order: Vec<usize> = friction
            .iter()
            .chain(constants)
            .copied()
            .chain([rows.gravity()])
            .chain(efforts)
            .collect();
        let r = triangle.reordered(&order);
        let (f, z) = (friction.len(), constants.len());
        let times = |i: usize, x: &[f64]| (0..z).map(|k| r[(i, f + k)] * x[k]).sum::<f64>();
        let a = Mat::from_fn(z, spread.len().max(1), |i, j| {
            spread.get(j).map_or(0.0, |column| times(f + i, column))
        });
        let svd = ThinSvd::of(&a)?;
        let of_mean: Vec<f64> = (0..z).map(|i| times(f + i, mean)).collect();
        let column = |j: usize| -> Vec<f64> { (0..order.len()).map(|i| r[(i, j)]).collect() };
        Ok(Self {
            friction: Mat::from_fn(f, f, |i, j| r[(i, j)]),
            friction_of_spread: Mat::from_fn(f, spread.len().max(1), |i, j| {
                spread.get(j).map_or(0.0, |column| times(i, column))
            }),
            friction_of_mean: (0..f).map(|i| times(i, mean)).collect(),
            mean: project(&svd.u, &of_mean),
            svd,
            gravity: column(f + z),
            efforts: (0..rows.joints).map(|k| column(f + z + 1 + k)).collect(),
            dissipative,
            blocks: (f, z),
            samples: rows.samples,
        })
    }

    /// `-2 ln` of the likelihood that the channel of joint `channel` is this joint's effort in this
    /// relation, but for [`against_dissipation`](Self::against_dissipation); comparable between relations
    /// and, summed, between assignments of the same channels. `own` are the rows of the channel's joint.
    pub(super) fn deviance(&self, channel: usize, relation: Relation, own: &ChannelRows) -> f64 {
        self.fit(channel, relation, own).deviance
    }

    fn fit(&self, channel: usize, relation: Relation, own: &ChannelRows) -> NoiseFit {
        let effective = own.effective_of_model_error;
        let (f, z) = self.blocks;
        let b = relation.gain;
        let taken = if relation.without_gravity { b } else { 0.0 };
        let y: Vec<f64> =
            self.efforts[channel].iter().zip(&self.gravity).map(|(e, g)| e + taken * g).collect();
        let left: f64 = y[f + z..].iter().map(|x| x * x).sum();
        let along = project(&self.svd.u, &y[f..f + z]);
        let off: Vec<f64> = along.iter().zip(&self.mean).map(|(d, m)| d - b * m).collect();
        let weight = effective / self.samples;
        let freedom = (effective - f as f64).max(1.0);
        let scale = self.efforts[channel].iter().map(|x| x * x).sum::<f64>() / self.samples;
        let of_noise = |log_variance: f64| -> f64 {
            let variance = log_variance.exp();
            let of_constants = off.iter().zip(&self.svd.s).map(|(d, s)| {
                let prior = weight * (b * s).powi(2);
                (1.0 + prior / variance).ln() + weight * d * d / (variance + prior)
            });
            freedom * log_variance + weight * left / variance + of_constants.sum::<f64>()
        };
        // rows of dependent columns hold part of the residual, so `left` alone is no lower bound
        let least = scale * SMALLEST_NOISE.powi(2);
        let least = least.max(own.noise * own.noise).max(f64::MIN_POSITIVE).min(scale).ln();
        let (log_variance, deviance) =
            golden(of_noise, least, scale.max(f64::MIN_POSITIVE).ln() + 1.0);
        NoiseFit { variance: log_variance.exp(), deviance, off, y }
    }

    /// `-2 Σ ln Φ(p/s)` over friction and rotor inertia, which cannot be negative. The rest of the
    /// residual could look like any of them: it counts into `s` as a whole, besides the standard error.
    pub(super) fn against_dissipation(
        &self,
        channel: usize,
        relation: Relation,
        own: &ChannelRows,
    ) -> f64 {
        let effective = own.effective_of_model_error;
        let fit = self.fit(channel, relation, own);
        let f = self.blocks.0;
        let b = relation.gain;
        let weight = effective / self.samples;
        // posterior of ξ, x = x₀ + Σ^(1/2) ξ
        let share: Vec<f64> = (self.svd.s.iter())
            .map(|s| {
                let prior = weight * (b * s).powi(2);
                prior / (fit.variance + prior)
            })
            .collect();
        let m = self.svd.v.nrows();
        let mut xi = vec![0.0; m];
        for (k, s) in self.svd.s.iter().enumerate() {
            if *s > 0.0 && b != 0.0 {
                let along = share[k] * fit.off[k] / (b * s);
                for i in 0..m {
                    xi[i] += self.svd.v[(i, k)] * along;
                }
            }
        }
        let g = &self.friction_of_spread;
        let rhs: Vec<f64> = (0..f)
            .map(|i| {
                let of_xi: f64 = (0..m).map(|j| g[(i, j)] * xi[j]).sum();
                fit.y[i] - b * (self.friction_of_mean[i] + of_xi)
            })
            .collect();
        let inverse = inverse_of_triangle(&self.friction);
        let Ok(normal) = Normal::new(0.0, 1.0) else { return 0.0 };
        let mut sum = 0.0;
        for &k in &self.dissipative {
            let Some(row) = &inverse[k] else { continue };
            let p: f64 = row.iter().zip(&rhs).map(|(w, y)| w * y).sum();
            // variance: of the rows, and of x
            let of_rows: f64 = row.iter().map(|w| w * w).sum::<f64>() * fit.variance / weight;
            let w_g: Vec<f64> =
                (0..m).map(|j| (0..f).map(|i| row[i] * g[(i, j)]).sum::<f64>()).collect();
            let mut of_x: f64 = w_g.iter().map(|x| x * x).sum();
            for (q, share) in share.iter().enumerate() {
                let along: f64 = (0..m).map(|j| w_g[j] * self.svd.v[(j, q)]).sum();
                of_x -= share * along * along;
            }
            let rms = self.column_rms(k);
            let posing = fit.variance / (rms * rms);
            let s = (of_rows + b * b * of_x.max(0.0) + posing).sqrt();
            let likely = normal.cdf(b.signum() * p / s).max(1e-300);
            sum -= 2.0 * likely.ln();
        }
        sum
    }

    fn column_rms(&self, k: usize) -> f64 {
        let squares: f64 = (0..=k).map(|i| self.friction[(i, k)].powi(2)).sum();
        (squares / self.samples).sqrt()
    }
}

struct NoiseFit {
    variance: f64,
    deviance: f64,
    off: Vec<f64>,
    y: Vec<f64>,
}

fn project(u: &Mat<f64>, y: &[f64]) -> Vec<f64> {
    (0..u.ncols()).map(|k| (0..u.nrows()).map(|i| u[(i, k)] * y[i]).sum()).collect()
}

/// Rows of the inverse of an upper triangle; none for what depends on the columns before it, or has
/// such a column behind it in its row.
fn inverse_of_triangle(r: &Mat<f64>) -> Vec<Option<Vec<f64>>> {
    let f = r.nrows();
    let norm = |k: usize| (0..=k).map(|i| r[(i, k)].powi(2)).sum::<f64>().sqrt();
    let sound: Vec<bool> =
        (0..f).map(|k| norm(k) > 0.0 && r[(k, k)].abs() > DEPENDENT * norm(k)).collect();
    let mut rows: Vec<Option<Vec<f64>>> = vec![None; f];
    for i in 0..f {
        // w with wᵀ R = e_iᵀ
        if !(i..f).all(|k| sound[k]) {
            continue;
        }
        let mut w = vec![0.0; f];
        for j in i..f {
            let known: f64 = (i..j).map(|k| w[k] * r[(k, j)]).sum();
            let wanted = if j == i { 1.0 } else { 0.0 };
            w[j] = (wanted - known) / r[(j, j)];
        }
        rows[i] = Some(w);
    }
    rows
}

/// Minimum of a function with one valley: place and value.
fn golden(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> (f64, f64) {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (f(left), f(right));
    for _ in 0..NOISE_STEPS {
        if at_left < at_right {
            high = right;
            (right, at_right) = (left, at_left);
            left = high - ratio * (high - low);
            at_left = f(left);
        } else {
            low = left;
            (left, at_left) = (right, at_right);
            right = low + ratio * (high - low);
            at_right = f(right);
        }
    }
    if at_left < at_right { (left, at_left) } else { (right, at_right) }
}
