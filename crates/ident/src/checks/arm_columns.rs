//! Products of the columns of the whole arm, for every joint as any recorded joint and for any gravity.
//!
//! ```text
//! effort_s = Y_j(q; g) x + φ_s p + noise,   Y_j(q; g) = Y_j(q; 0) + Σ g_k G_jk(q)
//! ```
//!
//! Joint `j` of the arm is recorded as joint `s`, with its sign. Friction belongs to what is recorded, so only the columns of
//! the constants are formed again where joints are exchanged or mirrored; gravity enters linearly, so any direction
//! of it is a combination of columns that are formed once. All are kept as products over blocks of time.

use std::sync::Arc;

use armident_dynamics::{ArmMotion, RigidArm};
use armident_inference::correlation_time;
use armident_kinematics::JointKind;
use armident_motion::{Motion, MotionSettings, RESTING_RANGE};
use armident_numeric::{Cholesky, Mat, dot, gram_of_columns, range};
use armident_recording::Recording;
use nalgebra::Vector3;
use rayon::prelude::*;

use super::rows::{SAMPLES_PER_CUTOFF, edge};
use crate::regression::{BatchProblem, Term};

/// Blocks of time for the jackknife of an estimate, at most: its quantiles hardly change with more.
const MOST_BLOCKS: usize = 20;
/// ... and at least so many independent samples of the motion in each.
const INDEPENDENT_PER_BLOCK: f64 = 2.0;
/// Fewest blocks of all recordings: with less, quantiles of a covariance of two components are wide.
const FEWEST_BLOCKS: usize = 10;
/// Ridge of friction columns that are collinear, relative to their size.
pub(super) const RIDGE: f64 = 1e-9;

/// Which recorded joint each joint of the arm is, with which sign, and which effort column is its.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct JointMap {
    /// joint of the arm -> joint of the recordings
    pub(super) source: Vec<usize>,
    /// 1, or -1 where positions and efforts count the other way
    pub(super) sign: Vec<f64>,
    /// joint of the arm -> joint of the recordings whose effort column holds its effort
    pub(super) effort: Vec<usize>,
}

impl JointMap {
    pub(super) fn as_labelled(joints: usize) -> Self {
        let source: Vec<usize> = (0..joints).collect();
        Self { effort: source.clone(), sign: vec![1.0; joints], source }
    }

    /// Whether every joint is the one that it is called, whatever its effort column is.
    pub(super) fn joints_are_as_labelled(&self) -> bool {
        self.source.iter().enumerate().all(|(j, s)| j == *s) && self.sign.iter().all(|s| *s > 0.0)
    }

    pub(super) fn is_as_labelled(&self) -> bool {
        *self == Self::as_labelled(self.source.len())
    }

    /// Columns of the recordings as those of the joints of the arm.
    pub(super) fn of_arm(&self, recorded: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |(&s, &sign): (&usize, &f64)| recorded[s].iter().map(|x| sign * x).collect();
        self.source.iter().zip(&self.sign).map(of).collect()
    }

    /// The motion of the joints of the arm, each with the effort that is recorded beside its position.
    pub(super) fn motion(&self, motion: &Motion) -> Motion {
        let mut moved = motion.clone().without_fine();
        moved.position = self.of_arm(&motion.position);
        moved.velocity = self.of_arm(&motion.velocity);
        moved.acceleration = self.of_arm(&motion.acceleration);
        moved.effort = motion.effort.as_ref().map(|e| self.of_arm(e));
        moved.effort_filtered = motion.effort_filtered.as_ref().map(|e| self.of_arm(e));
        moved
    }

    /// Motions of recordings with another cut-off \[Hz\]; none where it is not possible for a recording.
    pub(super) fn motions_with_cutoff(
        &self,
        cutoff_hz: f64,
        recordings: &[Recording],
        names: &[String],
    ) -> Option<Vec<Motion>> {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let settings = MotionSettings { cutoff_hz: Some(cutoff_hz), ..MotionSettings::default() };
        let below = |r| Some(self.motion(&Motion::from_recording(r, &names, &settings).ok()?));
        recordings.iter().map(below).collect()
    }
}

/// What one recording holds whatever its joints are.
struct Recorded {
    /// at 16 times the cut-off
    motion: Motion,
    /// samples left out at both ends, and of the others all but every so many
    edge: usize,
    stride: usize,
    /// per recorded joint, the kept rows of its friction, its own spring, and its effort
    friction: Vec<Vec<Vec<f64>>>,
    spring: Vec<Vec<Vec<f64>>>,
    effort: Vec<Vec<f64>>,
    /// first rows of the blocks, and the end
    blocks: Vec<usize>,
}

impl Recorded {
    fn keep(&self, column: &[f64]) -> Vec<f64> {
        let end = column.len() - self.edge;
        column[self.edge..end].iter().step_by(self.stride).copied().collect()
    }
}

