//! The motion on which a finding differs most from its alternatives.
//!
//! T-optimality: of each pair the residual of the finding's effort after a fit of the alternative's columns and of all that is
//! fitted anyway, in standard deviations of the noise ([`crate::imitation`]). An alternative with a shape imitates with the
//! shape that is best for it. Over several pairs the sum of `log(1 + residual²)` is maximised: what separates one pair well
//! makes up for no other. Where an effort does not follow from columns (play, an elastic joint) the difference of two fitted
//! models takes the place of the finding's effort, and only what is fitted anyway imitates it.
//!
//! References: A. C. Atkinson, V. V. Fedorov, The design of experiments for discriminating between two rival models,
//! Biometrika 62(1), 1975; the sum is own.

use armident_effects::{ArmColumns, Effect, EffectOnJoint, Library, Scan, Scope};
use armident_kinematics::DrivingAxisChain;
use armident_recording::Recording;
use serde::Serialize;

use crate::designer::planned_recording;
use crate::error::ExcitationError;
use crate::imitation::Fitted;
use crate::information::{Columns, Parameters, Regressors};
use crate::law_columns::{PlacedLaw, PlannedMotion};

/// Samples per second on which motions are compared during the search \[Hz\].
pub(crate) const COMPARED_HZ: f64 = 50.0;
/// Residual share of the square of an effort that is rounding.
const LEAST_SHARE: f64 = 1e-6;

/// Two fitted models that recordings do not distinguish.
pub trait RivalModels: std::fmt::Debug + Sync {
    /// Efforts of the one minus those of the other on a motion, `[joint][sample]` \[N m or N\]; none where they cannot be
    /// predicted.
    fn difference(&self, motion: &Recording) -> Option<Vec<Vec<f64>>>;
}

/// A finding and an effect that the recordings do not distinguish from it.
#[derive(Debug, Clone)]
pub struct RivalEffects<'a> {
    /// The finding with its parameters.
    pub finding: EffectOnJoint,
    /// Slug of the alternative.
    pub alternative: String,
    /// Joint of the alternative: the first of two neighbours, or the one that moves the link; empty for the whole arm.
    pub alternative_joint: String,
    /// The models fitted with the one and with the other, for efforts that need a simulation.
    pub models: Option<&'a dyn RivalModels>,
}

/// How well a motion separates a pair.
#[derive(Debug, Clone, Serialize)]
pub struct Separation {
    /// Slug of the finding.
    pub finding: String,
    /// Its joint; empty for the whole arm.
    pub joint: String,
    /// Slug of the alternative.
    pub alternative: String,
    /// Its joint.
    pub alternative_joint: String,
    /// Residual of the finding's effort where the alternative and all that is fitted anyway imitate it, in standard deviations
    /// of one recorded effort (root of the sum of squares); none where the effort does not follow from the motion alone.
    pub standard_errors: Option<f64>,
    /// Why the pair is no part of the design, or only in part.
    pub note: Option<String>,
}

/// A pair whose efforts are known on a motion.
enum Rival<'a> {
    Columns {
        finding: PlacedLaw,
        shape: Vec<f64>,
        coefficients: Vec<f64>,
        other: Option<PlacedLaw>,
    },
    Models(&'a dyn RivalModels),
}

/// The pairs of a design.
pub(crate) struct Rivals<'a> {
    chain: &'a DrivingAxisChain,
    parameters: &'a Parameters<'a>,
    rivals: Vec<Option<Rival<'a>>>,
    rows: Vec<Separation>,
}

impl<'a> Rivals<'a> {
    /// # Errors
    /// [`ExcitationError::Rival`]: an effect or a joint that is not known, or other parameters than those of the law; or no
    /// pair whose efforts are known on a motion.
    pub(crate) fn of(
        chain: &'a DrivingAxisChain,
        parameters: &'a Parameters<'a>,
        pairs: &[RivalEffects<'a>],
    ) -> Result<Self, ExcitationError> {
        let (mut rivals, mut rows) = (Vec::new(), Vec::new());
        for pair in pairs {
            let fault = |found: String| ExcitationError::Rival { found };
            let law =
                Library::standard().resolve(&pair.finding).map_err(|e| fault(e.to_string()))?;
            let other = Library::standard()
                .get(&pair.alternative)
                .ok_or_else(|| fault(format!("there is no effect `{}`", pair.alternative)))?;
            let place = |law: &'static dyn Effect, joint: &str| match law.law().scope {
                Scope::Arm => Ok(0),
                _ => chain
                    .joints
                    .iter()
                    .position(|j| j.name == joint)
                    .ok_or_else(|| fault(format!("joint `{joint}` is not on the chain"))),
            };
            let finding = PlacedLaw { law, joint: place(law, &pair.finding.joint)? };
            let other = PlacedLaw { law: other, joint: place(other, &pair.alternative_joint)? };
            let follows = |law: &dyn Effect| law.law().scan == Scan::Columns;
            let both_follow = follows(law) && follows(other.law);
            let models = pair.models.filter(|_| !both_follow);
            let note = match (follows(law), follows(other.law)) {
                _ if models.is_some() => {
                    Some("the two fitted models: only what is fitted anyway imitates")
                }
                (false, _) => Some("the finding's effort needs a simulation"),
                (true, false) => Some(
                    "the alternative's effort needs a simulation: only what is fitted anyway imitates",
                ),
                (true, true) => None,
            };
            let (shape, coefficients) = law.shape_and_coefficients(&pair.finding.parameters);
            let other = follows(other.law).then_some(other);
            let columns =
                follows(law).then_some(Rival::Columns { finding, shape, coefficients, other });
            rivals.push(models.map(Rival::Models).or(columns));
            rows.push(Separation {
                finding: pair.finding.effect.clone(),
                joint: pair.finding.joint.clone(),
                alternative: pair.alternative.clone(),
                alternative_joint: pair.alternative_joint.clone(),
                standard_errors: None,
                note: note.map(str::to_owned),
            });
        }
        if rivals.iter().all(Option::is_none) {
            let found = match rows.is_empty() {
                true => "no finding has an alternative".to_owned(),
                false => {
                    "no finding whose effort follows from a motion has an alternative".to_owned()
                }
            };
            return Err(ExcitationError::Rival { found });
        }
        Ok(Self { chain, parameters, rivals, rows })
    }

