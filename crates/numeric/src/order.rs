//! Order statistics.

/// The value at `index` of the sorted values, which are reordered; none if there are not so many.
///
/// `(n - 1) / 2` gives the lower median of n values, `n / 2` the upper one.
///
/// ```
/// use armident_numeric::order_statistic;
///
/// assert_eq!(order_statistic(&mut [3.0, 1.0, 4.0, 2.0], 1), Some(2.0));
/// assert_eq!(order_statistic(&mut [], 0), None);
/// ```
pub fn order_statistic(values: &mut [f64], index: usize) -> Option<f64> {
    (index < values.len()).then(|| *values.select_nth_unstable_by(index, f64::total_cmp).1)
}

/// The smallest and the largest value; `[f64::MAX, f64::MIN]` of none.
pub fn extremes(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let wider = |[least, most]: [f64; 2], x: f64| [least.min(x), most.max(x)];
    values.into_iter().fold([f64::MAX, f64::MIN], wider)
}

/// The largest less the smallest value; negative of none.
///
/// ```
/// assert_eq!(armident_numeric::range(&[3.0, -1.0, 4.0]), 5.0);
/// ```
pub fn range(values: &[f64]) -> f64 {
    let [least, most] = extremes(values.iter().copied());
    most - least
}
