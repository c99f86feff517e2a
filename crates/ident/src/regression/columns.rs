//! Columns of the parameters over a motion: what each adds to the effort of a joint per unit.
//!
//! Method: all columns and the effort pass through the same zero-phase low-pass; columns that follow the sign of a speed
//! jump between two samples, so they are formed from all samples before they are filtered and thinned.
//!
//! References: M. Gautier, A comparison of filtered models for dynamic identification of robots, IEEE CDC 1996 (parallel
//! filtering); the rest is own.

use armident_dynamics::ArmMotion;
use armident_effects::{BASELINE, Effect, LawRole, ReversalModel};
use armident_kinematics::InertialParameters;
use armident_model::{effect_columns, pair_columns};
use armident_motion::Motion;
use rayon::prelude::*;

use super::known_load::effort_of_body;
use super::problem::BatchProblem;
use super::unknown::{Coupling, LAWS, SHARED, Term};

/// A column, and the term it belongs to.
pub(crate) type TermColumn = (usize, Vec<f64>);

/// Whether a law follows the sign of a speed.
fn jumps(law: &dyn Effect) -> bool {
    law.law().roles.contains(&LawRole::Dry)
}

impl BatchProblem {
    /// Columns of one joint over a motion, through its filter, in the order of
    /// [`Self::terms_of_joint`].
    pub(crate) fn columns(&self, joint: usize, motion: &Motion) -> Vec<Vec<f64>> {
        let jumping = self.jumping_columns(joint, motion);
        self.columns_beside(joint, motion, &self.arm_motion(motion), &jumping)
    }

