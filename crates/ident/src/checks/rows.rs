//! The rows of all checks: one triangle a joint, with the columns of the model, the
//! URDF's gravity, the efforts of all joints, and the joint's own effort at other times.

use armident_dynamics::{ArmMotion, RigidArm, inverse_dynamics_of_motion};
use armident_motion::{Motion, QualityReport};
use armident_numeric::{AccumulatedQr, NumericError};
use armident_recording::{Interpolation, Quantity};

use crate::regression::{BatchProblem, RANK_CUT, Term};
use crate::used_samples::EDGE_PERIODS;
use armident_inference::correlation_time;

/// Effort shifts tried to either side.
pub(super) const SHIFTS_ASIDE: usize = 16;
/// Longest delay looked for \[s\]: drives and field buses have been seen to take some tens of
/// milliseconds.
pub(super) const LONGEST_DELAY_S: f64 = 0.06;
/// Samples per period of the cut-off at which the correlation of residuals is looked at.
pub(super) const SAMPLES_PER_CUTOFF: f64 = 4.0;

/// Rows of one joint, reduced.
///
/// Columns: the joint's terms, the URDF's gravity effort, the effort of every joint, the joint's own
/// effort at each of [`shifts_s`], which also stands on the right-hand side.
#[derive(Debug, Clone)]
pub(super) struct ChannelRows {
    pub(super) triangle: AccumulatedQr,
    /// number of the joint's terms
    pub(super) terms: usize,
    /// number of joints
    pub(super) joints: usize,
    /// samples
    pub(super) samples: f64,
    /// effective sample size of the residual of the joint's terms
    pub(super) effective: f64,
    /// the same for the error of laws that are not quite those of the robot: noise is as independent as above, a
    /// function of the motion only as much as the residual of friction alone
    pub(super) effective_of_model_error: f64,
    /// standard deviation of the recorded noise after the low-pass \[N m or N\]: no model leaves less
    pub(super) noise: f64,
    /// root mean square of the residual \[N m or N\]
    pub(super) residual_rms: f64,
    /// standard deviation of the filtered effort \[N m or N\]
    pub(super) effort_sd: f64,
    /// standard deviation of the URDF's effort \[N m or N\]
    pub(super) urdf_sd: f64,
    /// share of the squared effort beside friction that the URDF's effort explains, times any gain
    pub(super) urdf_share: f64,
    /// share of the variance of the effort that friction alone explains
    pub(super) friction_share: f64,
}

/// What the terms of a joint leave of its effort at each shift: the vectors have the squares and products of the residuals.
pub(super) struct ShiftedResiduals {
    /// Independent samples beyond the terms.
    pub(super) freedom: f64,
    /// `[shift][row]`
    pub(super) left: Vec<Vec<f64>>,
}

impl ChannelRows {
    /// What its terms leave of its effort at each shift.
    pub(super) fn shifted_residuals(&self) -> ShiftedResiduals {
        let own = independent(&self.triangle, &(0..self.terms).collect::<Vec<usize>>());
        let first = own.len();
        let shifts = 2 * SHIFTS_ASIDE + 1;
        let order: Vec<usize> =
            own.into_iter().chain((0..shifts).map(|k| self.shifted(k))).collect();
        let r = self.triangle.reordered(&order);
        let left = |k: usize| (first..first + shifts).map(|i| r[(i, first + k)]).collect();
        ShiftedResiduals {
            freedom: (self.effective - first as f64).max(1.0),
            left: (0..shifts).map(left).collect(),
        }
    }

    pub(super) fn gravity(&self) -> usize {
        self.terms
    }

    pub(super) fn effort_of(&self, joint: usize) -> usize {
        self.terms + 1 + joint
    }

    pub(super) fn shifted(&self, shift: usize) -> usize {
        self.terms + 1 + self.joints + shift
    }

    /// Share of the standard deviation of the effort that the terms leave: as many terms as independent samples would leave
    /// nothing of an effort that has nothing to do with them.
    pub(super) fn residual_share(&self) -> f64 {
        let freedom = (self.effective - self.terms as f64).max(1.0);
        let variance = self.residual_rms.powi(2) * (self.effective / freedom).max(1.0);
        (variance.sqrt() / self.effort_sd).min(1.0)
    }

