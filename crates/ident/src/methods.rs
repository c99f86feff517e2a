//! The ways to solve the batch problem, with standard errors that know how residuals hang together.
//!
//! | method | answers to |
//! | --- | --- |
//! | [`Method::Ols`] | nothing: every row of every joint weighs the same |
//! | [`Method::Wls`] | joints of different noise |
//! | [`Method::Irls`] | samples that are off: Huber's weights on each joint's own scale |
//! | [`Method::Iv`] | noise in the columns: instruments from the simulated arm (IDIM-IV) |
//!
//! Standard errors come from leaving out one of twenty stretches of time after the other (delete-a-block
//! jackknife), whatever the method: residuals of a model that lacks physics keep their sign for a good
//! part of a second, which errors from white residuals do not know.
//!
//! Sources: P. J. Huber, Robust Statistics (1981); A. Janot, P.-O. Vandanjon, M. Gautier, A generic
//! instrumental variable approach for industrial robot identification, IEEE T-CST 22 (2014), and A revised
//! Durbin-Wu-Hausman test for industrial robot identification, Control Eng. Practice 48 (2016);
//! H. R. Kuensch, The jackknife and the bootstrap for general stationary observations, Annals of
//! Statistics 17 (1989); for t quantiles with blocks, C. A. Bester, T. G. Conley, C. B. Hansen, Journal of
//! Econometrics 165 (2011).

use armident_dynamics::ArmMotion;
use armident_motion::{DerivativeSource, Motion, MotionSettings};
use armident_numeric::{AccumulatedQr, Mat, NumericError};
use armident_simulation::{SimulatedArm, SimulationError, TrackingGains, Trajectory, track};
use rayon::prelude::*;

use crate::batch::{BatchEstimate, BatchProblem, BatchSettings, Beliefs, RANK_CUT};
use crate::quantiles::{student_t_975, student_t_tail};
use crate::rows::{JointRows, TermColumn, kept};
use armident_model::ArmModel;

/// Huber's constant: 95 % efficiency where the noise is normal after all.
const HUBER: f64 = 1.345;
/// Standard deviation of normal noise over the median of its absolute values.
const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;
/// Robust weights are done when no value moves by more of its standard error.
const ROBUST_TOLERANCE: f64 = 0.02;
const MOST_ROBUST_PASSES: usize = 10;
/// Passes after which the scales stay: they hardly move, and cost a pass each.
const SCALE_PASSES: usize = 2;
/// Fewer blocks than this say nothing about the errors.
const FEWEST_BLOCKS: usize = 4;
/// Bandwidth of the simulated controller, as a share of the cut-off: above the motion, below the noise.
const LOOP_OVER_CUTOFF: f64 = 0.5;

/// Slowest control cycle of the simulation \[Hz\].
const CONTROL_HZ: f64 = 500.0;

/// How the batch problem is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Ordinary least squares.
    Ols,
    /// Weighted by the joints' noise.
    Wls,
    /// Weighted, and reweighted robustly sample by sample.
    Irls,
    /// Weighted instrumental variables.
    Iv,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 4] = [Self::Ols, Self::Wls, Self::Irls, Self::Iv];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ols => "ols",
            Self::Wls => "wls",
            Self::Irls => "irls",
            Self::Iv => "iv",
        }
    }
}

/// Whether least squares and instruments agree: Durbin, Wu and Hausman, term by term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Endogeneity {
    /// Term that differs most.
    pub term: usize,
    /// Instrumental less weighted least-squares value, over the standard error of the difference.
    pub t: f64,
    /// Probability of as large a difference of any term if the columns have no noise (Bonferroni).
    pub p: f64,
}

/// Why an estimate failed.
#[derive(Debug, thiserror::Error)]
pub enum MethodError {
    /// The numbers.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// The arm found first cannot be simulated, so there are no instruments.
    #[error(
        "cannot simulate instruments: neither the least-squares model nor the URDF can be simulated: {0}"
    )]
    NoInstruments(Box<SimulationError>),
}

