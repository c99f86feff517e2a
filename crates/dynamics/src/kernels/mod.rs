//! Batches: what a whole motion needs, one sample in each lane of the processor's registers.
//!
//! A block of samples goes through the arm joint by joint, so that the kind of each joint is decided once a block. One source
//! for all instruction sets: the kernels are generic over [`pulp::Simd`], and [`pulp::Arch`] picks AVX-512, AVX2, NEON or
//! scalar code at run time. The functions of one sample beside this folder follow the paper; the tests compare both.
//! What is computed for a sample depends on no other sample.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

mod arm;
mod block;
mod inertia_matrix;
mod inverse_dynamics;
mod link_motion;
mod one_matrix;
mod regressor;
mod wrench;

#[cfg(test)]
mod tests;

pub(crate) use block::Columns;
pub(crate) use one_matrix::inertia_matrix_from_bodies;
pub(crate) use regressor::Wanted;

use crate::arm::RigidArm;
use crate::lanes::{BLOCK, Column};
use arm::joints_of;
use block::Block;
use inertia_matrix::matrices_of_block;
use inverse_dynamics::efforts_of_block;
use regressor::rows_of_block;

/// Efforts of joints `least` to n over a motion; `effort[joint]` has one entry a sample.
pub(crate) fn efforts_into(
    arm: &RigidArm,
    columns: &Columns<'_>,
    least: usize,
    effort: &mut [Vec<f64>],
) {
    Arch::new().dispatch(Efforts { arm, columns, least, effort });
}

struct Efforts<'a> {
    arm: &'a RigidArm,
    columns: &'a Columns<'a>,
    least: usize,
    effort: &'a mut [Vec<f64>],
}

impl WithSimd for Efforts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let joints = joints_of(self.arm);
        let gravity: [f64; 3] = self.arm.gravity_e0.into();
        let (mut block, mut memory) =
            (Block::of(*self.columns), inverse_dynamics::Memory::new(simd, joints.len()));
        for first in (0..self.columns.samples()).step_by(BLOCK) {
            block.go_to(simd, &joints, first);
            efforts_of_block(simd, &joints, &gravity, &block, self.least, &mut memory, self.effort);
        }
    }
}

/// Calls `each(joint, first sample, samples, row)` with the regressor's rows of some joints, block by block: entry `10 i + k` of a
/// row is the column of parameter `k` of link `i`. Links before the joint, and what is not `wanted[i][k]`, have any value.
pub(crate) fn for_each_row(
    arm: &RigidArm,
    columns: &Columns<'_>,
    rows: Range<usize>,
    wanted: &[Wanted],
    each: impl FnMut(usize, usize, usize, &[Column]),
) {
    Arch::new().dispatch(Rows { arm, columns, rows, wanted, each });
}

struct Rows<'a, F> {
    arm: &'a RigidArm,
    columns: &'a Columns<'a>,
    rows: Range<usize>,
    wanted: &'a [Wanted],
    each: F,
}

impl<F: FnMut(usize, usize, usize, &[Column])> WithSimd for Rows<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let joints = joints_of(self.arm);
        let gravity: [f64; 3] = self.arm.gravity_e0.into();
        let mut block = Block::of(*self.columns);
        let mut memory = regressor::Memory::new(simd, joints.len());
        for first in (0..self.columns.samples()).step_by(BLOCK) {
            block.go_to(simd, &joints, first);
            let len = block.len;
            rows_of_block(
                simd,
                &joints,
                &gravity,
                &block,
                self.rows.clone(),
                self.wanted,
                &mut memory,
                |joint, row| (self.each)(joint, first, len, row),
            );
        }
    }
}

/// Upper triangle of the inertia matrix at joint positions, row by row: `matrix[entry]` has one number a sample.
pub(crate) fn inertia_matrices_into(
    arm: &RigidArm,
    columns: &Columns<'_>,
    matrix: &mut [Vec<f64>],
) {
    Arch::new().dispatch(InertiaMatrices { arm, columns, matrix });
}

struct InertiaMatrices<'a> {
    arm: &'a RigidArm,
    columns: &'a Columns<'a>,
    matrix: &'a mut [Vec<f64>],
}

impl WithSimd for InertiaMatrices<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let joints = joints_of(self.arm);
        let n = joints.len();
        let mut block = Block::of(*self.columns);
        let mut memory = inertia_matrix::Memory::new(simd, &joints);
        for first in (0..self.columns.samples()).step_by(BLOCK) {
            block.go_to(simd, &joints, first);
            let place = |i: usize, k: usize| upper_triangle(n, i, k);
            matrices_of_block(simd, &joints, &block, place, &mut memory, self.matrix);
        }
    }
}

/// Place of entry `i, k >= i` in the upper triangle of an n x n matrix, row by row.
pub fn upper_triangle(n: usize, i: usize, k: usize) -> usize {
    i * n + k - i * (i + 1) / 2
}
