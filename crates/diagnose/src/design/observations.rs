//! Rows of the comparison: weights, noise, and how columns become rows.

use std::ops::Range;

use armident_motion::BandMotion;

use crate::design::comparison::Comparison;

/// Most weight of a row in which its joint sticks: its friction is then no function of its motion.
const STUCK_WEIGHT: f64 = 0.15;
/// Residual at rest, in noise levels, that leaves rows at rest no weight while that residual is measured.
const AT_REST_UNKNOWN: f64 = 1e3;
/// Share of a row's kernel over stuck samples (or other samples that are excluded) from which on the
/// row counts as stuck.
const STUCK_SHARE: f64 = 0.12;

/// A quantity on all joints, in weighted rows; empty where it is zero.
pub(crate) type JointColumns = Vec<Vec<f64>>;

/// Which rows of a recording count as these samples do.
fn touched(signals: &BandMotion, samples: &[bool]) -> impl Iterator<Item = bool> {
    let samples: Vec<f64> = samples.iter().map(|b| f64::from(u8::from(*b))).collect();
    signals.band.rows(&samples).into_iter().map(|share| share > STUCK_SHARE)
}

/// Weights of the rows: each iteration of the selection makes a value of its own.
#[derive(Debug, Clone)]
pub(crate) struct Weights {
    /// `[joint][row]`: one over the noise in the band, less where the joint sticks; 0 without effort
    by_row: JointColumns,
    /// independent samples per row
    pub(crate) share: f64,
    /// `[joint]`, 1 or more: factor by which model discrepancy lowers the weights of judged rows
    pub(crate) discrepancy: Vec<f64>,
    /// the same before a change
    pub(crate) discrepancy_before: Vec<f64>,
    /// `[joint]`: residual of a rest, in noise levels; 0 before it is known
    at_rest: Vec<f64>,
}

/// Weight of a row in a rest of so many rows that has this residual, in noise levels.
///
/// A joint that rests answers with any effort between the breakaway levels: one unknown value for the whole rest. The rest
/// is an interval, then: one observation whose deviation is that residual, however many rows record it.
fn weight_at_rest(residual: f64, rows: usize) -> f64 {
    let of_friction = (residual * residual - 1.0).max(0.0);
    STUCK_WEIGHT.min((1.0 + of_friction * rows as f64).sqrt().recip())
}

/// Number of rows of the rest that each row is in, 1 where the joint moves.
fn rows_of_dwells(stuck: &[bool]) -> Vec<usize> {
    let of_run = |run: &[bool]| vec![if run[0] { run.len() } else { 1 }; run.len()];
    stuck.chunk_by(|a, b| a == b).flat_map(of_run).collect()
}

impl Weights {
    /// The same with so many independent samples per row.
    pub(crate) fn with_share(self, share: f64) -> Self {
        Self { share, ..self }
    }
}

/// The rows of every joint: recordings one after the other.
#[derive(Debug, Clone)]
pub(crate) struct Observations {
    /// `[joint][row]`: noise in the band \[N m or N\]
    pub(crate) deviation: JointColumns,
    /// `[joint]`: noise of one recorded sample \[N m or N\]
    pub(crate) sample_deviation: Vec<f64>,
    /// first row of each recording, and the number of rows
    pub(crate) starts: Vec<usize>,
    /// rows per second of the first recording
    pub(crate) rows_hz: f64,
    /// `[joint][row]`
    pub(crate) stuck: Vec<Vec<bool>>,
    /// `[joint][row]`: rows of the rest it is in
    rows_of_rest: Vec<Vec<usize>>,
    pub(crate) comparison: Comparison,
    /// first recording in which laws act: the first judged, or the first of all where they may have acted before
    laws_from: usize,
    pub(crate) weights: Weights,
}

