//! Physical consistency of the links of a model.

use std::collections::BTreeMap;

use armident_ident::Consistent;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::by_joint::{ByJoint, or_nan};

/// Physically consistent links, and effects of admissible sign, of a model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ConsistencyReport {
    /// Whether the estimate is physically consistent.
    pub exact: bool,
    /// Distance from the estimate in its own information metric \[standard errors\].
    #[serde(deserialize_with = "or_nan")]
    pub distance_in_standard_errors: f64,
    /// Lower bound of the distance of any consistent links up to `bound_holds_to` times the size of the URDF's.
    #[serde(deserialize_with = "or_nan")]
    pub distance_at_least: f64,
    /// Duality gap of half the squared distance.
    #[serde(deserialize_with = "or_nan")]
    pub duality_gap: f64,
    /// Size of the links, relative to the URDF's, up to which the bound holds.
    #[serde(deserialize_with = "or_nan")]
    pub bound_holds_to: f64,
    /// Whether the iteration has converged; if not, the bound still holds.
    pub converged: bool,
    /// Newton steps.
    pub steps: usize,
    /// Entropic divergence of the links from the URDF's.
    #[serde(deserialize_with = "or_nan")]
    pub divergence_from_urdf: f64,
    /// Joints whose URDF link is not physically consistent: the nearest consistent one was used instead.
    pub urdf_links_projected: Vec<String>,
    /// Joints whose URDF link has no mass or no extent: a tiny one was used instead.
    pub urdf_links_thickened: Vec<String>,
    /// Ten parameters of every link about the origin of its frame `E_i`, by joint.
    pub links: BTreeMap<String, [f64; 10]>,
    /// Smallest eigenvalue of every link's pseudo-inertia, by joint.
    pub smallest_eigenvalues: ByJoint,
}

impl ConsistencyReport {
    /// Of a result, with the names of the joints.
    pub fn of(found: &Consistent, joints: &[&str]) -> Self {
        let named = |list: &[usize]| list.iter().map(|&j| joints[j].to_owned()).collect();
        let name = |joint: &&str| (*joint).to_owned();
        Self {
            exact: found.exact,
            distance_in_standard_errors: found.distance_in_standard_errors,
            distance_at_least: found.distance_at_least,
            duality_gap: found.duality_gap,
            bound_holds_to: found.gap_holds_to,
            converged: found.converged,
            steps: found.steps,
            divergence_from_urdf: found.divergence,
            urdf_links_projected: named(&found.prior_projected),
            urdf_links_thickened: named(&found.prior_thickened),
            links: joints.iter().map(name).zip(found.links.iter().map(|l| l.to_array())).collect(),
            smallest_eigenvalues: (joints.iter().map(name))
                .zip(found.smallest_eigenvalues.iter().copied())
                .collect(),
        }
    }

    /// Warnings about the URDF.
    pub fn warnings(&self) -> Vec<String> {
        let projected = self.urdf_links_projected.join(", ");
        let warning = format!(
            "the URDF inertia of the link moved by {projected} is not physically consistent; its \
             projection is used as the prior [prior-projected]"
        );
        if projected.is_empty() { Vec::new() } else { vec![warning] }
    }
}
