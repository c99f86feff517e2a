//! The physically consistent links and effects nearest to an estimate.
//!
//! Method: projection in the metric of the estimate's information matrix ([`consistency`](crate::consistency)).
//!
//! References: in [`consistency`](crate::consistency).

use armident_effects::{Admissible, EffectOnJoint};

use super::estimate::BatchEstimate;
use super::problem::BatchProblem;
use super::unknown::{LAWS, Term};
use crate::consistency::{ConsistencyError, ConsistencyProblem, Consistent, EffectUnknown};

impl BatchProblem {
    /// Physically consistent links, and effects of the admissible sign, nearest to an estimate in its information metric.
    ///
    /// [`Consistent::estimated`] is in the order of [`Self::terms`], [`Consistent::effects`] that of
    /// the effects among the terms and then of [`Self::merged`].
    ///
    /// # Errors
    /// [`ConsistencyError`] when a number is not finite.
    pub fn nearest_consistent(
        &self,
        estimate: &BatchEstimate,
    ) -> Result<Consistent, ConsistencyError> {
        // the constants of a minimal set are independent, so they are the first terms
        let own = self.terms.iter().enumerate().filter_map(|(k, term)| {
            let non_negative = non_negative(term)?;
            Some(EffectUnknown {
                adds_to: vec![(k, 1.0)],
                non_negative,
                merged: false,
                prior: None,
            })
        });
        let merged = self.merged.iter().filter_map(|merged| {
            let non_negative = non_negative(&merged.term)?;
            Some(EffectUnknown {
                adds_to: merged.into.clone(),
                non_negative,
                merged: true,
                prior: None,
            })
        });
        let effects: Vec<EffectUnknown> = own.chain(merged).collect();
        ConsistencyProblem::new(self.arm(), self.set(), &effects)
            .nearest(&estimate.values, &estimate.information_root)
    }

    /// The effects of a consistent set; what is merged into constants is among them where the links
    /// alone cannot have these.
    pub fn consistent_effects(
        &self,
        consistent: &Consistent,
        joint_names: &[&str],
    ) -> Vec<EffectOnJoint> {
        let mut list = self.effects(&consistent.estimated, joint_names);
        let own = self.terms.iter().filter(|t| non_negative(t).is_some()).count();
        let merged = self.merged.iter().filter(|m| non_negative(&m.term).is_some());
        for (merged, &value) in merged.zip(&consistent.effects[own..]) {
            let Term::Effect { joint, effect, parameter } = merged.term else { continue };
            if value == 0.0 {
                continue;
            }
            let law = LAWS[effect].law();
            let mut parameters = vec![0.0; law.parameters.len()];
            parameters[parameter] = value;
            list.push(EffectOnJoint::new(law.slug, joint_names[joint], parameters));
        }
        list
    }
}

/// Whether what is unknown beside the links must not be negative; none for a constant.
fn non_negative(term: &Term) -> Option<bool> {
    if let Term::Load { .. } = term {
        return Some(false);
    }
    term.parameter().map(|parameter| parameter.admissible == Admissible::NonNegative)
}