    /// How much of the effort is the URDF's, and how much is friction.
    fn measure_shares(&mut self, problem: &BatchProblem, joint: usize) {
        let values = problem.set().values(&problem.arm().constants());
        let mut order: Vec<usize> = Vec::new();
        let mut constants: Vec<(usize, f64)> = Vec::new();
        for (place, &k) in problem.terms_of_joint(joint).iter().enumerate() {
            match problem.terms[k] {
                Term::Constant(c) => constants.push((place, values[c])),
                _ => order.push(place),
            }
        }
        let friction = order.len();
        order.extend(constants.iter().map(|(place, _)| *place));
        order.push(self.effort_of(joint));
        let r = self.triangle.reordered(&order);
        let last = order.len() - 1;
        let (mut along, mut of_urdf, mut of_effort) = (0.0, 0.0, 0.0);
        for i in friction..=last {
            let urdf: f64 =
                constants.iter().enumerate().map(|(k, (_, x))| r[(i, friction + k)] * x).sum();
            along += urdf * r[(i, last)];
            of_urdf += urdf * urdf;
            of_effort += r[(i, last)] * r[(i, last)];
        }
        let share = along * along / (of_urdf * of_effort);
        self.urdf_share = if share.is_finite() { share } else { 0.0 };
        let left = of_effort / self.samples / self.effort_sd.powi(2);
        self.friction_share = if left.is_finite() { (1.0 - left).max(0.0) } else { 0.0 };
    }

