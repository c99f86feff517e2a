//! Transmissions that neighbouring joints share, chosen by cross-validation.
//!
//! The last motors of a wrist often drive their joint through the one before: their friction acts on the sum of both
//! speeds, and on both joints.
//!
//! Method: forward selection over pairs of neighbours. A pair is taken where the errors of left-out folds are
//! significantly lower with it, by a tenth at least; its ratio is the one that lowers the training error of both joints
//! most.
//!
//! References: own; coupled wrists in W. Khalil, E. Dombre, Modeling, Identification and Control of Robots (2002).

use armident_effects::MotionScale;
use armident_inference::levels::CLEAR_T;
use armident_numeric::NumericError;

use super::fold_errors::fold_errors;
use crate::regression::{BatchProblem, BatchSettings, Coupling, JointRows, SHARED, noise_of};
use armident_inference::significant_gain;

/// Share by which the error of left-out folds must fall (geometric mean of both joints),
const LEAST_GAIN: f64 = 0.1;

/// A coupling that the recordings show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CouplingFound {
    /// Which.
    pub coupling: Coupling,
    /// Share by which the error of both joints falls where it was not fitted (geometric mean).
    pub gain: f64,
}

impl BatchProblem {
    /// All couplings that the law offers of neighbours without a dead zone.
    pub(super) fn coupling_candidates(&self) -> Vec<Coupling> {
        (1..self.by_joint.len())
            .filter(|&second| !self.has_dead_zone[second - 1] && !self.has_dead_zone[second])
            .flat_map(|second| {
                let kind = self.arm().joints[second].kind;
                let scale = MotionScale {
                    kind,
                    speed_rms: 1.0,
                    position_deviation: 1.0,
                    duration_s: 1.0,
                    temperature_c: None,
                };
                let shapes = SHARED.shapes(&scale).into_iter();
                shapes.map(move |shape| Coupling { first: second - 1, ratio: shape[0] })
            })
            .collect()
    }

    /// The couplings that rows with the columns of all possible ones show, the clearest first.
    pub(super) fn couplings_shown(
        &self,
        all: &BatchProblem,
        rows: &JointRows,
        settings: &BatchSettings,
    ) -> Result<Vec<CouplingFound>, NumericError> {
        let candidates = self.coupling_candidates();
        let mut found: Vec<CouplingFound> = Vec::new();
        loop {
            let chosen: Vec<Coupling> = found.iter().map(|f| f.coupling).collect();
            let without = self.with_couplings(&chosen);
            let mut before: Option<Vec<Vec<f64>>> = None;
            let mut best: Option<CouplingFound> = None;
            for first in 0..self.by_joint.len().saturating_sub(1) {
                if chosen.iter().any(|c| c.first == first) {
                    continue;
                }
                let of_pair: Vec<Coupling> =
                    candidates.iter().copied().filter(|c| c.first == first).collect();
                let Some(coupling) = self.nearest_ratio(all, rows, settings, &chosen, &of_pair)?
                else {
                    continue;
                };
                if before.is_none() {
                    let of_without = rows.select(all, &without);
                    before = Some(fold_errors(&without, &of_without, settings)?);
                }
                let with = self.with_couplings(&[&chosen[..], &[coupling]].concat());
                let after = fold_errors(&with, &rows.select(all, &with), settings)?;
                let gain = before.as_deref().and_then(|before| {
                    significant_gain(before, &after, &coupling.joints(), CLEAR_T)
                });
                let Some(gain) = gain else { continue };
                if gain > LEAST_GAIN && best.is_none_or(|best| gain > best.gain) {
                    best = Some(CouplingFound { coupling, gain });
                }
            }
            match best {
                Some(next) => found.push(next),
                None => return Ok(found),
            }
        }
    }

    /// The coupling of a pair that lowers the error of both joints most where it is fitted; none where
    /// that is too little already.
    fn nearest_ratio(
        &self,
        all: &BatchProblem,
        rows: &JointRows,
        settings: &BatchSettings,
        chosen: &[Coupling],
        of_pair: &[Coupling],
    ) -> Result<Option<Coupling>, NumericError> {
        let Some(first) = of_pair.first() else { return Ok(None) };
        let alone = |couplings: &[Coupling]| -> Result<f64, NumericError> {
            let problem = self.with_couplings(couplings);
            let mut left = 0.0;
            for joint in first.joints() {
                let triangle = rows.select_joint(all, &problem, joint);
                left += 0.5 * noise_of(&triangle, rows, joint)?.ln();
            }
            Ok(left)
        };
        let before = alone(chosen)?;
        let mut nearest: Option<(f64, Coupling)> = None;
        for &coupling in of_pair {
            let couplings = [chosen, &[coupling]].concat();
            // each joint with coefficients of its own: the most there is to gain
            if before - alone(&couplings)? < -(-LEAST_GAIN).ln_1p() {
                continue;
            }
            let with = self.with_couplings(&couplings);
            let left = error_of_both(&with, &rows.select(all, &with), coupling, settings)?;
            if nearest.is_none_or(|(least, _)| left < least) {
                nearest = Some((left, coupling));
            }
        }
        Ok(nearest.map(|(_, coupling)| coupling))
    }
}

/// Sum of the logarithms of the errors of both joints of a coupling.
fn error_of_both(
    problem: &BatchProblem,
    rows: &JointRows,
    coupling: Coupling,
    settings: &BatchSettings,
) -> Result<f64, NumericError> {
    let noise = problem.noise_alone(rows)?;
    let regularisation = problem.regularisation(settings)?;
    let values = problem.weighted(rows, &noise, &regularisation)?.answer.solution;
    let fits = problem.fit(rows, &values);
    Ok(coupling.joints().map(|joint| fits[joint].rmse.ln()).iter().sum::<f64>())
}