    /// What all joints need of motions.
    pub(crate) fn arm_motions<'m>(&self, motions: &[&'m Motion]) -> Vec<ArmMotion<'m>> {
        motions.par_iter().map(|motion| self.arm_motion(motion)).collect()
    }

    pub(crate) fn arm_motion<'m>(&self, motion: &'m Motion) -> ArmMotion<'m> {
        ArmMotion::new(&motion.position, &motion.velocity, &motion.acceleration)
    }

    /// [`Self::columns`] where what all joints need, and what jumps, is formed already.
    pub(crate) fn columns_beside(
        &self,
        joint: usize,
        motion: &Motion,
        moved: &ArmMotion<'_>,
        jumping: &[TermColumn],
    ) -> Vec<Vec<f64>> {
        let (mut terms, wanted) = self.constants_of(joint);
        let constants = self.set().columns();
        let mut columns = constants.of_arm_motion(self.arm(), joint, moved, &wanted);
        for (k, column) in self.smooth_columns(joint, motion) {
            terms.push(k);
            columns.push(column);
        }
        motion.filter_columns(&mut columns);
        let mut all: Vec<TermColumn> = terms.into_iter().zip(columns).collect();
        all.extend(jumping.iter().cloned());
        // the order of the terms of a joint is that of all terms
        all.sort_by_key(|(k, _)| *k);
        all.into_iter().map(|(_, column)| column).collect()
    }

    /// Effort of one joint over a motion as values explain it, through the filter: all that is smooth
    /// goes through it as one column.
    pub(crate) fn explained(
        &self,
        joint: usize,
        motion: &Motion,
        moved: &ArmMotion<'_>,
        jumping: &[TermColumn],
        values: &[f64],
    ) -> Vec<f64> {
        let (terms, wanted) = self.constants_of(joint);
        let factors: Vec<f64> = terms.iter().map(|&k| values[k]).collect();
        let rigid = self.set().columns().combined(&wanted, &factors);
        let mut explained = rigid.of_arm_motion(self.arm(), joint, moved, &[0]);
        let add = |k: usize, column: &[f64], to: &mut [Vec<f64>]| {
            to[0].iter_mut().zip(column).for_each(|(sum, x)| *sum += values[k] * x);
        };
        for (k, column) in self.smooth_columns(joint, motion) {
            add(k, &column, &mut explained);
        }
        motion.filter_columns(&mut explained);
        for (k, column) in jumping {
            add(*k, column, &mut explained);
        }
        explained.swap_remove(0)
    }

    /// The terms of a joint that are constants, and which ones.
    fn constants_of(&self, joint: usize) -> (Vec<usize>, Vec<usize>) {
        self.by_joint[joint]
            .iter()
            .filter_map(|&k| match self.terms[k] {
                Term::Constant(c) => Some((k, c)),
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => None,
            })
            .unzip()
    }

    /// Columns of effects and shared transmissions that do not jump and of loads, not filtered.
    fn smooth_columns(&self, joint: usize, motion: &Motion) -> Vec<TermColumn> {
        let mut columns = self.effect_columns_where(joint, motion, |law| !jumps(law));
        for coupling in self.couplings_on(joint) {
            columns.extend(self.shared_columns(joint, coupling, motion, false));
        }
        columns.extend(self.load_columns(joint, motion));
        columns
    }

    /// Columns of what follows the sign of a speed, formed from all samples (it jumps between two of them)
    /// and brought through the filter to those of the motion.
    pub(crate) fn jumping_columns(&self, joint: usize, motion: &Motion) -> Vec<TermColumn> {
        let fine = motion.fine();
        let mut done: Vec<TermColumn> = Vec::new();
        let mut waiting = self.effect_columns_where(joint, fine, jumps);
        let mut filter = |waiting: &mut Vec<TermColumn>| {
            let (terms, columns): (Vec<usize>, Vec<_>) = waiting.drain(..).unzip();
            done.extend(terms.into_iter().zip(motion.filtered_fine(columns)));
        };
        for coupling in self.couplings_on(joint) {
            // a few at a time: these columns have all samples
            if waiting.len() >= 4 {
                filter(&mut waiting);
            }
            waiting.extend(self.shared_columns(joint, coupling, fine, true));
        }
        filter(&mut waiting);
        done
    }

    /// Columns of the effects of the library that are wanted, not filtered.
    fn effect_columns_where(
        &self,
        joint: usize,
        motion: &Motion,
        wanted: impl Fn(&dyn Effect) -> bool,
    ) -> Vec<TermColumn> {
        let reversal = self.reversal(joint);
        let kind = self.arm().joints[joint].kind;
        let mut of_effect: Vec<Option<Vec<Vec<f64>>>> = vec![None; LAWS.len()];
        let mut columns = Vec::new();
        for &k in &self.by_joint[joint] {
            let Term::Effect { effect, parameter, .. } = self.terms[k] else { continue };
            let law = LAWS[effect];
            if wanted(law) {
                let formed = of_effect[effect]
                    .get_or_insert_with(|| effect_columns(law, &[], kind, joint, motion, reversal));
                columns.push((k, formed[parameter].clone()));
            }
        }
        columns
    }

    fn reversal(&self, joint: usize) -> Option<ReversalModel> {
        self.reversals.as_ref().map(|reversals| reversals[joint])
    }

    /// Columns of dry friction of a joint with other reversals, as [`Self::columns`] has it.
    pub(crate) fn direction_columns(
        &self,
        joint: usize,
        motion: &Motion,
        reversals: &[ReversalModel],
    ) -> Vec<Vec<f64>> {
        let kind = self.arm().joints[joint].kind;
        let Some(law) = BASELINE.iter().find(|law| jumps(**law)) else { return Vec::new() };
        let formed = reversals
            .iter()
            .filter_map(|&reversal| {
                effect_columns(*law, &[], kind, joint, motion.fine(), Some(reversal)).pop()
            })
            .collect();
        motion.filtered_fine(formed)
    }

    /// The shared transmissions among the parameters that a joint is part of.
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

    /// Columns of the unknown parameters of the loads, not filtered, with the indices of their terms.
    pub(crate) fn load_columns(&self, joint: usize, motion: &Motion) -> Vec<(usize, Vec<f64>)> {
        let of_joint = self.by_joint[joint].iter();
        of_joint
            .filter_map(|&k| {
                let Term::Load { load, number } = self.terms[k] else { return None };
                if !self.loads[load].is_on(&motion.source) {
                    return Some((k, vec![0.0; motion.len()]));
                }
                let mut unit = [0.0; InertialParameters::COUNT];
                unit[number] = 1.0;
                let body = InertialParameters::from_array(&unit);
                Some((k, effort_of_body(self.arm(), &body, motion).swap_remove(joint)))
            })
            .collect()
    }
}
