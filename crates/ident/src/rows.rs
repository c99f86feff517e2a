//! From motions to rows: the columns of every joint, reduced to triangles.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use armident_effects::{EVERYDAY, Effect, JointMotion, Place, directions_with};
use armident_kinematics::JointKind;
use armident_numeric::AccumulatedQr;
use armident_recording::Motion;

use crate::batch::{BatchProblem, Term};

/// Periods of the cut-off frequency left out at both ends of a recording, of the fit and of its
/// errors alike: the filter does not know what came before, so accelerations are wrong there. The
/// slowest pole of the 4th-order low-pass decays with 0.42 periods: 3 % are left after 1.5.
pub(crate) const EDGE_PERIODS: f64 = 1.5;
/// Share where nothing was fitted.
pub(crate) const DEFAULT_SPEED_RESOLUTION: f64 = 0.05;
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

/// Samples that a fit uses: without the ends, which the filter spoils.
pub(crate) fn kept(motion: &Motion) -> std::ops::Range<usize> {
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
fn blocks_of(motion: &Motion, total_s: f64) -> Vec<std::ops::Range<usize>> {
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
        self.accumulate_with(motions, |_, _, _, _| {}, |_, joint| self.by_joint[joint].len())
    }

    /// The same with columns as `prepare(motion index, joint, columns, effort)` leaves them, of which
    /// there are `width(joint)`.
    pub(crate) fn accumulate_with(
        &self,
        motions: &[&Motion],
        prepare: impl Fn(usize, usize, &mut Vec<Vec<f64>>, &mut Vec<f64>) + Sync,
        width: impl Fn(&Self, usize) -> usize,
    ) -> JointRows {
        let n = self.by_joint.len();
        let widths: Vec<usize> = (0..n).map(|joint| width(self, joint)).collect();
        let total_s: f64 = motions.iter().map(|m| kept(m).len() as f64 / m.rate_hz).sum();
        let (mut independent, mut samples) = (0.0, 0.0);
        for motion in motions {
            let count = kept(motion).len() as f64;
            independent += motion.independent_share() * count;
            samples += count;
        }
        // joints are dealt out to threads; each is summed in the order of its recordings, so that the
        // result does not depend on who was first
        let next = AtomicUsize::new(0);
        let done: Mutex<Vec<Option<RowsOfJoint>>> = Mutex::new(vec![None; n]);
        let work = || {
            loop {
                let joint = next.fetch_add(1, Ordering::Relaxed);
                if joint >= n {
                    break;
                }
                let rows = self.rows_of_joint(joint, widths[joint], motions, total_s, &prepare);
                if let Ok(mut done) = done.lock() {
                    done[joint] = Some(rows);
                }
            }
        };
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        std::thread::scope(|scope| {
            for _ in 1..threads.min(n) {
                scope.spawn(work);
            }
            work();
        });
        let done = done.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut rows = JointRows {
            triangles: Vec::with_capacity(n),
            effort: Vec::with_capacity(n),
            share: if samples > 0.0 { independent / samples } else { 1.0 },
            blocks: Vec::with_capacity(n),
        };
        for of_joint in done.into_iter().flatten() {
            rows.triangles.push(of_joint.triangle);
            rows.effort.push(of_joint.effort);
            rows.blocks.push(of_joint.blocks);
        }
        rows
    }

    fn rows_of_joint(
        &self,
        joint: usize,
        width: usize,
        motions: &[&Motion],
        total_s: f64,
        prepare: &impl Fn(usize, usize, &mut Vec<Vec<f64>>, &mut Vec<f64>),
    ) -> RowsOfJoint {
        let mut rows = RowsOfJoint {
            triangle: AccumulatedQr::new(width),
            effort: (0, 0.0, 0.0),
            blocks: Vec::new(),
        };
        for (index, motion) in motions.iter().enumerate() {
            #[expect(clippy::expect_used, reason = "documented panic: checked by the callers")]
            let effort = motion.effort_filtered.as_ref().expect("a motion with efforts");
            let own = &effort[joint][kept(motion)];
            rows.effort.0 += own.len();
            rows.effort.1 += own.iter().sum::<f64>();
            rows.effort.2 += own.iter().map(|e| e * e).sum::<f64>();
            let mut columns = self.columns(joint, motion);
            let mut y = effort[joint].clone();
            prepare(index, joint, &mut columns, &mut y);
            for block in blocks_of(motion, total_s) {
                let part: Vec<Vec<f64>> =
                    columns.iter().map(|c| c[block.clone()].to_vec()).collect();
                let mut triangle = AccumulatedQr::new(columns.len());
                triangle.push_columns(&part, &y[block]);
                rows.triangle.merge(&triangle);
                rows.blocks.push(triangle);
            }
        }
        rows
    }

    /// Columns of one joint over a motion, through its filter, in the order of
    /// [`Self::terms_of_joint`].
    pub(crate) fn columns(&self, joint: usize, motion: &Motion) -> Vec<Vec<f64>> {
        let wanted: Vec<usize> = self.by_joint[joint]
            .iter()
            .filter_map(|&k| match self.terms[k] {
                Term::Constant(c) => Some(c),
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => None,
            })
            .collect();
        let mut columns = self.set().columns().of_motion(
            self.arm(),
            joint,
            &motion.position,
            &motion.velocity,
            &motion.acceleration,
            &wanted,
        );
        motion.filter_columns(&mut columns);
        // what follows the sign of a speed jumps between samples
        let fine = motion.fine();
        let resolution = self.resolution(joint);
        let mut of_effect: Vec<Option<Vec<Vec<f64>>>> = vec![None; EVERYDAY.len()];
        for &k in &self.by_joint[joint] {
            let Term::Effect { effect, parameter, .. } = self.terms[k] else { continue };
            let law = EVERYDAY[effect];
            let formed = of_effect[effect].get_or_insert_with(|| {
                let kind = self.arm().joints[joint].kind;
                let jumps = law.law().places.contains(&Place::Dry);
                let from = if jumps { fine } else { motion };
                let mut formed = effect_columns(law, &[], kind, joint, from, resolution);
                if jumps {
                    formed = formed.into_iter().map(|c| motion.filtered_fine(c)).collect();
                } else {
                    motion.filter_columns(&mut formed);
                }
                formed
            });
            columns.push(formed[parameter].clone());
        }
        let mut further: Vec<(usize, Vec<f64>)> = (self.shared_columns(joint, fine).into_iter())
            .map(|(k, column)| (k, motion.filtered_fine(column)))
            .collect();
        for (k, column) in self.load_columns(joint, motion) {
            let mut column = [column];
            motion.filter_columns(&mut column);
            let [column] = column;
            further.push((k, column));
        }
        further.sort_by_key(|(k, _)| *k);
        columns.extend(further.into_iter().map(|(_, column)| column));
        columns
    }

    fn resolution(&self, joint: usize) -> Option<f64> {
        self.speed_resolution.as_ref().map(|r| r[joint])
    }

    /// The column of the direction of motion of a joint at another speed resolution, as
    /// [`Self::columns`] has it.
    pub(crate) fn direction_column(
        &self,
        joint: usize,
        motion: &Motion,
        resolution: f64,
    ) -> Vec<f64> {
        let kind = self.arm().joints[joint].kind;
        let jumping = EVERYDAY.iter().find(|law| law.law().places.contains(&Place::Dry));
        let formed = jumping.and_then(|law| {
            effect_columns(*law, &[], kind, joint, motion.fine(), Some(resolution)).pop()
        });
        motion.filtered_fine(formed.unwrap_or_else(|| vec![0.0; motion.fine().len()]))
    }
}

