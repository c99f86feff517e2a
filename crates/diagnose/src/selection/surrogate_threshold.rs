//! Surrogate threshold: effort that columns unrelated to the efforts explain on a joint of these recordings.
//!
//! White noise leaves little of it. Model discrepancy is autocorrelated, and any column with a similar correlation time explains
//! part of it. The amount is measured with columns of the library that are shifted in time.
//!
//! Hypothesis: a column is unrelated to the efforts; its explained mean square is a scaled chi-squared variable.
//! References: J. Theiler, S. Eubank, A. Longtin, B. Galdrikian, J. D. Farmer, Testing for nonlinearity in time series: the
//! method of surrogate data, Physica D 58, 1992.

use armident_effects::Baseline;
use armident_inference::chi_square_quantile;
use armident_numeric::dot;
use rayon::prelude::*;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::regression::fit_set::Estimate;
use crate::regression::marginalised::Marginalised;
use armident_inference::levels::CHANGE_ERROR;

/// Surrogate terms a joint: their mean is then known to a fifth.
const TERMS: usize = 40;
/// Steps of the golden ratio spread the shifts, whatever their number.
const GOLDEN: f64 = 0.618_033_988_75;

/// Effort that surrogate terms explain.
pub(crate) struct SurrogateThreshold {
    /// `[joint]`: mean square effort that a column explains, in squared standard deviations of one recorded sample
    square: Vec<f64>,
    /// candidates that there were to choose from
    choices: usize,
}

impl SurrogateThreshold {
    /// No threshold.
    pub(crate) fn none(joints: usize) -> Self {
        Self { square: vec![0.0; joints], choices: 1 }
    }

    /// Of surrogate terms beside an estimate.
    pub(crate) fn beside(metric: &Marginalised<'_>, of: &Estimate) -> Self {
        let problem = metric.problem;
        let (mut small, ids) = problem.restricted(&of.set);
        let first = small.columns.len();
        let joints = problem.observations.joints();
        let mut joint_of = Vec::new();
        for j in 0..joints {
            let shifted = shifted_columns(metric, j);
            joint_of.extend(shifted.iter().map(|_| j));
            let blocks = shifted.into_iter().map(|column| {
                let mut blocks = vec![Vec::new(); joints];
                blocks[j] = column;
                blocks
            });
            small.push_columns(blocks.collect());
        }
        let mut square = vec![0.0; joints];
        let marginalised = small.marginalised(metric.scale, &metric.inflated);
        let Some(fit) = marginalised.fit(marginalised.columns_of(&ids)) else {
            return Self::none(joints);
        };
        let explained: Vec<f64> = joint_of
            .par_iter()
            .enumerate()
            .map(|(k, &j)| {
                let column = &small.columns[first + k][j];
                let in_metric = dot(column, column).max(f64::MIN_POSITIVE);
                let size = small.observations.in_sample_noise(j, column).powi(2);
                marginalised.gain(&fit, &[first + k]) * size / in_metric
            })
            .collect();
        for (j, square) in square.iter_mut().enumerate() {
            let of_joint: Vec<f64> = explained
                .iter()
                .zip(&joint_of)
                .filter(|(_, of)| **of == j)
                .map(|(x, _)| *x)
                .collect();
            *square = of_joint.iter().sum::<f64>() / of_joint.len().max(1) as f64;
        }
        Self { square, choices: problem.candidates.len() }
    }

    /// 99 % threshold of a candidate of so many columns on a joint, family-wise over all candidates; in noise levels.
    pub(crate) fn least(&self, joint: usize, columns: usize) -> f64 {
        let tail = CHANGE_ERROR / self.choices as f64;
        let quantile = chi_square_quantile(1.0 - tail, columns.max(1) as f64).unwrap_or(0.0);
        (self.square[joint] * quantile).sqrt()
    }
}

/// Columns of laws on a joint, each shifted in time within its recording.
fn shifted_columns(metric: &Marginalised<'_>, joint: usize) -> Vec<Vec<f64>> {
    let problem = metric.problem;
    let starts = &problem.observations.starts;
    let is_law = |candidate: &&Candidate| {
        matches!(candidate.kind, CandidateKind::Law(_))
            && candidate.location.joints == [joint]
            && candidate.location.window.is_none()
            && candidate.transform.is_none()
            && !candidate.moves_its_link()
            && candidate.has(|law| law.baseline != Some(Baseline::Offset))
    };
    let mut columns: Vec<usize> = problem
        .candidates
        .iter()
        .filter(is_law)
        .flat_map(|candidate| candidate.columns.iter().copied())
        .collect();
    columns.sort_unstable();
    columns.dedup();
    if columns.is_empty() {
        return Vec::new();
    }
    (0..TERMS)
        .map(|k| {
            // between a quarter and three quarters of the recording
            let shift = 0.25 + 0.5 * ((GOLDEN * (k + 1) as f64) % 1.0);
            let chosen = columns[k * columns.len() / TERMS % columns.len()];
            let mut column = problem.columns[chosen][joint].clone();
            let rows = column.len();
            for pair in starts.windows(2).filter(|pair| pair[1] <= rows) {
                let of_recording = &mut column[pair[0]..pair[1]];
                of_recording.rotate_left((shift * of_recording.len() as f64) as usize);
            }
            column
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::training::Design;
    use crate::regression::fit_set::fit_set;
    use crate::selection::materiality::{LEAST, band_noise};
    use crate::test_arms::{swung, ur5};
    use armident_model::OperatingPoint;

    /// A surrogate column explains one part of white noise in as many as there are independent samples; of noise with a
    /// correlation time of half a second, several times more.
    #[test]
    fn autocorrelated_residual_raises_surrogate_threshold() {
        const JOINT: usize = 2;
        let chain = ur5();
        // Knuth's generator, from 0 to 1
        let drawn = |k: usize| {
            let mixed = (k as u64 + 1).wrapping_mul(6_364_136_223_846_793_005);
            let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(1_442_695_040_888_963_407);
            (mixed >> 40) as f64 / (1_u64 << 24) as f64
        };
        let chance = |lasting_nm: f64| {
            let mut recorded = swung(&chain, 0.1, |_, _| 0.0);
            for (t, effort) in recorded.effort[JOINT].iter_mut().enumerate() {
                *effort += 0.1 * (drawn(t) - 0.5) + lasting_nm * (drawn(1_000_000 + t / 100) - 0.5);
            }
            // the noise of the recording has as much power, but little in the band
            let design = Design::new(&chain, vec![recorded]);
            let problem = design.problem(&OperatingPoint::of(design.joints()));
            let metric = problem.marginalised(0.0, &[]);
            let found = SurrogateThreshold::beside(&metric, &fit_set(&metric, Vec::new()).unwrap());
            let independent =
                problem.observations.weights.share * problem.observations.len() as f64;
            let share = found.square[JOINT] * independent / band_noise(&problem, JOINT).powi(2);
            (share, found.least(JOINT, 1), found.least(JOINT, 2))
        };
        let (of_noise, one, two) = chance(0.0);
        let (of_lasting, lasting, _) = chance(0.1);
        assert!((0.4..2.5).contains(&of_noise), "{of_noise}");
        assert!(one < two && two < 0.5 * LEAST, "{one} {two}");
        assert!(of_lasting > 4.0 * of_noise && lasting > one, "{of_lasting} {of_noise} {lasting}");
    }
}
