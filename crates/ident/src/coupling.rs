//! Transmissions that neighbouring joints share, chosen by cross-validation.
//!
//! The last motors of a wrist often drive their joint through the one before: their friction acts on the
//! sum of both speeds, and on both joints. Which pairs, and with what ratio, the training recordings are
//! asked: a pair is taken where the efforts of stretches of time that were not fitted are explained
//! clearly better with it.

use armident_effects::{Effect, EffectOnJoint, JointCoupling, MotionScale};
use armident_kinematics::JointKind;
use armident_numeric::NumericError;
use armident_recording::Motion;

use crate::batch::{BatchProblem, BatchSettings, Beliefs, RANK_CUT, Term};
use crate::rows::{JointRows, joint_motion};

/// The law of a shared transmission.
pub(crate) const SHARED: &dyn Effect = &JointCoupling;
/// Stretches of time that are left out in turn.
const FOLDS: usize = 5;
/// Share by which the error of what was left out must fall (geometric mean of both joints),
const LEAST_GAIN: f64 = 0.1;
/// and over its standard error, from the folds.
const LEAST_GAIN_IN_ERRORS: f64 = 2.0;

/// A transmission shared by a joint and the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// The first of both joints, from 0.
    pub first: usize,
    /// Speed of the common shaft: that of the second joint and `ratio` times that of the first.
    pub ratio: f64,
}

impl Coupling {
    /// The law's name in files.
    pub const SLUG: &str = "joint_coupling";

    /// Both joints.
    pub fn joints(self) -> [usize; 2] {
        [self.first, self.first + 1]
    }

    fn terms(self) -> impl Iterator<Item = Term> {
        (0..SHARED.law().parameters.len() - 1)
            .map(move |coefficient| Term::Shared { coupling: self, coefficient })
    }
}

/// A coupling that the recordings show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CouplingFound {
    /// Which.
    pub coupling: Coupling,
    /// Share by which the error of both joints falls where it was not fitted (geometric mean).
    pub gain: f64,
}