/// Columns of the arm that do not depend on how joints are recorded, and what forms the others.
pub(super) struct ArmColumns<'p> {
    problem: &'p BatchProblem,
    /// without gravity, and with one unit of it along each axis of `E_0`
    still: RigidArm,
    pulled: [RigidArm; 3],
    recorded: Vec<Recorded>,
    /// per joint, its constants, and the places among them of those that gravity pulls at
    constants: Vec<Vec<usize>>,
    heavy: Vec<Vec<usize>>,
    /// per recorded joint
    pub(super) samples: Vec<f64>,
    /// independent samples of the residual of friction: the motion's, not those of noise
    pub(super) independent: Vec<f64>,
    /// whether it moves
    pub(super) moves: Vec<bool>,
}

/// Products of the columns of one joint of the arm: friction, spring, constants without gravity, the heavy ones per unit of
/// gravity along each axis, and the efforts of all recorded joints.
#[derive(Clone)]
pub(super) struct JointProducts {
    /// per block of time
    pub(super) blocks: Arc<Vec<Mat<f64>>>,
    /// rows of each block
    rows: Vec<usize>,
    pub(super) friction: usize,
    pub(super) spring: usize,
    pub(super) constants: Vec<usize>,
    heavy: Vec<usize>,
    /// the joint of the recordings whose column holds the effort
    pub(super) effort: usize,
    joints: usize,
}

impl<'p> ArmColumns<'p> {
    /// `problem` is that of an arm whose gravity has no special direction.
    pub(super) fn of(problem: &'p BatchProblem, motions: &[Motion]) -> Self {
        let arm = problem.arm();
        let n = arm.dof();
        let mut still = arm.clone();
        still.gravity_e0 = Vector3::zeros();
        let pulled = [Vector3::x(), Vector3::y(), Vector3::z()].map(|along| {
            let mut pulled = arm.clone();
            pulled.gravity_e0 = along;
            pulled
        });
        let set = problem.set();
        let constants: Vec<Vec<usize>> = (0..n)
            .map(|j| (0..set.len()).filter(|&c| set.constants[c].joint >= j).collect())
            .collect();
        let heavy = constants
            .iter()
            .map(|of| (0..of.len()).filter(|&k| set.constants[of[k]].unit() != "kg m2").collect())
            .collect();
        let mut recorded: Vec<Recorded> =
            motions.iter().map(|motion| recorded_of(problem, motion)).collect();
        let mut samples = vec![0.0; n];
        let mut independent = vec![1.0; n];
        let mut moves = vec![false; n];
        for s in 0..n {
            samples[s] = recorded.iter().map(|r| r.effort[s].len() as f64).sum();
            let left = beyond_friction(&recorded, s);
            independent[s] = (samples[s] / correlation_time(&left)).max(1.0);
            moves[s] = motions.iter().any(|m| range(&m.position[s]) >= RESTING_RANGE);
        }
        let least = (0..n).filter(|&s| moves[s]).map(|s| independent[s]).fold(f64::MAX, f64::min);
        let count = ((least / INDEPENDENT_PER_BLOCK) as usize).clamp(FEWEST_BLOCKS, MOST_BLOCKS);
        let all: usize = recorded.iter().map(|r| r.effort[0].len()).sum();
        for of in &mut recorded {
            let rows = of.effort[0].len();
            let own = (count * rows).div_ceil(all.max(1)).max(1);
            of.blocks = (0..=own).map(|b| b * rows / own).collect();
        }
        Self { problem, still, pulled, recorded, constants, heavy, samples, independent, moves }
    }

    pub(super) fn joints(&self) -> usize {
        self.constants.len()
    }

    /// Blocks of each recording.
    pub(super) fn blocks_by_recording(&self) -> Vec<usize> {
        self.recorded.iter().map(|r| r.blocks.len() - 1).collect()
    }

