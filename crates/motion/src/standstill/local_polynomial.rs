//! Least squares of few terms through some samples of a motion.

use armident_numeric::{Cholesky, dot};

/// Weight of a sample so far off, of which those within `side` count: the tricube of Cleveland, Robust locally weighted
/// regression, 1979.
pub(super) fn nearness(off: f64, side: f64) -> f64 {
    (1.0 - (off / (side + 1.0)).powi(3)).powi(3)
}

/// A sample with the values that the terms have at it.
pub(super) struct Sample<const TERMS: usize> {
    pub(super) weight: f64,
    pub(super) terms: [f64; TERMS],
    pub(super) value: f64,
}

/// A fit of as many terms as a sample has.
pub(super) struct Fit {
    pub(super) coefficients: Vec<f64>,
    /// of the coefficients, for values of variance 1 over their weight
    pub(super) variances: Vec<f64>,
    /// weighted squares that are left
    pub(super) left: f64,
    /// sum of the weights
    pub(super) weight: f64,
}

impl Fit {
    /// None where the samples do not tell the terms apart.
    pub(super) fn of<const TERMS: usize>(samples: &[Sample<TERMS>]) -> Option<Self> {
        let mut gram = [[0.0; TERMS]; TERMS];
        let mut with_value = [0.0; TERMS];
        for Sample { weight, terms, value } in samples {
            for (i, term) in terms.iter().enumerate() {
                with_value[i] += weight * term * value;
                for (j, other) in terms[..=i].iter().enumerate() {
                    gram[i][j] += weight * term * other;
                }
            }
        }
        let factor = Cholesky::of(TERMS, |i, j| gram[i][j])?;
        let coefficients = factor.solve(&with_value);
        let left = |s: &Sample<TERMS>| s.weight * (s.value - dot(&coefficients, &s.terms)).powi(2);
        Some(Self {
            left: samples.iter().map(left).sum(),
            weight: samples.iter().map(|s| s.weight).sum(),
            variances: factor.inverse_diagonal(),
            coefficients,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights are how often a sample is there, and squares are those about the line.
    #[test]
    fn a_weight_of_two_is_two_samples() {
        let values = [1.0, 3.5, 5.0, 6.5];
        let sample =
            |weight: f64, x: usize| Sample { weight, terms: [1.0, x as f64], value: values[x] };
        let weighted = [sample(1.0, 0), sample(2.0, 1), sample(1.0, 2), sample(1.0, 3)];
        let repeated = [0, 1, 1, 2, 3].map(|x| sample(1.0, x));
        let [a, b] = [Fit::of(&weighted).unwrap(), Fit::of(&repeated).unwrap()];
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        for (a, b) in a.coefficients.iter().zip(&b.coefficients) {
            assert!(near(*a, *b));
        }
        assert!(near(a.left, b.left) && a.left > 0.1 && near(a.weight, 5.0));
        // of a slope: one over the squares about the mean place
        let mean = 7.0 / 5.0;
        let squares: f64 = [0.0, 1.0, 1.0, 2.0, 3.0].iter().map(|x: &f64| (x - mean).powi(2)).sum();
        assert!(near(a.variances[1], 1.0 / squares));
        assert!(Fit::of(&weighted[..1]).is_none());
    }
}
