//! From motions to rows: the columns of every joint, reduced to triangles.

use std::ops::Range;

use armident_dynamics::ArmMotion;
use armident_effects::{EVERYDAY, Effect, Place, ReversalModel};
use armident_model::effect_columns;
use armident_motion::Motion;
use armident_numeric::AccumulatedQr;
use rayon::prelude::*;

use crate::batch::{BatchProblem, LAWS, Term};

/// Periods of the cut-off frequency left out at both ends of a recording, of the fit and of its
/// errors alike: the filter does not know what came before, so accelerations are wrong there. The
/// slowest pole of the 4th-order low-pass decays with 0.42 periods: 3 % are left after 1.5.
pub(crate) const EDGE_PERIODS: f64 = 1.5;
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
    /// per joint, stretches of time one after the other that make up its triangle
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
}

impl RowsOfJoint {
    fn new(width: usize) -> Self {
        Self { triangle: AccumulatedQr::new(width), effort: (0, 0.0, 0.0), blocks: Vec::new() }
    }

    /// Adds stretches of samples, block by block.
    fn add(
        &mut self,
        columns: &[Vec<f64>],
        y: &[f64],
        blocks: impl IntoIterator<Item = Range<usize>>,
    ) {
        for block in blocks {
            let part: Vec<&[f64]> = columns.iter().map(|c| &c[block.clone()]).collect();
            let mut triangle = AccumulatedQr::new(columns.len());
            triangle.push_columns(&part, &y[block]);
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

/// Samples of a motion that fits use: without its ends, which the filter spoils.
pub fn used_samples(motion: &Motion) -> Range<usize> {
    kept(motion)
}

/// Samples that a fit uses: without the ends, which the filter spoils.
pub(crate) fn kept(motion: &Motion) -> Range<usize> {
    let edge = match &motion.filter {
        Some(filter) => {
            let edge = (EDGE_PERIODS * motion.rate_hz / filter.cutoff_hz()).ceil() as usize;
            edge.min(motion.len() / 4)
        }
        None => 0,
    };
    edge..motion.len() - edge
}

/// Ranges of samples of one motion that standard errors take for independent, `total_s` being the length
/// of all motions.
fn blocks_of(motion: &Motion, total_s: f64) -> Vec<Range<usize>> {
    let kept = kept(motion);
    let length_s = kept.len() as f64 / motion.rate_hz;
    let most = motion
        .filter
        .as_ref()
        .map_or(f64::INFINITY, |filter| length_s * filter.cutoff_hz() / SHORTEST_BLOCK_PERIODS);
    let count = (BLOCKS * length_s / total_s).round().min(most).max(1.0) as usize;
    (0..count)
        .map(|b| kept.start + b * kept.len() / count..kept.start + (b + 1) * kept.len() / count)
        .collect()
}

impl BatchProblem<'_> {
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
            rows.add(&columns, effort, [part.clone()]);
            rows.count(&effort[part.clone()]);
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
        let total_s: f64 = motions.iter().map(|m| kept(m).len() as f64 / m.rate_hz).sum();
        let (mut independent, mut samples) = (0.0, 0.0);
        for motion in motions {
            let count = kept(motion).len() as f64;
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

    /// Columns of one joint over a motion, through its filter, in the order of
    /// [`Self::terms_of_joint`].
    pub(crate) fn columns(&self, joint: usize, motion: &Motion) -> Vec<Vec<f64>> {
        let jumping = self.jumping_columns(joint, motion);
        self.columns_beside(joint, motion, &self.arm_motion(motion), &jumping)
    }

    /// What all joints need of motions.
    pub(crate) fn arm_motions<'m>(&self, motions: &[&'m Motion]) -> Vec<ArmMotion<'m>> {
        motions.par_iter().map(|motion| self.arm_motion(motion)).collect()
    }

