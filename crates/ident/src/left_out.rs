//! Choices made by the training recordings: what explains stretches of time that were not fitted.
//!
//! The recordings are cut into five stretches; each is predicted by a fit to the other four. That decides
//! how dry friction of each joint turns, which neighbours share a transmission, and whose friction
//! bends over the speed.
//! Errors of a model on motions it was fitted to would decide for whatever has more to fit with. How far the
//! robot description is believed is asked of all stretches together
//! (`BatchProblem::doubt_of_links`).

use armident_effects::{Place, ReversalModel};
use armident_motion::Motion;
use armident_numeric::{AccumulatedQr, NumericError};

use crate::batch::{BatchProblem, BatchSettings, LAWS, Term};
use crate::bending::BendFound;
use crate::coupling::{CouplingFound, rows_of};
use crate::rows::JointRows;
use armident_model::DEFAULT_SPEED_RESOLUTION;

/// Stretches of time that are left out in turn.
const FOLDS: usize = 5;
/// Friction that turns later than usual must be better by this many standard errors, from the stretches,
const LEAST_GAIN_IN_ERRORS: f64 = 2.0;
/// and by so many where it turns sooner, as the law says; and where columns are checked: friction that is left over must not
/// look like a fault.
const LEAST_GAIN_OF_SHARP: f64 = 1.0;
/// Speeds below which friction may turn, as shares of a joint's RMS speed, the usual one first,
const SPEED_SHARES: [f64; 4] = [DEFAULT_SPEED_RESOLUTION, 0.005, 0.02, 0.1];
/// and those of drive trains that wind up far.
const FAR_SPEED_SHARES: [f64; 2] = [0.2, 0.3];

/// What the recordings are asked for beside how dry friction turns and the doubt of the description.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sought {
    /// Transmissions that neighbours share.
    pub couplings: bool,
    /// Joints whose friction grows more slowly than the speed.
    pub bends: bool,
}

impl Sought {
    /// All of it.
    pub const ALL: Self = Self { couplings: true, bends: true };
    /// Nothing of it.
    pub const NOTHING: Self = Self { couplings: false, bends: false };
}

/// What the recordings chose.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// Transmissions that neighbours share, the clearest first.
    pub couplings: Vec<CouplingFound>,
    /// Joints whose friction grows more slowly than the speed, in their order.
    pub bends: Vec<BendFound>,
    /// The settings, with the doubt of the description that the recordings ask for.
    pub settings: BatchSettings,
}

