//! Delete-a-block jackknife of least squares.
//!
//! Method: the fit is repeated without each block of neighbouring samples; the scatter of these estimates gives their
//! covariance. Blocks, because residuals of a model that lacks physics keep their sign for a good part of a second,
//! which standard errors from white residuals do not know. Intervals use Student's t with one degree of freedom less than
//! blocks.
//!
//! References: H. R. Künsch, The jackknife and the bootstrap for general stationary observations, Annals of Statistics 17
//! (1989); for the quantiles C. A. Bester, T. G. Conley, C. B. Hansen, Inference with dependent data using cluster
//! covariance estimators, Journal of Econometrics 165 (2011).

use armident_numeric::AccumulatedQr;

/// Fewer blocks than this give no standard errors.
pub const FEWEST_BLOCKS: usize = 4;

/// The triangle of all blocks but one, for each one.
pub fn leave_one_out(blocks: &[AccumulatedQr]) -> Vec<AccumulatedQr> {
    let empty = AccumulatedQr::new(blocks[0].unknowns());
    let joined = |a: &AccumulatedQr, b: &AccumulatedQr| {
        let mut both = a.clone();
        both.merge(b);
        both
    };
    let mut before = vec![empty.clone()];
    for block in &blocks[..blocks.len() - 1] {
        before.push(joined(&before[before.len() - 1], block));
    }
    let mut after = empty;
    let mut all = Vec::with_capacity(blocks.len());
    for (block, before) in blocks.iter().zip(&before).rev() {
        all.push(joined(before, &after));
        after = joined(&after, block);
    }
    all.reverse();
    all
}

/// Distance of each estimate (`[block][parameter]`) from the mean of all.
pub fn deviations(estimates: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let parameters = estimates.first().map_or(0, Vec::len);
    let count = estimates.len() as f64;
    let mean = |k: usize| estimates.iter().map(|x| x[k]).sum::<f64>() / count;
    let means: Vec<f64> = (0..parameters).map(mean).collect();
    estimates.iter().map(|x| x.iter().zip(&means).map(|(x, m)| x - m).collect()).collect()
}

/// Standard error from the sum of squared deviations of `blocks` estimates.
pub fn standard_error(sum_of_squares: f64, blocks: usize) -> f64 {
    (sum_of_squares * (blocks - 1) as f64 / blocks as f64).sqrt()
}

/// Variance from the estimates of one parameter, one a left-out block.
pub fn variance(estimates: &[f64]) -> f64 {
    let count = estimates.len() as f64;
    let mean = estimates.iter().sum::<f64>() / count;
    let squares: f64 = estimates.iter().map(|x| (x - mean).powi(2)).sum();
    (count - 1.0) / count * squares
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(seed: usize) -> AccumulatedQr {
        let mut block = AccumulatedQr::new(2);
        let rows: Vec<Vec<f64>> = (0..5)
            .map(|i| (0..3).map(|j| ((7 * seed + 3 * i + j) as f64).sin()).collect())
            .collect();
        block.push_rows(&rows);
        block
    }

    #[test]
    fn each_block_is_left_out_once() {
        let blocks: Vec<AccumulatedQr> = (0..5).map(block).collect();
        for (b, left) in leave_one_out(&blocks).iter().enumerate() {
            let mut expected = AccumulatedQr::new(2);
            for (k, block) in blocks.iter().enumerate() {
                if k != b {
                    expected.merge(block);
                }
            }
            let (x, y) = (left.solve(1e-12).unwrap(), expected.solve(1e-12).unwrap());
            for (x, y) in x.solution.iter().zip(&y.solution) {
                assert!((x - y).abs() < 1e-12);
            }
        }
    }
}
