//! The logarithm of a sum of numbers that are known by their logarithms.
//!
//! Statistic: `ln Σ exp(x)`, by the largest of them, so that nothing over- or underflows: priors are integrated out by it.
//!
//! References: own.

/// `ln Σ exp(x)`; negative infinity for none.
pub fn log_sum(logs: &[f64]) -> f64 {
    let top = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY {
        return top;
    }
    top + logs.iter().map(|l| (l - top).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::log_sum;

    #[test]
    fn sums_of_logarithms() {
        assert!((log_sum(&[0.0, 0.0]) - 2.0_f64.ln()).abs() < 1e-15);
        assert!((log_sum(&[-1e4, -1e4]) + 1e4 - 2.0_f64.ln()).abs() < 1e-9);
        assert_eq!(log_sum(&[f64::NEG_INFINITY]), f64::NEG_INFINITY);
    }
}
