//! Regularised Coulomb friction.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::detail::{above_zero, detail};
use crate::layout::Block;
use crate::results::{ByJoint, DiagnoseReport};
use crate::section::{SectionData, Source};

/// Speed below which Coulomb friction is linear in the speed, by joint \[rad/s or m/s\].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct RegularisedCoulomb(pub ByJoint);

impl SectionData for RegularisedCoulomb {
    const KEY: &'static str = "coulomb_regularised_below";
    const FORMER_KEYS: &'static [&'static str] = &["friction_fades_below"];

    fn of(source: &Source<'_>) -> Option<Self> {
        let diagnosis = source.diagnosis;
        above_zero(&diagnosis.joints, &diagnosis.model.regularised_below()).map(Self)
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let speeds = self.0.listed(|joint| format!("{}/s", result.position_unit(joint)));
        detail(format!("Coulomb friction is regularised (linear in speed) below: {speeds}"))
    }
}