impl BatchProblem<'_> {
    /// Solves by a method, with standard errors from blocks. Also gives the rows of plain least squares,
    /// and for [`Method::Iv`] the test of least squares against it; `model` is the arm's, for its
    /// simulation.
    ///
    /// # Errors
    /// [`MethodError`].
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn solve_by(
        &self,
        method: Method,
        model: &ArmModel,
        motions: &[&Motion],
        settings: &BatchSettings,
    ) -> Result<(JointRows, BatchEstimate, Option<Endogeneity>), MethodError> {
        let rows = self.accumulate(motions);
        self.solve_rows_by(rows, method, model, motions, settings)
    }

    /// The same with the rows of the motions.
    pub(crate) fn solve_rows_by(
        &self,
        rows: JointRows,
        method: Method,
        model: &ArmModel,
        motions: &[&Motion],
        settings: &BatchSettings,
    ) -> Result<(JointRows, BatchEstimate, Option<Endogeneity>), MethodError> {
        let weighted = self.estimate_with(&rows, settings)?;
        let beliefs = self.beliefs(settings)?;
        let mut endogeneity = None;
        let estimate = match method {
            Method::Wls => {
                let mut found = weighted;
                self.with_block_errors(&rows, &beliefs, &mut found, 1.0, |r| r.clone())?;
                found
            }
            Method::Ols => {
                let n = self.by_joint.len() as f64;
                let level = weighted.effort_noise.iter().map(|s| s * s).sum::<f64>() / n;
                let mut found = self.at_noise(&rows, &beliefs, vec![level.sqrt(); n as usize])?;
                self.with_block_errors(&rows, &beliefs, &mut found, 1.0, |r| r.clone())?;
                found.effort_noise.clone_from(&weighted.effort_noise);
                found
            }
            Method::Irls => self.robust(motions, settings, &rows, weighted)?,
            Method::Iv => {
                let (found, tested) =
                    self.instrumental(model, motions, settings, &rows, &weighted)?;
                endogeneity = tested;
                found
            }
        };
        Ok((rows, estimate, endogeneity))
    }

    /// Solves at given noise levels.
    fn at_noise(
        &self,
        rows: &JointRows,
        beliefs: &Beliefs,
        noise: Vec<f64>,
    ) -> Result<BatchEstimate, NumericError> {
        let solved = self.weighted(rows, &noise, beliefs)?;
        let independent = rows.share * rows.effort.iter().map(|e| e.0 as f64).sum::<f64>();
        let freedom = (independent - self.terms.len() as f64).max(1.0);
        self.finished(rows, beliefs, noise, freedom, solved)
    }

    /// Huber's estimate: rows of samples beyond [`HUBER`] scales of their joint count for less, the scale
    /// being that of the median.
    fn robust(
        &self,
        motions: &[&Motion],
        settings: &BatchSettings,
        plain: &JointRows,
        start: BatchEstimate,
    ) -> Result<BatchEstimate, MethodError> {
        let beliefs = self.beliefs(settings)?;
        let mut found = start;
        let mut rows = plain.clone();
        let n = self.by_joint.len();
        // what jumps is the costly part, and the same in every pass
        let jumping: Vec<Vec<Vec<TermColumn>>> = (0..n)
            .into_par_iter()
            .map(|joint| motions.iter().map(|m| self.jumping_columns(joint, m)).collect())
            .collect();
        let moved = self.arm_motions(motions);
        let mut scales = vec![0.0; n];
        // the weights follow the values: only samples within the scale resist, all carry weight
        // (Huber's Σψ' against Σw)
        let mut widening = 1.0;
        for pass in 0..MOST_ROBUST_PASSES {
            let values = found.values.clone();
            let mut weighing: Vec<Weighing> = (0..n)
                .into_par_iter()
                .map(|joint| self.left_of_joint(joint, motions, &moved, &jumping[joint], &values))
                .collect();
            for (weighing, scale) in weighing.iter_mut().zip(&mut scales) {
                if pass < SCALE_PASSES {
                    *scale = weighing.scale();
                }
                weighing.weigh(HUBER * *scale);
            }
            rows = self.accumulate_with(
                motions,
                |index, joint, effort| {
                    let jumping = &jumping[joint][index];
                    let mut columns =
                        self.columns_beside(joint, motions[index], &moved[index], jumping);
                    let mut y = effort.to_vec();
                    let roots = &weighing[joint].roots[index];
                    for column in columns.iter_mut().chain([&mut y]) {
                        let kept = &mut column[kept(motions[index])];
                        kept.iter_mut().zip(roots).for_each(|(x, root)| *x *= root);
                    }
                    (columns, y)
                },
                |joint| self.by_joint[joint].len(),
            );
            let total = |of: fn(&Weighing) -> f64| weighing.iter().map(of).sum::<f64>();
            widening = total(|w| w.sum) / f64::max(total(|w| w.within), 0.5 * total(|w| w.samples));
            found = self.estimate_with(&rows, settings)?;
            let moved = (0..values.len())
                .filter_map(|k| {
                    Some((found.values[k] - values[k]).abs() / found.standard_error(k)?)
                })
                .filter(|moved| moved.is_finite())
                .fold(0.0, f64::max);
            if moved < ROBUST_TOLERANCE {
                break;
            }
        }
        self.with_block_errors(&rows, &beliefs, &mut found, widening, |r| r.clone())?;
        // noise and fit are those of all samples alike
        found.train = self.fit(plain, &found.values);
        for (noise, fit) in found.effort_noise.iter_mut().zip(&found.train) {
            *noise = noise.max(fit.rmse);
        }
        Ok(found)
    }

    /// What values leave of the efforts of a joint.
    fn left_of_joint(
        &self,
        joint: usize,
        motions: &[&Motion],
        moved: &[ArmMotion<'_>],
        jumping: &[Vec<TermColumn>],
        values: &[f64],
    ) -> Weighing {
        let left = |index: usize| -> Option<Vec<f64>> {
            let motion = motions[index];
            let effort = &motion.effort_filtered.as_ref()?[joint];
            let explained = self.explained(joint, motion, &moved[index], &jumping[index], values);
            Some(kept(motion).map(|t| (effort[t] - explained[t]).abs()).collect())
        };
        let roots = (0..motions.len()).map(|index| left(index).unwrap_or_default());
        Weighing { roots: roots.collect(), sum: 0.0, within: 0.0, samples: 0.0 }
    }

    /// Two-stage least squares with the columns of the simulated arm for instruments, and the test.
    fn instrumental(
        &self,
        model: &ArmModel,
        motions: &[&Motion],
        settings: &BatchSettings,
        rows: &JointRows,
        weighted: &BatchEstimate,
    ) -> Result<(BatchEstimate, Option<Endogeneity>), MethodError> {
        let simulated: Vec<Motion> = motions
            .iter()
            .map(|motion| {
                // links found by least squares need not be ones of a body; the description's will do for
                // instruments, which only have to move alike
                let found = self.set().applied_to(model.clone(), &self.constants(&weighted.values));
                simulated(self, &found, &weighted.values, motion)
                    .or_else(|_| simulated(self, model, &weighted.values, motion))
            })
            .collect::<Result<_, _>>()
            .map_err(|error| MethodError::NoInstruments(Box::new(error)))?;
        let stacked = self.accumulate_with(
            motions,
            |index, joint, effort| {
                let mut all = self.columns(joint, &simulated[index]);
                all.extend(self.columns(joint, motions[index]));
                (all, effort.to_vec())
            },
            |joint| 2 * self.by_joint[joint].len(),
        );
        let projected = |rows: &JointRows| JointRows {
            triangles: rows.triangles.iter().map(first_stage).collect(),
            ..rows.clone()
        };
        let beliefs = self.beliefs(settings)?;
        let noise = weighted.effort_noise.clone();
        let mut found = self.at_noise(&projected(&stacked), &beliefs, noise)?;
        let of_iv = self.with_block_errors(&stacked, &beliefs, &mut found, 1.0, projected)?;
        let mut same_noise = weighted.clone();
        let of_ls = self.with_block_errors(rows, &beliefs, &mut same_noise, 1.0, |r| r.clone())?;
        found.train = self.fit(rows, &found.values);
        let blocks = of_iv.len().min(of_ls.len());
        if blocks < FEWEST_BLOCKS {
            return Ok((found, None));
        }
        // the difference of both, block by block
        let difference = |k: usize| -> (f64, f64) {
            let squares: f64 = of_iv.iter().zip(&of_ls).map(|(a, b)| (a[k] - b[k]).powi(2)).sum();
            let error = (squares * (blocks - 1) as f64 / blocks as f64).sqrt();
            (found.values[k] - weighted.values[k], error)
        };
        let freedom = (blocks - 1) as f64;
        let tested = (0..self.terms.len())
            .filter(|&k| !found.at_bound[k] && !weighted.at_bound[k])
            .map(|k| (k, difference(k)))
            .filter(|(_, (_, error))| *error > 0.0)
            .map(|(k, (off, error))| (k, off / error))
            .collect::<Vec<_>>();
        let count = tested.len() as f64;
        let worst = tested.into_iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let endogeneity = worst.map(|(term, t)| Endogeneity {
            term,
            t,
            p: (2.0 * count * student_t_tail(t.abs(), freedom)).min(1.0),
        });
        Ok((found, endogeneity))
    }

    /// Puts standard errors from blocks into an estimate: solved once more without each block, at its
    /// noise levels and with the unknowns at their bounds held there. Returns how far each of these
    /// solutions lies from their mean.
    ///
    /// `widening` is for what the rows do not know of the method. What the prior knows is not in the blocks: it joins with its own covariance, `A⁻¹ P A⁻¹`.
    pub(crate) fn with_block_errors(
        &self,
        rows: &JointRows,
        beliefs: &Beliefs,
        estimate: &mut BatchEstimate,
        widening: f64,
        stage: impl Fn(&JointRows) -> JointRows,
    ) -> Result<Vec<Vec<f64>>, NumericError> {
        let blocks = rows.blocks.iter().map(Vec::len).min().unwrap_or(0);
        if blocks < FEWEST_BLOCKS {
            return Ok(Vec::new());
        }
        let p = self.terms.len();
        let without: Vec<Vec<AccumulatedQr>> =
            rows.blocks.iter().map(|of_joint| leave_one_out(of_joint)).collect();
        let mut solutions: Vec<Vec<f64>> = Vec::with_capacity(blocks);
        let free: Vec<usize> = (0..p).filter(|&k| !estimate.at_bound[k]).collect();
        let unbound = Beliefs { bound: None, prior: beliefs.prior.clone() };
        for b in 0..blocks {
            let left = stage(&JointRows {
                triangles: without.iter().map(|of_joint| of_joint[b].clone()).collect(),
                blocks: Vec::new(),
                ..rows.clone_without_rows()
            });
            solutions.push(self.solution_of(&left, &estimate.effort_noise, &unbound, &free)?);
        }
        let mean = |k: usize| solutions.iter().map(|x| x[k]).sum::<f64>() / blocks as f64;
        let means: Vec<f64> = (0..p).map(mean).collect();
        let off: Vec<Vec<f64>> =
            solutions.iter().map(|x| x.iter().zip(&means).map(|(x, m)| x - m).collect()).collect();
        let factor = widening * widening * (blocks - 1) as f64 / blocks as f64;
        let of_prior = beliefs.prior.as_ref().map(|prior| prior.carried(&estimate.covariance));
        estimate.covariance = Mat::from_fn(p, p, |i, j| {
            let of_blocks: f64 = off.iter().map(|d| d[i] * d[j]).sum();
            factor * of_blocks + of_prior.as_ref().map_or(0.0, |c| c[(i, j)])
        });
        estimate.quantile_95 = student_t_975((blocks - 1) as f64);
        Ok(off)
    }

    /// Values at given noise, those not in `free` being 0.
    fn solution_of(
        &self,
        rows: &JointRows,
        noise: &[f64],
        beliefs: &Beliefs,
        free: &[usize],
    ) -> Result<Vec<f64>, NumericError> {
        let (all, mean) = self.information(rows, noise, beliefs);
        let solved = all.with_unknowns(free).solve(RANK_CUT)?;
        let mut values = vec![0.0; self.terms.len()];
        for (&k, x) in free.iter().zip(&solved.solution) {
            values[k] = x + mean.as_ref().map_or(0.0, |m| m[k]);
        }
        Ok(values)
    }
}

