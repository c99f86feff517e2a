//! The physically consistent links nearest to the constants of Algorithm 2.

use armident_dynamics::RigidArm;
use armident_numeric::{Mat, information_root};

use super::estimate::Algorithm2Estimate;
use crate::consistency::{ConsistencyError, ConsistencyProblem, Consistent};
use crate::minimal_set::MinimalSet;

impl Algorithm2Estimate {
    /// Physically consistent links nearest to the constants found; those that no step seeks are the given model's.
    ///
    /// # Errors
    /// [`ConsistencyError`] when a number is not finite.
    pub fn nearest_consistent(
        &self,
        arm: &RigidArm,
        set: &MinimalSet,
    ) -> Result<Consistent, ConsistencyError> {
        let known = |k: usize| self.values[k].is_finite();
        let of_arm = set.values(&arm.constants());
        let values: Vec<f64> = (self.values.iter().zip(&of_arm))
            .map(|(found, of_arm)| if found.is_finite() { *found } else { *of_arm })
            .collect();
        let covariance = Mat::from_fn(values.len(), values.len(), |i, j| {
            if known(i) && known(j) { self.covariance[(i, j)] } else { 0.0 }
        });
        let root = information_root(&covariance)?;
        ConsistencyProblem::new(arm, set, &[]).nearest(&values, &root)
    }
}
