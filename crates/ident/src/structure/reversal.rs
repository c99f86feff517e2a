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

use armident_effects::{LawRole, MotionScale, ReversalModel};
use armident_inference::levels::{CLEAR_T, EXPECTED_T};
use armident_inference::significant_gain;
use armident_model::DEFAULT_SPEED_RESOLUTION;
use armident_motion::Motion;
use armident_numeric::NumericError;

use super::fold_errors::{fold_errors, has_folds};
use crate::regression::{BatchProblem, BatchSettings, JointRows, LAWS, Term};

/// Reversals to choose from, in shares of the motion of each joint.
#[derive(Debug, Clone)]
pub struct ReversalCandidates {
    /// the usual one first; none where velocities are exact
    tried: Vec<ReversalModel>,
    joints: Vec<MotionScale>,
}

impl ReversalCandidates {
    /// The usual reversal and all others, on joints that move like this.
    pub fn new(usual: ReversalModel, joints: Vec<MotionScale>) -> Self {
        let speeds = ReversalModel::SPEED_SHARES.map(ReversalModel::regularised);
        let travels = ReversalModel::TRAVEL_SHARES.map(ReversalModel::presliding);
        let others = speeds.into_iter().chain(travels).filter(|share| *share != usual);
        Self { tried: [usual].into_iter().chain(others).collect(), joints }
    }

    /// The candidate with the lowest errors on left-out folds for each joint, among those that lower them by more than
    /// `least` of their standard errors against the usual one.
    ///
    /// `fold_errors` gives the squared errors `[fold][joint]` with candidate `i` on every joint, which is the model by joint.
    ///
    /// # Errors
    /// Those of `fold_errors`.
    pub fn choose<E>(
        &self,
        least: impl Fn(usize, ReversalModel) -> f64,
        mut fold_errors: impl FnMut(usize, &[ReversalModel]) -> Result<Vec<Vec<f64>>, E>,
    ) -> Result<Vec<usize>, E> {
        let mut best = vec![(0.0, 0_usize); self.joints.len()];
        let mut before: Option<Vec<Vec<f64>>> = None;
        for (which, share) in self.tried.iter().enumerate() {
            let errors = fold_errors(which, &self.on_joints(which))?;
            let Some(before) = &before else {
                before = Some(errors);
                continue;
            };
            for (joint, best) in best.iter_mut().enumerate() {
                let gain = significant_gain(before, &errors, &[joint], least(joint, *share));
                if let Some(gain) = gain.filter(|gain| *gain > best.0) {
                    *best = (gain, which);
                }
            }
        }
        Ok(best.into_iter().map(|(_, which)| which).collect())
    }

    /// Candidate `which` as it is on each joint.
    fn on_joints(&self, which: usize) -> Vec<ReversalModel> {
        self.joints.iter().map(|joint| self.tried[which].on(joint)).collect()
    }

    /// Candidate `which` as it is on one joint.
    pub fn on(&self, joint: usize, which: usize) -> ReversalModel {
        self.tried[which].on(&self.joints[joint])
    }

    /// Those of the motions of `identify`; none where velocities are exact.
    pub(super) fn of(problem: &BatchProblem, motions: &[&Motion]) -> Self {
        if motions.iter().all(|m| m.filter.is_none()) {
            return Self { tried: Vec::new(), joints: Vec::new() };
        }
        let root_mean_square = |of: &dyn Fn(&Motion) -> &Vec<f64>, about: f64| {
            let squares: f64 =
                motions.iter().flat_map(|m| of(m)).map(|x| (x - about).powi(2)).sum();
            let count: usize = motions.iter().map(|m| m.len()).sum();
            (squares / count as f64).sqrt().max(f64::MIN_POSITIVE)
        };
        let duration = |m: &&Motion| match &m.time_s[..] {
            [first, .., last] => last - first,
            _ => 0.0,
        };
        let duration_s = motions.iter().map(duration).fold(0.0, f64::max);
        let scale = |joint: usize| {
            let all = || motions.iter().flat_map(|m| &m.position[joint]);
            let mean = all().sum::<f64>() / all().count() as f64;
            MotionScale {
                kind: problem.arm().joints[joint].kind,
                speed_rms: root_mean_square(&|m| &m.velocity[joint], 0.0),
                position_deviation: root_mean_square(&|m| &m.position[joint], mean),
                duration_s,
                temperature_c: None,
            }
        };
        let joints = motions.first().map_or(0, |m| m.velocity.len());
        Self::new(
            ReversalModel::regularised(DEFAULT_SPEED_RESOLUTION),
            (0..joints).map(scale).collect(),
        )
    }

    pub(super) fn usual(&self) -> Option<Vec<ReversalModel>> {
        (!self.tried.is_empty()).then(|| self.on_joints(0))
    }
}

/// Largest share of the speed below which a check regularises dry friction.
const FASTEST_OF_A_CHECK: f64 = 0.1;

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
        let mut candidates = ReversalCandidates::of(self, motions);
        candidates.tried.retain(|share| {
            matches!(share, ReversalModel::RegularisedSign { below } if *below <= FASTEST_OF_A_CHECK)
        });
        self.reversals = candidates.usual();
        let rows = self.rows_with_directions(motions, &candidates);
        if has_folds(&rows) && candidates.tried.len() > 1 {
            let settings = BatchSettings::default();
            let least = |_, _| EXPECTED_T;
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
        let others = 1..candidates.tried.len().max(1);
        let moved = usual.arm_motions(motions);
        usual.accumulate_with(
            motions,
            |index, joint, effort| {
                let jumping = usual.jumping_columns(joint, motions[index]);
                let mut columns =
                    usual.columns_beside(joint, motions[index], &moved[index], &jumping);
                let others: Vec<ReversalModel> =
                    others.clone().map(|which| candidates.on(joint, which)).collect();
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
        (candidates, least): (&ReversalCandidates, fn(usize, ReversalModel) -> f64),
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
        if candidates.tried.is_empty() {
            return Ok(ChosenReversals { reversals: None, rows: with(&vec![0; n]) });
        }
        let errors = |which, _: &[ReversalModel]| {
            fold_errors(wanted, &with(&vec![which; n]).select(self, wanted), settings)
        };
        let which = candidates.choose(least, errors)?;
        let chosen = |(joint, &which): (usize, &usize)| candidates.on(joint, which);
        let reversals = Some(which.iter().enumerate().map(chosen).collect());
        Ok(ChosenReversals { reversals, rows: with(&which) })
    }
}

/// Number of standard errors by which a reversal must lower the errors of left-out folds against the usual one.
pub(super) fn least_gain(_joint: usize, share: ReversalModel) -> f64 {
    match share {
        ReversalModel::RegularisedSign { below } if below < DEFAULT_SPEED_RESOLUTION => EXPECTED_T,
        _ => CLEAR_T,
    }
}

/// The reversals of all joints, and the rows that have them.
pub(super) struct ChosenReversals {
    pub(super) reversals: Option<Vec<ReversalModel>>,
    pub(super) rows: JointRows,
}
