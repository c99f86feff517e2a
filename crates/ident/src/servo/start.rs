//! Where the fit of simulated positions starts.
//!
//! Method: robust linear least squares (IRLS with the weights of Cauchy) of command minus position on what the equation of the
//! joint has over its stiffness: load, offset, direction, velocity; on samples in which the joint moves by more than its
//! encoder resolves, with a delay of one sample.
//!
//! References: P. W. Holland, R. E. Welsch, Robust regression using iteratively reweighted least-squares, Communications in
//! Statistics 6 (1977).

use armident_numeric::{AccumulatedQr, order_statistic};

use super::joint_data::JointData;

/// Rounds of weights.
const ROUNDS: usize = 30;
/// Samples over which a moving joint passes a step of its encoder: the velocity then has a sign.
const STEPS_WITHIN: f64 = 4.0;
const RANK_CUT: f64 = 1e-9;
/// Tuning constant of the weights of Cauchy, in standard deviations: 95 % efficiency on normal errors.
pub(super) const CAUCHY: f64 = 2.385;

/// Start of a fit, each over the stiffness.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    /// 1/K \[rad/(N m) or m/N\]; none where no load is felt.
    pub(super) compliance: Option<f64>,
    /// \[rad or m\]
    pub(super) offset: f64,
    /// \[rad or m\]
    pub(super) dry: f64,
    /// \[s\]
    pub(super) damping: f64,
}

impl Start {
    /// From all recordings of a joint.
    pub(super) fn of(data: &[JointData]) -> Self {
        let sample_s = data.iter().map(|d| d.sample_s).fold(f64::INFINITY, f64::min);
        let resolution = data.iter().map(|d| d.resolution).fold(0.0, f64::max);
        // load, offset, direction, velocity; command minus position
        let mut rows: Vec<[f64; 5]> = Vec::new();
        for d in data {
            let moves = d.resolution / (STEPS_WITHIN * d.sample_s);
            for k in 1..d.time_s.len() {
                let v = d.velocity[k];
                if v.abs() > moves {
                    let error = d.gain * (d.command[k - 1] - d.position[k]);
                    rows.push([d.load[k], 1.0, v.signum(), v, error]);
                }
            }
        }
        let felt = |x: &[f64; 4]| x[0] > 0.0 && x[0] * load_range(data) > resolution;
        let solved = solve(&rows, true).filter(felt).map(|x| (Some(x[0]), x));
        let solved = solved.or_else(|| solve(&rows, false).map(|x| (None, x)));
        let (compliance, [_, offset, dry, velocity]) = solved.unwrap_or((None, [0.0; 4]));
        Self { compliance, offset, dry: dry.max(resolution), damping: velocity.max(sample_s) }
    }
}

/// Range of the load over all recordings \[N m or N\].
pub(super) fn load_range(data: &[JointData]) -> f64 {
    let all: Vec<f64> = data.iter().flat_map(|d| d.load.iter().copied()).collect();
    armident_numeric::range(&all)
}

fn solve(rows: &[[f64; 5]], with_load: bool) -> Option<[f64; 4]> {
    let first = usize::from(!with_load);
    let mut weights = vec![1.0; rows.len()];
    let mut found = None;
    for _ in 0..ROUNDS {
        let mut system = AccumulatedQr::new(4 - first);
        let weighted: Vec<Vec<f64>> = rows
            .iter()
            .zip(&weights)
            .map(|(row, w): (&[f64; 5], &f64)| row[first..].iter().map(|x| w * x).collect())
            .collect();
        if weighted.len() < 16 {
            return None;
        }
        system.push_rows(&weighted);
        let solution = system.solve(RANK_CUT).ok()?.solution;
        let mut x = [0.0; 4];
        x[first..].copy_from_slice(&solution);
        let residual: Vec<f64> = rows
            .iter()
            .map(|row| row[4] - x.iter().zip(row).map(|(x, a)| x * a).sum::<f64>())
            .collect();
        let mut sizes: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
        let middle = sizes.len() / 2;
        let scale = 1.4826 * order_statistic(&mut sizes, middle)?;
        if scale <= 0.0 {
            return Some(x);
        }
        for (w, r) in weights.iter_mut().zip(&residual) {
            *w = 1.0 / (1.0 + (r / (CAUCHY * scale)).powi(2)).sqrt();
        }
        found = Some(x);
    }
    found
}
