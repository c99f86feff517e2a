//! Transmissions that neighbouring joints share, chosen by cross-validation.
//!
//! The last motors of a wrist often drive their joint through the one before: their friction acts on the
//! sum of both speeds, and on both joints. Which pairs, and with what ratio, the training recordings are
//! asked: a pair is taken where the efforts of stretches of time that were not fitted are explained
//! clearly better with it.

use armident_effects::{Effect, EffectOnJoint, JointCoupling, MotionScale};
use armident_motion::Motion;
use armident_numeric::{AccumulatedQr, NumericError};

use crate::batch::{BatchProblem, BatchSettings, Term, noise_of};
use crate::left_out::{clear_gain, errors_left_out};
use crate::rows::{JointRows, TermColumn};
use armident_model::pair_columns;

/// The law of a shared transmission.
pub(crate) const SHARED: &dyn Effect = &JointCoupling;
/// Share by which the error of what was left out must fall (geometric mean of both joints),
const LEAST_GAIN: f64 = 0.1;
/// and over its standard error, from the folds.
const LEAST_GAIN_IN_ERRORS: f64 = 2.0;

/// A transmission shared by a joint and the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// The first of both joints, from 0.
    pub first: usize,
    /// Speed of the common shaft: that of the second joint and `ratio` times that of the first.
    pub ratio: f64,
}

impl Coupling {
    /// The law's name in files.
    pub const SLUG: &str = "joint_coupling";

    /// Both joints.
    pub fn joints(self) -> [usize; 2] {
        [self.first, self.first + 1]
    }

    fn terms(self) -> impl Iterator<Item = Term> {
        (0..SHARED.law().parameters.len() - 1)
            .map(move |coefficient| Term::Shared { coupling: self, coefficient })
    }
}

/// A coupling that the recordings show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CouplingFound {
    /// Which.
    pub coupling: Coupling,
    /// Share by which the error of both joints falls where it was not fitted (geometric mean).
    pub gain: f64,
}

