//! Windows of time in which a constant force on the tip explains the residual.

use armident_effects::{ExternalContact, LawRole};
use nalgebra::{Matrix3, Vector3};

use crate::design::candidate::{Candidate, CandidateKind, Location};
use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;

/// Shortest and longest window \[s\], and the grid of its ends.
const SHORTEST_S: f64 = 0.32;
const LONGEST_S: f64 = 9.0;
const GRID_S: f64 = 0.12;
/// Least gain, in squared noise units, of a window worth offering: three components and two ends
/// searched among some ten thousand windows.
const LEAST_GAIN: f64 = 150.0;
/// Length of the ramps at both ends \[s\]: forces neither start nor stop at once.
const RAMP_S: f64 = 0.08;

/// `-Jᵀ` of the tip as recorded, as rows and at every sample.
pub(crate) struct ContactColumns {
    /// `[recording][axis][joint][sample]`
    samples: Vec<Vec<Vec<Vec<f64>>>>,
    /// `[axis]`, rows of all joints
    rows: Vec<Vec<Vec<f64>>>,
}

impl ContactColumns {
    pub(crate) fn new(design: &Design<'_>, at: &[Posed<'_>]) -> Self {
        let samples: Vec<Vec<Vec<Vec<f64>>>> = at
            .iter()
            .map(|at| at.recorded_arm_columns(&ExternalContact, 0, design.chain))
            .collect();
        let rows = (0..3)
            .map(|axis| {
                let pieces: Vec<Vec<Vec<f64>>> = samples.iter().map(|s| s[axis].clone()).collect();
                design.arm_blocks(&pieces)
            })
            .collect();
        Self { samples, rows }
    }

    /// The best window of each recording: `(gain, recording, [from, to])`.
    fn windows(&self, design: &Design<'_>, residual: &[Vec<f64>]) -> Vec<(f64, usize, [f64; 2])> {
        let mut best = Vec::new();
        for (r, signals) in
            design.signals.iter().enumerate().skip(design.observations.comparison.first_judged())
        {
            let (first, end) = (design.observations.starts[r], design.observations.starts[r + 1]);
            let mut products = vec![Matrix3::<f64>::zeros()];
            let mut moments = vec![Vector3::<f64>::zeros()];
            for k in first..end {
                let (mut product, mut moment) = (products[k - first], moments[k - first]);
                for j in 0..design.joints() {
                    let at = |axis: usize| self.rows[axis][j].get(k).copied().unwrap_or(0.0);
                    let force = Vector3::new(at(0), at(1), at(2));
                    product += force * force.transpose();
                    moment += force * residual[j][k];
                }
                products.push(product);
                moments.push(moment);
            }
            let rows_hz = signals.band.rows_hz;
            let count = |seconds: f64| (seconds * rows_hz).round().max(1.0) as usize;
            let step = count(GRID_S);
            let mut found: Option<(f64, usize, [f64; 2])> = None;
            for from in (0..end - first).step_by(step) {
                for to in (from + count(SHORTEST_S)..=(from + count(LONGEST_S)).min(end - first))
                    .step_by(step)
                {
                    let product = products[to] - products[from];
                    let moment = moments[to] - moments[from];
                    let ridge = Matrix3::identity() * (1e-6 * product.trace() + f64::MIN_POSITIVE);
                    let Some(cholesky) = (product + ridge).cholesky() else { continue };
                    let gain = moment.dot(&cholesky.solve(&moment));
                    if gain > LEAST_GAIN && found.is_none_or(|f| gain > f.0) {
                        let time = |row: usize| {
                            let kept = &signals.band.kept;
                            signals.time_s[kept[row.min(kept.len() - 1)]]
                        };
                        found = Some((gain, r, [time(from), time(to)]));
                    }
                }
            }
            best.extend(found);
        }
        best
    }

    /// Adds a candidate for a window; gives its id.
    pub(crate) fn push(
        &self,
        design: &Design<'_>,
        problem: &mut LinearProblem,
        recording: usize,
        window: [f64; 2],
    ) -> usize {
        let columns = (0..3)
            .map(|axis| {
                let pieces: Vec<Vec<Vec<f64>>> = self
                    .samples
                    .iter()
                    .enumerate()
                    .map(|(r, samples)| {
                        let time = &design.signals[r].time_s;
                        let inside =
                            |t: f64| if r == recording { trapezoid(t, window) } else { 0.0 };
                        samples[axis]
                            .iter()
                            .map(|c| c.iter().zip(time).map(|(x, t)| x * inside(*t)).collect())
                            .collect()
                    })
                    .collect();
                problem.push_columns(vec![design.arm_blocks(&pieces)])
            })
            .collect();
        problem.candidates.push(Candidate {
            kind: CandidateKind::Law(&ExternalContact),
            location: Location { joints: Vec::new(), window: Some((recording, window)) },
            shape: window.to_vec(),
            columns,
            searched: 2,
            places: vec![LawRole::Contact],
            transform: None,
            hidden: Vec::new(),
            above_band: 1.0,
            is_of_size_one: false,
        });
        problem.candidates.len() - 1
    }

    /// Adds a candidate for the best window of each recording that is not there yet; gives their ids.
    pub(crate) fn offer(
        &self,
        design: &Design<'_>,
        problem: &mut LinearProblem,
        residual: &[Vec<f64>],
    ) -> Vec<usize> {
        let mut offered = Vec::new();
        for (_, recording, window) in self.windows(design, residual) {
            let close = |a: [f64; 2]| {
                (a[0] - window[0]).abs() < GRID_S && (a[1] - window[1]).abs() < GRID_S
            };
            let known = problem
                .candidates
                .iter()
                .any(|g| g.location.window.is_some_and(|(r, w)| r == recording && close(w)));
            if !known {
                offered.push(self.push(design, problem, recording, window));
            }
        }
        offered
    }
}

/// 1 inside the window, ramps at its ends.
pub(crate) fn trapezoid(time_s: f64, window: [f64; 2]) -> f64 {
    let ramp = RAMP_S.min(0.5 * (window[1] - window[0])).max(f64::MIN_POSITIVE);
    ((time_s - window[0]) / ramp).min((window[1] - time_s) / ramp).clamp(0.0, 1.0)
}