impl BatchProblem<'_> {
    /// Chooses how each joint's dry friction turns and, where sought, the transmissions that neighbours share and the joints whose
    /// friction bends, which become unknowns of this problem; and how far the description is believed, where the settings
    /// believe it at all. Costs one accumulation with some columns more.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn choose(
        &mut self,
        motions: &[&Motion],
        settings: &BatchSettings,
        sought: Sought,
    ) -> Result<Chosen, NumericError> {
        let mut chosen = Chosen { couplings: Vec::new(), bends: Vec::new(), settings: *settings };
        let candidates = if sought.couplings { self.possible_couplings() } else { Vec::new() };
        let bends = if sought.bends { self.possible_bends() } else { Vec::new() };
        let all = self.with_couplings(&candidates).with_bends(&bends);
        let turns = Turns::of(motions);
        self.turns = turns.usual();
        let rows = all.with_all_directions(motions, &turns);
        if !has_folds(&rows) {
            return Ok(chosen);
        }
        let mut with = self.clone();
        let mut resolved = all.resolved(&rows, &with, (&turns, least_gain), settings)?;
        if sought.couplings {
            chosen.couplings = self.couplings_shown(&all, &resolved.rows, settings)?;
        }
        if !chosen.couplings.is_empty() {
            let found: Vec<_> = chosen.couplings.iter().map(|f| f.coupling).collect();
            with = self.with_couplings(&found);
            resolved = all.resolved(&rows, &with, (&turns, least_gain), settings)?;
        }
        if sought.bends {
            chosen.bends = with.bends_shown(&all, &resolved.rows, settings)?;
        }
        if !chosen.bends.is_empty() {
            let found: Vec<usize> = chosen.bends.iter().map(|f| f.joint).collect();
            with = with.with_bends(&found);
            resolved = all.resolved(&rows, &with, (&turns, least_gain), settings)?;
        }
        if settings.link_prior.is_some() {
            let rows = rows_of(&resolved.rows, &all, &with);
            let link_prior = with.doubt_of_links(&rows, settings)?;
            chosen.settings = BatchSettings { link_prior, ..*settings };
        }
        with.turns = resolved.turns;
        *self = with;
        Ok(chosen)
    }

    /// Chooses the speed below which each joint's dry friction turns, alone: what a check asks for first is a lag of the
    /// efforts, which a friction that turns late would take.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn choose_turning_speeds(&mut self, motions: &[&Motion]) -> Result<(), NumericError> {
        let mut turns = Turns::of(motions);
        turns.tried.retain(|turn| SPEED_SHARES.map(ReversalModel::regularised).contains(turn));
        self.turns = turns.usual();
        let rows = self.with_all_directions(motions, &turns);
        if has_folds(&rows) && turns.tried.len() > 1 {
            let settings = BatchSettings::default();
            let least = |_| LEAST_GAIN_OF_SHARP;
            let resolved = self.resolved(&rows, self, (&turns, least), &settings)?;
            self.turns = resolved.turns;
        }
        Ok(())
    }

    /// Rows with the usual turn, and behind their columns the directions of the others.
    fn with_all_directions(&self, motions: &[&Motion], turns: &Turns) -> JointRows {
        let mut usual = self.clone();
        usual.turns = turns.usual();
        let others = turns.tried.get(1..).unwrap_or_default();
        let moved = usual.arm_motions(motions);
        usual.accumulate_with(
            motions,
            |index, joint, effort| {
                let jumping = usual.jumping_columns(joint, motions[index]);
                let mut columns =
                    usual.columns_beside(joint, motions[index], &moved[index], &jumping);
                let others: Vec<ReversalModel> =
                    others.iter().map(|of| turns.on(joint, *of)).collect();
                columns.extend(usual.direction_columns(joint, motions[index], &others));
                (columns, effort.to_vec())
            },
            |joint| usual.by_joint[joint].len() + others.len(),
        )
    }

    /// From rows with the directions of all turns behind the columns of this problem: the
    /// turns with which `wanted` predicts best, and the rows that have them.
    fn resolved(
        &self,
        rows: &JointRows,
        wanted: &BatchProblem<'_>,
        (turns, least): (&Turns, fn(ReversalModel) -> f64),
        settings: &BatchSettings,
    ) -> Result<Resolved, NumericError> {
        let n = self.by_joint.len();
        let with = |which: &[usize]| -> JointRows {
            let places: Vec<Vec<usize>> = (0..n)
                .map(|joint| {
                    let terms = &self.by_joint[joint];
                    let of_term = |(place, &k): (usize, &usize)| match self.terms[k] {
                        Term::Effect { effect, .. }
                            if which[joint] > 0
                                && LAWS[effect].law().roles.contains(&Place::Dry) =>
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
        for which in 0..turns.tried.len() {
            let rows = rows_of(&with(&vec![which; n]), self, wanted);
            let errors = errors_left_out(wanted, &rows, settings)?;
            let Some(before) = &before else {
                before = Some(errors);
                continue;
            };
            for (joint, best) in best.iter_mut().enumerate() {
                let gain = clear_gain(before, &errors, &[joint], least(turns.tried[which]));
                if let Some(gain) = gain.filter(|gain| *gain > best.0) {
                    *best = (gain, which);
                }
            }
        }
        let which: Vec<usize> = best.into_iter().map(|(_, which)| which).collect();
        let chosen = |(joint, &which): (usize, &usize)| turns.on(joint, turns.tried[which]);
        let found =
            (!turns.tried.is_empty()).then(|| which.iter().enumerate().map(chosen).collect());
        Ok(Resolved { turns: found, rows: with(&which) })
    }
}

/// By how many standard errors a turn must explain more than the usual one.
fn least_gain(turn: ReversalModel) -> f64 {
    match turn {
        ReversalModel::RegularisedSign { below } if below < DEFAULT_SPEED_RESOLUTION => {
            LEAST_GAIN_OF_SHARP
        }
        _ => LEAST_GAIN_IN_ERRORS,
    }
}

struct Resolved {
    turns: Option<Vec<ReversalModel>>,
    rows: JointRows,
}

/// Ways in which dry friction may turn, the usual one first: below a share of a joint's RMS speed, or over a share of the
/// standard deviation of its position.
///
/// Dry friction of a stiff drive jumps at a reversal: the smallest share of the speed only keeps the noise of the
/// velocity out. A drive train that winds up first reverses its friction over some hundredths of the
/// working speed or some thousandths of a radian; a column that jumps there puts the difference into viscous friction and
/// inertia. Which of them a joint has, its own recording says.
struct Turns {
    /// shares; none where velocities are exact
    tried: Vec<ReversalModel>,
    rms_speed: Vec<f64>,
    deviation: Vec<f64>,
}

impl Turns {
    fn of(motions: &[&Motion]) -> Self {
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

    fn usual(&self) -> Option<Vec<ReversalModel>> {
        let usual = *self.tried.first()?;
        Some((0..self.rms_speed.len()).map(|joint| self.on(joint, usual)).collect())
    }
}

fn has_folds(rows: &JointRows) -> bool {
    rows.blocks.iter().all(|blocks| blocks.len() >= FOLDS)
}

/// Share by which the errors of some joints fall where they were not fitted (geometric mean); none unless
/// that is some number of its standard errors. Errors are squared sums, fold by fold.
pub(crate) fn clear_gain(
    before: &[Vec<f64>],
    after: &[Vec<f64>],
    joints: &[usize],
    in_errors: f64,
) -> Option<f64> {
    let count = before.len() as f64;
    let gains: Vec<f64> = (before.iter().zip(after))
        .map(|(before, after)| {
            let logs = joints.iter().map(|&joint| 0.5 * (before[joint] / after[joint]).ln());
            logs.sum::<f64>() / joints.len() as f64
        })
        .collect();
    let mean = gains.iter().sum::<f64>() / count;
    let scatter: f64 = gains.iter().map(|g| (g - mean).powi(2)).sum();
    let error = (scatter / (count * (count - 1.0))).sqrt();
    (mean > 0.0 && mean > in_errors * error).then(|| 1.0 - (-mean).exp())
}

/// Squared error of every joint on each stretch of time, fitted to the others.
pub(crate) fn errors_left_out(
    problem: &BatchProblem<'_>,
    rows: &JointRows,
    settings: &BatchSettings,
) -> Result<Vec<Vec<f64>>, NumericError> {
    let beliefs = problem.beliefs(settings)?;
    let noise = problem.noise_alone(rows)?;
    let merged = |wanted: &dyn Fn(usize) -> bool| -> Vec<AccumulatedQr> {
        let of_joint = |blocks: &Vec<AccumulatedQr>| {
            let mut sum = AccumulatedQr::new(blocks[0].unknowns());
            for (_, block) in blocks.iter().enumerate().filter(|(b, _)| wanted(*b)) {
                sum.merge(block);
            }
            sum
        };
        rows.blocks.iter().map(of_joint).collect()
    };
    let blocks = rows.blocks.iter().map(Vec::len).min().unwrap_or(0);
    let folds: Vec<Vec<AccumulatedQr>> =
        (0..FOLDS).map(|fold| merged(&|b| b * FOLDS / blocks == fold)).collect();
    (0..FOLDS)
        .map(|left_out| {
            let triangles = (0..rows.triangles.len())
                .map(|joint| {
                    let mut sum = AccumulatedQr::new(folds[0][joint].unknowns());
                    for (_, fold) in folds.iter().enumerate().filter(|(f, _)| *f != left_out) {
                        sum.merge(&fold[joint]);
                    }
                    sum
                })
                .collect();
            let fitted = JointRows { triangles, ..rows.clone_without_rows() };
            let values = problem.weighted(&fitted, &noise, &beliefs)?.answer.solution;
            let error = |(joint, fold): (usize, &AccumulatedQr)| {
                let x: Vec<f64> = problem.by_joint[joint].iter().map(|&k| values[k]).collect();
                fold.residual_sum_of_squares(&x).max(f64::MIN_POSITIVE)
            };
            Ok(folds[left_out].iter().enumerate().map(error).collect())
        })
        .collect()
}
