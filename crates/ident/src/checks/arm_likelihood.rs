//! How likely the efforts of all joints are together, under one set of links.
//!
//! ```text
//! effort_j = b_j Y_j x + φ_j p_j + noise_j,   x ~ N(x₀, Λ),   b_j ~ N(1, 0.3²),   p flat,   noise of unknown level
//! ```
//!
//! Method: as [`likelihood`](super::likelihood), but the constants are those of all joints together, so what one joint
//! shows of a link binds the others. `x` is integrated out in closed form, gains and noise levels are at their most likely
//! values (MacKay's fixed point). A joint's column may also be any multiple of its effort, or have a spring or a
//! counterbalance beside it, each with the prior of a fault: what one column alone explains is no case against the arm.
//!
//! References: D. J. C. MacKay, Bayesian interpolation, Neural Computation 4 (1992).

use std::sync::OnceLock;

use armident_inference::log_sum;
use armident_numeric::{Cholesky, Mat, dot};
use nalgebra::Vector3;

use super::arm_columns::{ArmColumns, JointProducts, beyond_first};
use super::link_errors::{LARGEST_LOG_GAIN, USUAL_LOG_GAIN};

/// Steps of the fixed point of noise levels and gains: at most.
const STEPS: usize = 16;
/// Change of the logarithm of a variance at which they have converged: a hundredth of a unit of likelihood.
const CONVERGED: f64 = 1e-3;
/// Share of the effort beside friction that must remain for another meaning of its column to be tried.
const POOR: f64 = 0.1;
/// Prior probability of a spring or a counterbalance on a joint, ...
const SPRING: f64 = 0.03;
/// ... and of a column that is another multiple of the effort.
const OTHER_GAIN: f64 = 0.02;
/// Smallest noise as a share of the effort: arms are known to no better than this.
const SMALLEST_NOISE: f64 = 1e-3;
/// Relative size of the jitter that makes a prior covariance definite.
const JITTER: f64 = 1e-10;

/// Prior of the constants: `x = mean + root z`, `z ~ N(0, I)`.
pub(super) struct ConstantPrior {
    pub(super) mean: Vec<f64>,
    /// lower triangle
    root: Mat<f64>,
}

impl ConstantPrior {
    /// From the columns of a root of the covariance; none where there is no prior.
    pub(super) fn of(mean: Vec<f64>, spread: &[Vec<f64>]) -> Option<Self> {
        let n = mean.len();
        let covariance = |i: usize, j: usize| spread.iter().map(|s| s[i] * s[j]).sum::<f64>();
        let size: Vec<f64> = (0..n).map(|i| covariance(i, i).sqrt()).collect();
        let largest = size.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return None;
        }
        let size: Vec<f64> = size.iter().map(|s| s.max(1e-9 * largest)).collect();
        let scaled = |i: usize, j: usize| {
            covariance(i, j) / (size[i] * size[j]) + if i == j { JITTER } else { 0.0 }
        };
        let factor = Cholesky::of(n, scaled)?;
        // columns of the triangle: L e_k
        let mut root = Mat::zeros(n, n);
        for i in 0..n {
            for (j, value) in factor.row(i).iter().enumerate() {
                root[(i, j)] = size[i] * value;
            }
        }
        Some(Self { mean, root })
    }

    /// Rows of the root of some constants, and behind them `extra` parameters that stay as they are.
    pub(super) fn standardised_with(&self, constants: &[usize], extra: usize) -> Mat<f64> {
        let (z, m) = (constants.len(), self.mean.len());
        Mat::from_fn(z + extra, m + extra, |i, k| match (i < z, k < m) {
            (true, true) => self.root[(constants[i], k)],
            (false, false) if i - z == k - m => 1.0,
            _ => 0.0,
        })
    }
}

/// What a column is taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// The joint's effort.
    Effort,
    /// The joint's effort beside a spring or a counterbalance.
    Compliant,
    /// Any multiple of the effort, with either sign.
    Multiple,
}

/// One joint at one gravity: products of its constants and its effort, friction projected out.
struct JointSystem {
    constants: Vec<usize>,
    /// with the effort behind the constants
    products: Mat<f64>,
    samples: f64,
    independent: f64,
    /// parameters projected out
    aside: f64,
    least_variance: f64,
}

/// What is known of each recorded joint beside its columns.
pub(super) struct JointFacts {
    /// standard deviation of the recorded noise in the band \[N m or N\]
    pub(super) noise: Vec<f64>,
    /// the effort is known as a current or voltage only
    pub(super) is_signal: Vec<bool>,
    /// left out: the column shows nothing of its joint
    pub(super) is_mute: Vec<bool>,
}