    /// The products where joints are recorded like this.
    pub(super) fn products(&self, map: &JointMap) -> Vec<JointProducts> {
        let n = self.joints();
        let columns = self.problem.set().columns();
        let zero: Vec<Vec<Vec<f64>>> =
            self.recorded.iter().map(|r| vec![vec![0.0; r.motion.len()]; n]).collect();
        let moved: Vec<[Vec<Vec<f64>>; 3]> = (self.recorded.iter())
            .map(|r| {
                let m = &r.motion;
                [&m.position, &m.velocity, &m.acceleration].map(|of| map.of_arm(of))
            })
            .collect();
        let moving: Vec<ArmMotion<'_>> =
            moved.iter().map(|[q, dq, ddq]| ArmMotion::new(q, dq, ddq)).collect();
        let resting: Vec<ArmMotion<'_>> = (moved.iter().zip(&zero))
            .map(|([q, ..], zero)| ArmMotion::new(q, zero, zero))
            .collect();
        (0..n)
            .into_par_iter()
            .map(|j| {
                let (source, sign) = (map.source[j], map.sign[j]);
                let (mut blocks, mut lengths) = (Vec::new(), Vec::new());
                for (k, of) in self.recorded.iter().enumerate() {
                    let mut formed =
                        columns.of_arm_motion(&self.still, j, &moving[k], &self.constants[j]);
                    let heavy: Vec<usize> =
                        self.heavy[j].iter().map(|&h| self.constants[j][h]).collect();
                    for pulled in &self.pulled {
                        formed.extend(columns.of_arm_motion(pulled, j, &resting[k], &heavy));
                    }
                    of.motion.filter_columns(&mut formed);
                    let mut rows: Vec<Vec<f64>> = of.friction[source].clone();
                    rows.extend(of.spring[source].iter().cloned());
                    rows.extend(formed.iter().map(|c| {
                        let mut kept = of.keep(c);
                        kept.iter_mut().for_each(|x| *x *= sign);
                        kept
                    }));
                    rows.extend(of.effort.iter().cloned());
                    for ends in of.blocks.windows(2) {
                        let block: Vec<&[f64]> =
                            rows.iter().map(|c| &c[ends[0]..ends[1]]).collect();
                        blocks.push(gram_of_columns(&block));
                        lengths.push(ends[1] - ends[0]);
                    }
                }
                JointProducts {
                    blocks: Arc::new(blocks),
                    rows: lengths,
                    friction: self.recorded[0].friction[source].len(),
                    spring: self.recorded[0].spring[source].len(),
                    constants: self.constants[j].clone(),
                    heavy: self.heavy[j].clone(),
                    effort: map.effort[j],
                    joints: n,
                }
            })
            .collect()
    }
}

impl JointProducts {
    /// The same where the efforts are in other columns.
    pub(super) fn with_effort(&self, effort: usize) -> Self {
        Self { effort, ..self.clone() }
    }

    /// Sum over the blocks that are wanted.
    pub(super) fn sum(&self, wanted: impl Fn(usize) -> bool) -> Mat<f64> {
        let size = self.blocks.first().map_or(0, Mat::nrows);
        let mut sum = Mat::zeros(size, size);
        for (_, block) in self.blocks.iter().enumerate().filter(|(b, _)| wanted(*b)) {
            sum += block;
        }
        sum
    }

    /// Share of the samples that these blocks hold.
    pub(super) fn share(&self, wanted: impl Fn(usize) -> bool) -> f64 {
        let all: usize = self.rows.iter().sum();
        let kept: usize =
            self.rows.iter().enumerate().filter(|(b, _)| wanted(*b)).map(|(_, rows)| rows).sum();
        kept as f64 / all.max(1) as f64
    }

    /// The products at one gravity in `E_0` \[m/s²\]: friction, with the spring or without, constants, then
    /// `extra` combinations of the heavy constants per unit of gravity along an axis, and the effort.
    pub(super) fn at_gravity(
        &self,
        sum: &Mat<f64>,
        gravity: &Vector3<f64>,
        with_spring: bool,
        extra: &[(Vector3<f64>, Vec<f64>)],
    ) -> Mat<f64> {
        let (f, s, z, h) = (self.friction, self.spring, self.constants.len(), self.heavy.len());
        let aside = f + if with_spring { s } else { 0 };
        let raw = sum.nrows();
        let width = aside + z + extra.len() + 1;
        let mut picks: Vec<Vec<(usize, f64)>> = (0..aside).map(|k| vec![(k, 1.0)]).collect();
        let place = |axis: usize, heavy: usize| f + s + z + axis * h + heavy;
        for k in 0..z {
            let mut pick = vec![(f + s + k, 1.0)];
            if let Some(heavy) = self.heavy.iter().position(|&at| at == k) {
                pick.extend((0..3).map(|axis| (place(axis, heavy), gravity[axis])));
            }
            picks.push(pick);
        }
        for (along, values) in extra {
            let of = self.heavy.iter().enumerate().flat_map(|(heavy, &k)| {
                let value = values[self.constants[k]];
                (0..3).map(move |axis| (place(axis, heavy), along[axis] * value))
            });
            picks.push(of.collect());
        }
        picks.push(vec![(raw - self.joints + self.effort, 1.0)]);
        // sum · C, then Cᵀ · that
        let mut half: Mat<f64> = Mat::zeros(raw, width);
        for (column, pick) in picks.iter().enumerate() {
            for &(from, factor) in pick {
                for row in 0..raw {
                    half[(row, column)] += factor * sum[(row, from)];
                }
            }
        }
        let mut product: Mat<f64> = Mat::zeros(width, width);
        for (row, pick) in picks.iter().enumerate() {
            for &(from, factor) in pick {
                for column in 0..width {
                    product[(row, column)] += factor * half[(from, column)];
                }
            }
        }
        product
    }
}

