//! How much of an effort nothing else can imitate.
//!
//! The columns `C` of a law and those of all that is fitted anyway, `X`, weighted by the noise: the information on the
//! coefficients of the law with all else fitted too is the Schur complement
//!
//! ```text
//! S = CᵀC - CᵀX (XᵀX)⁻¹ XᵀC
//! ```
//!
//! and `cᵀ S c` is the squared residual, in standard deviations of the noise, that an effort `C c` leaves after a fit of `X`.
//!
//! References: A. C. Atkinson, V. V. Fedorov, The design of experiments for discriminating between two rival models,
//! Biometrika 62(1), 1975 (T-optimality).

use armident_effects::ArmColumns;
use armident_numeric::{Cholesky, Mat, products_of_columns};

use crate::information::Regressors;

/// Added to the diagonal of the products of unit columns: parameters that a motion does not excite take part in no
/// imitation, and columns that are equal to ten digits are one.
const RIDGE: f64 = 1e-10;

/// Columns of all that is fitted anyway, on some motions.
pub(crate) struct Fitted {
    /// `[motion][joint]`: parameter of each column, and the columns
    motions: Vec<Regressors>,
    noise: Vec<f64>,
    size: Vec<f64>,
    factor: Option<Cholesky>,
}

impl Fitted {
    /// From the regressors of each motion, for so many parameters, with the noise of each joint.
    pub(crate) fn new(parameters: usize, motions: Vec<Regressors>, noise: &[f64]) -> Self {
        let mut sum = Mat::<f64>::zeros(parameters, parameters);
        for motion in &motions {
            for (joint, (places, columns)) in motion.iter().enumerate() {
                let views: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
                let gram = products_of_columns(&views, &views);
                let weight = noise[joint].powi(-2);
                for (a, &i) in places.iter().enumerate() {
                    for (b, &j) in places.iter().enumerate() {
                        sum[(i, j)] += weight * gram[(a, b)];
                    }
                }
            }
        }
        let size: Vec<f64> = (0..parameters)
            .map(|k| Some(sum[(k, k)].sqrt()).filter(|s| *s > 0.0).unwrap_or(1.0))
            .collect();
        let factor = Cholesky::of(parameters, |i, j| {
            sum[(i, j)] / (size[i] * size[j]) + if i == j { RIDGE } else { 0.0 }
        });
        Self { motions, noise: noise.to_vec(), size, factor }
    }

    /// `S` and `CᵀC` of columns `[motion][column][joint][sample]`; none where products are not finite.
    pub(crate) fn residual(&self, columns: &[ArmColumns]) -> Option<[Mat<f64>; 2]> {
        let factor = self.factor.as_ref()?;
        let count = columns.first()?.len();
        let mut own = Mat::<f64>::zeros(count, count);
        let mut cross = vec![vec![0.0; self.size.len()]; count];
        for (motion, columns) in self.motions.iter().zip(columns) {
            for (joint, (places, fitted)) in motion.iter().enumerate() {
                let views: Vec<&[f64]> = columns.iter().map(|c| c[joint].as_slice()).collect();
                if views.first().is_none_or(|view| view.is_empty()) {
                    continue;
                }
                let weight = self.noise[joint].powi(-2);
                let of_fitted: Vec<&[f64]> = fitted.iter().map(Vec::as_slice).collect();
                let (gram, products) =
                    (products_of_columns(&views, &views), products_of_columns(&of_fitted, &views));
                for c in 0..count {
                    for d in 0..count {
                        own[(c, d)] += weight * gram[(c, d)];
                    }
                    for (a, &place) in places.iter().enumerate() {
                        cross[c][place] += weight * products[(a, c)] / self.size[place];
                    }
                }
            }
        }
        let halves: Vec<Vec<f64>> = cross.iter().map(|c| factor.forward(c)).collect();
        let left = Mat::<f64>::from_fn(count, count, |c, d| {
            own[(c, d)] - armident_numeric::dot(&halves[c], &halves[d])
        });
        let is_finite = (0..count).all(|c| (0..count).all(|d| left[(c, d)].is_finite()));
        is_finite.then_some([left, own])
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;

    /// Of `1, t, t²` on a line, the square alone is left where constant and line are fitted; a line leaves nothing.
    #[test]
    fn residual_is_that_of_least_squares() {
        let t: Vec<f64> = (0..=100).map(|k| f64::from(k) / 50.0 - 1.0).collect();
        let power = |p: i32| -> Vec<f64> { t.iter().map(|t| t.powi(p)).collect() };
        let fitted = Fitted::new(2, vec![vec![(vec![0, 1], vec![power(0), power(1)])]], &[0.5]);
        let [left, own] = fitted.residual(&[vec![vec![power(2)], vec![power(1)]]]).unwrap();
        let mean: f64 = power(2).iter().sum::<f64>() / t.len() as f64;
        let expected: f64 = power(2).iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 0.25;
        assert!((left[(0, 0)] - expected).abs() < 1e-6 * expected);
        assert!(left[(1, 1)].abs() < 1e-8 * own[(1, 1)]);
    }
}