    /// Squared residual of each pair on a motion; 0 where rounding is all of it.
    fn residuals(&self, columns: &Columns, rate_hz: f64) -> Vec<Option<f64>> {
        let motion = PlannedMotion::new(columns, self.parameters.efforts(columns), rate_hz);
        let regressors = self.parameters.regressors(columns);
        self.rivals
            .iter()
            .map(|rival| {
                let rival = rival.as_ref()?;
                Some(self.residual(rival, (columns, &motion), rate_hz, &regressors))
            })
            .collect()
    }

    fn residual(
        &self,
        rival: &Rival<'_>,
        (columns, motion): (&Columns, &PlannedMotion<'_>),
        rate_hz: f64,
        regressors: &Regressors,
    ) -> f64 {
        let (chain, arm) = (self.chain, self.parameters.arm);
        let (finding, shape, coefficients, other) = match rival {
            Rival::Columns { finding, shape, coefficients, other } => {
                (*finding, shape, coefficients, *other)
            }
            Rival::Models(models) => {
                let names = chain.joints.iter().map(|joint| joint.name.as_str());
                let time_s = (0..columns[0].first().map_or(0, Vec::len))
                    .map(|k| k as f64 / rate_hz)
                    .collect();
                let planned = planned_recording("planned", names, time_s, columns.clone()).ok();
                let difference = planned.and_then(|planned| models.difference(&planned));
                return difference.map_or(0.0, |effort| {
                    self.beyond(regressors.clone(), self.parameters.len(), effort)
                });
            }
        };
        let effort = combined(&motion.law(chain, arm, finding, shape), coefficients);
        let Some(other) = other else {
            return self.beyond(regressors.clone(), self.parameters.len(), effort);
        };
        let shapes = other.law.shapes(&motion.scale(arm, other.joint));
        let imitations = shapes.iter().map(|shape| {
            let columns = motion.law(chain, arm, other, shape);
            let mut all = regressors.clone();
            for (joint, (places, of_joint)) in all.iter_mut().enumerate() {
                for (k, column) in columns.iter().enumerate() {
                    if !column[joint].is_empty() {
                        places.push(self.parameters.len() + k);
                        of_joint.push(column[joint].clone());
                    }
                }
            }
            self.beyond(all, self.parameters.len() + columns.len(), effort.clone())
        });
        imitations.fold(f64::INFINITY, f64::min)
    }

    fn beyond(&self, regressors: Regressors, count: usize, effort: Vec<Vec<f64>>) -> f64 {
        let fitted = Fitted::new(count, vec![regressors], &self.parameters.noise);
        let columns: [ArmColumns; 1] = [vec![effort]];
        fitted.residual(&columns).map_or(0.0, |[left, own]| {
            if left[(0, 0)] > LEAST_SHARE * own[(0, 0)] { left[(0, 0)] } else { 0.0 }
        })
    }

    /// What a search maximises.
    pub(crate) fn worth(&self, columns: &Columns) -> f64 {
        self.residuals(columns, COMPARED_HZ).iter().flatten().map(|square| square.ln_1p()).sum()
    }

    /// How well a motion separates the pairs, each sample as one recorded effort.
    pub(crate) fn separations(&self, columns: &Columns, rate_hz: f64) -> Vec<Separation> {
        let squares = self.residuals(columns, rate_hz);
        self.rows
            .iter()
            .zip(squares)
            .map(|(row, square)| Separation {
                standard_errors: square.map(f64::sqrt),
                ..row.clone()
            })
            .collect()
    }
}

/// The effort of columns with coefficients, `[joint][sample]`.
fn combined(columns: &ArmColumns, coefficients: &[f64]) -> Vec<Vec<f64>> {
    let joints = columns.first().map_or(0, Vec::len);
    (0..joints)
        .map(|joint| {
            let samples = columns.iter().map(|c| c[joint].len()).max().unwrap_or(0);
            let mut sum = vec![0.0; samples];
            for (column, coefficient) in columns.iter().zip(coefficients) {
                for (sum, x) in sum.iter_mut().zip(&column[joint]) {
                    *sum += coefficient * x;
                }
            }
            sum
        })
        .collect()
}
