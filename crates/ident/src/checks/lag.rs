//! How late the efforts come behind the motion: one number for the robot, of a delay or of a low-pass.
//!
//! Method: profile likelihood of the free model of each joint, its columns seen through a lag that is exact at every frequency, over
//! the number of the lag. The efforts stay as recorded, so that all lags have the same noise. Only samples away from the joint's
//! reversals are compared. Gauss-Newton steps on the derivative of the columns, projected (G. H. Golub, V. Pereyra, SIAM J. Numer.
//! Anal. 10, 413 (1973)). The interval is that of a [tabulated likelihood](super::likelihood_top).

use armident_motion::{LateSignals, Motion, SignalLag, ZeroPhaseLowPass};
use armident_numeric::{AccumulatedQr, NumericError};
use rayon::prelude::*;

use super::likelihood_top::half_of_95;
use super::rows::{ChannelRows, SAMPLES_PER_CUTOFF, edge, independent};
use crate::regression::{BatchProblem, RANK_CUT, Term};

/// Longest time constant and delay that are tried \[s\]: a low-pass of 2 Hz; drives filter at 5 Hz and above.
const LONGEST_S: f64 = 0.08;
/// Numbers of which the most likely one begins the search \[s\].
const STARTS_S: [f64; 3] = [-0.04, 0.0, 0.04];
/// Steps of a search, at most; they are cut to [`LONGEST_STEP_S`], and end below [`LAST_STEP_S`].
const STEPS: usize = 15;
const LONGEST_STEP_S: f64 = 0.02;
const LAST_STEP_S: f64 = 2e-5;
/// Samples that a joint has at least for each of its terms.
const SAMPLES_OF_A_TERM: usize = 2;
/// Speeds below this share of the root mean square speed are reversals, or rests.
const SLOW: f64 = 0.05;
/// How far the low-pass of the fit spreads what happens there, in periods of its cut-off.
const SPREAD: f64 = 0.75;
/// How long after it a lag is seen \[s\].
const AFTER_S: f64 = 0.1;

/// Noise of the accelerations, as a share of them, below which it is nothing beside the efforts: a lag that smooths the columns takes
/// their noise out.
const LITTLE_NOISE: f64 = 0.03;

/// How far above the cut-off of the fit lags are compared, at most, and below which share of the sampling rate.
const HIGHEST_BAND: f64 = 4.0;
const HIGHEST_SHARE: f64 = 0.1;

/// The cut-off up to which the noise of the accelerations is little \[Hz\]: it grows with the frequency to the power of five halves.
/// The wider the band, the clearer a lag, and the shorter what a reversal spreads to.
pub(super) fn band_of_lags_hz(cutoff_hz: f64, rate_hz: f64, acceleration_noise: f64) -> f64 {
    let quiet = (LITTLE_NOISE / acceleration_noise).powf(0.4);
    if quiet < 1.0 {
        return cutoff_hz * quiet;
    }
    (cutoff_hz * quiet.min(HIGHEST_BAND)).min(HIGHEST_SHARE * rate_hz).max(cutoff_hz)
}

/// Samples away from the reversals and rests of a joint: a joint that sticks reverses its friction gradually, and presliding friction
/// builds up late, which a lag would otherwise explain.
fn steady(motion: &Motion, joint: usize, cutoff_hz: f64) -> Vec<bool> {
    let velocity = &motion.velocity[joint];
    let squares: f64 = velocity.iter().map(|v| v * v).sum();
    let slow = SLOW * (squares / velocity.len().max(1) as f64).sqrt();
    let before = (motion.rate_hz * SPREAD / cutoff_hz).ceil() as usize;
    let after = before + (motion.rate_hz * AFTER_S).ceil() as usize;
    let mut is_steady = vec![true; velocity.len()];
    for k in 0..velocity.len() {
        let turns = k > 0 && velocity[k] * velocity[k - 1] < 0.0;
        if turns || velocity[k].abs() < slow {
            let end = (k + after).min(velocity.len());
            is_steady[k.saturating_sub(before)..end].fill(false);
        }
    }
    is_steady
}

/// The columns of one joint in one motion, and its efforts, at a rate that holds the band of the fit.
struct LateMotion {
    columns: LateSignals,
    effort: Vec<f64>,
    /// time since the first sample \[s\]
    since_start_s: Vec<f64>,
    /// samples away from the ends, in motion
    kept: Vec<usize>,
}

/// What is known of one joint.
struct JointLag {
    motions: Vec<LateMotion>,
    terms: usize,
    /// terms that are friction and offset, not of the links
    of_joint: Vec<usize>,
    freedom: f64,
}

/// The model of one joint, fitted through a lag.
struct FittedLag {
    /// `[motion][column]`
    late: Vec<Vec<Vec<f64>>>,
    /// effort of each motion
    models: Vec<Vec<f64>>,
    /// columns that do not depend on those before them
    own: Vec<usize>,
    squares: f64,
}

