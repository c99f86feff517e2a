//! Blocks of samples: small enough to stay in the first cache from joint to joint.

use pulp::Simd;

use super::BLOCK;
use super::arm::KernelJoint;
use super::lanes::Column;
use super::sin_cos::sin_cos_of_column;

/// Columns of a motion, one a joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns<'a> {
    pub(crate) q: &'a [&'a [f64]],
    pub(crate) dq: &'a [&'a [f64]],
    pub(crate) ddq: &'a [&'a [f64]],
    /// sines and cosines, where they are known
    pub(crate) angles: Option<&'a [(&'a [f64], &'a [f64])]>,
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
    copies: Vec<Copies>,
}

/// Position, velocity, acceleration, sine and cosine of a joint.
type Copies = [Column; 5];

impl<'a> Block<'a> {
    /// No sample yet.
    pub(super) fn of(columns: Columns<'a>) -> Self {
        let copies = vec![[[0.0; BLOCK]; 5]; columns.q.len()];
        Self { columns, first: 0, len: 0, copies }
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
        let Columns { q, dq, ddq, angles } = self.columns;
        for (j, (joint, copies)) in joints.iter().zip(&mut self.copies).enumerate() {
            if self.len < BLOCK {
                for (copy, column) in copies.iter_mut().zip([q[j], dq[j], ddq[j]]) {
                    copy[..self.len].copy_from_slice(&column[range.clone()]);
                }
            }
            let [q_copy, _, _, sin_copy, cos_copy] = copies;
            match angles.map(|angles| angles[j]) {
                None if joint.rotational => {
                    let q = q[j][range.clone()].first_chunk().unwrap_or(q_copy);
                    sin_cos_of_column(simd, joint.theta, q, sin_copy, cos_copy);
                }
                None => {
                    let (sin, cos) = joint.theta.sin_cos();
                    (*sin_copy, *cos_copy) = ([sin; BLOCK], [cos; BLOCK]);
                }
                Some((sin, cos)) if self.len < BLOCK => {
                    sin_copy[..self.len].copy_from_slice(&sin[range.clone()]);
                    cos_copy[..self.len].copy_from_slice(&cos[range.clone()]);
                }
                Some(_) => {}
            }
        }
    }

    /// The samples at one joint.
    #[inline(always)]
    pub(super) fn at(&self, joint: usize) -> JointBlock<'_> {
        let Columns { q, dq, ddq, angles } = self.columns;
        let copies = &self.copies[joint];
        let place = |column: &'a [f64], copy| -> &Column {
            if self.len < BLOCK { copy } else { column[self.first..].first_chunk().unwrap_or(copy) }
        };
        let (sin, cos) = match angles {
            Some(angles) => {
                (place(angles[joint].0, &copies[3]), place(angles[joint].1, &copies[4]))
            }
            None => (&copies[3], &copies[4]),
        };
        JointBlock {
            q: place(q[joint], &copies[0]),
            dq: place(dq[joint], &copies[1]),
            ddq: place(ddq[joint], &copies[2]),
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
