//! Quantiles and tails of Student's t, F and chi-square.
//!
//! Method: the distributions of `statrs`.
//!
//! References: Student, The probable error of a mean, Biometrika 6 (1908).

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

/// 97.5 % quantile of Student's t: half-width of a 95 % interval in standard errors.
///
/// NaN without a degree of freedom.
pub fn student_t_975(degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::NAN, |t| t.inverse_cdf(0.975))
}

/// Probability that Student's t exceeds a positive number.
pub fn student_t_tail(t: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::NAN, |law| law.sf(t))
}

/// Quantile of the F distribution; none for degrees of freedom that are not positive.
pub fn f_quantile(probability: f64, numerator: f64, denominator: f64) -> Option<f64> {
    Some(FisherSnedecor::new(numerator, denominator).ok()?.inverse_cdf(probability))
}

/// Probability that F exceeds a number; none for degrees of freedom that are not positive.
pub fn f_tail(f: f64, numerator: f64, denominator: f64) -> Option<f64> {
    Some(FisherSnedecor::new(numerator, denominator).ok()?.sf(f))
}

/// Quantile of the chi-square distribution; none for degrees of freedom that are not positive.
pub fn chi_square_quantile(probability: f64, degrees_of_freedom: f64) -> Option<f64> {
    Some(ChiSquared::new(degrees_of_freedom).ok()?.inverse_cdf(probability))
}

#[cfg(test)]
mod tests {
    use super::student_t_975;

    #[test]
    fn student_t_975_matches_printed_table() {
        for (freedom, quantile) in [(1.0, 12.706), (5.0, 2.571), (30.0, 2.042), (1e6, 1.960)] {
            assert!((student_t_975(freedom) - quantile).abs() < 5e-4);
        }
        assert!(student_t_975(0.0).is_nan());
    }
}
