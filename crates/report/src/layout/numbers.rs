//! Numbers as people read them.

/// At most `digits` significant digits, no exponent between 1e-4 and 1e6, trailing zeros cut;
/// numbers below `zero` print as `0`.
pub fn significant(value: f64, digits: usize, zero: f64) -> String {
    if value.is_nan() {
        return "-".to_owned();
    }
    if !value.is_finite() {
        return if value > 0.0 { "inf".to_owned() } else { "-inf".to_owned() };
    }
    if value.abs() <= zero {
        return "0".to_owned();
    }
    let exponent = format!("{:.*e}", digits - 1, value)
        .split_once('e')
        .and_then(|(_, e)| e.parse::<i32>().ok())
        .unwrap_or(0);
    if !(-5..6).contains(&exponent) {
        return format!("{:.*e}", digits - 1, value);
    }
    let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A share in percent, or as a multiple where it is ten and more.
pub fn percent(share: f64) -> String {
    match share {
        s if !s.is_finite() => "-".to_owned(),
        s if s >= 10.0 => format!("{} times", significant(s, 3, 0.0)),
        s => format!("{} %", significant(100.0 * s, 2, 0.0)),
    }
}

/// A unit as it stands after a number: that of a pure number, `1` in JSON, is none.
pub fn unit_after_number(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// A value rounded to two digits of its standard error, and the error: `("1.234", "0.012")`.
pub fn uncertain(value: f64, standard_error: f64) -> (String, String) {
    if !standard_error.is_finite() || standard_error <= 0.0 || !value.is_finite() {
        return (significant(value, 6, 0.0), significant(standard_error, 2, 0.0));
    }
    let decimals = 1 - standard_error.log10().floor() as i32;
    if value.abs() >= 1e6 || decimals > 12 {
        return (significant(value, 6, 0.0), significant(standard_error, 2, 0.0));
    }
    let decimals = decimals.max(0) as usize;
    (format!("{value:.decimals$}"), format!("{standard_error:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_significant_digits() {
        assert_eq!(significant(4.384_864_7, 6, 0.0), "4.38486");
        assert_eq!(significant(0.004_422_9, 6, 0.0), "0.0044229");
        assert_eq!(significant(-2.0, 6, 0.0), "-2");
        assert_eq!(significant(1e-17, 6, 1e-12), "0");
        assert_eq!(significant(-5.365e-7, 6, 0.0), "-5.36500e-7");
        assert_eq!(significant(123_456_789.0, 6, 0.0), "1.23457e8");
        assert_eq!(significant(120_000.0, 6, 0.0), "120000");
        assert_eq!(significant(f64::NAN, 6, 0.0), "-");
    }

    #[test]
    fn pure_numbers_have_no_unit() {
        assert_eq!(
            (unit_after_number("1"), unit_after_number("1/s"), unit_after_number("N m")),
            ("", "1/s", "N m")
        );
    }

    #[test]
    fn digits_follow_the_standard_error() {
        assert_eq!(uncertain(1.234_56, 0.0123), ("1.235".to_owned(), "0.012".to_owned()));
        assert_eq!(uncertain(-12.3, 4.6), ("-12.3".to_owned(), "4.6".to_owned()));
        assert_eq!(uncertain(1.0, f64::NAN), ("1".to_owned(), "-".to_owned()));
    }
}