impl Observations {
    /// `inertia`: `[recording][joint i][joint j]`, root mean square of the inertia matrix: through it
    /// the noise of differentiated encoders comes into the efforts.
    pub(crate) fn new(signals: &[BandMotion], inertia: &[Vec<Vec<f64>>]) -> Self {
        let joints = signals[0].position.len();
        let mut starts = vec![0];
        for s in signals {
            starts.push(starts[starts.len() - 1] + s.band.kept.len());
        }
        let weights = Weights {
            by_row: vec![Vec::new(); joints],
            share: signals.iter().map(|s| s.band.independent_share()).sum::<f64>()
                / signals.len() as f64,
            discrepancy: vec![1.0; joints],
            discrepancy_before: vec![1.0; joints],
            at_rest: vec![0.0; joints],
        };
        let mut rows = Self {
            deviation: vec![Vec::new(); joints],
            sample_deviation: vec![0.0; joints],
            stuck: vec![Vec::new(); joints],
            rows_of_rest: vec![Vec::new(); joints],
            rows_hz: signals[0].band.rows_hz,
            starts,
            comparison: Comparison::AgainstModel,
            laws_from: 0,
            weights,
        };
        for j in 0..joints {
            let mut squares = 0.0;
            for (r, s) in signals.iter().enumerate() {
                let from_effort = s.effort_noise_in_band[j].powi(2);
                let from_encoders: f64 =
                    (0..joints).map(|i| (inertia[r][j][i] * s.acceleration_noise[i]).powi(2)).sum();
                let deviation = (from_effort + from_encoders).sqrt();
                squares += s.effort_noise[j].powi(2) / signals.len() as f64;
                let stuck: Vec<bool> = touched(s, &s.stuck[j]).collect();
                rows.rows_of_rest[j].extend(rows_of_dwells(&stuck));
                for stuck in stuck {
                    let weight = if stuck { STUCK_WEIGHT } else { 1.0 };
                    let known = !s.effort[j].is_empty() && deviation > 0.0;
                    rows.weights.by_row[j].push(if known { weight / deviation } else { 0.0 });
                    rows.deviation[j].push(deviation);
                    rows.stuck[j].push(stuck);
                }
            }
            rows.sample_deviation[j] = squares.sqrt();
        }
        rows
    }

    pub(crate) fn joints(&self) -> usize {
        self.weights.by_row.len()
    }

    /// The same compared with those of its recordings before `from`.
    pub(crate) fn against_reference(self, from: usize) -> Self {
        Self { comparison: Comparison::AgainstReference { from }, laws_from: from, ..self }
    }

    /// The same with other weights.
    pub(crate) fn weighted(&self, weights: Weights) -> Self {
        Self { weights, ..self.clone() }
    }

    /// Weights without the judged rows of a joint at samples for which `unfit` holds, and the number of these.
    pub(crate) fn excluding(
        &self,
        signals: &[BandMotion],
        joint: usize,
        unfit: impl Fn(&BandMotion) -> Vec<bool>,
    ) -> (Weights, usize) {
        let mut weights = self.weights.clone();
        let mut excluded = 0;
        for (r, s) in signals.iter().enumerate().skip(self.comparison.first_judged()) {
            let rows = &mut weights.by_row[joint][self.starts[r]..self.starts[r + 1]];
            for (weight, unfit) in rows.iter_mut().zip(touched(s, &unfit(s))) {
                if unfit && *weight > 0.0 {
                    *weight = 0.0;
                    excluded += 1;
                }
            }
        }
        (weights, excluded)
    }

    /// Of every row, whether it counts as these samples of its recording do.
    pub(crate) fn rows_of(
        signals: &[BandMotion],
        samples: impl Fn(&BandMotion) -> Vec<bool>,
    ) -> Vec<bool> {
        signals.iter().flat_map(|s| touched(s, &samples(s)).collect::<Vec<bool>>()).collect()
    }

    /// Number of rows of one joint.
    pub(crate) fn len(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    /// Weighted rows counted as a whole one each: the sample size of the fit.
    pub(crate) fn effective(&self) -> f64 {
        (0..self.joints()).map(|j| self.effective_on(j)).sum()
    }

    /// The same of one joint.
    pub(crate) fn effective_on(&self, joint: usize) -> f64 {
        let of_rows = |rows: Range<usize>, discrepancy: f64| -> f64 {
            let rows =
                self.weights.by_row[joint][rows.clone()].iter().zip(&self.deviation[joint][rows]);
            rows.map(|(w, d)| (w * d * discrepancy).powi(2)).sum()
        };
        let judged = self.judged_from();
        of_rows(0..judged, self.weights.discrepancy_before[joint])
            + of_rows(judged..self.len(), self.weights.discrepancy[joint])
    }

    /// Weighted rows of joint `joint` from columns at every sample of each recording.
    pub(crate) fn form<'a>(
        &self,
        signals: &[BandMotion],
        joint: usize,
        columns: impl IntoIterator<Item = &'a [f64]>,
    ) -> Vec<f64> {
        let mut rows = Vec::with_capacity(self.len());
        for (s, column) in signals.iter().zip(columns) {
            rows.extend(s.band.rows(column));
        }
        self.weigh(joint, &mut rows);
        rows
    }

    fn weigh(&self, joint: usize, rows: &mut [f64]) {
        for (x, w) in rows.iter_mut().zip(&self.weights.by_row[joint]) {
            *x *= w;
        }
    }