/// Logarithm of the likelihood at a lag, with its slope over the number of the lag.
#[derive(Debug, Clone, Copy)]
struct AtLag {
    height: f64,
    slope: f64,
    /// of the negative logarithm
    curvature: f64,
}

/// Lags with one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LagKind {
    Delay,
    LowPass,
}

impl LagKind {
    fn of(self, number_s: f64) -> SignalLag {
        match self {
            Self::Delay => SignalLag { delay_s: number_s, ..SignalLag::default() },
            Self::LowPass => SignalLag { time_constant_s: number_s, ..SignalLag::default() },
        }
    }

    /// The smallest number.
    fn least_s(self) -> f64 {
        match self {
            Self::Delay => -LONGEST_S,
            Self::LowPass => 0.0,
        }
    }
}

impl JointLag {
    /// Of a joint with this number of independent samples; none where too few samples are compared.
    fn of(
        problem: &BatchProblem,
        motions: &[Motion],
        joint: usize,
        independent: f64,
    ) -> Option<Self> {
        let its_terms = problem.terms_of_joint(joint);
        let is_of_joint = |&k: &usize| matches!(problem.terms[its_terms[k]], Term::Effect { .. });
        let terms = its_terms.len();
        let mut samples = 0;
        let motions: Vec<LateMotion> = motions
            .iter()
            .filter_map(|motion| {
                let effort = &motion.effort_filtered.as_ref()?[joint];
                let filter = motion.filter.as_ref();
                let cutoff_hz =
                    filter.map_or(motion.rate_hz / SAMPLES_PER_CUTOFF, ZeroPhaseLowPass::cutoff_hz);
                let stride = (motion.rate_hz / (SAMPLES_PER_CUTOFF * cutoff_hz)).floor().max(1.0);
                let thinned = |all: &Vec<f64>| -> Vec<f64> {
                    all.iter().step_by(stride as usize).copied().collect()
                };
                let columns = problem.columns(joint, motion);
                samples += effort.len().div_ceil(stride as usize);
                let columns: Vec<Vec<f64>> = columns.iter().map(thinned).collect();
                let is_steady = steady(motion, joint, cutoff_hz);
                let edge = edge(motion);
                let kept = (0..motion.len()).step_by(stride as usize).enumerate();
                Some(LateMotion {
                    columns: LateSignals::new(&columns, motion.rate_hz / stride),
                    effort: thinned(effort),
                    since_start_s: thinned(&motion.time_s)
                        .iter()
                        .map(|t| t - motion.time_s[0])
                        .collect(),
                    kept: kept
                        .filter(|(_, k)| (edge..motion.len() - edge).contains(k) && is_steady[*k])
                        .map(|(thin, _)| thin)
                        .collect(),
                })
            })
            .collect();
        let kept: usize = motions.iter().map(|motion| motion.kept.len()).sum();
        let share = kept as f64 / samples.max(1) as f64;
        let freedom = (share * independent - terms as f64).max(1.0);
        let of_joint = (0..terms).filter(is_of_joint).collect();
        (kept > SAMPLES_OF_A_TERM * terms).then_some(Self { motions, terms, of_joint, freedom })
    }

    /// The triangle of the columns that have a lag.
    fn triangle(&self, late: &[Vec<Vec<f64>>]) -> AccumulatedQr {
        let columns = late.first().map_or(0, Vec::len);
        let mut triangle = AccumulatedQr::new(columns);
        for (motion, late) in self.motions.iter().zip(late) {
            let kept =
                |all: &Vec<f64>| -> Vec<f64> { motion.kept.iter().map(|&k| all[k]).collect() };
            let columns: Vec<Vec<f64>> = late.iter().map(kept).collect();
            triangle.push_columns(&columns, &kept(&motion.effort));
        }
        triangle
    }

    fn expected_log_ratio(
        &self,
        (kind, number_s): (LagKind, f64),
        (other, other_s): (LagKind, f64),
    ) -> Result<f64, NumericError> {
        let FittedLag { models, squares, .. } = self.fitted(kind.of(number_s))?;
        let mut through_other = self.late(other.of(other_s));
        through_other.iter_mut().zip(models).for_each(|(columns, model)| columns.push(model));
        let triangle = self.triangle(&through_other);
        let mut order = self.own(&triangle);
        let first = order.len();
        order.push(self.terms);
        let left = triangle.reordered(&order)[(first, first)];
        Ok(self.freedom * (left * left / squares).ln_1p())
    }

    /// The columns of each motion through a lag.
    fn late(&self, lag: SignalLag) -> Vec<Vec<Vec<f64>>> {
        self.motions.iter().map(|motion| motion.columns.with(lag)).collect()
    }

