//! Windows of time in which a constant force on the tip explains the residual.

use std::ops::Range;
use std::sync::OnceLock;

use armident_effects::{ExternalContact, LawRole};
use armident_motion::BandMotion;
use armident_numeric::range;
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
/// Parts of a window, in each of which a lasting force explains something, and the least share of the whole there or on a
/// second joint: a quarter of what an even force does.
const PARTS: usize = 4;
const LEAST_PART: f64 = 0.06;
/// Most rows of a window that were not measured: a gap in it that was interpolated, a channel that was held or clipped.
const MOST_UNMEASURED: f64 = 0.1;
/// Samples on a straight line that no channel with noise shows: the odds of quantised noise are a third a sample.
const STRAIGHT: usize = 8;
/// Length of the ramps at both ends \[s\]: forces neither start nor stop at once.
const RAMP_S: f64 = 0.08;

/// `-Jᵀ` of the tip as recorded, as rows and at every sample.
pub(crate) struct ContactColumns {
    /// `[recording][axis][joint][sample]`
    samples: Vec<Vec<Vec<Vec<f64>>>>,
    /// `[axis]`, rows of all joints
    rows: Vec<Vec<Vec<f64>>>,
    /// `[recording][joint][row]`, formed when a window is first looked for
    unmeasured: OnceLock<Vec<Vec<Vec<bool>>>>,
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
        Self { samples, rows, unmeasured: OnceLock::new() }
    }

    /// Whether a force in these rows is a contact, and no row is to be doubted before that: it explains something in most
    /// parts of the window, so that no outliers do; on two joints, or on one in every part; and not where the efforts of
    /// the joint that it explains most were not measured.
    fn is_plausible(
        &self,
        rows: Range<usize>,
        force: &Vector3<f64>,
        residual: &[Vec<f64>],
        (unmeasured, start): (&[Vec<bool>], usize),
    ) -> bool {
        let joints = residual.len();
        // by joint and part: reduction of the sum of squares
        let mut explained = vec![[0.0; PARTS]; joints];
        for (j, of_joint) in explained.iter_mut().enumerate() {
            for k in rows.clone() {
                let at = |axis: usize| self.rows[axis][j].get(k).copied().unwrap_or(0.0);
                let by_force = force.dot(&Vector3::new(at(0), at(1), at(2)));
                let left = residual[j][k];
                let part = (k - rows.start) * PARTS / rows.len();
                of_joint[part] += left * left - (left - by_force).powi(2);
            }
        }
        let of_joint: Vec<f64> = explained.iter().map(|parts| parts.iter().sum()).collect();
        let total: f64 = of_joint.iter().sum();
        let coherent = of_joint.iter().filter(|x| **x > LEAST_PART * total).count();
        let of_part = |part: usize| explained.iter().map(|parts| parts[part]).sum::<f64>();
        let parts = (0..PARTS).filter(|part| of_part(*part) > LEAST_PART * total).count();
        let most = (0..joints).max_by(|a, b| of_joint[*a].total_cmp(&of_joint[*b])).unwrap_or(0);
        let doubtful = rows.clone().filter(|k| unmeasured[most][k - start]);
        parts >= if coherent > 1 { PARTS - 1 } else { PARTS }
            && (doubtful.count() as f64) < MOST_UNMEASURED * rows.len() as f64
    }

    /// The best window of each recording: `(gain, recording, [from, to])`.
    fn windows(&self, design: &Design<'_>, residual: &[Vec<f64>]) -> Vec<(f64, usize, [f64; 2])> {
        let mut best = Vec::new();
        let unmeasured =
            self.unmeasured.get_or_init(|| design.signals.iter().map(unmeasured_rows).collect());
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
                    if gain > LEAST_GAIN
                        && found.is_none_or(|f| gain > f.0)
                        && self.is_plausible(
                            first + from..first + to,
                            &cholesky.solve(&moment),
                            residual,
                            (&unmeasured[r], first),
                        )
                    {
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

/// By joint and row: whether the effort there was not measured, but held, clipped or interpolated: it runs along a straight
/// line for longer than noise does.
fn unmeasured_rows(signals: &BandMotion) -> Vec<Vec<bool>> {
    let efforts = signals.with_known_effort(signals.effort.clone());
    efforts.iter().map(|effort| rows_of(signals, &straight(effort))).collect()
}

/// Samples on straight lines.
fn straight(samples: &[f64]) -> Vec<bool> {
    let range = range(samples);
    let mut on_line = vec![false; samples.len()];
    let mut from = 0;
    for k in 0..samples.len() {
        let is_kinked =
            k < 2 || (samples[k] - 2.0 * samples[k - 1] + samples[k - 2]).abs() > 1e-9 * range;
        if is_kinked {
            from = k.saturating_sub(1);
        }
        if k + 1 - from >= STRAIGHT {
            on_line[from..=k].fill(true);
        }
    }
    on_line
}

/// Rows that such samples are most of.
fn rows_of(signals: &BandMotion, samples: &[bool]) -> Vec<bool> {
    if samples.is_empty() {
        return vec![false; signals.band.kept.len()];
    }
    let samples: Vec<f64> = samples.iter().map(|x| f64::from(u8::from(*x))).collect();
    signals.band.rows(&samples).into_iter().map(|share| share > 0.5).collect()
}

/// 1 inside the window, ramps at its ends.
pub(crate) fn trapezoid(time_s: f64, window: [f64; 2]) -> f64 {
    let ramp = RAMP_S.min(0.5 * (window[1] - window[0])).max(f64::MIN_POSITIVE);
    ((time_s - window[0]) / ramp).min((window[1] - time_s) / ramp).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A channel that is held, and one that goes on along a line; noise and a short rest are measured.
    #[test]
    fn held_and_interpolated_samples_are_straight() {
        let noisy = |k: usize| ((k * 7919) % 101) as f64;
        let mut samples: Vec<f64> = (0..60).map(noisy).collect();
        samples[20..30].fill(50.0);
        for (k, x) in samples[40..52].iter_mut().enumerate() {
            *x = 3.0 * k as f64;
        }
        samples[10..13].fill(7.0);
        let found: Vec<usize> =
            straight(&samples).iter().enumerate().filter(|(_, x)| **x).map(|(k, _)| k).collect();
        assert_eq!(found, (20..30).chain(40..52).collect::<Vec<_>>());
    }
}