/// The arm at one gravity with its joints recorded in one way.
pub(super) struct ArmSystem {
    plain: Vec<JointSystem>,
    compliant: Vec<OnceLock<JointSystem>>,
    /// with springs: what the others are made of, and how many columns are friction and spring
    whole: Vec<(Mat<f64>, [usize; 2])>,
    is_signal: Vec<bool>,
    is_mute: Vec<bool>,
}

/// The most likely fit under one prior.
#[derive(Debug, Clone)]
pub(super) struct ArmFit {
    pub(super) log_likelihood: f64,
    /// noise variance of each joint of the arm \[(N m)² or N²\]: of the whole residual
    pub(super) variance: Vec<f64>,
    pub(super) gain: Vec<f64>,
    pub(super) meaning: Vec<Meaning>,
    pub(super) x: Vec<f64>,
    /// the residual as a share of what friction leaves
    pub(super) left: Vec<f64>,
    /// the least variance that any fit could have
    pub(super) least_variance: Vec<f64>,
}

impl ArmSystem {
    /// `wanted`: blocks of time that count.
    pub(super) fn of(
        columns: &ArmColumns<'_>,
        products: &[JointProducts],
        facts: &JointFacts,
        gravity: &Vector3<f64>,
        wanted: &dyn Fn(usize) -> bool,
    ) -> Self {
        let whole: Vec<(Mat<f64>, [usize; 2])> = products
            .iter()
            .map(|of| {
                let all = of.at_gravity(&of.sum(wanted), gravity, true, &[]);
                (all, [of.friction, of.spring])
            })
            .collect();
        let plain = |(of, (all, [friction, spring])): (&JointProducts, &(Mat<f64>, [usize; 2]))| {
            let share = of.share(wanted);
            let samples = share * columns.samples[of.effort];
            let last = all.nrows() - 1;
            let at = |k: usize| if k < *friction { k } else { k + spring };
            let size = all.nrows() - spring;
            let without = Mat::from_fn(size, size, |i, j| all[(at(i), at(j))]);
            JointSystem {
                constants: of.constants.clone(),
                products: beyond_first(&without, *friction),
                samples,
                independent: share * columns.independent[of.effort],
                aside: *friction as f64,
                least_variance: (SMALLEST_NOISE.powi(2) * all[(last, last)] / samples.max(1.0))
                    .max(facts.noise[of.effort].powi(2))
                    .max(f64::MIN_POSITIVE),
            }
        };
        let by_joint = |of: &[bool]| products.iter().map(|p| of[p.effort]).collect();
        Self {
            plain: products.iter().zip(&whole).map(plain).collect(),
            compliant: products.iter().map(|_| OnceLock::new()).collect(),
            is_signal: by_joint(&facts.is_signal),
            is_mute: by_joint(&facts.is_mute),
            whole,
        }
    }

    fn system(&self, joint: usize, meaning: Meaning) -> &JointSystem {
        let plain = &self.plain[joint];
        if meaning != Meaning::Compliant {
            return plain;
        }
        self.compliant[joint].get_or_init(|| {
            let (all, [friction, spring]) = &self.whole[joint];
            JointSystem {
                constants: plain.constants.clone(),
                products: beyond_first(all, friction + spring),
                aside: (friction + spring) as f64,
                ..*plain
            }
        })
    }

    /// The most likely meanings of the columns, gains and noise levels.
    pub(super) fn fit(&self, prior: &ConstantPrior) -> ArmFit {
        let n = self.plain.len();
        let mut meaning: Vec<Meaning> = (self.is_signal.iter())
            .map(|signal| if *signal { Meaning::Multiple } else { Meaning::Effort })
            .collect();
        let plain: Vec<Standardised> =
            self.plain.iter().map(|s| Standardised::of(s, prior)).collect();
        let compliant: Vec<OnceLock<Standardised>> =
            plain.iter().map(|_| OnceLock::new()).collect();
        let fit_as = |meaning: &[Meaning]| {
            let standardised: Vec<&Standardised> = (0..n)
                .map(|j| match meaning[j] {
                    Meaning::Compliant => compliant[j]
                        .get_or_init(|| Standardised::of(self.system(j, meaning[j]), prior)),
                    _ => &plain[j],
                })
                .collect();
            self.fit_as(prior, meaning, &standardised)
        };
        let mut best = fit_as(&meaning);
        // the worst joint first: it may be why others seem to be wrong
        let share = |fit: &ArmFit, j: usize| fit.variance[j] / self.plain[j].beside_friction();
        let mut open: Vec<usize> =
            (0..n).filter(|&j| !self.is_mute[j] && meaning[j] == Meaning::Effort).collect();
        while let Some(place) =
            (0..open.len()).max_by(|&a, &b| share(&best, open[a]).total_cmp(&share(&best, open[b])))
        {
            let j = open.swap_remove(place);
            if share(&best, j) < POOR {
                break;
            }
            for other in [Meaning::Multiple, Meaning::Compliant] {
                let mut tried = meaning.clone();
                tried[j] = other;
                let fit = fit_as(&tried);
                if fit.log_likelihood > best.log_likelihood {
                    best = fit;
                }
            }
            meaning.clone_from(&best.meaning);
        }
        best
    }

