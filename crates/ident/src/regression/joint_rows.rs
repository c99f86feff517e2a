//! From motions to rows: the columns of every joint, reduced to triangles.
//!
//! Method: the rows of one joint of one recording become one triangle by QR, merged over recordings in any order, so that
//! weighting joints by their noise needs no second pass over the samples. Triangles of blocks of time are kept beside
//! for standard errors and cross-validation.
//!
//! References: own; sequential QR as in G. H. Golub, C. F. Van Loan, Matrix Computations.

use std::ops::Range;

use armident_motion::{Motion, Observations};
use armident_numeric::AccumulatedQr;
use rayon::prelude::*;

use super::problem::BatchProblem;
use crate::used_samples::used_samples;

/// Blocks that all recordings together are cut into, for standard errors: enough for a Student quantile
/// near the normal one, few enough that each outlasts the memory of the residuals.
const BLOCKS: f64 = 20.0;
/// Shortest block, in periods of the cut-off.
const SHORTEST_BLOCK_PERIODS: f64 = 2.0;

/// Rows of a set of recordings, one triangle per joint.
#[derive(Debug, Clone)]
pub struct JointRows {
    /// per joint, over the terms of [`BatchProblem::terms_of_joint`]
    pub(crate) triangles: Vec<AccumulatedQr>,
    /// per joint: number, sum and sum of squares of the filtered effort
    pub(crate) effort: Vec<(usize, f64, f64)>,
    /// independent samples over samples, weighted by samples
    pub(crate) share: f64,
    /// per joint, consecutive blocks of time that make up its triangle
    pub(crate) blocks: Vec<Vec<AccumulatedQr>>,
}

/// Rows of one joint of all recordings.
#[derive(Clone)]
struct RowsOfJoint {
    triangle: AccumulatedQr,
    effort: (usize, f64, f64),
    blocks: Vec<AccumulatedQr>,
}

impl JointRows {
    /// Adds the rows of other samples, of the same problem. The order does not matter, and neither does how
    /// samples were dealt out: orthogonal sums.
    pub fn merge(&mut self, other: &Self) {
        let count = |rows: &Self| rows.effort.iter().map(|e| e.0).sum::<usize>() as f64;
        let (own, others) = (count(self), count(other));
        if own + others > 0.0 {
            self.share = (own * self.share + others * other.share) / (own + others);
        }
        for (triangle, other) in self.triangles.iter_mut().zip(&other.triangles) {
            triangle.merge(other);
        }
        for (sums, other) in self.effort.iter_mut().zip(&other.effort) {
            *sums = (sums.0 + other.0, sums.1 + other.1, sums.2 + other.2);
        }
        for (blocks, other) in self.blocks.iter_mut().zip(&other.blocks) {
            blocks.extend(other.iter().cloned());
        }
    }

    /// Counts and shares without triangles.
    pub(crate) fn clone_without_rows(&self) -> Self {
        Self { triangles: Vec::new(), blocks: Vec::new(), effort: self.effort.clone(), ..*self }
    }

    /// The same rows with some of the columns of each joint, in the order given.
    pub(crate) fn with_places(&self, places: &[Vec<usize>]) -> Self {
        let joints = 0..places.len();
        let triangle = |joint: usize| self.triangles[joint].with_unknowns(&places[joint]);
        let blocks = |joint: usize| {
            self.blocks[joint].iter().map(|b| b.with_unknowns(&places[joint])).collect()
        };
        Self {
            triangles: joints.clone().map(triangle).collect(),
            blocks: joints.map(blocks).collect(),
            ..self.clone_without_rows()
        }
    }

    /// Of rows with the columns of problem `all`, those of problem `wanted`, whose terms are among them.
    pub(crate) fn select(&self, all: &BatchProblem, wanted: &BatchProblem) -> Self {
        let joints = 0..wanted.by_joint.len();
        let places: Vec<Vec<usize>> = joints.map(|joint| places_of(all, wanted, joint)).collect();
        self.with_places(&places)
    }

    /// The triangle of one joint with the columns of problem `wanted`.
    pub(crate) fn select_joint(
        &self,
        all: &BatchProblem,
        wanted: &BatchProblem,
        joint: usize,
    ) -> AccumulatedQr {
        self.triangles[joint].with_unknowns(&places_of(all, wanted, joint))
    }
}

impl RowsOfJoint {
    fn new(width: usize) -> Self {
        Self { triangle: AccumulatedQr::new(width), effort: (0, 0.0, 0.0), blocks: Vec::new() }
    }

    /// Adds samples block by block; a rest in a block is one row.
    fn add(
        &mut self,
        columns: &[Vec<f64>],
        y: &[f64],
        effort: &[f64],
        blocks: impl IntoIterator<Item = Observations>,
    ) {
        for block in blocks {
            let mut triangle = AccumulatedQr::new(columns.len());
            if let Some(samples) = block.without_rest() {
                let part: Vec<&[f64]> = columns.iter().map(|c| &c[samples.clone()]).collect();
                triangle.push_columns(&part, &y[samples.clone()]);
                self.count(&effort[samples]);
            } else {
                let part: Vec<Vec<f64>> = columns.iter().map(|c| block.of(c)).collect();
                triangle.push_columns(&part, &block.of(y));
                self.count(&block.of(effort));
            }
            self.triangle.merge(&triangle);
            self.blocks.push(triangle);
        }
    }

    /// Counts efforts.
    fn count(&mut self, effort: &[f64]) {
        self.effort.0 += effort.len();
        self.effort.1 += effort.iter().sum::<f64>();
        self.effort.2 += effort.iter().map(|e| e * e).sum::<f64>();
    }
}