    /// The same of a law: nothing before it acts.
    pub(crate) fn form_law<'a>(
        &self,
        signals: &[BandMotion],
        joint: usize,
        columns: impl IntoIterator<Item = &'a [f64]>,
    ) -> Vec<f64> {
        let mut rows = self.form(signals, joint, columns);
        self.fill_before_laws(&mut rows);
        rows
    }

    /// Weights rows of a law that are formed already.
    pub(crate) fn weigh_law(&self, joint: usize, rows: &mut [f64]) {
        self.weigh(joint, rows);
        self.fill_before_laws(rows);
    }

    /// The same with laws that act in all recordings.
    pub(crate) fn with_laws_throughout(&self) -> Self {
        Self { laws_from: 0, ..self.clone() }
    }

    /// Nothing in the rows before laws act.
    pub(crate) fn fill_before_laws(&self, rows: &mut [f64]) {
        rows[..self.starts[self.laws_from]].fill(0.0);
    }

    /// First judged row.
    pub(crate) fn judged_from(&self) -> usize {
        self.starts[self.comparison.first_judged()]
    }

    pub(crate) fn weight(&self, joint: usize) -> &[f64] {
        &self.weights.by_row[joint]
    }

    /// Weights for models that leave over so many times the noise of each joint: weights that do not know of it would
    /// let the discrepancy of one joint's model decide about all others.
    pub(crate) fn with_discrepancy(&self, discrepancy: Vec<f64>) -> Weights {
        let mut weights = self.weights.clone();
        let judged = self.judged_from();
        for (joint, factor) in discrepancy.iter().enumerate() {
            let change = weights.discrepancy[joint] / factor;
            weights.by_row[joint][judged..].iter_mut().for_each(|w| *w *= change);
        }
        Weights { discrepancy, ..weights }
    }

    /// The same of the reference.
    pub(crate) fn with_discrepancy_before(&self, discrepancy_before: Vec<f64>) -> Weights {
        let mut weights = self.weights.clone();
        let judged = self.judged_from();
        for (joint, factor) in discrepancy_before.iter().enumerate() {
            let change = weights.discrepancy_before[joint] / factor;
            weights.by_row[joint][..judged].iter_mut().for_each(|w| *w *= change);
        }
        Weights { discrepancy_before, ..weights }
    }

    /// Residual of the rows in which a joint rests, in noise levels: static friction is anything up to the breakaway effort,
    /// which may be many times the noise. None where it does not rest.
    pub(crate) fn residual_at_rest(&self, joint: usize, residual: &[f64]) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0);
        for (k, left) in residual.iter().enumerate() {
            let weight = self.weights.by_row[joint][k];
            if self.stuck[joint][k] && weight > 0.0 {
                sum += (left / (weight * self.deviation[joint][k])).powi(2);
                count += 1;
            }
        }
        (count > 0).then(|| (sum / f64::from(count)).sqrt())
    }

    /// Weights with which rows at rest decide nothing, so that a fit shows their residual.
    pub(crate) fn without_dwells(&self) -> Weights {
        self.with_residual_at_rest(vec![AT_REST_UNKNOWN; self.joints()])
    }

    /// Weights for these residuals of each joint at rest, in noise levels.
    pub(crate) fn with_residual_at_rest(&self, at_rest: Vec<f64>) -> Weights {
        let mut weights = self.weights.clone();
        for (joint, new) in at_rest.iter().enumerate() {
            let old = weights.at_rest[joint];
            let dwells = self.stuck[joint].iter().zip(&self.rows_of_rest[joint]);
            for (w, (is_stuck, rows)) in weights.by_row[joint].iter_mut().zip(dwells) {
                if *is_stuck {
                    *w *= weight_at_rest(*new, *rows) / weight_at_rest(old, *rows);
                }
            }
        }
        Weights { at_rest, ..weights }
    }

    /// Root mean square of weighted rows of one joint that do not stick, in units of the noise in the
    /// band, whatever the discrepancy in the weights.
    pub(crate) fn in_band_noise(&self, joint: usize, rows: &[f64]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (k, x) in rows.iter().enumerate().skip(self.judged_from()) {
            if !self.stuck[joint][k] && self.weights.by_row[joint][k] > 0.0 {
                sum += (x * self.weights.discrepancy[joint]).powi(2);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }

    /// Root mean square of weighted rows of one joint, over the rows that do not stick, back in the
    /// unit of the effort over the noise of one recorded sample.
    pub(crate) fn in_sample_noise(&self, joint: usize, rows: &[f64]) -> f64 {
        self.in_sample_noise_of(joint, rows, |_| true)
    }

    /// The same of those rows that are wanted.
    pub(crate) fn in_sample_noise_of(
        &self,
        joint: usize,
        rows: &[f64],
        is_wanted: impl Fn(usize) -> bool,
    ) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (k, x) in rows.iter().enumerate().skip(self.judged_from()) {
            if !self.stuck[joint][k] && self.weights.by_row[joint][k] > 0.0 && is_wanted(k) {
                sum += (x / self.weights.by_row[joint][k]).powi(2);
                count += 1;
            }
        }
        if count == 0 || self.sample_deviation[joint] == 0.0 {
            return 0.0;
        }
        (sum / f64::from(count)).sqrt() / self.sample_deviation[joint]
    }
}
