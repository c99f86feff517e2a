//! Sine and cosine of many angles.
//!
//! The angle is reduced to ±π/2 by multiples of π in three parts (Cody and Waite 1980), then both are Taylor series: the first
//! term that is left out is below 2e-17. Angles above [`LARGEST`] go to the standard library.

use pulp::{Arch, Simd, WithSimd};

use crate::lanes::{Column, Lanes, lanes, store};

/// Largest angle \[rad\] of the reduction: `k PI[0]` and `k PI[1]` are exact up to 2^20 half turns.
const LARGEST: f64 = 1e5;
/// π in parts of 33 bits, 33 bits and the remainder.
const PI: [f64; 3] =
    [3.141_592_653_468_251_2, 1.215_420_101_260_793_2e-10, 4.044_532_497_591_901e-21];
/// 1.5 · 2^52: a number plus this has no fraction.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;
/// 1.5 · 2^53: a number plus this is even.
const TO_EVEN: f64 = 13_510_798_882_111_488.0;

/// `(-1)^k / (2k+1)!`, k = 10 to 1.
const SIN: [f64; 10] = series::<10>(1);
/// `(-1)^k / (2k)!`, k = 10 to 1.
const COS: [f64; 10] = series::<10>(0);

/// `(-1)^k / (2k + odd)!`, k = N to 1.
const fn series<const N: usize>(odd: usize) -> [f64; N] {
    let mut terms = [0.0; N];
    let (mut factorial, mut sign, mut k) = (1.0, 1.0, 1);
    while k <= N {
        factorial *= ((2 * k + odd) * (2 * k + odd - 1)) as f64;
        sign = -sign;
        terms[N - k] = sign / factorial;
        k += 1;
    }
    terms
}

/// Sine and cosine of angles below [`LARGEST`].
#[inline(always)]
fn sin_cos<S: Simd>(simd: S, angle: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let number = |x: f64| Lanes::splat(simd, x);
    let turns = angle.times_plus(number(std::f64::consts::FRAC_1_PI), number(TO_INTEGER))
        - number(TO_INTEGER);
    let rest = turns.times_from(number(PI[0]), angle);
    let rest = turns.times_from(number(PI[1]), rest);
    let rest = turns.times_from(number(PI[2]), rest);
    // -1 after an odd number of half turns
    let odd = turns - ((turns + number(TO_EVEN)) - number(TO_EVEN));
    let sign = (odd * number(-2.0)).times_plus(odd, number(1.0));
    let square = rest * rest;
    let (mut sin, mut cos) = (number(SIN[0]), number(COS[0]));
    for k in 1..SIN.len() {
        sin = sin.times_plus(square, number(SIN[k]));
        cos = cos.times_plus(square, number(COS[k]));
    }
    let signed = rest * sign;
    ((signed * square).times_plus(sin, signed), (square * sign).times_plus(cos, sign))
}

/// Sines and cosines of `theta + q` \[rad\] for a column; what is done for one angle does not depend on the others.
#[inline(always)]
pub(crate) fn sin_cos_of_column<S: Simd>(
    simd: S,
    theta: f64,
    q: &Column,
    sin: &mut Column,
    cos: &mut Column,
) {
    let positions = lanes(simd, q);
    let offset = Lanes::splat(simd, theta);
    for chunk in 0..q.len() / S::F64_LANES {
        let (s, c) = sin_cos(simd, positions(chunk) + offset);
        store(sin, chunk, s);
        store(cos, chunk, c);
    }
    let mut beyond = false;
    for &q in q {
        beyond |= is_beyond(theta + q);
    }
    if beyond {
        by_standard_library(theta, q, sin, cos);
    }
}

#[inline(always)]
fn is_beyond(angle: f64) -> bool {
    angle.abs() > LARGEST || angle.is_nan()
}

/// The same for the angles above [`LARGEST`] and those that are not finite.
#[cold]
fn by_standard_library(theta: f64, q: &Column, sin: &mut Column, cos: &mut Column) {
    for (t, q) in q.iter().enumerate() {
        let angle = theta + q;
        if is_beyond(angle) {
            (sin[t], cos[t]) = angle.sin_cos();
        }
    }
}

/// Sines and cosines of some angles \[rad\], as those of the joints of an arm: here the lanes are joints.
pub(crate) fn sines_and_cosines(angles: &[f64; EIGHT]) -> ([f64; EIGHT], [f64; EIGHT]) {
    let (mut sin, mut cos) = Arch::new().dispatch(Eight(angles));
    for (t, angle) in angles.iter().enumerate() {
        if is_beyond(*angle) {
            (sin[t], cos[t]) = angle.sin_cos();
        }
    }
    (sin, cos)
}

/// Lanes of the widest registers.
pub(crate) const EIGHT: usize = 8;

struct Eight<'a>(&'a [f64; EIGHT]);

impl WithSimd for Eight<'_> {
    type Output = ([f64; EIGHT], [f64; EIGHT]);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let (mut sin, mut cos) = ([0.0; EIGHT], [0.0; EIGHT]);
        let angles = lanes(simd, self.0);
        for chunk in 0..EIGHT / S::F64_LANES {
            let (s, c) = sin_cos(simd, angles(chunk));
            store(&mut sin, chunk, s);
            store(&mut cos, chunk, c);
        }
        (sin, cos)
    }
}
