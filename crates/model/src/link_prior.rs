//! The prior on link inertias: the URDF's links, each with an error relative to its size.
//!
//! Method: a link of pseudo-inertia `J = L Lᵀ` differs from the URDF's by `L (x 1 + X) Lᵀ`. Its density is known to the
//! prior scale `r`: `x` is normal with this standard deviation, and all moments of mass go with it, as in a link of another
//! material or wall thickness. So is its shape: `X` is symmetric, its diagonal normal with `r`, the rest with `r / √2`, so
//! that every second moment of mass, along every line, is known to `r` of its size. The prior depends on neither units nor
//! frames: `tr((J⁻¹ dJ)²)` is the metric that the physical consistency uses too; in it alone a link that is only heavier
//! would be as unlikely as four errors of its shape. Errors of each parameter apart, relative to mass times length squared,
//! would question a slender link's thickness as much as its length.
//!
//! References: T. Lee, F. C. Park, A geometric algorithm for robust multibody inertial parameter
//! identification, IEEE RA-L 3(3), 2018.

use std::f64::consts::FRAC_1_SQRT_2;

use armident_kinematics::InertialParameters;
use nalgebra::Matrix4;

/// A link the description gives next to nothing for may still have this share of the mean link's
/// mass, and be as thick as this share of its length.
pub const LEAST_SHARE: f64 = 0.1;

/// An independent error of one link, of one standard deviation at a prior scale of 1.
#[derive(Debug, Clone, Copy)]
pub struct LinkError {
    /// Index of the link.
    pub link: usize,
    /// What it adds to the standard parameters of the link.
    pub change: InertialParameters,
}

/// Independent errors of the links, as many for each, in their order. None when no link has mass or extent: there is no
/// prior.
pub fn link_errors(links: &[InertialParameters]) -> Option<Vec<LinkError>> {
    let mean = MeanLink::of(links)?;
    let of_link = |(link, given): (usize, &InertialParameters)| {
        let root = mean.least_root_of(given);
        std::iter::once(Matrix4::identity()).chain(symmetric_basis()).map(move |error| {
            let change =
                InertialParameters::from_pseudo_inertia(&(root * error * root.transpose()));
            LinkError { link, change }
        })
    };
    Some(links.iter().enumerate().flat_map(of_link).collect())
}

/// An orthonormal basis of the symmetric matrices.
fn symmetric_basis() -> impl Iterator<Item = Matrix4<f64>> {
    (0..4).flat_map(|i| (i..4).map(move |j| (i, j))).map(|(i, j)| {
        let mut error = Matrix4::zeros();
        let size = if i == j { 1.0 } else { FRAC_1_SQRT_2 };
        (error[(i, j)], error[(j, i)]) = (size, size);
        error
    })
}

/// Radius of gyration about the frame origin \[m\]; 0 without mass.
pub fn radius_of_gyration_m(link: &InertialParameters) -> f64 {
    let half_trace = 0.5 * link.inertia_origin_kgm2.trace().abs();
    if link.mass_kg == 0.0 { 0.0 } else { (half_trace / link.mass_kg.abs()).sqrt() }
}

/// What the links of an arm are like in the mean.
#[derive(Debug, Clone, Copy)]
pub struct MeanLink {
    /// Mass \[kg\].
    pub mass_kg: f64,
    /// Radius of gyration about the frame origin \[m\].
    pub length_m: f64,
}

impl MeanLink {
    /// None where no link has mass or extent.
    pub fn of(links: &[InertialParameters]) -> Option<Self> {
        let count = links.len() as f64;
        let mass_kg = links.iter().map(|link| link.mass_kg.abs()).sum::<f64>() / count;
        let length_m = links.iter().map(radius_of_gyration_m).sum::<f64>() / count;
        (mass_kg > 0.0 && length_m > 0.0).then_some(Self { mass_kg, length_m })
    }

    /// A root `L` of the pseudo-inertia `J = L Lᵀ` of the nearest consistent link that is heavy and thick enough: what a
    /// description may be wrong by even where it gives next to nothing.
    fn least_root_of(&self, link: &InertialParameters) -> Matrix4<f64> {
        let body = link.nearest_physical();
        let mass = body.mass_kg.max(LEAST_SHARE * self.mass_kg);
        let least = mass * (LEAST_SHARE * self.length_m).powi(2);
        let eigen = body.second_moment_com_kgm2().symmetric_eigen();
        let thick = eigen.eigenvalues.map(|x| x.max(least));
        InertialParameters::pseudo_inertia_root(mass, body.com_m(), &eigen.eigenvectors, &thick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    /// Mass and second moments of a body are known to the same share; a link
    /// without mass has the errors of a tenth of the mean link.
    #[test]
    fn mass_and_second_moments_are_known_to_the_same_share() {
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.2, 0.3, 0.4));
        let heavy = InertialParameters::from_com(2.0, Vector3::new(0.3, 0.0, 0.4), inertia);
        let errors = link_errors(&[heavy, InertialParameters::zero()]).unwrap();
        assert_eq!(errors.len(), 22);
        let deviation = |link: usize, of: &dyn Fn(&InertialParameters) -> f64| {
            let errors = errors.iter().filter(|error| error.link == link);
            errors.map(|error| of(&error.change).powi(2)).sum::<f64>().sqrt()
        };
        // of density and of shape
        let twice = 2f64.sqrt();
        assert!((deviation(0, &|change| change.mass_kg) - 2.0 * twice).abs() < 1e-9);
        let second = |change: &InertialParameters| change.pseudo_inertia()[(2, 2)];
        assert!((deviation(0, &second) - second(&heavy) * twice).abs() < 1e-9);
        assert!((deviation(1, &|change| change.mass_kg) - 0.1 * twice).abs() < 1e-9);
        assert!(link_errors(&[InertialParameters::zero()]).is_none());
    }
}