impl BatchProblem<'_> {
    /// The same with unknowns of shared transmissions behind its own.
    #[must_use]
    pub fn with_couplings(&self, couplings: &[Coupling]) -> Self {
        let mut problem = self.clone();
        for coupling in couplings {
            for term in coupling.terms() {
                for joint in coupling.joints() {
                    problem.by_joint[joint].push(problem.terms.len());
                }
                problem.terms.push(term);
            }
        }
        problem
    }

    /// The couplings of neighbours that these motions show, the clearest first. Costs one accumulation
    /// with a few columns more.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn couplings_shown(
        &self,
        motions: &[&Motion],
        settings: &BatchSettings,
    ) -> Result<Vec<CouplingFound>, NumericError> {
        let candidates: Vec<Coupling> = (1..self.by_joint.len())
            .flat_map(|second| {
                let kind = self.arm().joints[second].kind;
                let scale =
                    MotionScale { kind, speed_rms: 1.0, position_deviation: 1.0, duration_s: 1.0 };
                let shapes = SHARED.shapes(&scale).into_iter();
                shapes.map(move |shape| Coupling { first: second - 1, ratio: shape[0] })
            })
            .collect();
        let all = self.with_couplings(&candidates);
        let rows = all.accumulate(motions);
        let blocks = rows.blocks.iter().map(Vec::len).min().unwrap_or(0);
        let mut found: Vec<CouplingFound> = Vec::new();
        if blocks < FOLDS {
            return Ok(found);
        }
        let beliefs_of = |problem: &BatchProblem<'_>| problem.beliefs(settings);
        loop {
            let chosen: Vec<Coupling> = found.iter().map(|f| f.coupling).collect();
            let mut best: Option<CouplingFound> = None;
            for first in 0..self.by_joint.len() - 1 {
                if chosen.iter().any(|c| c.first == first) {
                    continue;
                }
                let of_pair = candidates.iter().filter(|c| c.first == first);
                let mut nearest: Option<(f64, Coupling)> = None;
                for &coupling in of_pair {
                    let with = self.with_couplings(&[&chosen[..], &[coupling]].concat());
                    let picked = rows_of(&rows, &all, &with);
                    let left = error_of_both(&with, &picked, coupling, &beliefs_of(&with)?)?;
                    if nearest.is_none_or(|(least, _)| left < least) {
                        nearest = Some((left, coupling));
                    }
                }
                let Some((_, coupling)) = nearest else { continue };
                let without = self.with_couplings(&chosen);
                let with = self.with_couplings(&[&chosen[..], &[coupling]].concat());
                let before = errors_left_out(&without, &rows_of(&rows, &all, &without), settings)?;
                let after = errors_left_out(&with, &rows_of(&rows, &all, &with), settings)?;
                let gains: Vec<f64> = (before.iter().zip(&after))
                    .map(|(before, after)| {
                        let of_joint = |joint: usize| 0.5 * (before[joint] / after[joint]).ln();
                        0.5 * coupling.joints().map(of_joint).iter().sum::<f64>()
                    })
                    .collect();
                let mean = gains.iter().sum::<f64>() / FOLDS as f64;
                let scatter: f64 = gains.iter().map(|g| (g - mean).powi(2)).sum();
                let error = (scatter / (FOLDS * (FOLDS - 1)) as f64).sqrt();
                let gain = 1.0 - (-mean).exp();
                let clear = gain > LEAST_GAIN && mean > LEAST_GAIN_IN_ERRORS * error;
                if clear && best.is_none_or(|best| gain > best.gain) {
                    best = Some(CouplingFound { coupling, gain });
                }
            }
            match best {
                Some(next) => found.push(next),
                None => return Ok(found),
            }
        }
    }

    /// Columns of the shared transmissions of a joint, not filtered, with the indices of their terms.
    pub(crate) fn shared_columns(&self, joint: usize, motion: &Motion) -> Vec<(usize, Vec<f64>)> {
        let mut formed: Vec<(Coupling, Vec<[Vec<f64>; 2]>)> = Vec::new();
        let mut columns = Vec::new();
        for &k in &self.by_joint[joint] {
            let Term::Shared { coupling, coefficient } = self.terms[k] else { continue };
            let index = formed.iter().position(|(of, _)| *of == coupling).unwrap_or_else(|| {
                let joints = coupling.joints();
                let kinds = joints.map(|j| self.arm().joints[j].kind);
                let pair = pair_columns(SHARED, &[coupling.ratio], joints, kinds, motion);
                formed.push((coupling, pair));
                formed.len() - 1
            });
            columns.push((k, formed[index].1[coefficient][joint - coupling.first].clone()));
        }
        columns
    }

    /// The shared transmissions within a vector of all terms.
    pub(crate) fn couplings_of(&self, values: &[f64], joint_names: &[&str]) -> Vec<EffectOnJoint> {
        let mut list: Vec<(Coupling, Vec<f64>)> = Vec::new();
        for (term, &value) in self.terms.iter().zip(values) {
            let Term::Shared { coupling, .. } = *term else { continue };
            match list.iter_mut().find(|(of, _)| *of == coupling) {
                Some((_, coefficients)) => coefficients.push(value),
                None => list.push((coupling, vec![value])),
            }
        }
        list.into_iter()
            .map(|(coupling, coefficients)| {
                let [a, b] = coupling.joints().map(|joint| joint_names[joint]);
                let parameters = SHARED.parameters(&[coupling.ratio], &coefficients);
                EffectOnJoint {
                    other_joint: Some(b.to_owned()),
                    ..EffectOnJoint::new(SHARED.law().slug, a, parameters)
                }
            })
            .collect()
    }
}

/// Columns of an effect of two joints on both of them, not filtered.
pub(crate) fn pair_columns(
    effect: &dyn Effect,
    shape: &[f64],
    joints: [usize; 2],
    kinds: [JointKind; 2],
    motion: &Motion,
) -> Vec<[Vec<f64>; 2]> {
    // the direction is that of the common shaft, which the law forms itself
    let none = vec![0.0; motion.len()];
    let [a, b] = [0, 1].map(|side| joint_motion(kinds[side], joints[side], motion, &none));
    effect.pair_columns(shape, &a, &b)
}

