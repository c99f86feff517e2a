//! How dry friction of each joint reverses, chosen on left-out folds.
//!
//! Method: dry friction of a stiff drive jumps at a reversal; the smallest share of the speed only keeps the noise of the
//! velocity out. A drive train that winds up first reverses its friction over some hundredths of the working speed
//! (regularised Coulomb friction) or some thousandths of a radian (presliding friction); a column that jumps there puts
//! the difference into viscous friction and inertia. Each joint takes the candidate with the lowest errors on left-out
//! folds, if it is significantly lower than that of the usual one.
//!
//! References: P. R. Dahl, A solid friction model (1968); B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of
//! models, analysis tools and compensation methods for the control of machines with friction, Automatica 30 (1994); the
//! choice is own.

use armident_effects::{LawRole, ReversalModel};
use armident_inference::levels::{CLEAR_T, EXPECTED_T};
use armident_model::DEFAULT_SPEED_RESOLUTION;
use armident_motion::Motion;
use armident_numeric::NumericError;

use super::fold_errors::{fold_errors, has_folds};
use crate::regression::{BatchProblem, BatchSettings, JointRows, LAWS, Term};
use armident_inference::significant_gain;

/// Speeds below which friction may be regularised, as shares of a joint's RMS speed, the usual one first,
const SPEED_SHARES: [f64; 4] = [DEFAULT_SPEED_RESOLUTION, 0.005, 0.02, 0.1];
/// and those of drive trains that wind up far.
const FAR_SPEED_SHARES: [f64; 2] = [0.2, 0.3];

impl BatchProblem {
    /// Chooses only the speed below which each joint's dry friction is regularised: a check looks for a lag of the efforts
    /// first, which presliding friction would absorb.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn choose_reversal_speeds(&mut self, motions: &[&Motion]) -> Result<(), NumericError> {
        let mut candidates = ReversalCandidates::of(motions);
        candidates.tried.retain(|turn| SPEED_SHARES.map(ReversalModel::regularised).contains(turn));
        self.reversals = candidates.usual();
        let rows = self.rows_with_directions(motions, &candidates);
        if has_folds(&rows) && candidates.tried.len() > 1 {
            let settings = BatchSettings::default();
            let least = |_| EXPECTED_T;
            let chosen = self.choose_reversals(&rows, self, (&candidates, least), &settings)?;
            self.reversals = chosen.reversals;
        }
        Ok(())
    }

    /// Rows with the usual reversal, and behind their columns the directions of the other candidates.
    pub(super) fn rows_with_directions(
        &self,
        motions: &[&Motion],
        candidates: &ReversalCandidates,
    ) -> JointRows {
        let mut usual = self.clone();
        usual.reversals = candidates.usual();
        let others = candidates.tried.get(1..).unwrap_or_default();
        let moved = usual.arm_motions(motions);
        usual.accumulate_with(
            motions,
            |index, joint, effort| {
                let jumping = usual.jumping_columns(joint, motions[index]);
                let mut columns =
                    usual.columns_beside(joint, motions[index], &moved[index], &jumping);
                let others: Vec<ReversalModel> =
                    others.iter().map(|of| candidates.on(joint, *of)).collect();
                columns.extend(usual.direction_columns(joint, motions[index], &others));
                (columns, effort.to_vec())
            },
            |joint| usual.by_joint[joint].len() + others.len(),
        )
    }

    /// From rows with the directions of all candidates behind the columns of this problem: the
    /// reversals with which `wanted` predicts best, and the rows that have them.
    pub(super) fn choose_reversals(
        &self,
        rows: &JointRows,
        wanted: &BatchProblem,
        (candidates, least): (&ReversalCandidates, fn(ReversalModel) -> f64),
        settings: &BatchSettings,
    ) -> Result<ChosenReversals, NumericError> {
        let n = self.by_joint.len();
        let with = |which: &[usize]| -> JointRows {
            let places: Vec<Vec<usize>> = (0..n)
                .map(|joint| {
                    let terms = &self.by_joint[joint];
                    let of_term = |(place, &k): (usize, &usize)| match self.terms[k] {
                        Term::Effect { effect, .. }
                            if which[joint] > 0
                                && LAWS[effect].law().roles.contains(&LawRole::Dry) =>
                        {
                            terms.len() + which[joint] - 1
                        }
                        _ => place,
                    };
                    terms.iter().enumerate().map(of_term).collect()
                })
                .collect();
            rows.with_places(&places)
        };
        let mut best = vec![(0.0, 0_usize); n];
        let mut before: Option<Vec<Vec<f64>>> = None;
        for which in 0..candidates.tried.len() {
            let rows = with(&vec![which; n]).select(self, wanted);
            let errors = fold_errors(wanted, &rows, settings)?;
            let Some(before) = &before else {
                before = Some(errors);
                continue;
            };
            for (joint, best) in best.iter_mut().enumerate() {
                let gain =
                    significant_gain(before, &errors, &[joint], least(candidates.tried[which]));
                if let Some(gain) = gain.filter(|gain| *gain > best.0) {
                    *best = (gain, which);
                }
            }
        }
        let which: Vec<usize> = best.into_iter().map(|(_, which)| which).collect();
        let chosen =
            |(joint, &which): (usize, &usize)| candidates.on(joint, candidates.tried[which]);
        let found =
            (!candidates.tried.is_empty()).then(|| which.iter().enumerate().map(chosen).collect());
        Ok(ChosenReversals { reversals: found, rows: with(&which) })
    }
}

