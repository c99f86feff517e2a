//! Choices made by the training recordings: what explains stretches of time that were not fitted.
//!
//! The recordings are cut into five stretches; each is predicted by a fit to the other four. That decides
//! how fast the direction of motion of each joint is resolved, which neighbours share a transmission, and whose friction
//! bends over the speed.
//! Errors of a model on motions it was fitted to would decide for whatever has more to fit with. How far the
//! robot description is believed is asked of all stretches together
//! (`BatchProblem::doubt_of_links`).

use armident_effects::Place;
use armident_numeric::{AccumulatedQr, NumericError};
use armident_recording::Motion;

use crate::batch::{BatchProblem, BatchSettings, LAWS, Term};
use crate::bending::BendFound;
use crate::coupling::{CouplingFound, rows_of};
use crate::rows::{DEFAULT_SPEED_RESOLUTION, JointRows};

/// Stretches of time that are left out in turn.
const FOLDS: usize = 5;
/// Another choice must be better by this many standard errors, from the stretches.
const LEAST_GAIN_IN_ERRORS: f64 = 2.0;

/// What the recordings are asked for beside speed resolutions and the doubt of the description.
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
    /// Chooses each joint's speed resolution and, where sought, the transmissions that neighbours share and the joints whose
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
        let resolutions = Resolutions::of(motions);
        self.speed_resolution = resolutions.usual();
        let rows = all.with_all_directions(motions, &resolutions);
        if !has_folds(&rows) {
            return Ok(chosen);
        }
        let mut with = self.clone();
        let mut resolved = all.resolved(&rows, &with, &resolutions, settings)?;
        if sought.couplings {
            chosen.couplings = self.couplings_shown(&all, &resolved.rows, settings)?;
        }
        if !chosen.couplings.is_empty() {
            let found: Vec<_> = chosen.couplings.iter().map(|f| f.coupling).collect();
            with = self.with_couplings(&found);
            resolved = all.resolved(&rows, &with, &resolutions, settings)?;
        }
        if sought.bends {
            chosen.bends = with.bends_shown(&all, &resolved.rows, settings)?;
        }
        if !chosen.bends.is_empty() {
            let found: Vec<usize> = chosen.bends.iter().map(|f| f.joint).collect();
            with = with.with_bends(&found);
            resolved = all.resolved(&rows, &with, &resolutions, settings)?;
        }
        if settings.link_prior.is_some() {
            let rows = rows_of(&resolved.rows, &all, &with);
            let link_prior = with.doubt_of_links(&rows, settings)?;
            chosen.settings = BatchSettings { link_prior, ..*settings };
        }
        with.speed_resolution = resolved.resolution;
        *self = with;
        Ok(chosen)
    }

    /// Chooses each joint's speed resolution alone.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn choose_speed_resolution(&mut self, motions: &[&Motion]) -> Result<(), NumericError> {
        let resolutions = Resolutions::of(motions);
        self.speed_resolution = resolutions.usual();
        let rows = self.with_all_directions(motions, &resolutions);
        if has_folds(&rows) && resolutions.shares.len() > 1 {
            let settings = BatchSettings::default();
            let resolved = self.resolved(&rows, self, &resolutions, &settings)?;
            self.speed_resolution = resolved.resolution;
        }
        Ok(())
    }

    /// Rows with the usual resolution, and behind their columns the directions of the others.
    fn with_all_directions(&self, motions: &[&Motion], resolutions: &Resolutions) -> JointRows {
        let mut usual = self.clone();
        usual.speed_resolution = resolutions.usual();
        let others = resolutions.shares.get(1..).unwrap_or_default();
        let moved = usual.arm_motions(motions);
        usual.accumulate_with(
            motions,
            |index, joint, effort| {
                let jumping = usual.jumping_columns(joint, motions[index]);
                let mut columns =
                    usual.columns_beside(joint, motions[index], &moved[index], &jumping);
                let rms = resolutions.rms_speed[joint];
                let at: Vec<f64> = others.iter().map(|share| share * rms).collect();
                columns.extend(usual.direction_columns(joint, motions[index], &at));
                (columns, effort.to_vec())
            },
            |joint| usual.by_joint[joint].len() + others.len(),
        )
    }

    /// From rows with the directions of all resolutions behind the columns of this problem: the
    /// resolutions with which `wanted` predicts best, and the rows that have them.
    fn resolved(
        &self,
        rows: &JointRows,
        wanted: &BatchProblem<'_>,
        resolutions: &Resolutions,
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
                                && LAWS[effect].law().places.contains(&Place::Dry) =>
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
        for which in 0..resolutions.shares.len() {
            let rows = rows_of(&with(&vec![which; n]), self, wanted);
            let errors = errors_left_out(wanted, &rows, settings)?;
            let Some(before) = &before else {
                before = Some(errors);
                continue;
            };
            for (joint, best) in best.iter_mut().enumerate() {
                let gain = clear_gain(before, &errors, &[joint], LEAST_GAIN_IN_ERRORS);
                if let Some(gain) = gain.filter(|gain| *gain > best.0) {
                    *best = (gain, which);
                }
            }
        }
        let which: Vec<usize> = best.into_iter().map(|(_, which)| which).collect();
        let chosen = |(&which, rms): (&usize, &f64)| resolutions.shares[which] * rms;
        let resolution = (!resolutions.shares.is_empty())
            .then(|| which.iter().zip(&resolutions.rms_speed).map(chosen).collect());
        Ok(Resolved { resolution, rows: with(&which) })
    }
}

struct Resolved {
    resolution: Option<Vec<f64>>,
    rows: JointRows,
}

/// Speed resolutions that are tried, as shares of a joint's RMS speed; below it the direction fades to
/// zero. The usual one comes first.
///
/// Dry friction of a stiff drive jumps at a reversal: the smallest share only keeps the noise of the
/// velocity out. A drive train that winds up first reverses its friction over some hundredths of the
/// working speed; a column that jumps there puts the difference into viscous friction and inertia.
/// Which of the two a joint has, its own recording says.
struct Resolutions {
    /// none where velocities are exact
    shares: Vec<f64>,
    rms_speed: Vec<f64>,
}

impl Resolutions {
    fn of(motions: &[&Motion]) -> Self {
        let joints = motions.first().map_or(0, |m| m.velocity.len());
        let rms_speed = (0..joints)
            .map(|joint| {
                let squares: f64 =
                    motions.iter().flat_map(|m| &m.velocity[joint]).map(|v| v * v).sum();
                let count: usize = motions.iter().map(|m| m.len()).sum();
                (squares / count as f64).sqrt().max(f64::MIN_POSITIVE)
            })
            .collect();
        let exact = motions.iter().all(|m| m.filter.is_none());
        let shares = if exact { &[][..] } else { &[DEFAULT_SPEED_RESOLUTION, 0.005, 0.02, 0.1, 0.2, 0.3] };
        Self { shares: shares.to_vec(), rms_speed }
    }

    fn usual(&self) -> Option<Vec<f64>> {
        let usual = self.shares.first()?;
        Some(self.rms_speed.iter().map(|rms| usual * rms).collect())
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
