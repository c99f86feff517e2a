//! Efforts that were computed instead of measured: a target, a command, the output of a model.
//!
//! Every drive that moves has friction, and every sensor noise. A model without friction has neither: what its rigid
//! body leaves is rounding.

use armident_effects::{Admissible, LawRole};

use super::rows::ChannelRows;
use crate::regression::{BatchProblem, LAWS, Term};

/// Root of the share of the squared effort that friction must explain on a measured joint: bearings alone take a hundredth
/// of the effort, gears a tenth.
const LEAST_FRICTION: f64 = 5e-3;
/// The same of the residual, and of noise: torque sensors are good to some thousandths of their range.
const LEAST_RESIDUAL: f64 = 5e-3;
const LEAST_NOISE: f64 = 2e-3;

/// What a joint's effort has beside its rigid body, each as a share of its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BesideRigid {
    pub(super) friction: f64,
    pub(super) residual: f64,
    pub(super) noise: f64,
}

impl BesideRigid {
    /// `noise`: that of one recorded sample \[N m or N\].
    pub(super) fn of(problem: &BatchProblem, joint: usize, rows: &ChannelRows, noise: f64) -> Self {
        let is_dissipative = |k: &usize| match problem.terms[*k] {
            Term::Effect { effect, .. } => {
                !LAWS[effect].law().roles.contains(&LawRole::Inertia)
                    && problem.terms[*k]
                        .parameter()
                        .is_some_and(|p| p.admissible == Admissible::NonNegative)
            }
            _ => false,
        };
        let terms = problem.terms_of_joint(joint);
        let (last, first): (Vec<usize>, Vec<usize>) =
            (0..terms.len()).partition(|&place| is_dissipative(&terms[place]));
        let order: Vec<usize> =
            first.iter().chain(&last).copied().chain([rows.effort_of(joint)]).collect();
        let r = rows.triangle.reordered(&order);
        let effort = terms.len();
        let of_friction: f64 = (first.len()..effort).map(|i| r[(i, effort)].powi(2)).sum();
        Self {
            friction: (of_friction / rows.samples).sqrt() / rows.effort_sd,
            residual: rows.residual_rms / rows.effort_sd,
            noise: noise / rows.effort_sd,
        }
    }

    pub(super) fn is_computed(&self) -> bool {
        self.friction < LEAST_FRICTION && self.residual < LEAST_RESIDUAL && self.noise < LEAST_NOISE
    }
}
