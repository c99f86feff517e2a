//! Rows of zeros that a second publisher puts between rows of motion.

use armident_numeric::order_statistic;

/// Share of the rows above which rows of zeros are no exception.
const MOST: f64 = 0.6;
/// A joint at so many of its largest usual steps from zero on both sides cannot have been there in between.
const FAR_STEPS: f64 = 5.0;
/// Quantile of the steps that is the largest usual one: outliers and reversals are rarer.
const USUAL: f64 = 0.99;

/// Rows in which every channel is exactly 0 although joints are far from 0 in the rows around.
///
/// An arm at rest in its zero position, or a recording that begins there, has none: its neighbouring rows are near 0.
pub(crate) fn rows_of_zeros(positions: &[&[f64]], others: &[&[f64]]) -> Vec<usize> {
    let n = positions.first().map_or(0, |position| position.len());
    let is_zero = |k: usize| positions.iter().chain(others).all(|values| values[k] == 0.0);
    let (zeros, rest): (Vec<usize>, Vec<usize>) = (0..n).partition(|k| is_zero(*k));
    if zeros.is_empty() || rest.len() < 2 || zeros.len() as f64 > MOST * n as f64 {
        return Vec::new();
    }
    let far: Vec<f64> = (positions.iter())
        .map(|position| {
            let mut steps: Vec<f64> =
                rest.windows(2).map(|pair| (position[pair[1]] - position[pair[0]]).abs()).collect();
            let place = (USUAL * (steps.len() - 1) as f64) as usize;
            FAR_STEPS * order_statistic(&mut steps, place).unwrap_or(f64::MAX)
        })
        .collect();
    let is_far = |k: usize| -> Vec<bool> {
        positions.iter().zip(&far).map(|(position, far)| position[k].abs() > *far).collect()
    };
    let is_foreign = |k: &usize| {
        let after = rest.partition_point(|row| row < k);
        let sides = [after.checked_sub(1).map(|row| rest[row]), rest.get(after).copied()];
        let known: Vec<Vec<bool>> = sides.into_iter().flatten().map(is_far).collect();
        (0..positions.len()).any(|joint| known.iter().all(|far| far[joint]))
    };
    zeros.into_iter().filter(is_foreign).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(offset: f64) -> Vec<f64> {
        (0..400).map(|k| offset + 0.3 * (0.03 * f64::from(k)).sin()).collect()
    }

    #[test]
    fn zeros_between_rows_of_motion_are_found() {
        let (mut a, mut b, mut effort) = (swing(0.0), swing(0.7), swing(20.0));
        let rows: Vec<usize> = (0..400).filter(|k| k % 7 == 3 || (100..104).contains(k)).collect();
        for k in &rows {
            (a[*k], b[*k], effort[*k]) = (0.0, 0.0, 0.0);
        }
        assert_eq!(rows_of_zeros(&[&a, &b], &[&effort]), rows);
        // efforts of a joint alone are no rows of zeros
        assert!(rows_of_zeros(&[&swing(0.7)], &[&effort]).is_empty());
    }

    #[test]
    fn arms_at_rest_at_zero_are_not_accused() {
        let mut at_home = vec![0.0; 100];
        at_home.extend(swing(0.0).iter().take(210));
        at_home.extend(vec![0.0; 100]);
        assert!(rows_of_zeros(&[&at_home], &[&at_home]).is_empty());
        assert!(rows_of_zeros(&[&[0.0; 50]], &[]).is_empty());
        assert!(rows_of_zeros(&[], &[]).is_empty());
    }
}
