//! Samples with lines between them.

/// The value at a time; before the first and after the last sample these go on.
pub(crate) fn at(time_s: &[f64], values: &[f64], t: f64) -> f64 {
    let last = time_s.len() - 1;
    let after = time_s.partition_point(|stamp| *stamp <= t).clamp(1, last);
    let (from, to) = (time_s[after - 1], time_s[after]);
    let share = ((t - from) / (to - from)).clamp(0.0, 1.0);
    values[after - 1] + share * (values[after] - values[after - 1])
}
