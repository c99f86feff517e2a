//! The Fourier motion with the largest information inside the limits.
//!
//! Method: D-optimal design, ascent of `log det F` by Adam from random starts. A motion keeps to the limits of position,
//! velocity, acceleration and jerk because its shape is scaled to them; the derivative of that scale is part of the gradient.
//! What exceeds an effort limit is punished, and refused at the end ([`crate::effort_bound`]). What comes near to a contact is
//! punished too, and drawn towards a free pose at the end until it is clear ([`crate::clearance`]).
//!
//! References: D. P. Kingma, J. Ba, Adam: a method for stochastic optimization, ICLR 2015; the parametrisation is own.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::clearance::{Clearance, MARGIN_M, Nearest};
use crate::effort_bound::{Rates, effort_rates};
use crate::error::ExcitationError;
use crate::fourier::{FourierJoint, to_rest};
use crate::information::{Ascent, Columns, Parameters};
use crate::limits::MotionLimits;

/// Samples of the shortest wave during the search.
const SAMPLES_OF_A_WAVE: usize = 12;
/// Steps of the ascent from one start, and its rate at the first and the last.
const STEPS: usize = 160;
const RATES: [f64; 2] = [0.06, 0.004];
/// Decay of the mean gradient and of its square (Kingma & Ba 2015).
const DECAY: [f64; 2] = [0.9, 0.99];
/// Nats for an effort above its limit by all of it, on every sample.
const EFFORT_PENALTY: f64 = 4000.0;
/// Share of an effort limit that the search uses: the bound between samples is some per cent wide.
const BETWEEN_SAMPLES: f64 = 0.96;
/// Nats for a pair of shapes that is nearer than the margin by [`NEAR_M`], on every sample.
const CONTACT_PENALTY: f64 = 1000.0;
/// Distance to the margin in which a contact begins to be punished, and its unit \[m\]: samples of the search are coarse.
const NEAR_M: f64 = 0.02;
/// Step of the check for contacts before intervals are halved \[s\].
const CONTACT_STEP_S: f64 = 0.05;
/// Bisections of how far a motion is drawn towards the free pose.
const DRAWN: usize = 12;
/// Random steps from one start of a climb, the size of the first, and the power of ten of the smallest travel.
const WALK: usize = 60;
const FIRST_STEP: f64 = 0.3;
const SMALLEST_TRAVEL: f64 = -1.7;
/// Step of the check between samples \[s\], and most samples: a slower motion changes less between them.
const CHECK_STEP_S: f64 = 5e-4;
const MOST_CHECKED: usize = 40_000;

/// A Fourier motion of all joints that keeps to the limits at every time.
#[derive(Debug, Clone)]
pub struct FourierMotion {
    /// Length \[s\].
    pub period_s: f64,
    /// Motion of each joint.
    pub joints: Vec<FourierJoint>,
    /// Share of its shape about the free pose that is clear; 1 where nothing was in the way.
    pub clear_share: f64,
    /// `log det F` with the samples of the search.
    pub log_determinant: f64,
    /// Starts of the search.
    pub starts: usize,
}

impl FourierMotion {
    /// Position, velocity and acceleration at these times.
    pub(crate) fn columns(&self, time_s: &[f64]) -> Columns {
        let of = |k: usize| -> Vec<Vec<f64>> {
            let column = |joint: &FourierJoint| {
                time_s.iter().map(|t| joint.at(*t, self.period_s)[k]).collect()
            };
            self.joints.iter().map(column).collect()
        };
        [of(0), of(1), of(2)]
    }

    /// The same path, slower by a factor.
    #[must_use]
    pub fn slower(&self, factor: f64) -> Self {
        Self { period_s: factor * self.period_s, ..self.clone() }
    }
}

/// Samples of a search among motions of so many waves.
pub(crate) fn samples_of(harmonics: usize) -> usize {
    SAMPLES_OF_A_WAVE * harmonics
}

/// Search for motions of one length.
pub(crate) struct Search<'a> {
    pub(crate) parameters: &'a Parameters<'a>,
    pub(crate) limits: &'a [MotionLimits],
    pub(crate) names: &'a [String],
    pub(crate) clearance: Option<&'a Clearance<'a>>,
    /// a pose that is free; used where there is something to touch
    pub(crate) home: &'a [f64],
    pub(crate) period_s: f64,
    pub(crate) harmonics: usize,
}