    /// The terms that do not depend on those before them.
    fn own(&self, triangle: &AccumulatedQr) -> Vec<usize> {
        independent(triangle, &(0..self.terms).collect::<Vec<usize>>())
    }

    fn fitted(&self, lag: SignalLag) -> Result<FittedLag, NumericError> {
        let late = self.late(lag);
        let triangle = self.triangle(&late);
        let own = self.own(&triangle);
        let fit = triangle.with_unknowns(&own).solve(RANK_CUT)?;
        let model = |late: &Vec<Vec<f64>>| {
            let mut model = vec![0.0; late.first().map_or(0, Vec::len)];
            for (&column, x) in own.iter().zip(&fit.solution) {
                model.iter_mut().zip(&late[column]).for_each(|(m, c)| *m += x * c);
            }
            model
        };
        let models = late.iter().map(model).collect();
        Ok(FittedLag { late, models, own, squares: fit.residual_sum_of_squares })
    }

    fn growth(&self, lag: SignalLag) -> Result<LagGrowth, NumericError> {
        let FittedLag { mut late, models, own, .. } = self.fitted(lag)?;
        let warming: Vec<usize> =
            self.of_joint.iter().copied().filter(|k| own.contains(k)).collect();
        let drifts = warming.len() + 1;
        for ((motion, late), model) in self.motions.iter().zip(&mut late).zip(&models) {
            let since_s = &motion.since_start_s;
            let times = |column: &[f64], of: &dyn Fn(f64) -> f64| -> Vec<f64> {
                column.iter().zip(since_s).map(|(c, t)| c * of(*t)).collect()
            };
            let rate = motion.columns.by_delay(model);
            let middle_s = 0.5 * since_s.last().copied().unwrap_or_default();
            // friction, offset and gain that change steadily: drives that become warm are no clock
            let since_middle = |t: f64| t - middle_s;
            let drifting: Vec<Vec<f64>> = warming
                .iter()
                .map(|&k| &late[k])
                .chain([model])
                .map(|column| times(column, &since_middle))
                .collect();
            late.extend(drifting);
            late.push(rate.clone());
            late.push(times(&rate, &|t| -t));
        }
        let triangle = self.triangle(&late);
        let beside: Vec<usize> =
            own.iter().copied().chain(self.terms..self.terms + drifts).collect();
        let mut order = independent(&triangle, &beside);
        let first = order.len();
        let rate = self.terms + drifts;
        order.extend([rate, rate + 1, rate + 2]);
        let r = triangle.reordered(&order);
        let at = |i: usize, j: usize| r[(first + i, first + j)];
        let squares: f64 = (0..3).map(|i| at(i, 2).powi(2)).sum();
        let freedom = (self.freedom - (first - own.len()) as f64).max(1.0);
        let scale = freedom / squares;
        Ok(LagGrowth {
            information: [
                at(0, 0) * at(0, 0),
                at(0, 0) * at(0, 1),
                at(0, 1).powi(2) + at(1, 1).powi(2),
            ]
            .map(|x| scale * x),
            slope: [at(0, 0) * at(0, 2), at(0, 1) * at(0, 2) + at(1, 1) * at(1, 2)]
                .map(|x| scale * x),
        })
    }

    fn at(&self, kind: LagKind, number_s: f64) -> Result<AtLag, NumericError> {
        let FittedLag { mut late, models, own, .. } = self.fitted(kind.of(number_s))?;
        for ((motion, late), model) in self.motions.iter().zip(&mut late).zip(&models) {
            late.push(match kind {
                LagKind::Delay => motion.columns.by_delay(model),
                LagKind::LowPass => motion.columns.by_time_constant(model, number_s),
            });
        }
        // what the terms leave of the derivative, and of the effort
        let order: Vec<usize> = own.iter().copied().chain([self.terms, self.terms + 1]).collect();
        let r = self.triangle(&late).reordered(&order);
        let first = own.len();
        let [rate, along, beside] =
            [(0, 0), (0, 1), (1, 1)].map(|(i, j)| r[(first + i, first + j)]);
        let squares = along * along + beside * beside;
        let scale = self.freedom / squares;
        Ok(AtLag {
            height: -0.5 * self.freedom * squares.ln(),
            slope: scale * rate * along,
            curvature: scale * rate * rate,
        })
    }
}

/// What one joint shows of its lag at the start of each recording \[s\] and of the drift of the clock of its efforts: the
/// logarithm of the likelihood to second order about a lag.
#[derive(Debug, Clone, Copy)]
pub(super) struct LagGrowth {
    /// minus the second derivatives: lag and lag, lag and drift, drift and drift
    pub(super) information: [f64; 3],
    /// first derivatives: lag, drift
    pub(super) slope: [f64; 2],
}