    fn fit_as(
        &self,
        prior: &ConstantPrior,
        meaning: &[Meaning],
        standardised: &[&Standardised],
    ) -> ArmFit {
        let (n, m) = (self.plain.len(), prior.mean.len());
        let systems: Vec<&JointSystem> = (0..n).map(|j| self.system(j, meaning[j])).collect();
        let usable: Vec<usize> = (0..n).filter(|&j| !self.is_mute[j]).collect();
        let mut x = prior.mean.clone();
        let mut gain = vec![1.0; n];
        let mut variance: Vec<f64> =
            systems.iter().map(|s| s.beside_friction().max(s.least_variance)).collect();
        for &j in usable.iter().filter(|&&j| meaning[j] == Meaning::Multiple) {
            let (along, square) = systems[j].against(&x);
            if square > 0.0 {
                gain[j] = bounded(along / square, systems[j], square);
            }
        }
        let mut log_likelihood = f64::NEG_INFINITY;
        let mut last = false;
        for step in 0..STEPS {
            let mut changed = 0.0_f64;
            let weight: Vec<f64> = (0..n)
                .map(|j| systems[j].independent / (systems[j].samples.max(1.0) * variance[j]))
                .collect();
            let mut information = Mat::<f64>::zeros(m, m);
            let mut rhs = vec![0.0; m];
            for &j in &usable {
                let factor = weight[j] * gain[j] * gain[j];
                information += faer_scaled(&standardised[j].square, factor);
                for (k, r) in rhs.iter_mut().enumerate() {
                    *r += weight[j] * gain[j] * standardised[j].effort[k]
                        - factor * standardised[j].mean[k];
                }
            }
            let entry = |i: usize, j: usize| information[(i, j)] + f64::from(u8::from(i == j));
            let Some(root) = Cholesky::of(m, entry) else { break };
            let z = root.solve(&rhs);
            for (i, x) in x.iter_mut().enumerate() {
                *x = prior.mean[i] + (0..=i).map(|k| prior.root[(i, k)] * z[k]).sum::<f64>();
            }
            let inverse = root.inverse();
            let mut twice = -root.log_determinant() - dot(&z, &z);
            for &j in &usable {
                let system = systems[j];
                let (along, square) = system.against(&x);
                let effort = system.effort_square();
                let freedom = (system.independent - system.aside).max(1.0);
                let used: f64 =
                    weight[j] * gain[j] * gain[j] * standardised[j].trace_with(&inverse);
                // what the constants take, the gain counted with them
                let left_of = |b: f64| (effort - 2.0 * b * along + b * b * square).max(0.0);
                let per = system.independent / system.samples.max(1.0);
                let left = left_of(gain[j]);
                twice -= freedom * variance[j].ln() + weight[j] * left;
                twice += match meaning[j] {
                    Meaning::Effort | Meaning::Compliant => {
                        let spread = USUAL_LOG_GAIN;
                        let known = weight[j] * square * spread * spread;
                        -((gain[j] - 1.0) / spread).powi(2) - (1.0 + known).ln()
                    }
                    Meaning::Multiple => {
                        let known = weight[j] * square * gain[j] * gain[j];
                        -2.0 * (4.0 * LARGEST_LOG_GAIN).ln() - (1.0 + known).ln()
                    }
                };
                twice += match meaning[j] {
                    Meaning::Effort => 2.0 * (1.0 - SPRING - OTHER_GAIN).ln(),
                    // flat coefficients: a quarter of an e-fold an independent sample each, as Schwarz counts
                    Meaning::Compliant => {
                        let coefficients = system.aside - self.plain[j].aside;
                        2.0 * SPRING.ln() - coefficients * system.independent.max(1.0).ln()
                    }
                    Meaning::Multiple if self.is_signal[j] => 0.0,
                    Meaning::Multiple => 2.0 * OTHER_GAIN.ln(),
                };
                if last {
                    continue;
                }
                let free = (freedom - used).max(0.1 * freedom).max(0.5);
                let before = variance[j];
                variance[j] = (per * left / free).max(system.least_variance);
                changed = changed.max((variance[j] / before).ln().abs());
                if square > 0.0 {
                    gain[j] = match meaning[j] {
                        Meaning::Multiple => bounded(along / square, system, square),
                        Meaning::Effort | Meaning::Compliant => {
                            let (known, prior) =
                                (per * square / variance[j], USUAL_LOG_GAIN.powi(-2));
                            let likely = per * along / variance[j];
                            ((likely + prior) / (known + prior)).max(0.1)
                        }
                    };
                }
            }
            log_likelihood = 0.5 * twice;
            if last {
                break;
            }
            last = changed < CONVERGED || step + 2 == STEPS;
        }
        let left = (0..n).map(|j| variance[j] / systems[j].beside_friction()).collect();
        let least_variance = systems.iter().map(|s| s.least_variance).collect();
        ArmFit {
            log_likelihood,
            variance,
            gain,
            meaning: meaning.to_vec(),
            x,
            left,
            least_variance,
        }
    }
}