/// Columns of an effect on one joint of a motion, not filtered.
pub(crate) fn effect_columns(
    effect: &dyn Effect,
    shape: &[f64],
    kind: JointKind,
    joint: usize,
    motion: &Motion,
    speed_resolution: Option<f64>,
) -> Vec<Vec<f64>> {
    let velocity = &motion.velocity[joint];
    let speed_resolution = match (speed_resolution, &motion.filter) {
        // without a low-pass velocities are exact: so is their sign
        (_, None) => 0.0,
        (Some(given), _) => given,
        (None, _) => {
            let squares: f64 = velocity.iter().map(|v| v * v).sum();
            DEFAULT_SPEED_RESOLUTION * (squares / velocity.len() as f64).sqrt()
        }
    };
    let direction = directions_with(velocity, speed_resolution.max(f64::MIN_POSITIVE));
    effect.columns(shape, &joint_motion(kind, joint, motion, &direction))
}

/// The motion of one joint as laws take it.
pub(crate) fn joint_motion<'a>(
    kind: JointKind,
    joint: usize,
    motion: &'a Motion,
    direction: &'a [f64],
) -> JointMotion<'a> {
    JointMotion {
        kind,
        time_s: &motion.time_s,
        position: &motion.position[joint],
        velocity: &motion.velocity[joint],
        acceleration: &motion.acceleration[joint],
        direction,
        rigid_effort: &[],
    }
}
