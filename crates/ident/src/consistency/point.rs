//! A point inside the cone of real links and admissible effects.

use armident_kinematics::InertialParameters;
use nalgebra::Matrix4;

/// Standard parameters of a link, and coordinates of a symmetric 4x4 matrix.
pub(super) const TEN: usize = InertialParameters::COUNT;
/// Scale of unknowns without a bound: they follow the data.
pub(super) const FREE: f64 = 1e4;

/// A point inside the cone.
#[derive(Debug, Clone)]
pub(super) struct Point {
    /// `L` of every link
    pub(super) factors: Vec<Matrix4<f64>>,
    /// the scaled effects
    pub(super) effects: Vec<f64>,
}

impl Point {
    /// Pseudo-inertias `Λ X Λᵀ` as links.
    pub(super) fn links(&self, roots: &[Matrix4<f64>]) -> Vec<InertialParameters> {
        let of = |(factor, root): (&Matrix4<f64>, &Matrix4<f64>)| {
            let half = root * factor;
            InertialParameters::from_pseudo_inertia(&(half * half.transpose()))
        };
        self.factors.iter().zip(roots).map(of).collect()
    }

    /// `Σ tr X` of the links.
    pub(super) fn size_of_links(&self) -> f64 {
        self.factors.iter().map(Matrix4::norm_squared).sum()
    }
}