/// A gain within the range that is looked at, and no larger than the recorded effort allows twice over.
fn bounded(gain: f64, system: &JointSystem, square: f64) -> f64 {
    let most = (2.0 * (system.effort_square() / square).sqrt()).min(LARGEST_LOG_GAIN.exp());
    let least = (-LARGEST_LOG_GAIN).exp();
    if gain == 0.0 { least } else { gain.signum() * gain.abs().clamp(least.min(most), most) }
}

impl JointSystem {
    fn effort_square(&self) -> f64 {
        let last = self.products.nrows() - 1;
        self.products[(last, last)].max(0.0)
    }

    /// Mean square of the effort that friction does not explain.
    fn beside_friction(&self) -> f64 {
        self.effort_square() / self.samples.max(1.0)
    }

    /// Product of the effort with the one that constants give, and the square of that.
    fn against(&self, x: &[f64]) -> (f64, f64) {
        let z = self.constants.len();
        let own: Vec<f64> = self.constants.iter().map(|&c| x[c]).collect();
        let mut square = 0.0;
        for i in 0..z {
            let row: f64 = (0..z).map(|j| self.products[(i, j)] * own[j]).sum();
            square += own[i] * row;
        }
        let along: f64 = (0..z).map(|i| self.products[(i, z)] * own[i]).sum();
        (along, square.max(0.0))
    }
}

/// A joint's products over the standardised constants.
struct Standardised {
    /// `Lᵀ K L`
    square: Mat<f64>,
    /// `Lᵀ Yᵀ e`
    effort: Vec<f64>,
    /// `Lᵀ K x₀`
    mean: Vec<f64>,
}

impl Standardised {
    fn of(system: &JointSystem, prior: &ConstantPrior) -> Self {
        let (z, m) = (system.constants.len(), prior.mean.len());
        let root = Mat::from_fn(z, m, |i, k| prior.root[(system.constants[i], k)]);
        let products = Mat::from_fn(z, z, |i, j| system.products[(i, j)]);
        let half = &products * &root;
        let square = root.transpose() * &half;
        let over = |values: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..m).map(|k| (0..z).map(|i| root[(i, k)] * values(i)).sum()).collect()
        };
        let of_mean: Vec<f64> = (0..z)
            .map(|i| (0..z).map(|j| products[(i, j)] * prior.mean[system.constants[j]]).sum())
            .collect();
        Self { square, effort: over(&|i| system.products[(i, z)]), mean: over(&|i| of_mean[i]) }
    }

    fn trace_with(&self, other: &Mat<f64>) -> f64 {
        let m = other.nrows();
        (0..m).map(|i| (0..m).map(|j| self.square[(i, j)] * other[(i, j)]).sum::<f64>()).sum()
    }
}

fn faer_scaled(a: &Mat<f64>, factor: f64) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| factor * a[(i, j)])
}

/// The priors integrated out, all equally likely.
pub(super) fn mean_likelihood(fits: &[ArmFit]) -> f64 {
    let all: Vec<f64> = fits.iter().map(|fit| fit.log_likelihood).collect();
    log_sum(&all) - (fits.len() as f64).ln()
}
