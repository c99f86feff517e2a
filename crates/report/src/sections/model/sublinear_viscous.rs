//! Sublinear viscous friction.

use armident_effects::{Effect, SublinearViscousFriction};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::detail;
use crate::layout::{Block, significant};
use crate::results::{ByJoint, DiagnoseReport};
use crate::section::{SectionData, Source};

/// Coefficient of sublinear viscous friction, by joint \[N m (s/rad)^0.5 or N (s/m)^0.5\]. Viscous friction among the
/// findings of such a joint is its linear approximation; the model has less.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct SublinearViscous(pub ByJoint);

impl SectionData for SublinearViscous {
    const KEY: &'static str = "sublinear_viscous";
    const FORMER_KEYS: &'static [&'static str] = &["friction_bends"];

    fn of(source: &Source<'_>) -> Option<Self> {
        let found = source.diagnosis.model.sublinear_friction();
        let coefficients: ByJoint = found.map(|(joint, c)| (joint.to_owned(), c)).collect();
        (!coefficients.is_empty()).then_some(Self(coefficients))
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let coefficient = |(joint, c): (&String, &f64)| {
            let (effort, position) = (result.effort_unit(joint), result.position_unit(joint));
            let number = significant(*c, 2, 0.0);
            format!("{joint} {number} {effort} (s/{position})^0.5")
        };
        let coefficients: Vec<String> = self.0.iter().map(coefficient).collect();
        detail(format!(
            "Viscous friction is sublinear: the model adds {}, c = {}. The friction values above are its linear \
             approximation.",
            SublinearViscousFriction.law().formula,
            coefficients.join(", ")
        ))
    }
}