    fn arm_motion<'m>(&self, motion: &'m Motion) -> ArmMotion<'m> {
        ArmMotion::new(self.arm(), &motion.position, &motion.velocity, &motion.acceleration)
    }

    /// [`Self::columns`] where what all joints need, and what jumps, is formed already.
    pub(crate) fn columns_beside(
        &self,
        joint: usize,
        motion: &Motion,
        moved: &ArmMotion<'_>,
        jumping: &[TermColumn],
    ) -> Vec<Vec<f64>> {
        let (mut terms, wanted) = self.constants_of(joint);
        let constants = self.set().columns();
        let mut columns = constants.of_arm_motion(self.arm(), joint, moved, &wanted);
        for (k, column) in self.smooth_columns(joint, motion) {
            terms.push(k);
            columns.push(column);
        }
        motion.filter_columns(&mut columns);
        let mut all: Vec<TermColumn> = terms.into_iter().zip(columns).collect();
        all.extend(jumping.iter().cloned());
        // the order of the terms of a joint is that of all terms
        all.sort_by_key(|(k, _)| *k);
        all.into_iter().map(|(_, column)| column).collect()
    }

    /// Effort of one joint over a motion as values explain it, through the filter: all that is smooth
    /// goes through it as one column.
    pub(crate) fn explained(
        &self,
        joint: usize,
        motion: &Motion,
        moved: &ArmMotion<'_>,
        jumping: &[TermColumn],
        values: &[f64],
    ) -> Vec<f64> {
        let (terms, wanted) = self.constants_of(joint);
        let factors: Vec<f64> = terms.iter().map(|&k| values[k]).collect();
        let rigid = self.set().columns().combined(&wanted, &factors);
        let mut explained = rigid.of_arm_motion(self.arm(), joint, moved, &[0]);
        let add = |k: usize, column: &[f64], to: &mut [Vec<f64>]| {
            to[0].iter_mut().zip(column).for_each(|(sum, x)| *sum += values[k] * x);
        };
        for (k, column) in self.smooth_columns(joint, motion) {
            add(k, &column, &mut explained);
        }
        motion.filter_columns(&mut explained);
        for (k, column) in jumping {
            add(*k, column, &mut explained);
        }
        explained.swap_remove(0)
    }

    /// The terms of a joint that are constants, and which ones.
    fn constants_of(&self, joint: usize) -> (Vec<usize>, Vec<usize>) {
        self.by_joint[joint]
            .iter()
            .filter_map(|&k| match self.terms[k] {
                Term::Constant(c) => Some((k, c)),
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => None,
            })
            .unzip()
    }

    /// Columns of effects and shared transmissions that do not jump and of loads, not filtered.
    fn smooth_columns(&self, joint: usize, motion: &Motion) -> Vec<TermColumn> {
        let mut columns = self.effect_columns_where(joint, motion, |law| !jumps(law));
        for coupling in self.couplings_on(joint) {
            columns.extend(self.shared_columns(joint, coupling, motion, false));
        }
        columns.extend(self.load_columns(joint, motion));
        columns
    }

    /// Columns of what follows the sign of a speed, formed from all samples (it jumps between two of them)
    /// and brought through the filter to those of the motion.
    pub(crate) fn jumping_columns(&self, joint: usize, motion: &Motion) -> Vec<TermColumn> {
        let fine = motion.fine();
        let mut done: Vec<TermColumn> = Vec::new();
        let mut waiting = self.effect_columns_where(joint, fine, jumps);
        let mut filter = |waiting: &mut Vec<TermColumn>| {
            let (terms, columns): (Vec<usize>, Vec<_>) = waiting.drain(..).unzip();
            done.extend(terms.into_iter().zip(motion.filtered_fine(columns)));
        };
        for coupling in self.couplings_on(joint) {
            // a few at a time: these columns have all samples
            if waiting.len() >= 4 {
                filter(&mut waiting);
            }
            waiting.extend(self.shared_columns(joint, coupling, fine, true));
        }
        filter(&mut waiting);
        done
    }

    /// Columns of the effects of the library that are wanted, not filtered.
    fn effect_columns_where(
        &self,
        joint: usize,
        motion: &Motion,
        wanted: impl Fn(&dyn Effect) -> bool,
    ) -> Vec<TermColumn> {
        let turn = self.turn(joint);
        let kind = self.arm().joints[joint].kind;
        let mut of_effect: Vec<Option<Vec<Vec<f64>>>> = vec![None; LAWS.len()];
        let mut columns = Vec::new();
        for &k in &self.by_joint[joint] {
            let Term::Effect { effect, parameter, .. } = self.terms[k] else { continue };
            let law = LAWS[effect];
            if wanted(law) {
                let formed = of_effect[effect]
                    .get_or_insert_with(|| effect_columns(law, &[], kind, joint, motion, turn));
                columns.push((k, formed[parameter].clone()));
            }
        }
        columns
    }

    fn turn(&self, joint: usize) -> Option<ReversalModel> {
        self.turns.as_ref().map(|turns| turns[joint])
    }

    /// Columns of dry friction of a joint that turns in other ways, as [`Self::columns`] has it.
    pub(crate) fn direction_columns(
        &self,
        joint: usize,
        motion: &Motion,
        turns: &[ReversalModel],
    ) -> Vec<Vec<f64>> {
        let kind = self.arm().joints[joint].kind;
        let Some(law) = EVERYDAY.iter().find(|law| jumps(**law)) else { return Vec::new() };
        let formed = turns
            .iter()
            .filter_map(|&turn| {
                effect_columns(*law, &[], kind, joint, motion.fine(), Some(turn)).pop()
            })
            .collect();
        motion.filtered_fine(formed)
    }
}

/// A column, and the term it belongs to.
pub(crate) type TermColumn = (usize, Vec<f64>);

/// Whether a law follows the sign of a speed.
fn jumps(law: &dyn Effect) -> bool {
    law.law().roles.contains(&Place::Dry)
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
        let (columns, y) = form(index, joint, effort);
        rows.add(&columns, &y, blocks_of(motion, total_s));
        // the effort itself, whatever was made of it
        rows.count(&effort[kept(motion)]);
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