/// Huber's weights of one joint.
struct Weighing {
    /// per motion and kept sample: what is left of the effort, then the root of the weight
    roots: Vec<Vec<f64>>,
    /// sum of the weights, samples within the scale, and all
    sum: f64,
    within: f64,
    samples: f64,
}

impl Weighing {
    /// Standard deviation of what is left, if it is normal, from its median.
    fn scale(&self) -> f64 {
        let mut left: Vec<f64> = self.roots.concat();
        let middle = left.len() / 2;
        if left.is_empty() {
            return f64::MIN_POSITIVE;
        }
        let median = *left.select_nth_unstable_by(middle, f64::total_cmp).1;
        (MAD_TO_SIGMA * median).max(f64::MIN_POSITIVE)
    }

    fn weigh(&mut self, limit: f64) {
        for left in self.roots.iter_mut().flatten() {
            let off = *left / limit;
            self.samples += 1.0;
            self.sum += off.max(1.0).recip();
            if off <= 1.0 {
                self.within += 1.0;
                *left = 1.0;
            } else {
                *left = off.recip().sqrt();
            }
        }
    }
}

/// The triangle of all blocks but one, for each one.
pub(crate) fn leave_one_out(blocks: &[AccumulatedQr]) -> Vec<AccumulatedQr> {
    let empty = AccumulatedQr::new(blocks[0].unknowns());
    let joined = |a: &AccumulatedQr, b: &AccumulatedQr| {
        let mut both = a.clone();
        both.merge(b);
        both
    };
    let mut before = vec![empty.clone()];
    for block in &blocks[..blocks.len() - 1] {
        before.push(joined(&before[before.len() - 1], block));
    }
    let mut after = empty;
    let mut all = Vec::with_capacity(blocks.len());
    for (block, before) in blocks.iter().zip(&before).rev() {
        all.push(joined(before, &after));
        after = joined(&after, block);
    }
    all.reverse();
    all
}

