//! A distance between two axes that is not the given one.
//!
//! Method: likelihood of the free model of each joint, with the distance as a factor of the given one. All inertial constants and
//! friction are free at each distance, so that no wrong inertia looks like a wrong length: what shows a length is how weight and
//! coupling of the same body are related. Three values about the given one show where the likelihood rises; from there on it is
//! followed uphill, and its top is that of a [table](super::likelihood_top). A length is wrong where the top is a thousand times as
//! likely as the given one, for each length that was tried, where it takes a seventh of the residual of a joint, and where its interval
//! excludes the given one.
//! References: own.

use armident_dynamics::{ArmMotion, RigidArm};
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings};
use armident_numeric::{AccumulatedQr, NumericError};
use armident_recording::Recording;
use rayon::prelude::*;

use super::arm_columns::JointMap;
use super::likelihood_top::{CLEARLY, Top};
use super::rows::{self, ChannelRows, edge};
use crate::minimal_set::MinimalSet;
use crate::regression::{BatchProblem, RANK_CUT, TermColumn};

/// Shortest distance that is looked at \[m\]: a shorter one moves efforts by less than friction does.
const SHORTEST_M: f64 = 0.01;
/// Factor between neighbouring distances.
const STEP: f64 = 1.15;
/// Factor between those of the last table.
const FINE_STEP: f64 = 1.02;
/// Largest factor of a distance, either way: beyond it the file is of another arm.
const MOST: f64 = 4.0;
/// Residual of a joint at the found distance over that at the given one: a sixth more without it, as for a finding.
const MATERIAL: f64 = 6.0 / 7.0;
/// Cut-off \[Hz\]: below it the efforts of an arm are those of its links; springs of transmissions and controllers are above it.
const CUTOFF_HZ: f64 = 6.0;
/// Residual over noise below which nothing is to be explained.
const AT_NOISE: f64 = 1.2;

/// Which of the two lengths of a driving-axis frame (S.-K. Lin 1992, eq. 3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameLength {
    /// `b`, the common normal from the axis before.
    Normal,
    /// `d'`, the offset along the axis of the joint.
    Offset,
}

/// A distance between two axes that recordings contradict.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkLength {
    /// Place of the joint in the chain.
    pub joint: usize,
    /// Which length of its frame.
    pub along: FrameLength,
    /// The given length \[m\].
    pub given_m: f64,
    /// Most likely length \[m\].
    pub length_m: f64,
    /// 95 % interval \[m\].
    pub interval_95_m: [f64; 2],
    /// `2 ln` of the likelihood of it over that of the given one.
    pub evidence: f64,
    /// RMS residual of the joint on which it is worth most, over that with the given one.
    pub residual_ratio: f64,
    /// That joint.
    pub shown_by: usize,
    /// RMS residual of that joint with the given length \[N m or N\].
    pub residual_given: f64,
}

impl LinkLength {
    /// Standard error \[m\].
    pub fn standard_error_m(&self) -> f64 {
        (self.interval_95_m[1] - self.interval_95_m[0]).abs() / (2.0 * 1.96)
    }

    /// The model with this length; its links are as they were in their frames.
    pub fn corrected(&self, model: &ArmModel) -> ArmModel {
        self.lengthened(model, self.length_m - self.given_m)
    }

    /// A [corrected](Self::corrected) model with the given length again.
    pub fn as_given(&self, model: &ArmModel) -> ArmModel {
        self.lengthened(model, self.given_m - self.length_m)
    }

    fn lengthened(&self, model: &ArmModel, by_m: f64) -> ArmModel {
        let mut changed = model.clone();
        *length_of(&mut changed.chain.joints[self.joint].frame, self.along) += by_m;
        changed
    }
}

fn length_of(frame: &mut armident_kinematics::DrivingAxisFrame, along: FrameLength) -> &mut f64 {
    match along {
        FrameLength::Normal => &mut frame.b_m,
        FrameLength::Offset => &mut frame.d_m,
    }
}

/// What does not change with the geometry.
struct Observed<'a> {
    problem: &'a BatchProblem,
    motions: &'a [Motion],
    /// joints that count
    joints: Vec<usize>,
    /// `[joint that counts][motion]`
    jumping: Vec<Vec<Vec<TermColumn>>>,
    /// independent samples beyond the terms, of each joint that counts
    freedom: Vec<f64>,
}