impl BatchProblem<'_> {
    /// The same with unknowns of shared transmissions behind its own.
    #[must_use]
    pub fn with_couplings(&self, couplings: &[Coupling]) -> Self {
        let mut problem = self.clone();
        for coupling in couplings {
            for term in coupling.terms() {
                for joint in coupling.joints() {
                    problem.by_joint[joint].push(problem.terms.len());
                }
                problem.terms.push(term);
            }
        }
        problem
    }

    /// All couplings that the law offers of neighbours whose efforts are reported.
    pub(crate) fn possible_couplings(&self) -> Vec<Coupling> {
        (1..self.by_joint.len())
            .filter(|&second| !self.unreported[second - 1] && !self.unreported[second])
            .flat_map(|second| {
                let kind = self.arm().joints[second].kind;
                let scale =
                    MotionScale { kind, speed_rms: 1.0, position_deviation: 1.0, duration_s: 1.0 };
                let shapes = SHARED.shapes(&scale).into_iter();
                shapes.map(move |shape| Coupling { first: second - 1, ratio: shape[0] })
            })
            .collect()
    }

    /// The couplings that rows with the columns of all possible ones show, the clearest first.
    pub(crate) fn couplings_shown(
        &self,
        all: &BatchProblem<'_>,
        rows: &JointRows,
        settings: &BatchSettings,
    ) -> Result<Vec<CouplingFound>, NumericError> {
        let candidates = self.possible_couplings();
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
                    let of_without = rows_of(rows, all, &without);
                    before = Some(errors_left_out(&without, &of_without, settings)?);
                }
                let with = self.with_couplings(&[&chosen[..], &[coupling]].concat());
                let after = errors_left_out(&with, &rows_of(rows, all, &with), settings)?;
                let gain = before.as_deref().and_then(|before| {
                    clear_gain(before, &after, &coupling.joints(), LEAST_GAIN_IN_ERRORS)
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
        all: &BatchProblem<'_>,
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
                let triangle = triangle_of(rows, all, &problem, joint);
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
            let left = error_of_both(&with, &rows_of(rows, all, &with), coupling, settings)?;
            if nearest.is_none_or(|(least, _)| left < least) {
                nearest = Some((left, coupling));
            }
        }
        Ok(nearest.map(|(_, coupling)| coupling))
    }

    /// The shared transmissions among the unknowns that a joint is part of.
    pub(crate) fn couplings_on(&self, joint: usize) -> Vec<Coupling> {
        let mut all: Vec<Coupling> = Vec::new();
        for &k in &self.by_joint[joint] {
            if let Term::Shared { coupling, .. } = self.terms[k]
                && !all.contains(&coupling)
            {
                all.push(coupling);
            }
        }
        all
    }

    /// Columns of a shared transmission of a joint that jump with the direction of motion, or the others, not
    /// filtered.
    pub(crate) fn shared_columns(
        &self,
        joint: usize,
        coupling: Coupling,
        motion: &Motion,
        jumping: bool,
    ) -> Vec<TermColumn> {
        let joints = coupling.joints();
        let kinds = joints.map(|j| self.arm().joints[j].kind);
        let mut formed = pair_columns(SHARED, &[coupling.ratio], joints, kinds, motion);
        let mut columns = Vec::new();
        for &k in &self.by_joint[joint] {
            if let Term::Shared { coupling: of, coefficient } = self.terms[k]
                && of == coupling
                && SHARED.coefficient_jumps(coefficient) == jumping
            {
                columns.push((k, std::mem::take(&mut formed[coefficient][joint - coupling.first])));
            }
        }
        columns
    }

    /// The shared transmissions within a vector of all terms.
    pub(crate) fn couplings_of(&self, values: &[f64], joint_names: &[&str]) -> Vec<EffectOnJoint> {
        let mut list: Vec<(Coupling, Vec<f64>)> = Vec::new();
        for (term, &value) in self.terms.iter().zip(values) {
            let Term::Shared { coupling, .. } = *term else { continue };
            match list.iter_mut().find(|(of, _)| *of == coupling) {
                Some((_, coefficients)) => coefficients.push(value),
                None => list.push((coupling, vec![value])),
            }
        }
        list.into_iter()
            .map(|(coupling, coefficients)| {
                let [a, b] = coupling.joints().map(|joint| joint_names[joint]);
                let parameters = SHARED.parameters(&[coupling.ratio], &coefficients);
                EffectOnJoint {
                    other_joint: Some(b.to_owned()),
                    ..EffectOnJoint::new(SHARED.law().slug, a, parameters)
                }
            })
            .collect()
    }
}

/// Columns of a joint in rows with the columns of many candidates, that a problem with some of them has.
fn places_of(all: &BatchProblem<'_>, wanted: &BatchProblem<'_>, joint: usize) -> Vec<usize> {
    let place = |&k: &usize| {
        let term = wanted.terms[k];
        all.by_joint[joint].iter().position(|&of_all| all.terms[of_all] == term)
    };
    wanted.by_joint[joint].iter().filter_map(place).collect()
}

fn triangle_of(
    rows: &JointRows,
    all: &BatchProblem<'_>,
    wanted: &BatchProblem<'_>,
    joint: usize,
) -> AccumulatedQr {
    rows.triangles[joint].with_unknowns(&places_of(all, wanted, joint))
}

/// Of rows with the columns of many candidates, those of a problem with some of them.
pub(crate) fn rows_of(
    rows: &JointRows,
    all: &BatchProblem<'_>,
    wanted: &BatchProblem<'_>,
) -> JointRows {
    let joints = 0..wanted.by_joint.len();
    let places: Vec<Vec<usize>> = joints.map(|joint| places_of(all, wanted, joint)).collect();
    rows.with_places(&places)
}

/// Sum of the logarithms of the errors of both joints of a coupling.
fn error_of_both(
    problem: &BatchProblem<'_>,
    rows: &JointRows,
    coupling: Coupling,
    settings: &BatchSettings,
) -> Result<f64, NumericError> {
    let noise = problem.noise_alone(rows)?;
    let beliefs = problem.beliefs(settings)?;
    let values = problem.weighted(rows, &noise, &beliefs)?.answer.solution;
    let fits = problem.fit(rows, &values);
    Ok(coupling.joints().map(|joint| fits[joint].rmse.ln()).iter().sum::<f64>())
}
