//! What comes back by chance when a term is removed: of wrong terms, which have nothing to do with the efforts, on the
//! same joint of the same recordings.
//!
//! Noise explains little of it. What the model of an arm is imperfect by is no noise: it lasts, and any term that lasts
//! as long takes some of it. How much is measured here, by laws of the library whose columns are shifted in time.

use armident_numeric::dot;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::certain::CHANCE;
use crate::problem::{Group, Meaning};
use crate::search::Answer;
use crate::whitened::Whitened;

/// Wrong terms a joint: their mean is then known to a fifth.
const TERMS: usize = 40;
/// Steps of the golden ratio spread the shifts, whatever their number.
const GOLDEN: f64 = 0.618_033_988_75;

/// What wrong terms explain.
pub(crate) struct Chance {
    /// `[joint]`: mean square effort that a column explains, in squared standard deviations of one recorded sample
    square: Vec<f64>,
    /// groups that there were to choose from
    choices: usize,
}

impl Chance {
    /// None explains anything.
    pub(crate) fn none(joints: usize) -> Self {
        Self { square: vec![0.0; joints], choices: 1 }
    }

    /// Of wrong terms beside an answer.
    pub(crate) fn beside(metric: &Whitened<'_>, of: &Answer) -> Self {
        let problem = metric.problem;
        let (mut small, ids) = problem.restricted(&of.set);
        let first = small.columns.len();
        let joints = problem.rows.joints();
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
        let whitened = small.whitened(metric.scale, &metric.wide);
        let Some(fit) = whitened.fit(whitened.columns_of(&ids)) else { return Self::none(joints) };
        let explained: Vec<f64> = joint_of
            .par_iter()
            .enumerate()
            .map(|(k, &j)| {
                let column = &small.columns[first + k][j];
                let in_metric = dot(column, column).max(f64::MIN_POSITIVE);
                let size = small.rows.in_sample_noise(j, column).powi(2);
                whitened.gain(&fit, &[first + k]) * size / in_metric
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
        Self { square, choices: problem.groups.len() }
    }

    /// What a group of so many columns explains on a joint by chance once in a hundred recordings, however many groups
    /// there are to choose from; in standard deviations of one recorded sample.
    pub(crate) fn least(&self, joint: usize, columns: usize) -> f64 {
        let tail = CHANCE / self.choices as f64;
        let law = ChiSquared::new(columns.max(1) as f64).ok();
        (self.square[joint] * law.map_or(0.0, |law| law.inverse_cdf(1.0 - tail))).sqrt()
    }
}

/// Columns of laws on a joint, each shifted in time within its recording.
fn shifted_columns(metric: &Whitened<'_>, joint: usize) -> Vec<Vec<f64>> {
    let problem = metric.problem;
    let starts = &problem.rows.starts;
    let is_law = |group: &&Group| {
        matches!(group.meaning, Meaning::Law(_))
            && group.site.joints == [joint]
            && group.site.window.is_none()
            && group.transform.is_none()
            && !group.moves_its_link()
            && group.slug() != "torque_offset"
    };
    let mut columns: Vec<usize> = problem
        .groups
        .iter()
        .filter(is_law)
        .flat_map(|group| group.columns.iter().copied())
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