/// Rows of the columns projected on their instruments: from `[Z X | y]`, what of `[X | y]` lies along `Z`.
fn first_stage(stacked: &AccumulatedQr) -> AccumulatedQr {
    let p = stacked.unknowns() / 2;
    let order: Vec<usize> = (0..=2 * p).collect();
    let triangle = stacked.reordered(&order);
    let mut projected = AccumulatedQr::new(p);
    let rows: Vec<Vec<f64>> =
        (0..p).map(|i| (p..=2 * p).map(|j| triangle[(i, j)]).collect()).collect();
    projected.push_rows(&rows);
    projected
}

/// The motion of an arm with the friction found, driven by a controller along the recorded motion: the
/// same motion, but for the noise that the loop does not follow and the derivatives make.
fn simulated(
    problem: &BatchProblem<'_>,
    model: &ArmModel,
    values: &[f64],
    motion: &Motion,
) -> Result<Motion, SimulationError> {
    let names: Vec<&str> = motion.joints.iter().map(String::as_str).collect();
    let arm = SimulatedArm::new(model.rigid_arm(), &names, &problem.effects(values, &names))?;
    let trajectory = Trajectory {
        joints: motion.joints.clone(),
        time_s: motion.time_s.clone(),
        position: motion.position.clone(),
        velocity: motion.velocity.clone(),
        acceleration: motion.acceleration.clone(),
        source: motion.source.clone(),
        notes: Vec::new(),
    };
    let start: Vec<f64> = motion.position.iter().map(|q| q[0]).collect();
    let cutoff_hz = motion.filter.as_ref().map(|f| f.cutoff_hz());
    let bandwidth_hz = LOOP_OVER_CUTOFF * cutoff_hz.unwrap_or(0.1 * motion.rate_hz);
    let gains = TrackingGains::of_bandwidth(arm.rigid(), &start, bandwidth_hz);
    // efforts held over a slow control cycle throw a light joint off before they are set again
    let finer = (CONTROL_HZ / motion.rate_hz).ceil().max(1.0);
    let trajectory = match finer {
        1.0 => trajectory,
        _ => trajectory.resampled(finer * motion.rate_hz)?,
    };
    let moved = track(&arm, arm.rigid(), &trajectory, &gains)?;
    let settings = MotionSettings {
        cutoff_hz,
        derivatives: DerivativeSource::Recorded,
        ..MotionSettings::default()
    };
    let mut instruments = Motion::from_recording(&moved, &names, &settings)?;
    let step = (instruments.rate_hz / motion.rate_hz).round().max(1.0) as usize;
    // a grid of its own may have a sample more or less
    for columns in
        [&mut instruments.position, &mut instruments.velocity, &mut instruments.acceleration]
    {
        for column in columns.iter_mut() {
            *column = column.iter().step_by(step).copied().collect();
            let last = column.last().copied().unwrap_or_default();
            column.resize(motion.len(), last);
        }
    }
    // the columns of the instruments go through the filter of the recorded ones
    let mut aligned = motion.clone();
    aligned.position = instruments.position;
    aligned.velocity = instruments.velocity;
    aligned.acceleration = instruments.acceleration;
    Ok(aligned.without_fine())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(seed: usize) -> AccumulatedQr {
        let mut block = AccumulatedQr::new(2);
        let rows: Vec<Vec<f64>> = (0..5)
            .map(|i| (0..3).map(|j| ((7 * seed + 3 * i + j) as f64).sin()).collect())
            .collect();
        block.push_rows(&rows);
        block
    }

    #[test]
    fn each_block_is_left_out_once() {
        let blocks: Vec<AccumulatedQr> = (0..5).map(block).collect();
        for (b, left) in leave_one_out(&blocks).iter().enumerate() {
            let mut expected = AccumulatedQr::new(2);
            for (k, block) in blocks.iter().enumerate() {
                if k != b {
                    expected.merge(block);
                }
            }
            let (x, y) = (left.solve(1e-12).unwrap(), expected.solve(1e-12).unwrap());
            for (x, y) in x.solution.iter().zip(&y.solution) {
                assert!((x - y).abs() < 1e-12);
            }
        }
    }

    /// Noise in the column pulls least squares towards zero, and not the instruments.
    #[test]
    fn instruments_undo_noise_in_the_column() {
        let (mut stacked, mut plain) = (AccumulatedQr::new(2), AccumulatedQr::new(1));
        for t in 0..4000 {
            let t = f64::from(t);
            let clean = (0.01 * t).sin();
            let noisy = clean + 0.6 * (1.7 * t * t).sin();
            stacked.push_rows(&[vec![clean, noisy, 2.0 * clean]]);
            plain.push_rows(&[vec![noisy, 2.0 * clean]]);
        }
        let by_instruments = first_stage(&stacked).solve(1e-12).unwrap().solution[0];
        let by_squares = plain.solve(1e-12).unwrap().solution[0];
        assert!((by_instruments - 2.0).abs() < 0.05, "{by_instruments}");
        assert!(by_squares < 1.7, "{by_squares}");
    }
}