impl Observed<'_> {
    /// Squared residuals of the free models at a geometry, by joint that counts.
    fn squares(&self, arm: &RigidArm) -> Result<Vec<f64>, NumericError> {
        let mut problem = BatchProblem::new(arm, &MinimalSet::of(arm)?);
        problem.reversals.clone_from(&self.problem.reversals);
        let moved = problem.arm_motions(&self.motions.iter().collect::<Vec<_>>());
        let of_joint = |(k, &joint): (usize, &usize)| -> Result<f64, NumericError> {
            let mut rows = AccumulatedQr::new(problem.terms_of_joint(joint).len());
            for ((motion, moved), jumping) in self.motions.iter().zip(&moved).zip(&self.jumping[k])
            {
                push(&mut rows, &problem, (joint, motion, moved), jumping);
            }
            Ok(rows.solve(RANK_CUT)?.residual_sum_of_squares)
        };
        self.joints.iter().enumerate().map(of_joint).collect()
    }

    fn log_likelihood(&self, squares: &[f64]) -> Vec<f64> {
        squares.iter().zip(&self.freedom).map(|(s, freedom)| -0.5 * freedom * s.ln()).collect()
    }
}

fn push(
    rows: &mut AccumulatedQr,
    problem: &BatchProblem,
    (joint, motion, moved): (usize, &Motion, &ArmMotion<'_>),
    jumping: &[TermColumn],
) {
    let Some(effort) = &motion.effort_filtered else { return };
    let edge = edge(motion);
    let kept = edge..motion.len() - edge;
    let observed = motion.observations(joint, kept.clone()).beginning_at(edge);
    let columns: Vec<Vec<f64>> = problem
        .columns_beside(joint, motion, moved, jumping)
        .iter()
        .map(|column| observed.of(&column[kept.clone()]))
        .collect();
    rows.push_columns(&columns, &observed.of(&effort[joint][kept]));
}

/// Motions of the recordings below the cut-off of this check; none where they cannot be formed, and those at hand where these
/// are not filtered, or by less.
fn slow(motions: &[Motion], (recordings, map): (&[Recording], &JointMap)) -> Option<Vec<Motion>> {
    let is_slow = |m: &Motion| m.filter.as_ref().is_none_or(|f| f.cutoff_hz() <= CUTOFF_HZ);
    if motions.iter().all(is_slow) {
        return Some(motions.to_vec());
    }
    let names: Vec<&str> = motions[0].joints.iter().map(String::as_str).collect();
    let settings = MotionSettings { cutoff_hz: Some(CUTOFF_HZ), ..MotionSettings::default() };
    let of =
        |r: &Recording| Motion::from_recording(r, &names, &settings).ok().map(|m| map.motion(&m));
    recordings.iter().map(of).collect()
}

/// The distance that the recordings contradict most clearly; none where they contradict none. `noise` as of the rows.
pub(super) fn link_length(
    problem: &BatchProblem,
    (motions, noise): (&[Motion], &[f64]),
    (recordings, map): (&[Recording], &JointMap),
    rows: &[ChannelRows],
    is_silent: &[bool],
) -> Result<Option<LinkLength>, NumericError> {
    let joints: Vec<usize> = (0..rows.len()).filter(|&j| !is_silent[j]).collect();
    if joints.iter().all(|&j| rows[j].residual_rms < AT_NOISE * rows[j].noise) {
        return Ok(None);
    }
    let Some(slow) = slow(motions, (recordings, map)) else { return Ok(None) };
    let arm = problem.arm();
    let rows = rows::accumulate(problem, arm, &slow, noise)?;
    let mut tried: Vec<(usize, FrameLength, f64)> = Vec::new();
    for (joint, geometry) in arm.joints.iter().enumerate().skip(1) {
        for (along, length) in
            [(FrameLength::Normal, geometry.frame.b_m), (FrameLength::Offset, geometry.frame.d_m)]
        {
            if length.abs() >= SHORTEST_M {
                tried.push((joint, along, length));
            }
        }
    }
    let thinned: Vec<Motion> = slow.into_iter().map(Motion::thinned).collect();
    let jumping = joints.iter().map(|&joint| {
        thinned.iter().map(|motion| problem.jumping_columns(joint, motion)).collect()
    });
    let observed = Observed {
        problem,
        motions: &thinned,
        jumping: jumping.collect(),
        freedom: joints
            .iter()
            .map(|&j| (rows[j].effective - rows[j].terms as f64).max(1.0))
            .collect(),
        joints,
    };
    let given = observed.squares(arm)?;
    if given.iter().any(|squares| squares.is_nan() || *squares <= 0.0) {
        return Ok(None);
    }
    let clearly = CLEARLY + 2.0 * (tried.len().max(1) as f64).ln();
    let found: Vec<Option<LinkLength>> = tried
        .par_iter()
        .map(|&(joint, along, given_m)| {
            let with = |factor: f64| -> Result<Vec<f64>, NumericError> {
                let mut arm = arm.clone();
                *length_of(&mut arm.joints[joint].frame, along) = factor * given_m;
                observed.squares(&arm)
            };
            let Some(found) = wrong_factor(&observed, &given, clearly, &with)? else {
                return Ok(None);
            };
            let shown_by = observed.joints[found.shown_by];
            let [a, b] = found.interval_95.map(|factor| factor * given_m);
            Ok(Some(LinkLength {
                joint,
                along,
                given_m,
                length_m: found.factor * given_m,
                interval_95_m: [a.min(b), a.max(b)],
                evidence: found.evidence,
                residual_ratio: found.residual_ratio,
                shown_by,
                residual_given: rows[shown_by].residual_rms,
            }))
        })
        .collect::<Result<_, NumericError>>()?;
    Ok(found.into_iter().flatten().max_by(|a, b| a.evidence.total_cmp(&b.evidence)))
}

/// A factor of a length that is clearly not 1.
struct WrongFactor {
    factor: f64,
    interval_95: [f64; 2],
    /// as of a [`LinkLength`]
    evidence: f64,
    residual_ratio: f64,
    /// place among the joints that count
    shown_by: usize,
}

/// The most likely factor of a length with its interval, where it is clear, material, and not 1.
fn wrong_factor(
    observed: &Observed<'_>,
    given: &[f64],
    clearly: f64,
    with: &(dyn Fn(f64) -> Result<Vec<f64>, NumericError> + Sync),
) -> Result<Option<WrongFactor>, NumericError> {
    let total = |squares: &[f64]| observed.log_likelihood(squares).iter().sum::<f64>();
    let here = total(given);
    let [shorter, longer] = [total(&with(1.0 / STEP)?), total(&with(STEP)?)];
    // the parabola through three values: what a length could gain
    let slope = 0.5 * (longer - shorter);
    let curvature = shorter + longer - 2.0 * here;
    let gain = if curvature < 0.0 { -0.5 * slope * slope / curvature } else { f64::INFINITY };
    if 2.0 * gain <= clearly {
        return Ok(None);
    }
    let step = if slope > 0.0 { STEP } else { 1.0 / STEP };
    let (mut factor, mut best) = (1.0, here);
    loop {
        let next = factor * step;
        if !(1.0 / MOST..=MOST).contains(&next) {
            return Ok(None);
        }
        let there = total(&with(next)?);
        if there <= best {
            break;
        }
        (factor, best) = (next, there);
    }
    // in logarithms of the factor, a step of the walk to either side
    let steps = (STEP.ln() / FINE_STEP.ln()).ceil() as i32;
    let factors: Vec<f64> = (-steps..=steps).map(|k| factor * FINE_STEP.powi(k)).collect();
    let squares: Vec<Vec<f64>> =
        factors.iter().map(|factor| with(*factor)).collect::<Result<_, NumericError>>()?;
    let by_value: Vec<Vec<f64>> = squares.iter().map(|s| observed.log_likelihood(s)).collect();
    let by_joint: Vec<Vec<f64>> =
        (0..given.len()).map(|j| by_value.iter().map(|of| of[j]).collect()).collect();
    let log_step = FINE_STEP.ln();
    let Some(Top { best, off, half, height, .. }) = Top::of(&by_joint, log_step) else {
        return Ok(None);
    };
    let log_factor = factors[best].ln() + off;
    let evidence = 2.0 * (height - here);
    let ratios = squares[best].iter().zip(given).map(|(with, given)| (with / given).sqrt());
    let Some((shown_by, residual_ratio)) = ratios.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
    else {
        return Ok(None);
    };
    let is_wrong = evidence > clearly && residual_ratio < MATERIAL && log_factor.abs() > half;
    Ok(is_wrong.then(|| WrongFactor {
        factor: log_factor.exp(),
        interval_95: [(log_factor - half).exp(), (log_factor + half).exp()],
        evidence,
        residual_ratio,
        shown_by,
    }))
}