/// Number of standard errors by which a reversal must lower the errors of left-out folds against the usual one.
pub(super) fn least_gain(turn: ReversalModel) -> f64 {
    match turn {
        ReversalModel::RegularisedSign { below } if below < DEFAULT_SPEED_RESOLUTION => EXPECTED_T,
        _ => CLEAR_T,
    }
}

/// The reversals of all joints, and the rows that have them.
pub(super) struct ChosenReversals {
    pub(super) reversals: Option<Vec<ReversalModel>>,
    pub(super) rows: JointRows,
}

/// Reversals that dry friction may have, the usual one first: regularised below a share of a joint's RMS speed, or
/// presliding over a share of the standard deviation of its position.
pub(super) struct ReversalCandidates {
    /// shares; none where velocities are exact
    tried: Vec<ReversalModel>,
    rms_speed: Vec<f64>,
    deviation: Vec<f64>,
}

impl ReversalCandidates {
    pub(super) fn of(motions: &[&Motion]) -> Self {
        let joints = motions.first().map_or(0, |m| m.velocity.len());
        let root_mean_square = |of: &dyn Fn(&Motion) -> &Vec<f64>, about: f64| {
            let squares: f64 =
                motions.iter().flat_map(|m| of(m)).map(|x| (x - about).powi(2)).sum();
            let count: usize = motions.iter().map(|m| m.len()).sum();
            (squares / count as f64).sqrt().max(f64::MIN_POSITIVE)
        };
        let rms_speed = |joint: usize| root_mean_square(&|m| &m.velocity[joint], 0.0);
        let deviation = |joint: usize| {
            let all = || motions.iter().flat_map(|m| &m.position[joint]);
            let mean = all().sum::<f64>() / all().count() as f64;
            root_mean_square(&|m| &m.position[joint], mean)
        };
        let exact = motions.iter().all(|m| m.filter.is_none());
        let speeds =
            SPEED_SHARES.into_iter().chain(FAR_SPEED_SHARES).map(ReversalModel::regularised);
        let all = speeds.chain(ReversalModel::TRAVEL_SHARES.map(ReversalModel::presliding));
        Self {
            tried: if exact { Vec::new() } else { all.collect() },
            rms_speed: (0..joints).map(rms_speed).collect(),
            deviation: (0..joints).map(deviation).collect(),
        }
    }

    /// A share as it is on a joint.
    fn on(&self, joint: usize, share: ReversalModel) -> ReversalModel {
        match share {
            ReversalModel::RegularisedSign { below } => {
                ReversalModel::regularised(below * self.rms_speed[joint])
            }
            ReversalModel::Presliding { travel } => {
                ReversalModel::presliding(travel * self.deviation[joint])
            }
        }
    }

    pub(super) fn usual(&self) -> Option<Vec<ReversalModel>> {
        let usual = *self.tried.first()?;
        Some((0..self.rms_speed.len()).map(|joint| self.on(joint, usual)).collect())
    }
}