/// The lag of one kind with the highest likelihood.
#[derive(Debug, Clone, Copy)]
pub(super) struct FoundLag {
    /// delay or time constant \[s\]
    pub(super) number_s: f64,
    /// half of its 95 % interval \[s\]
    pub(super) half_s: f64,
    /// `2 ln` of the likelihood over that of no lag
    pub(super) evidence: f64,
}

/// Lags of the efforts of some joints.
pub(super) struct Lags {
    joints: Vec<JointLag>,
    without: f64,
}

impl Lags {
    /// Of the joints that are not silent; none without any.
    pub(super) fn of(
        problem: &BatchProblem,
        motions: &[Motion],
        rows: &[ChannelRows],
        is_silent: &[bool],
    ) -> Result<Option<Self>, NumericError> {
        let of_joint = |joint: usize| -> Option<JointLag> {
            JointLag::of(problem, motions, joint, rows[joint].effective)
        };
        let alive: Vec<usize> = (0..rows.len()).filter(|&j| !is_silent[j]).collect();
        let joints: Vec<JointLag> = alive.par_iter().filter_map(|&j| of_joint(j)).collect();
        let without = height(&at_all(&joints, LagKind::Delay, 0.0)?);
        Ok((!joints.is_empty() && without.is_finite()).then_some(Self { joints, without }))
    }

    /// Number of joints.
    pub(super) fn joints(&self) -> usize {
        self.joints.len()
    }

    /// What each joint shows of its lag and of the growth of it, about a lag.
    pub(super) fn growths(&self, lag: SignalLag) -> Result<Vec<LagGrowth>, NumericError> {
        self.joints.par_iter().map(|joint| joint.growth(lag)).collect()
    }

    /// `2 ln` of the likelihood of one lag over that of another, of each joint.
    pub(super) fn log_ratios(
        &self,
        (kind, number_s): (LagKind, f64),
        (other, other_s): (LagKind, f64),
    ) -> Result<Vec<f64>, NumericError> {
        let [all, others] = [(kind, number_s), (other, other_s)]
            .map(|(kind, number_s)| at_all(&self.joints, kind, number_s));
        Ok(all?
            .iter()
            .zip(&others?)
            .map(|(one, other)| 2.0 * (one.height - other.height))
            .collect())
    }

    /// The same where the efforts are those of the model through the first lag: what the motion shows of the difference.
    pub(super) fn expected_log_ratios(
        &self,
        of: (LagKind, f64),
        over: (LagKind, f64),
    ) -> Result<Vec<f64>, NumericError> {
        self.joints.par_iter().map(|joint| joint.expected_log_ratio(of, over)).collect()
    }

    /// The most likely lag of a kind; none where the likelihood is highest at an end of the range, or nowhere.
    pub(super) fn most_likely(&self, kind: LagKind) -> Result<Option<FoundLag>, NumericError> {
        let mut from: Option<(f64, Vec<AtLag>)> = None;
        for number_s in STARTS_S.into_iter().filter(|&s| s >= kind.least_s()) {
            let there = at_all(&self.joints, kind, number_s)?;
            if from.as_ref().is_none_or(|(_, best)| height(&there) > height(best)) {
                from = Some((number_s, there));
            }
        }
        let Some((mut number_s, mut here)) = from else { return Ok(None) };
        let mut share = 1.0;
        for _ in 0..STEPS {
            let slope: f64 = here.iter().map(|at| at.slope).sum();
            let curvature: f64 = here.iter().map(|at| at.curvature).sum();
            let step = share * (slope / curvature).clamp(-LONGEST_STEP_S, LONGEST_STEP_S);
            if !step.is_finite() {
                return Ok(None);
            }
            let next_s = (number_s + step).clamp(kind.least_s(), LONGEST_S);
            let there = at_all(&self.joints, kind, next_s)?;
            if height(&there) >= height(&here) {
                (number_s, here, share) = (next_s, there, 1.0);
            } else {
                share *= 0.5;
            }
            if step.abs() < LAST_STEP_S {
                break;
            }
        }
        let curvature: f64 = here.iter().map(|at| at.curvature).sum();
        let slopes: Vec<f64> = here.iter().map(|at| at.slope).collect();
        let half_s = half_of_95(curvature, &slopes);
        let is_inside = (kind.least_s() + LAST_STEP_S..LONGEST_S - LAST_STEP_S).contains(&number_s);
        Ok((is_inside && half_s.is_finite()).then(|| FoundLag {
            number_s,
            half_s,
            evidence: 2.0 * (height(&here) - self.without),
        }))
    }
}

/// The likelihoods of all joints.
fn at_all(joints: &[JointLag], kind: LagKind, number_s: f64) -> Result<Vec<AtLag>, NumericError> {
    joints.par_iter().map(|joint| joint.at(kind, number_s)).collect()
}

fn height(all: &[AtLag]) -> f64 {
    all.iter().map(|at| at.height).sum()
}
