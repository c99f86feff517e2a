//! Derivatives of evenly sampled signals.

/// First derivative per second of even samples, of fourth order everywhere: central in the
/// interior, `(8 (f₊₁ - f₋₁) - (f₊₂ - f₋₂)) / 12h`, five-point one-sided formulas at the two
/// samples of each end. Exact for polynomials up to the fourth degree.
///
/// Fewer than five samples give the slope of the line from the first to the last.
/// Source: B. Fornberg, Generation of finite difference formulas on arbitrarily spaced grids,
/// Math. Comp. 51 (1988), tables 1 and 3.
pub fn differentiate(values: &[f64], rate_hz: f64) -> Vec<f64> {
    let n = values.len();
    if n < 5 {
        let slope = match values {
            [first, .., last] => (last - first) / (n - 1) as f64 * rate_hz,
            _ => 0.0,
        };
        return vec![slope; n];
    }
    let scale = rate_hz / 12.0;
    let mut derivative = vec![0.0; n];
    for (k, window) in values.windows(5).enumerate() {
        derivative[k + 2] = scale * (8.0 * (window[3] - window[1]) - (window[4] - window[0]));
    }
    let at = |k: usize| values[k];
    let from_end = |k: usize| values[n - 1 - k];
    [derivative[0], derivative[1]] = one_sided(at, scale);
    [derivative[n - 1], derivative[n - 2]] = one_sided(from_end, -scale);
    derivative
}

/// At the first and second of five samples.
fn one_sided(f: impl Fn(usize) -> f64, scale: f64) -> [f64; 2] {
    // differences to the first sample: a constant has derivative 0 exactly
    let d = |k: usize| f(k) - f(0);
    [
        scale * (48.0 * d(1) - 36.0 * d(2) + 16.0 * d(3) - 3.0 * d(4)),
        scale * (-10.0 * d(1) + 18.0 * d(2) - 6.0 * d(3) + d(4)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_on_quartics_up_to_the_ends() {
        let (rate_hz, c) = (50.0, [0.3, -1.2, 2.0, 0.7, -0.9]);
        let times = (0..30).map(|k| f64::from(k) / rate_hz - 0.2);
        let value = |t: f64| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
        let slope = |t: f64| c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * 4.0 * c[4]));
        let values: Vec<f64> = times.clone().map(value).collect();
        for (got, t) in differentiate(&values, rate_hz).iter().zip(times) {
            assert!((got - slope(t)).abs() < 1e-12, "{got} {}", slope(t));
        }
    }

    #[test]
    fn fourth_order() {
        let error = |rate_hz: f64| {
            let times = (0..=(rate_hz as usize)).map(|k| k as f64 / rate_hz);
            let values: Vec<f64> = times.clone().map(|t| (3.0 * t).sin()).collect();
            differentiate(&values, rate_hz)
                .iter()
                .zip(times)
                .map(|(got, t)| (got - 3.0 * (3.0 * t).cos()).abs())
                .fold(0.0, f64::max)
        };
        assert!((error(50.0) / error(100.0) - 16.0).abs() < 2.0);
    }

    #[test]
    fn few_samples() {
        assert!(differentiate(&[], 10.0).is_empty());
        assert_eq!(differentiate(&[4.0], 10.0), [0.0]);
        assert_eq!(differentiate(&[0.0, 1.0, 2.0, 3.0], 10.0), [10.0; 4]);
        assert_eq!(differentiate(&[2.5; 7], 10.0), [0.0; 7]);
    }
}