/// What the ascent moves: coefficients of each joint, and where its path lies in the range.
#[derive(Clone)]
struct Point {
    sine: Vec<Vec<f64>>,
    cosine: Vec<Vec<f64>>,
    place: Vec<f64>,
}

/// Shape of a joint on the samples of the search, scaled to the limits.
struct Shaped {
    /// `[derivative][sample]` before scaling
    shape: [Vec<f64>; 4],
    scale: f64,
    /// derivative and sample of the active limit with its weight in the ratio: none where nothing is active
    active: Vec<(usize, usize, f64)>,
    lowest: usize,
    highest: usize,
    start: f64,
    share: f64,
}

impl<'a> Search<'a> {
    /// Samples of the search.
    fn samples(&self) -> usize {
        samples_of(self.harmonics)
    }

    /// Derivative `k` of `sin(l ω t)` and `cos(l ω t) - 1` at each sample.
    fn basis(&self) -> Vec<[[Vec<f64>; 2]; 4]> {
        let n = self.samples();
        (1..=self.harmonics)
            .map(|l| {
                let rate = l as f64 * TAU / self.period_s;
                let wave = |k: usize, of: usize| -> Vec<f64> {
                    (0..n)
                        .map(|t| {
                            let (sin, cos) = (TAU * (l * t) as f64 / n as f64).sin_cos();
                            let value = match (of, k) {
                                (0, 0) => sin,
                                (0, 1) => cos,
                                (0, 2) => -sin,
                                (0, _) => -cos,
                                (_, 0) => cos - 1.0,
                                (_, 1) => -sin,
                                (_, 2) => -cos,
                                _ => sin,
                            };
                            rate.powi(k as i32) * value
                        })
                        .collect()
                };
                [0, 1, 2, 3].map(|k| [wave(k, 0), wave(k, 1)])
            })
            .collect()
    }

    fn shaped(&self, basis: &[[[Vec<f64>; 2]; 4]], point: &Point, joint: usize) -> Shaped {
        let n = self.samples();
        let limits = &self.limits[joint];
        let mut shape = [0, 1, 2, 3].map(|_| vec![0.0; n]);
        for (l, of) in basis.iter().enumerate() {
            for (k, column) in shape.iter_mut().enumerate() {
                let (a, b) = (point.sine[joint][l], point.cosine[joint][l]);
                for ((x, s), c) in column.iter_mut().zip(&of[k][0]).zip(&of[k][1]) {
                    *x += a * s + b * c;
                }
            }
        }
        let by = |column: &[f64], key: &dyn Fn(f64) -> f64| {
            (0..n).max_by(|&a, &b| key(column[a]).total_cmp(&key(column[b]))).unwrap_or(0)
        };
        let (highest, lowest) = (by(&shape[0], &|x| x), by(&shape[0], &|x| -x));
        let mut ratio = (shape[0][highest] - shape[0][lowest]) / limits.range();
        let mut active =
            vec![(0, highest, 1.0 / limits.range()), (0, lowest, -1.0 / limits.range())];
        for (k, limit) in [(1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)] {
            let at = by(&shape[k], &f64::abs);
            let of = shape[k][at];
            if of.abs() / limit > ratio {
                ratio = of.abs() / limit;
                active = vec![(k, at, of.signum() / limit)];
            }
        }
        if ratio <= 1.0 {
            active.clear();
        }
        let scale = 1.0 / ratio.max(1.0);
        let share = 1.0 / (1.0 + (-point.place[joint]).exp());
        let (low, high) = (scale * shape[0][lowest], scale * shape[0][highest]);
        let start = limits.lower - low + share * (limits.range() - (high - low));
        Shaped { shape, scale, active, lowest, highest, start, share }
    }

    fn motion(shaped: &[Shaped]) -> Columns {
        let of = |k: usize| -> Vec<Vec<f64>> {
            let column = |s: &Shaped| {
                let start = if k == 0 { s.start } else { 0.0 };
                s.shape[k].iter().map(|x| start + s.scale * x).collect()
            };
            shaped.iter().map(column).collect()
        };
        [of(0), of(1), of(2)]
    }

