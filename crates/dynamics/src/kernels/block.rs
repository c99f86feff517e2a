//! Blocks of samples: small enough to stay in the first cache from joint to joint.

use pulp::Simd;

use super::arm::KernelJoint;
use crate::lanes::BLOCK;
use crate::lanes::Column;
use crate::sin_cos::sin_cos_of_column;

/// Columns of a motion, one a joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns<'a> {
    pub(crate) q: &'a [&'a [f64]],
    pub(crate) dq: &'a [&'a [f64]],
    pub(crate) ddq: &'a [&'a [f64]],
}

impl Columns<'_> {
    pub(super) fn samples(&self) -> usize {
        self.q.first().map_or(0, |q| q.len())
    }
}

/// The samples of a block at one joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointBlock<'a> {
    pub(super) q: &'a Column,
    pub(super) dq: &'a Column,
    pub(super) ddq: &'a Column,
    pub(super) sin: &'a Column,
    pub(super) cos: &'a Column,
}

/// Samples `first .. first + len` at all joints: read where they are, or, fewer than [`BLOCK`], from copies that are
/// filled up.
#[derive(Debug, Clone)]
pub(super) struct Block<'a> {
    columns: Columns<'a>,
    pub(super) first: usize,
    pub(super) len: usize,
    joints: Vec<OwnColumns>,
}

/// What a block keeps of a joint.
#[derive(Debug, Clone)]
struct OwnColumns {
    sin: Column,
    cos: Column,
    /// position, velocity and acceleration of a block that is not whole
    copies: [Column; 3],
}

impl<'a> Block<'a> {
    /// No sample yet.
    ///
    /// # Panics
    /// When the columns differ in length.
    pub(super) fn of(columns: Columns<'a>) -> Self {
        let all = [columns.q, columns.dq, columns.ddq];
        let equal = |column: &&[f64]| column.len() == columns.samples();
        assert!(all.into_iter().flatten().all(equal), "columns of one length");
        let none = [0.0; BLOCK];
        let joint = OwnColumns { sin: none, cos: none, copies: [none; 3] };
        Self { columns, first: 0, len: 0, joints: vec![joint; columns.q.len()] }
    }

    /// Numbers of lanes that hold the samples.
    #[inline(always)]
    pub(super) fn chunks<S: Simd>(&self) -> usize {
        self.len.div_ceil(S::F64_LANES)
    }

    /// Goes to the samples that begin at `first`.
    #[inline(always)]
    pub(super) fn go_to<S: Simd>(&mut self, simd: S, joints: &[KernelJoint], first: usize) {
        self.first = first;
        self.len = BLOCK.min(self.columns.samples() - first);
        let range = first..first + self.len;
        let Columns { q, dq, ddq } = self.columns;
        for (j, (joint, own)) in joints.iter().zip(&mut self.joints).enumerate() {
            if self.len < BLOCK {
                for (copy, column) in own.copies.iter_mut().zip([q[j], dq[j], ddq[j]]) {
                    copy[..self.len].copy_from_slice(&column[range.clone()]);
                }
            }
            if joint.rotational {
                let q = q[j][range.clone()].first_chunk().unwrap_or(&own.copies[0]);
                sin_cos_of_column(simd, joint.theta, q, &mut own.sin, &mut own.cos);
            } else {
                let (sin, cos) = joint.theta.sin_cos();
                (own.sin, own.cos) = ([sin; BLOCK], [cos; BLOCK]);
            }
        }
    }

    /// The samples at one joint.
    #[inline(always)]
    pub(super) fn at(&self, joint: usize) -> JointBlock<'_> {
        let Columns { q, dq, ddq } = self.columns;
        let OwnColumns { sin, cos, copies } = &self.joints[joint];
        let [q_copy, dq_copy, ddq_copy] = copies;
        JointBlock {
            q: q[joint][self.first..].first_chunk().unwrap_or(q_copy),
            dq: dq[joint][self.first..].first_chunk().unwrap_or(dq_copy),
            ddq: ddq[joint][self.first..].first_chunk().unwrap_or(ddq_copy),
            sin,
            cos,
        }
    }

    /// Where the results of this block go in a column, and, where that is not a whole block, what they are copied to then.
    #[inline(always)]
    pub(super) fn place<'c>(
        &self,
        column: &'c mut [f64],
        spare: &'c mut Column,
    ) -> (&'c mut Column, Option<&'c mut [f64]>) {
        let rest = &mut column[self.first..];
        if rest.len() < BLOCK {
            return (spare, Some(rest));
        }
        (rest.first_chunk_mut().unwrap_or(spare), None)
    }
}