/// Length of the samples of a motion that fits use \[s\].
pub(crate) fn used_s(motion: &Motion) -> f64 {
    used_samples(motion).len() as f64 / motion.rate_hz
}

/// Ranges of samples of one motion that standard errors take for independent, `total_s` being the length
/// of all motions.
pub(crate) fn blocks_of(motion: &Motion, total_s: f64) -> Vec<Range<usize>> {
    let used = used_samples(motion);
    let length_s = used_s(motion);
    let most = motion
        .filter
        .as_ref()
        .map_or(f64::INFINITY, |filter| length_s * filter.cutoff_hz() / SHORTEST_BLOCK_PERIODS);
    let count = (BLOCKS * length_s / total_s).round().min(most).max(1.0) as usize;
    (0..count)
        .map(|b| used.start + b * used.len() / count..used.start + (b + 1) * used.len() / count)
        .collect()
}

impl BatchProblem {
    /// Reduces recordings to one triangle per joint. Memory: the columns of one joint of one
    /// recording at a time on each thread.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn accumulate(&self, motions: &[&Motion]) -> JointRows {
        let moved = self.arm_motions(motions);
        self.accumulate_with(
            motions,
            |index, joint, effort| {
                let jumping = self.jumping_columns(joint, motions[index]);
                let columns = self.columns_beside(joint, motions[index], &moved[index], &jumping);
                (columns, effort.to_vec())
            },
            |joint| self.by_joint[joint].len(),
        )
    }

    /// Rows of some of the samples of one motion, filtered as a whole: [merged](JointRows::merge) over all
    /// parts of [`used_samples`] they are those of the motion.
    ///
    /// # Panics
    /// When the motion has no effort or other joints than the arm, or fewer samples.
    pub fn accumulate_part(&self, motion: &Motion, part: Range<usize>) -> JointRows {
        let moved = self.arm_motion(motion);
        let of_joint = |joint: usize| {
            let jumping = self.jumping_columns(joint, motion);
            let columns = self.columns_beside(joint, motion, &moved, &jumping);
            let effort = effort_of(motion, joint);
            let mut rows = RowsOfJoint::new(columns.len());
            rows.add(&columns, effort, effort, [motion.observations(joint, part.clone())]);
            rows
        };
        let of_joints = (0..self.by_joint.len()).into_par_iter().map(of_joint).collect();
        rows_of_joints(of_joints, motion.independent_share())
    }

    /// The same with columns and right-hand sides as `form(motion index, joint, effort)` gives them,
    /// `width(joint)` columns.
    pub(crate) fn accumulate_with(
        &self,
        motions: &[&Motion],
        form: impl Fn(usize, usize, &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) + Sync,
        width: impl Fn(usize) -> usize + Sync,
    ) -> JointRows {
        let n = self.by_joint.len();
        let total_s: f64 = motions.iter().map(|m| used_s(m)).sum();
        let (mut independent, mut samples) = (0.0, 0.0);
        for motion in motions {
            let count = used_samples(motion).len() as f64;
            independent += motion.independent_share() * count;
            samples += count;
        }
        // each joint is summed in the order of its recordings, so that the result does not depend on who
        // was first
        let of_joints: Vec<RowsOfJoint> = (0..n)
            .into_par_iter()
            .map(|joint| rows_of_joint(joint, width(joint), motions, total_s, &form))
            .collect();
        rows_of_joints(of_joints, if samples > 0.0 { independent / samples } else { 1.0 })
    }
}

fn rows_of_joint(
    joint: usize,
    width: usize,
    motions: &[&Motion],
    total_s: f64,
    form: &(impl Fn(usize, usize, &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) + Sync),
) -> RowsOfJoint {
    let mut rows = RowsOfJoint::new(width);
    for (index, motion) in motions.iter().enumerate() {
        let effort = effort_of(motion, joint);
        let (mut columns, mut y) = form(index, joint, effort);
        // rows of zeros mean nothing
        for unmeasured in motion.unmeasured() {
            for column in columns.iter_mut().chain([&mut y]) {
                column[unmeasured.clone()].fill(0.0);
            }
        }
        let blocks = blocks_of(motion, total_s).into_iter();
        // counted is the effort itself, whatever was made of it
        rows.add(&columns, &y, effort, blocks.map(|block| motion.observations(joint, block)));
    }
    rows
}

#[expect(clippy::expect_used, reason = "documented panic: checked by the callers")]
fn effort_of(motion: &Motion, joint: usize) -> &[f64] {
    &motion.effort_filtered.as_ref().expect("a motion with efforts")[joint]
}

fn rows_of_joints(of_joints: Vec<RowsOfJoint>, share: f64) -> JointRows {
    let mut rows =
        JointRows { triangles: Vec::new(), effort: Vec::new(), share, blocks: Vec::new() };
    for of_joint in of_joints {
        rows.triangles.push(of_joint.triangle);
        rows.effort.push(of_joint.effort);
        rows.blocks.push(of_joint.blocks);
    }
    rows
}

/// Columns of a joint in rows with the columns of many candidates, that a problem with some of them has.
fn places_of(all: &BatchProblem, wanted: &BatchProblem, joint: usize) -> Vec<usize> {
    let place = |&k: &usize| {
        let term = wanted.terms[k];
        all.by_joint[joint].iter().position(|&of_all| all.terms[of_all] == term)
    };
    wanted.by_joint[joint].iter().filter_map(place).collect()
}
