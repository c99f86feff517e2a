//! What `identify` says of the links: whether real ones have the estimated constants.

use std::collections::BTreeMap;

use armident_ident::Consistent;
use serde::Serialize;

use crate::numbers::significant;

/// The real links, and effects of the admissible sign, of the model that was found.
#[derive(Debug, Clone, Serialize)]
pub struct ConsistencyReport {
    /// Whether real links have exactly the estimated values.
    pub exact: bool,
    /// Distance from the estimate in its own information metric \[standard errors\].
    pub distance_in_standard_errors: f64,
    /// No real links up to `bound_holds_to` times the size of the URDF's are nearer than this.
    pub distance_at_least: f64,
    /// Duality gap of half the squared distance.
    pub duality_gap: f64,
    /// Size of the links, relative to the URDF's, up to which the bound holds.
    pub bound_holds_to: f64,
    /// Whether the iteration ended at the nearest links; if not, the bound still holds.
    pub converged: bool,
    /// Newton steps.
    pub steps: usize,
    /// Entropic divergence of the links from the URDF's.
    pub divergence_from_urdf: f64,
    /// Joints whose URDF link no real body has: the nearest real one was used in its place.
    pub urdf_links_projected: Vec<String>,
    /// Joints whose URDF link has no mass or no extent: a tiny one was used in its place.
    pub urdf_links_thickened: Vec<String>,
    /// Ten parameters of every link about the origin of its frame `E_i`, by joint.
    pub links: BTreeMap<String, [f64; 10]>,
    /// Smallest eigenvalue of every link's pseudo-inertia, by joint.
    pub smallest_eigenvalues: BTreeMap<String, f64>,
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

    /// What the user should know of the URDF.
    pub fn warnings(&self) -> Vec<String> {
        let projected = self.urdf_links_projected.join(", ");
        let warning = format!(
            "no body has the URDF's inertia of the link moved by {projected}: the nearest real one \
             stands in its place where the recordings leave the links open [prior-projected]"
        );
        if projected.is_empty() { Vec::new() } else { vec![warning] }
    }

    /// One line of the page.
    pub fn text(&self) -> String {
        if self.exact {
            return "links: real ones have exactly these constants\n".to_owned();
        }
        let bound = match self.distance_at_least {
            0.0 => String::new(),
            least => format!(" (none is nearer than {})", significant(least, 3, 0.0)),
        };
        format!(
            "links: the nearest real ones are {} standard errors off{bound}; the model has them\n",
            significant(self.distance_in_standard_errors, 3, 0.0),
        )
    }
}