    /// A random point: waves whose size falls with their rate.
    fn random(&self, random: &mut Pcg64) -> Point {
        let joints = self.limits.len();
        let mut coefficients = |joint: usize| -> Vec<f64> {
            (1..=self.harmonics)
                .map(|l| {
                    let size: f64 = random.sample(StandardNormal);
                    size * self.limits[joint].range() / (1.0 + l as f64)
                })
                .collect()
        };
        let mut point = Point {
            sine: (0..joints).map(&mut coefficients).collect(),
            cosine: (0..joints).map(&mut coefficients).collect(),
            place: vec![0.0; joints],
        };
        for place in &mut point.place {
            *place = random.sample(StandardNormal);
        }
        for (sine, cosine) in point.sine.iter_mut().zip(&mut point.cosine) {
            to_rest(sine, cosine);
        }
        point
    }

    /// Effort beyond its limit as a penalty, and the slope of it: linear, so that the best motion keeps to the limit
    /// (an exact penalty), and quadratic far from it.
    fn excess(&self) -> impl Fn(usize, f64) -> (f64, f64) + '_ {
        let weight = EFFORT_PENALTY / self.samples() as f64;
        move |joint, effort| match self.limits[joint].effort.map(|e| BETWEEN_SAMPLES * e) {
            Some(limit) if effort.abs() > limit => {
                let over = effort.abs() / limit - 1.0;
                let slope = weight * (1.0 + 2.0 * over) / limit * effort.signum();
                (weight * over * (1.0 + over), slope)
            }
            _ => (0.0, 0.0),
        }
    }

    /// Efforts of a random motion inside the limits, root mean square by joint.
    pub(crate) fn usual_efforts(&self, seed: u64) -> Vec<f64> {
        let point = self.random(&mut Pcg64::seed_from_u64(seed));
        let basis = self.basis();
        let shaped: Vec<Shaped> =
            (0..self.limits.len()).map(|joint| self.shaped(&basis, &point, joint)).collect();
        let mean = |effort: &Vec<f64>| {
            (effort.iter().map(|e| e * e).sum::<f64>() / effort.len() as f64).sqrt()
        };
        self.parameters.efforts(&Self::motion(&shaped)).iter().map(mean).collect()
    }

    /// A random motion that is clear and inside the limits of position, velocity, acceleration and jerk.
    pub(crate) fn random_motion(&self, seed: u64) -> FourierMotion {
        let point = self.random(&mut Pcg64::seed_from_u64(seed));
        self.cleared(self.finished(&self.basis(), &point, f64::NAN))
    }

    /// The best of one start.
    fn ascend(&self, seed: u64, end: Instant) -> FourierMotion {
        let basis = self.basis();
        let joints = self.limits.len();
        let mut point = self.random(&mut Pcg64::seed_from_u64(seed));
        let mut best = (f64::NEG_INFINITY, point.clone());
        let parameters = joints * (2 * self.harmonics + 1);
        let (mut mean, mut square) = (vec![0.0; parameters], vec![0.0; parameters]);
        for step in 0..STEPS {
            let shaped: Vec<Shaped> =
                (0..joints).map(|joint| self.shaped(&basis, &point, joint)).collect();
            let columns = Self::motion(&shaped);
            let Some(mut found) = self.parameters.ascent(&columns, self.excess()) else { break };
            self.punish_contacts(&columns[0], &mut found);
            if found.value > best.0 {
                best = (found.value, point.clone());
            }
            if Instant::now() >= end {
                break;
            }
            let x = step as f64 / STEPS as f64;
            let rate = RATES[0] * (RATES[1] / RATES[0]).powf(x);
            let mut place = 0;
            for (joint, shaped) in shaped.iter().enumerate() {
                let [sine, cosine, of_place] = self.slope(
                    &basis,
                    shaped,
                    joint,
                    [0, 1, 2].map(|k| found.gradient[k][joint].as_slice()),
                );
                let range = self.limits[joint].range();
                let mut moved = |gradient: f64, size: f64| {
                    // parameters in units of their size, so that one rate serves all
                    let g = gradient * size;
                    mean[place] = DECAY[0] * mean[place] + (1.0 - DECAY[0]) * g;
                    square[place] = DECAY[1] * square[place] + (1.0 - DECAY[1]) * g * g;
                    let rounds = step as i32 + 1;
                    let m = mean[place] / (1.0 - DECAY[0].powi(rounds));
                    let s = square[place] / (1.0 - DECAY[1].powi(rounds));
                    place += 1;
                    size * rate * m / (s.sqrt() + f64::MIN_POSITIVE)
                };
                for l in 0..self.harmonics {
                    let size = range / (2.0 + l as f64);
                    // the scale is taken into the coefficients: they stay where limits begin to act
                    point.sine[joint][l] =
                        shaped.scale * point.sine[joint][l] + moved(sine[l], size);
                    point.cosine[joint][l] =
                        shaped.scale * point.cosine[joint][l] + moved(cosine[l], size);
                }
                point.place[joint] += moved(of_place[0], 4.0);
                to_rest(&mut point.sine[joint], &mut point.cosine[joint]);
            }
        }
        self.cleared(self.finished(&basis, &best.1, best.0))
    }

    fn punish_contacts(&self, position: &[Vec<f64>], found: &mut Ascent) {
        let Some(clearance) = self.clearance else { return };
        let samples = self.samples();
        let weight = CONTACT_PENALTY / samples as f64;
        let penalty = |distance: f64| {
            let x = ((MARGIN_M + NEAR_M - distance) / NEAR_M).max(0.0);
            (weight * (x + x * x), -weight * (1.0 + 2.0 * x) / NEAR_M)
        };
        for t in 0..samples {
            let pose: Vec<f64> = position.iter().map(|q| q[t]).collect();
            let (sum, slope) = clearance.penalty(&pose, penalty);
            found.value -= sum;
            for (gradient, slope) in found.gradient[0].iter_mut().zip(slope) {
                gradient[t] -= slope;
            }
        }
    }

    /// The smallest distance of a motion, between samples too, or the contact; none where nothing can touch.
    pub(crate) fn clear(&self, motion: &FourierMotion) -> Result<Option<f64>, Nearest> {
        let Some(clearance) = self.clearance else { return Ok(None) };
        let bounds = motion.joints.iter().map(|j| j.bounds(motion.period_s).derivatives[1]);
        let most: Vec<f64> = bounds.collect();
        let state = |t: f64| {
            let of = |k: usize| motion.joints.iter().map(|j| j.at(t, motion.period_s)[k]).collect();
            [of(0), of(1)]
        };
        clearance.along(motion.period_s, CONTACT_STEP_S, &most, state).map(Some)
    }

    /// The motion if it is clear, else as much of it about the free pose as is: limits hold on the way, for they hold at both
    /// ends of it.
    fn cleared(&self, motion: FourierMotion) -> FourierMotion {
        if self.clear(&motion).is_ok() {
            return motion;
        }
        let drawn = |share: f64| FourierMotion {
            joints: motion
                .joints
                .iter()
                .zip(self.home)
                .map(|(joint, home)| FourierJoint {
                    start: home + share * (joint.start - home),
                    ..joint.scaled(share)
                })
                .collect(),
            ..motion.clone()
        };
        let (mut clear, mut met) = (0.0, 1.0);
        for _ in 0..DRAWN {
            let share = 0.5 * (clear + met);
            if self.clear(&drawn(share)).is_ok() {
                clear = share;
            } else {
                met = share;
            }
        }
        let found = drawn(clear);
        let log_determinant = self.log_determinant(&found);
        FourierMotion { log_determinant, clear_share: clear, ..found }
    }

    /// `log det F` with the samples of the search.
    fn log_determinant(&self, motion: &FourierMotion) -> f64 {
        let step_s = motion.period_s / self.samples() as f64;
        let time_s: Vec<f64> = (0..self.samples()).map(|k| k as f64 * step_s).collect();
        let new = self.parameters.information(&motion.columns(&time_s));
        let all = self.parameters.given.as_ref().map_or_else(|| new.clone(), |g| g.with(&new));
        all.log_determinant().unwrap_or(f64::NEG_INFINITY)
    }

    /// Derivatives of the objective in the coefficients and the place of a joint, from those in its samples.
    fn slope(
        &self,
        basis: &[[[Vec<f64>; 2]; 4]],
        of: &Shaped,
        joint: usize,
        gradient: [&[f64]; 3],
    ) -> [Vec<f64>; 3] {
        let total: f64 = gradient[0].iter().sum();
        let (low, high) = (of.shape[0][of.lowest], of.shape[0][of.highest]);
        // start = lower - (1 - share) s low - share s high + share range
        let of_scale: f64 = (0..3)
            .map(|k| gradient[k].iter().zip(&of.shape[k]).map(|(g, x)| g * x).sum::<f64>())
            .sum::<f64>()
            - total * ((1.0 - of.share) * low + of.share * high);
        let coefficient = |wave: usize, l: usize| -> f64 {
            let along: f64 =
                (0..3).map(|k| armident_numeric::dot(gradient[k], &basis[l][k][wave])).sum();
            let position = &basis[l][0][wave];
            let of_start = (1.0 - of.share) * position[of.lowest] + of.share * position[of.highest];
            let of_ratio: f64 =
                of.active.iter().map(|&(k, t, weight)| weight * basis[l][k][wave][t]).sum();
            of.scale * (along - total * of_start) - of.scale.powi(2) * of_ratio * of_scale
        };
        let mut sine: Vec<f64> = (0..self.harmonics).map(|l| coefficient(0, l)).collect();
        let mut cosine: Vec<f64> = (0..self.harmonics).map(|l| coefficient(1, l)).collect();
        to_rest(&mut sine, &mut cosine);
        // in units in which the scale has been taken into the coefficients
        for x in sine.iter_mut().chain(&mut cosine) {
            *x /= of.scale;
        }
        let slack = self.limits[joint].range() - of.scale * (high - low);
        [sine, cosine, vec![total * slack * of.share * (1.0 - of.share)]]
    }

    /// The motion of a point, scaled so that its bounds between samples keep to the limits.
    fn finished(&self, basis: &[[[Vec<f64>; 2]; 4]], point: &Point, value: f64) -> FourierMotion {
        let joints = (0..self.limits.len())
            .map(|joint| {
                let limits = &self.limits[joint];
                let shaped = self.shaped(basis, point, joint);
                let rough = FourierJoint {
                    start: 0.0,
                    sine: point.sine[joint].clone(),
                    cosine: point.cosine[joint].clone(),
                }
                .scaled(shaped.scale);
                let bounds = rough.bounds(self.period_s);
                let [v, a, j] = bounds.derivatives;
                let ratio = ((bounds.position[1] - bounds.position[0]) / limits.range())
                    .max(v / limits.velocity)
                    .max(a / limits.acceleration)
                    .max(j / limits.jerk);
                let factor = 1.0 / ratio.max(1.0);
                let (low, high) = (factor * bounds.position[0], factor * bounds.position[1]);
                let start =
                    limits.lower - low + shaped.share * (limits.range() - (high - low)).max(0.0);
                FourierJoint { start, ..rough.scaled(factor) }
            })
            .collect();
        FourierMotion {
            period_s: self.period_s,
            joints,
            clear_share: 1.0,
            log_determinant: value,
            starts: 1,
        }
    }

    /// The best motion that random starts find until the time is over; at least one start a thread.
    ///
    /// # Errors
    /// [`ExcitationError::Effort`] where all exceed an effort limit.
    pub(crate) fn best(
        &self,
        seed: u64,
        budget: Duration,
    ) -> Result<FourierMotion, ExcitationError> {
        let begin = Instant::now();
        let end = begin + budget;
        let at_a_time = rayon::current_num_threads().max(1) as u64;
        let (mut best, mut nearest): (Option<FourierMotion>, Option<(f64, usize)>) = (None, None);
        let mut starts = 0;
        loop {
            let found: Vec<FourierMotion> = (0..at_a_time)
                .into_par_iter()
                .map(|k| self.ascend(seed.wrapping_add(starts + k), end))
                .collect();
            starts += at_a_time;
            for motion in found {
                let (ratio, joint) = self.effort_ratio(&motion);
                if ratio > 1.0 {
                    if nearest.is_none_or(|(least, _)| ratio < least) {
                        nearest = Some((ratio, joint));
                    }
                    continue;
                }
                let is_better = |b: &FourierMotion| motion.log_determinant > b.log_determinant;
                if best.as_ref().is_none_or(is_better) {
                    best = Some(motion);
                }
            }
            if Instant::now() >= end {
                break;
            }
        }
        let tried = starts as usize;
        match (best, nearest) {
            (Some(best), _) => Ok(FourierMotion { starts: tried, ..best }),
            (None, nearest) => Err(self.too_weak(nearest, tried)),
        }
    }

    /// The motion with the largest worth that random starts find until the time is over: each goes on by random steps that are
    /// kept where they are better, and whose size follows how many are (a (1+1) evolution strategy). Starts differ in travel
    /// and pace, because some effects show on small and slow motions.
    ///
    /// # Errors
    /// [`ExcitationError::Effort`] where all exceed an effort limit.
    pub(crate) fn climb(
        &self,
        seed: u64,
        budget: Duration,
        step_s: f64,
        worth: impl Fn(&Columns) -> f64 + Sync,
    ) -> Result<FourierMotion, ExcitationError> {
        let end = Instant::now() + budget;
        let steps = (self.period_s / step_s).round().max(1.0) as usize;
        let time_s: Vec<f64> = (0..=steps).map(|k| k as f64 * step_s).collect();
        let basis = self.basis();
        let walk = |seed: u64| -> FourierMotion {
            let mut random = Pcg64::seed_from_u64(seed);
            let mut point = self.random(&mut random);
            let paced = random.random_range(1..=self.harmonics).max(3);
            for joint in 0..self.limits.len() {
                let travel = 10.0_f64.powf(random.random_range(SMALLEST_TRAVEL..0.0));
                for wave in [&mut point.sine[joint], &mut point.cosine[joint]] {
                    wave.iter_mut().for_each(|x| *x *= travel);
                    wave[paced.min(self.harmonics)..].fill(0.0);
                }
                to_rest(&mut point.sine[joint], &mut point.cosine[joint]);
            }
            let value = |point: &Point| {
                let motion = self.finished(&basis, point, 0.0);
                let columns = motion.columns(&time_s);
                let efforts = self.parameters.efforts(&columns);
                let within = efforts.iter().zip(self.limits).all(|(effort, limits)| {
                    let most = limits.effort.map_or(f64::INFINITY, |e| BETWEEN_SAMPLES * e);
                    effort.iter().all(|e| e.abs() <= most)
                });
                if within { worth(&columns) } else { f64::NEG_INFINITY }
            };
            let mut best = (value(&point), point);
            let mut size = FIRST_STEP;
            for _ in 0..WALK {
                if Instant::now() >= end {
                    break;
                }
                let mut moved = best.1.clone();
                for joint in 0..self.limits.len() {
                    let waves = [&mut moved.sine[joint], &mut moved.cosine[joint]];
                    for wave in waves {
                        let scale = wave.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                        for (l, x) in wave.iter_mut().enumerate() {
                            let step: f64 = random.sample(StandardNormal);
                            *x += size * scale * step / (1.0 + l as f64).sqrt();
                        }
                    }
                    let step: f64 = random.sample(StandardNormal);
                    moved.place[joint] += size * step;
                    to_rest(&mut moved.sine[joint], &mut moved.cosine[joint]);
                }
                let found = value(&moved);
                // a fifth of the steps succeed at the best size (Rechenberg 1973)
                if found > best.0 {
                    best = (found, moved);
                    size *= 1.5;
                } else {
                    size *= 1.5_f64.powf(-0.25);
                }
            }
            self.cleared(self.finished(&basis, &best.1, best.0))
        };
        let at_a_time = rayon::current_num_threads().max(1) as u64;
        let mut best: Option<(f64, FourierMotion)> = None;
        let mut nearest: Option<(f64, usize)> = None;
        let mut starts = 0;
        loop {
            let found: Vec<FourierMotion> = (0..at_a_time)
                .into_par_iter()
                .map(|k| walk(seed.wrapping_add(starts + k)))
                .collect();
            starts += at_a_time;
            for motion in found {
                let (ratio, joint) = self.effort_ratio(&motion);
                if ratio > 1.0 {
                    if nearest.is_none_or(|(least, _)| ratio < least) {
                        nearest = Some((ratio, joint));
                    }
                    continue;
                }
                let value = worth(&motion.columns(&time_s));
                if best.as_ref().is_none_or(|(most, _)| value > *most) {
                    best = Some((value, motion));
                }
            }
            if Instant::now() >= end {
                break;
            }
        }
        let tried = starts as usize;
        match best {
            Some((_, best)) => Ok(FourierMotion { starts: tried, ..best }),
            None => Err(self.too_weak(nearest, tried)),
        }
    }

    /// The error for motions that all exceed an effort limit.
    fn too_weak(&self, nearest: Option<(f64, usize)>, tried: usize) -> ExcitationError {
        let (ratio, joint) = nearest.unwrap_or((f64::INFINITY, 0));
        let limit = self.limits[joint].effort.unwrap_or(f64::INFINITY);
        ExcitationError::Effort {
            joint: self.names.get(joint).cloned().unwrap_or_default(),
            effort: ratio * limit,
            limit,
            tried,
        }
    }

    /// Largest effort over its limit and the joint, between samples too.
    pub(crate) fn effort_ratio(&self, motion: &FourierMotion) -> (f64, usize) {
        let samples = ((motion.period_s / CHECK_STEP_S).ceil() as usize).min(MOST_CHECKED);
        let time_s: Vec<f64> =
            (0..=samples).map(|k| motion.period_s * k as f64 / samples as f64).collect();
        let jerks: Vec<f64> =
            motion.joints.iter().map(|j| j.bounds(motion.period_s).derivatives[2]).collect();
        effort_ratio(self.parameters, self.limits, &time_s, &motion.columns(&time_s), &jerks)
    }
}

