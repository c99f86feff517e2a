//! The number of the kernels: one sample in each lane.

use std::ops::{Add, Mul, Neg, Sub};

use pulp::Simd;

/// One number for each of `S::F64_LANES` samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    value: S::f64s,
}

/// Components of a vector in a link's frame.
pub(crate) type Vector<S> = [Lanes<S>; 3];

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self { simd, value: simd.splat_f64s(value) }
    }

    /// `self · b + c`, rounded once where the processor can.
    #[inline(always)]
    pub(crate) fn times_plus(self, b: Self, c: Self) -> Self {
        Self { simd: self.simd, value: self.simd.mul_add_e_f64s(self.value, b.value, c.value) }
    }

    /// `c - self · b`, rounded once where the processor can.
    #[inline(always)]
    pub(crate) fn times_from(self, b: Self, c: Self) -> Self {
        let value = self.simd.negate_mul_add_e_f64s(self.value, b.value, c.value);
        Self { simd: self.simd, value }
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { simd: self.simd, value: self.simd.add_f64s(self.value, other.value) }
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { simd: self.simd, value: self.simd.sub_f64s(self.value, other.value) }
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { simd: self.simd, value: self.simd.mul_f64s(self.value, other.value) }
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { simd: self.simd, value: self.simd.neg_f64s(self.value) }
    }
}

/// `a · b`.
#[inline(always)]
pub(crate) fn dot<S: Simd>(a: Vector<S>, b: Vector<S>) -> Lanes<S> {
    a[0].times_plus(b[0], a[1].times_plus(b[1], a[2] * b[2]))
}

/// Samples of a block: the numbers that a kernel keeps of 32 samples of seven joints take 20 kB.
pub(crate) const BLOCK: usize = 32;

/// One quantity of the samples of a block.
pub(crate) type Column = [f64; BLOCK];

/// The lanes of a column.
#[inline(always)]
pub(crate) fn lanes<S: Simd>(simd: S, column: &[f64]) -> impl Fn(usize) -> Lanes<S> {
    let (all, _) = S::as_simd_f64s(column);
    move |chunk| Lanes { simd, value: all[chunk] }
}

/// Writes the lanes of a chunk of a column.
#[inline(always)]
pub(crate) fn store<S: Simd>(column: &mut [f64], chunk: usize, lanes: Lanes<S>) {
    S::as_mut_simd_f64s(column).0[chunk] = lanes.value;
}