/// The remainder of products once their first columns are projected out of the others.
pub(super) fn beyond_first(product: &Mat<f64>, first: usize) -> Mat<f64> {
    let rest = product.nrows() - first;
    let size = |k: usize| product[(k, k)].max(f64::MIN_POSITIVE).sqrt();
    let entry = |i: usize, j: usize| {
        let scaled = product[(i, j)] / (size(i) * size(j));
        if i == j { 1.0 + RIDGE } else { scaled }
    };
    let Some(root) = Cholesky::of(first, entry) else {
        return Mat::from_fn(rest, rest, |i, j| product[(first + i, first + j)]);
    };
    let along: Vec<Vec<f64>> = (0..rest)
        .map(|j| {
            let column: Vec<f64> = (0..first).map(|i| product[(i, first + j)] / size(i)).collect();
            root.forward(&column)
        })
        .collect();
    Mat::from_fn(rest, rest, |i, j| product[(first + i, first + j)] - dot(&along[i], &along[j]))
}

fn recorded_of(problem: &BatchProblem, motion: &Motion) -> Recorded {
    let n = problem.arm().dof();
    let thinned = motion.clone().thinned();
    let moved = problem.arm_motion(&thinned);
    let stride = thinned.filter.as_ref().map_or(1.0, |filter| {
        (thinned.rate_hz / (SAMPLES_PER_CUTOFF * filter.cutoff_hz())).floor().max(1.0)
    });
    let mut of = Recorded {
        edge: edge(&thinned),
        stride: stride as usize,
        friction: Vec::new(),
        spring: Vec::new(),
        effort: Vec::new(),
        blocks: Vec::new(),
        motion: thinned.clone(),
    };
    for joint in 0..n {
        let jumping = problem.jumping_columns(joint, &thinned);
        let columns = problem.columns_beside(joint, &thinned, &moved, &jumping);
        let terms = problem.terms_of_joint(joint).iter();
        let is_friction = |k: &usize| !matches!(problem.terms[*k], Term::Constant(_));
        let friction = terms.zip(&columns).filter(|(k, _)| is_friction(k)).map(|(_, c)| of.keep(c));
        // with the rotor of a joint whose own inertia is the same column: another joint may be recorded there
        let mut friction: Vec<Vec<f64>> = friction.collect();
        let mut rotor = vec![thinned.acceleration[joint].clone()];
        thinned.filter_columns(&mut rotor);
        friction.push(of.keep(&rotor[0]));
        let mut spring = springs(problem.arm().joints[joint].kind, &thinned.position[joint]);
        thinned.filter_columns(&mut spring);
        of.friction.push(friction);
        of.spring.push(spring.iter().map(|c| of.keep(c)).collect());
        let effort = thinned.effort_filtered.as_ref().map(|e| of.keep(&e[joint]));
        of.effort.push(effort.unwrap_or_default());
    }
    of
}

/// What a spring or a counterbalance on the joint pulls like.
fn springs(kind: JointKind, position: &[f64]) -> Vec<Vec<f64>> {
    let of = |law: fn(f64) -> f64| position.iter().map(|q| law(*q)).collect::<Vec<f64>>();
    if kind.is_rotational() { vec![of(|q| q), of(f64::sin), of(f64::cos)] } else { vec![of(|q| q)] }
}

/// Per recording, the effort of a joint that its friction does not explain.
fn beyond_friction(recorded: &[Recorded], joint: usize) -> Vec<Vec<f64>> {
    let count = recorded[0].friction[joint].len();
    let mut product: Mat<f64> = Mat::zeros(count + 1, count + 1);
    for of in recorded {
        let mut columns: Vec<&[f64]> = of.friction[joint].iter().map(Vec::as_slice).collect();
        columns.push(&of.effort[joint]);
        product += gram_of_columns(&columns);
    }
    let size = |k: usize| product[(k, k)].max(f64::MIN_POSITIVE).sqrt();
    let scaled = |i: usize, j: usize| {
        if i == j { 1.0 + RIDGE } else { product[(i, j)] / (size(i) * size(j)) }
    };
    let solution = Cholesky::of(count, scaled).map_or(vec![0.0; count], |root| {
        let rhs: Vec<f64> = (0..count).map(|k| product[(k, count)] / size(k)).collect();
        root.solve(&rhs).iter().enumerate().map(|(k, x)| x / size(k)).collect()
    });
    recorded
        .iter()
        .map(|of| {
            let mut left = of.effort[joint].clone();
            for (column, x) in of.friction[joint].iter().zip(&solution) {
                left.iter_mut().zip(column).for_each(|(l, c)| *l -= x * c);
            }
            left
        })
        .collect()
}