/// Of rows with the columns of many candidates, those of a problem with some of them.
fn rows_of(rows: &JointRows, all: &BatchProblem<'_>, wanted: &BatchProblem<'_>) -> JointRows {
    let places: Vec<Vec<usize>> = (wanted.by_joint.iter().zip(&all.by_joint))
        .map(|(wanted_terms, all_terms)| {
            let place = |&k: &usize| {
                let term = wanted.terms[k];
                all_terms.iter().position(|&of_all| all.terms[of_all] == term)
            };
            wanted_terms.iter().filter_map(place).collect()
        })
        .collect();
    JointRows {
        triangles: (rows.triangles.iter().zip(&places))
            .map(|(triangle, places)| triangle.with_unknowns(places))
            .collect(),
        blocks: (rows.blocks.iter().zip(&places))
            .map(|(blocks, places)| blocks.iter().map(|b| b.with_unknowns(places)).collect())
            .collect(),
        ..rows.clone_without_rows()
    }
}

/// Mean logarithm of the errors of both joints of a coupling.
fn error_of_both(
    problem: &BatchProblem<'_>,
    rows: &JointRows,
    coupling: Coupling,
    beliefs: &Beliefs,
) -> Result<f64, NumericError> {
    let noise: Vec<f64> = (0..problem.by_joint.len())
        .map(|joint| noise_alone(rows, joint))
        .collect::<Result<_, _>>()?;
    let values = problem.weighted(rows, &noise, beliefs)?.answer.solution;
    let fits = problem.fit(rows, &values);
    Ok(coupling.joints().map(|joint| fits[joint].rmse.ln()).iter().sum::<f64>())
}

/// Root mean square of what the columns of a joint alone leave of its effort.
fn noise_alone(rows: &JointRows, joint: usize) -> Result<f64, NumericError> {
    let left = rows.triangles[joint].solve(RANK_CUT)?.residual_sum_of_squares;
    let floor = f64::EPSILON * rows.effort[joint].2.sqrt() + f64::MIN_POSITIVE;
    Ok((left / rows.effort[joint].0 as f64).sqrt().max(floor))
}

/// Squared error of every joint on each stretch of time, fitted to the others.
fn errors_left_out(
    problem: &BatchProblem<'_>,
    rows: &JointRows,
    settings: &BatchSettings,
) -> Result<Vec<Vec<f64>>, NumericError> {
    let beliefs = problem.beliefs(settings)?;
    let joints = 0..problem.by_joint.len();
    let noise: Vec<f64> =
        joints.clone().map(|joint| noise_alone(rows, joint)).collect::<Result<_, _>>()?;
    let blocks = rows.blocks.iter().map(Vec::len).min().unwrap_or(0);
    (0..FOLDS)
        .map(|fold| {
            let left_out = |b: usize| b * FOLDS / blocks == fold;
            let merged = |joint: usize, wanted: &dyn Fn(usize) -> bool| {
                let of_joint = &rows.blocks[joint];
                let mut sum = armident_numeric::AccumulatedQr::new(of_joint[0].unknowns());
                for (b, block) in of_joint.iter().enumerate().filter(|(b, _)| wanted(*b)) {
                    debug_assert!(b < blocks);
                    sum.merge(block);
                }
                sum
            };
            let fitted = JointRows {
                triangles: joints.clone().map(|j| merged(j, &|b| !left_out(b))).collect(),
                ..rows.clone_without_rows()
            };
            let values = problem.weighted(&fitted, &noise, &beliefs)?.answer.solution;
            Ok(joints
                .clone()
                .map(|joint| {
                    let x: Vec<f64> = problem.by_joint[joint].iter().map(|&k| values[k]).collect();
                    merged(joint, &left_out).residual_sum_of_squares(&x).max(f64::MIN_POSITIVE)
                })
                .collect())
        })
        .collect()
}
