//! Values of the minimal constants put into the links of a model.

use armident_dynamics::RigidArm;
use armident_model::ArmModel;

use super::algorithm_m::MinimalSet;

impl MinimalSet {
    /// The model with links whose minimal constants have these values, in the order of the set.
    ///
    /// Standard parameters outside the minimal set keep the values they have, which changes no
    /// effort; the links need not be physically consistent one by one.
    #[must_use]
    pub fn applied_to(&self, model: ArmModel, values: &[f64]) -> ArmModel {
        let arm = RigidArm::from_chain(&model.chain);
        let mut bodies = arm.constants();
        let difference: Vec<f64> =
            values.iter().zip(self.values(&bodies)).map(|(new, old)| new - old).collect();
        for (constant, change) in self.constants.iter().zip(difference) {
            constant.add_to(change, &mut bodies);
        }
        model.with_links(&arm.with_constants(&bodies).links)
    }
}