/// Largest effort over its limit and the joint, of a sampled motion whose jerks are bounded.
pub(crate) fn effort_ratio(
    parameters: &Parameters<'_>,
    limits: &[MotionLimits],
    time_s: &[f64],
    columns: &Columns,
    jerks: &[f64],
) -> (f64, usize) {
    let efforts = parameters.efforts(columns);
    let [q, v, a] = columns;
    let mut worst = (0.0, 0);
    let mut rates = Vec::with_capacity(limits.len());
    for k in 0..time_s.len().saturating_sub(1) {
        let h = time_s[k + 1] - time_s[k];
        let larger = |of: &[f64]| of[k].abs().max(of[k + 1].abs());
        rates.clear();
        rates.extend((0..limits.len()).map(|j| {
            let jerk = jerks[j];
            let acceleration = larger(&a[j]) + 0.5 * h * jerk;
            let velocity = larger(&v[j]) + 0.5 * h * acceleration;
            let position = larger(&q[j]) + 0.5 * h * velocity;
            Rates { position, velocity, acceleration, jerk }
        }));
        let change = effort_rates(parameters.arm, &rates);
        for (j, limits) in limits.iter().enumerate() {
            let Some(limit) = limits.effort else { continue };
            let ratio = (larger(&efforts[j]) + 0.5 * h * change[j]) / limit;
            if ratio > worst.0 {
                worst = (ratio, j);
            }
        }
    }
    worst
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;
    use crate::limits::motion_limits;
    use crate::test_arms::{arm, chain};
    use armident_dynamics::RigidArm;
    use armident_ident::MinimalSet;
    use std::collections::BTreeMap;

    /// A UR5 inside its limits.
    struct Case {
        arm: RigidArm,
        set: MinimalSet,
        limits: Vec<MotionLimits>,
    }

    impl Case {
        fn new() -> Self {
            let arm = arm();
            let set = MinimalSet::of(&arm).unwrap();
            let (limits, _) = motion_limits(&chain(), &BTreeMap::new()).unwrap();
            Self { arm, set, limits }
        }

        fn parameters(&self) -> Parameters<'_> {
            Parameters::new(&self.arm, &self.set, vec![0.5; self.arm.dof()])
        }

        fn search<'a>(&'a self, parameters: &'a Parameters<'a>, harmonics: usize) -> Search<'a> {
            let (period_s, names, home) = (10.0, &[], &[]);
            let (limits, clearance) = (&self.limits, None);
            Search { parameters, limits, names, clearance, home, period_s, harmonics }
        }
    }

    /// The best of a few steps keeps to the limits on a finer grid, and tells more than the random motion it began with.
    #[test]
    fn found_motion_keeps_to_limits_and_tells_more() {
        let case = Case::new();
        let parameters = case.parameters();
        let search = case.search(&parameters, 5);
        let limits = &case.limits;
        let best = search.best(3, Duration::from_millis(1500)).unwrap();
        let time_s: Vec<f64> = (0..=20_000).map(|k| f64::from(k) / 2000.0).collect();
        let [q, v, a] = best.columns(&time_s);
        for (j, limits) in limits.iter().enumerate() {
            let within = |of: &[f64], low: f64, high: f64| {
                of.iter().all(|x| *x >= low - 1e-9 && *x <= high + 1e-9)
            };
            assert!(within(&q[j], limits.lower, limits.upper));
            assert!(within(&v[j], -limits.velocity, limits.velocity));
            assert!(within(&a[j], -limits.acceleration, limits.acceleration));
        }
        let mut sampled = 0.0_f64;
        for (effort, limits) in parameters.efforts(&[q, v, a]).iter().zip(limits) {
            let largest = effort.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
            sampled = sampled.max(largest / limits.effort.unwrap());
        }
        let (bound, _) = search.effort_ratio(&best);
        assert!(sampled <= bound && bound <= 1.0 && bound < 1.1 * sampled, "{sampled} {bound}");
        let sampled = |motion: &FourierMotion| {
            let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) / 100.0).collect();
            parameters.information(&motion.columns(&time_s))
        };
        let random = sampled(&search.random_motion(3));
        let found = sampled(&best);
        assert!(found.log_determinant().unwrap() > random.log_determinant().unwrap() + 10.0);
        assert!(found.condition().unwrap() < random.condition().unwrap());
    }

    /// The gradient in the coefficients is that of the objective.
    #[test]
    fn slopes_are_those_of_the_objective() {
        let case = Case::new();
        let parameters = case.parameters();
        let search = case.search(&parameters, 4);
        let basis = search.basis();
        let point = search.random(&mut Pcg64::seed_from_u64(8));
        let shaped = |point: &Point| -> Vec<Shaped> {
            (0..case.arm.dof()).map(|joint| search.shaped(&basis, point, joint)).collect()
        };
        let ascent = |point: &Point| {
            parameters.ascent(&Search::motion(&shaped(point)), search.excess()).unwrap()
        };
        let found = ascent(&point);
        for joint in [0, 2, 5] {
            let of = &shaped(&point)[joint];
            let slope = search.slope(
                &basis,
                of,
                joint,
                [0, 1, 2].map(|k| found.gradient[k][joint].as_slice()),
            );
            let h = 1e-6;
            let mut moved = [point.clone(), point.clone()];
            // a direction that keeps the ends at rest: l A_l adds to zero
            moved.iter_mut().zip([-h, h]).for_each(|(p, h)| {
                p.sine[joint][0] += 2.0 * h;
                p.sine[joint][1] -= h;
            });
            let expected = (ascent(&moved[1]).value - ascent(&moved[0]).value) / (2.0 * h);
            let gradient = of.scale * (2.0 * slope[0][0] - slope[0][1]);
            assert!(
                (gradient - expected).abs() < 1e-2 * (1.0 + expected.abs()),
                "{gradient} {expected}"
            );
            let mut moved = [point.clone(), point.clone()];
            moved[0].place[joint] -= h;
            moved[1].place[joint] += h;
            let expected = (ascent(&moved[1]).value - ascent(&moved[0]).value) / (2.0 * h);
            assert!((slope[2][0] - expected).abs() < 1e-2 * (1.0 + expected.abs()));
        }
    }
}