    /// Size and effective sample size of the residual.
    fn measure_residual(
        &mut self,
        problem: &BatchProblem,
        joint: usize,
        motions: &[Motion],
        moved: &[ArmMotion<'_>],
    ) -> Result<(), NumericError> {
        // all terms, and those of friction alone
        let own: Vec<usize> = (0..self.terms).collect();
        let is_friction = |place: &usize| {
            !matches!(problem.terms[problem.terms_of_joint(joint)[*place]], Term::Constant(_))
        };
        let friction: Vec<usize> = own.iter().copied().filter(is_friction).collect();
        let fitted = |places: &[usize]| self.triangle.with_unknowns(places).solve(RANK_CUT);
        let fits = [(fitted(&own)?, own), (fitted(&friction)?, friction)];
        let mut thinned = [Vec::new(), Vec::new()];
        let mut squares = 0.0;
        for (motion, moved) in motions.iter().zip(moved) {
            let Some(effort) = &motion.effort_filtered else { continue };
            let columns = model_columns(problem, joint, motion, moved);
            let edge = edge(motion);
            let stride = motion.filter.as_ref().map_or(1.0, |filter| {
                (motion.rate_hz / (SAMPLES_PER_CUTOFF * filter.cutoff_hz())).floor().max(1.0)
            });
            for (k, (fit, places)) in fits.iter().enumerate() {
                let left: Vec<f64> = (0..motion.len() - 2 * edge)
                    .map(|t| {
                        let pairs = places.iter().zip(&fit.solution);
                        let fitted: f64 = pairs.map(|(&c, x)| columns[c][t] * x).sum();
                        effort[joint][edge + t] - fitted
                    })
                    .collect();
                let kept = motion.observations(joint, edge..motion.len() - edge);
                let left = kept.beginning_at(edge).of(&left);
                if k == 0 {
                    squares += left.iter().map(|r| r * r).sum::<f64>();
                }
                thinned[k]
                    .push(left.iter().step_by(stride as usize).copied().collect::<Vec<f64>>());
            }
        }
        // the low-pass passes no more, whatever the residual of many terms looks like
        let most: f64 = motions.iter().map(|m| m.independent_share() * m.len() as f64).sum();
        let independent = |of: &[Vec<f64>]| {
            let count: usize = of.iter().map(Vec::len).sum();
            (count as f64 / correlation_time(of)).min(most).max(1.0)
        };
        self.residual_rms = (squares / self.samples).sqrt();
        self.effective = independent(&thinned[0]);
        // the residual is noise to this share, and otherwise a function of the motion
        let over = self.noise / self.residual_rms;
        let noisy = if over.is_finite() { over.powi(2).min(1.0) } else { 1.0 };
        let of_motion = independent(&thinned[1]).min(self.effective);
        // as many terms as independent samples leave no residual, which looks like noise
        let free = (1.0 - self.terms as f64 / most).max(0.0);
        self.effective_of_model_error = of_motion + noisy.max(free) * (self.effective - of_motion);
        Ok(())
    }
}

/// The columns that are none of those before them: a triangle whose leading columns depend on one another leaves parts of the
/// later ones in their rows.
pub(super) fn independent(rows: &AccumulatedQr, columns: &[usize]) -> Vec<usize> {
    let r = rows.reordered(columns);
    let is_own = |k: &usize| {
        let size = (0..=*k).map(|i| r[(i, *k)].powi(2)).sum::<f64>().sqrt();
        r[(*k, *k)].abs() > RANK_CUT * size
    };
    (0..columns.len()).filter(is_own).map(|k| columns[k]).collect()
}

/// Times by which the effort is read later \[s\]: positive finds an effort that lags.
pub(super) fn shifts_s() -> Vec<f64> {
    let steps = SHIFTS_ASIDE as f64;
    (0..=2 * SHIFTS_ASIDE).map(|k| (k as f64 - steps) / steps * LONGEST_DELAY_S).collect()
}

/// The motion with its efforts read `delay_s` later.
pub(super) fn with_effort_from(motion: &Motion, delay_s: f64) -> Motion {
    with_effort_at(motion, |t| t + delay_s)
}

/// The motion with its efforts put back to its times, where their clock is fast by the share `drift`.
pub(super) fn with_effort_before_clock(motion: &Motion, drift: f64) -> Motion {
    let start_s = motion.time_s.first().copied().unwrap_or_default();
    with_effort_at(motion, |t| start_s + (t - start_s) / (1.0 + drift))
}

/// The motion with its efforts read at other times.
fn with_effort_at(motion: &Motion, time_s: impl Fn(f64) -> f64) -> Motion {
    let times: Vec<f64> = motion.time_s.iter().map(|t| time_s(*t)).collect();
    let at = Interpolation::new(&motion.time_s, &times, 2.0 / motion.rate_hz);
    let mut moved = motion.clone();
    for efforts in [&mut moved.effort, &mut moved.effort_filtered].into_iter().flatten() {
        efforts.iter_mut().for_each(|effort| *effort = at.apply(effort));
    }
    moved
}

/// Samples left out at both ends, of the filter and of the shifts.
pub(super) fn edge(motion: &Motion) -> usize {
    let of_filter = motion.filter.as_ref().map_or(0.0, |filter| EDGE_PERIODS / filter.cutoff_hz());
    let edge = (motion.rate_hz * of_filter.max(LONGEST_DELAY_S)).ceil() as usize;
    edge.min(motion.len() / 4)
}

/// Model columns of one joint over one motion, without the ends.
fn model_columns(
    problem: &BatchProblem,
    joint: usize,
    motion: &Motion,
    moved: &ArmMotion<'_>,
) -> Vec<Vec<f64>> {
    let edge = edge(motion);
    let jumping = problem.jumping_columns(joint, motion);
    let mut columns = problem.columns_beside(joint, motion, moved, &jumping);
    for column in &mut columns {
        column.truncate(motion.len() - edge);
        column.drain(..edge);
    }
    columns
}

/// Standard deviation of the noise of one recorded sample of a joint, of the noisiest recording; none where it is not known.
pub(super) fn recorded_noise(
    reports: &[QualityReport],
    name: &str,
    quantity: Quantity,
) -> Option<f64> {
    let channels = reports.iter().flat_map(|r| &r.channels);
    let own = channels.filter(|c| c.joint == name && c.quantity == quantity);
    own.filter_map(|c| c.noise).max_by(f64::total_cmp)
}

/// Standard deviation of values about their mean.
pub(super) fn deviation(values: &[&[f64]]) -> f64 {
    let all = || values.iter().copied().flatten();
    let count = all().count().max(1) as f64;
    let mean = all().sum::<f64>() / count;
    (all().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Noise of a joint's acceleration after the low-pass, of white noise of the position differentiated twice, as a share of the
/// acceleration; none where accelerations are exact, or no noise is known.
pub(super) fn acceleration_noise(
    reports: &[QualityReport],
    motions: &[Motion],
    joint: usize,
    name: &str,
) -> Option<f64> {
    let sigma = recorded_noise(reports, name, Quantity::Position)?;
    let cutoffs_hz: Option<Vec<f64>> =
        motions.iter().map(|m| Some(m.filter.as_ref()?.cutoff_hz())).collect();
    let cutoff_hz = cutoffs_hz?.into_iter().fold(0.0, f64::max);
    let rate_hz = motions.iter().map(|m| m.rate_hz).fold(f64::INFINITY, f64::min);
    let noise = sigma
        * (std::f64::consts::TAU * cutoff_hz).powi(2)
        * (2.0 * cutoff_hz / (5.0 * rate_hz)).sqrt();
    let all: Vec<&[f64]> = motions.iter().map(|m| m.acceleration[joint].as_slice()).collect();
    Some(noise / deviation(&all))
}

/// Standard deviation of the recorded noise of each joint's effort after the low-pass \[N m or N\].
pub(super) fn noise_in_band(
    names: &[&str],
    motions: &[Motion],
    reports: &[QualityReport],
) -> Vec<f64> {
    let samples: f64 = motions.iter().map(|m| m.len() as f64).sum();
    let of_joint = |name: &&str| {
        let squares: f64 = motions
            .iter()
            .zip(reports)
            .map(|(motion, report)| {
                let effort = report
                    .channels
                    .iter()
                    .find(|c| c.joint == **name && c.quantity == Quantity::Effort);
                let sigma = effort.and_then(|c| c.noise).unwrap_or(0.0);
                sigma * sigma * motion.independent_share() * motion.len() as f64
            })
            .sum();
        (squares / samples).sqrt()
    };
    names.iter().map(of_joint).collect()
}

/// Reduces all motions, joint by joint. Memory: the columns of one joint of one recording.
pub(super) fn accumulate(
    problem: &BatchProblem,
    arm: &RigidArm,
    motions: &[Motion],
    noise: &[f64],
) -> Result<Vec<ChannelRows>, NumericError> {
    let n = arm.dof();
    let shifts = shifts_s();
    let mut gravity: Vec<Vec<Vec<f64>>> = Vec::new();
    let mut of_urdf = vec![(0.0, 0.0, 0.0); n];
    let moved = problem.arm_motions(&motions.iter().collect::<Vec<_>>());
    for (motion, moved) in motions.iter().zip(&moved) {
        let still = vec![vec![0.0; motion.len()]; n];
        let mut of_motion = inverse_dynamics_of_motion(arm, &motion.position, &still, &still);
        motion.filter_columns(&mut of_motion);
        gravity.push(of_motion);
        let rigid = moved.efforts(arm);
        let edge = edge(motion);
        for (moments, effort) in of_urdf.iter_mut().zip(&rigid) {
            for e in &effort[edge..effort.len() - edge] {
                *moments = (moments.0 + 1.0, moments.1 + e, moments.2 + e * e);
            }
        }
    }
    let mut all = Vec::with_capacity(n);
    for joint in 0..n {
        let terms = problem.terms_of_joint(joint).len();
        let mut rows = ChannelRows {
            triangle: AccumulatedQr::new(terms + 1 + n + shifts.len()),
            terms,
            joints: n,
            samples: 0.0,
            effective: 0.0,
            effective_of_model_error: 0.0,
            noise: noise[joint],
            residual_rms: 0.0,
            effort_sd: 0.0,
            urdf_sd: 0.0,
            urdf_share: 0.0,
            friction_share: 0.0,
        };
        let mut effort_moments = (0.0, 0.0);
        for ((motion, moved), gravity) in motions.iter().zip(&moved).zip(&gravity) {
            let Some(effort) = &motion.effort_filtered else { continue };
            let edge = edge(motion);
            let kept = edge..motion.len() - edge;
            let mut columns = model_columns(problem, joint, motion, moved);
            columns.push(gravity[joint][kept.clone()].to_vec());
            columns.extend(effort.iter().map(|e| e[kept.clone()].to_vec()));
            for shift in &shifts {
                let later: Vec<f64> =
                    motion.time_s[kept.clone()].iter().map(|t| t + shift).collect();
                let longest_s = 2.0 / motion.rate_hz;
                let at = Interpolation::new(&motion.time_s, &later, longest_s);
                columns.push(at.apply(&effort[joint]));
            }
            // a rest is one row
            let observed = motion.observations(joint, kept.clone()).beginning_at(edge);
            let columns: Vec<Vec<f64>> = columns.iter().map(|c| observed.of(c)).collect();
            let own = observed.of(&effort[joint][kept]);
            rows.triangle.push_columns(&columns, &own);
            rows.samples += own.len() as f64;
            effort_moments.0 += own.iter().sum::<f64>();
            effort_moments.1 += own.iter().map(|e| e * e).sum::<f64>();
        }
        let mean = effort_moments.0 / rows.samples;
        rows.effort_sd = (effort_moments.1 / rows.samples - mean * mean).max(0.0).sqrt();
        let (count, sum, of_squares) = of_urdf[joint];
        rows.urdf_sd = (of_squares / count - (sum / count).powi(2)).max(0.0).sqrt();
        rows.measure_residual(problem, joint, motions, &moved)?;
        rows.measure_shares(problem, joint);
        all.push(rows);
    }
    Ok(all)
}
