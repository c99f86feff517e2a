//! The prior of the inertia constants: the URDF's links, each with an error relative to its size.
//!
//! Method: a link of pseudo-inertia `J = L Lᵀ` differs from the URDF's by `L X Lᵀ` with `X` symmetric, its diagonal normal
//! with the standard deviation `r` (the prior scale), the rest with `r / √2`: every second moment of mass, along every
//! line, is known to `r` of its size, and the mass too. It depends on neither units nor frames: `tr((J⁻¹ dJ)²)` is the
//! metric that the physical consistency uses too. Errors of each parameter apart, relative to mass times length squared,
//! would doubt a slender link's thickness as much as its length.
//!
//! Links `π ~ N(π₀, D)` give constants `x = T π ~ N(T π₀, T D Tᵀ)`: the prior of a constant follows from that of the links
//! it is made of, with all its correlations.
//!
//! References: T. Lee, F. C. Park, A geometric algorithm for robust multibody inertial parameter
//! identification, IEEE RA-L 3(3), 2018.

use std::f64::consts::FRAC_1_SQRT_2;

use armident_dynamics::RigidArm;
use armident_kinematics::InertialParameters;
use armident_numeric::{Mat, NumericError, PseudoInverse};
use nalgebra::Matrix4;

use crate::minimal_set::MinimalSet;

/// A link the description gives next to nothing for may still have this share of the mean link's
/// mass, and be as thick as this share of its length.
const FLOOR: f64 = 0.1;
/// Widening of the constants that rotor inertia is part of, on which a URDF has no information.
pub(crate) const UNKNOWN: f64 = 1e3;
/// Cut of the decomposition of `T D Tᵀ`; constants of a minimal set are independent.
const RANK_CUT: f64 = 1e-12;

/// Prior of the constants as rows of least squares: `B x ≈ B x₀` with residuals of variance 1.
#[derive(Debug, Clone)]
pub(crate) struct LinkPrior {
    /// `x₀`.
    pub(crate) mean: Vec<f64>,
    /// `B`, with `BᵀB` the inverse of the covariance of the constants.
    pub(crate) rows: Vec<Vec<f64>>,
}

impl LinkPrior {
    /// Second moments of mass of every link known to `relative`; `with_rotor` lists the constants
    /// that also hold a rotor's inertia. None when no link has mass: there is no prior.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub(crate) fn of(
        arm: &RigidArm,
        set: &MinimalSet,
        with_rotor: &[usize],
        relative: f64,
    ) -> Result<Option<Self>, NumericError> {
        let Some(mut spread) = spread_of_links(arm, set, relative) else { return Ok(None) };
        for &k in with_rotor {
            let own = spread.iter().map(|column| column[k].powi(2)).sum::<f64>().sqrt();
            spread.push((0..set.len()).map(|c| if c == k { UNKNOWN * own } else { 0.0 }).collect());
        }

        // the rows of ((T D^(1/2))ᵀ)⁺ᵀ have the inverse of T D Tᵀ for their product
        let tall = Mat::from_fn(spread.len(), set.len(), |i, j| spread[i][j]);
        let inverse = PseudoInverse::of(&tall, RANK_CUT)?;
        let rows = (0..spread.len())
            .map(|i| {
                let unit: Vec<f64> = (0..spread.len()).map(|k| f64::from(k == i)).collect();
                inverse.apply(&unit)
            })
            .collect();
        Ok(Some(Self { mean: set.values(&arm.constants()), rows }))
    }
}

/// Columns `T dπ`: what each independent error of a link, of one standard deviation, does to the
/// constants. None when no link has mass.
fn spread_of_links(arm: &RigidArm, set: &MinimalSet, relative: f64) -> Option<Vec<Vec<f64>>> {
    let mean = MeanLink::of(arm, set)?;
    let least = Least { mass_kg: FLOOR * mean.mass_kg, radius_m: FLOOR * mean.length_m };
    let mut spread: Vec<Vec<f64>> = Vec::with_capacity(10 * arm.links.len());
    for (i, link) in arm.links.iter().enumerate() {
        let root = least.root_of(link);
        for error in directions() {
            let of_link = root * error * root.transpose() * relative;
            spread.push(alone(arm, set, i, InertialParameters::from_pseudo_inertia(&of_link)));
        }
    }
    Some(spread)
}

/// The same where every parameter of a link has an error of its own, as a typing error makes it: the mass
/// relative to the mass, a first moment to mass times length, an inertia to mass times length squared, with the
/// radius of gyration about the frame origin for a length. That is the prior of the input checks: on pieces of real
/// recordings it detects wrong columns better than relative errors of moments do.
///
/// With a `load`, the last link may carry a body of this many times the mean link's mass, of its length,
/// that the description does not know.
pub(crate) fn spread_of_numbers(
    arm: &RigidArm,
    set: &MinimalSet,
    relative: f64,
    load: f64,
) -> Option<Vec<Vec<f64>>> {
    let mean = MeanLink::of(arm, set)?;
    let mut spread: Vec<Vec<f64>> = Vec::with_capacity(10 * (arm.links.len() + 1));
    let last = arm.links.len() - 1;
    let load = (load > 0.0).then_some((last, load * mean.mass_kg, mean.length_m));
    let own = arm.links.iter().enumerate().map(|(i, link)| {
        let mass = relative * link.mass_kg.abs().max(FLOOR * mean.mass_kg);
        (i, mass, gyration(link).max(FLOOR * mean.length_m))
    });
    for (i, mass, length) in own.chain(load) {
        for number in 0..InertialParameters::COUNT {
            let mut unit = [0.0; InertialParameters::COUNT];
            unit[number] = match number {
                0 => mass,
                1..4 => mass * length,
                _ => mass * length * length,
            };
            spread.push(alone(arm, set, i, InertialParameters::from_array(&unit)));
        }
    }
    Some(spread)
}

/// Constants of an arm of one link.
fn alone(arm: &RigidArm, set: &MinimalSet, index: usize, link: InertialParameters) -> Vec<f64> {
    let mut alone = arm.clone();
    alone.links.fill(InertialParameters::zero());
    alone.links[index] = link;
    set.values(&alone.constants())
}

/// Radius of gyration about the frame origin \[m\]; 0 without mass.
fn gyration(link: &InertialParameters) -> f64 {
    let half_trace = 0.5 * link.inertia_origin_kgm2.trace().abs();
    if link.mass_kg == 0.0 { 0.0 } else { (half_trace / link.mass_kg.abs()).sqrt() }
}

/// What the links of an arm are like in the mean.
struct MeanLink {
    mass_kg: f64,
    length_m: f64,
}

impl MeanLink {
    /// None where there is no prior: no link has mass, or efforts depend on no constant.
    fn of(arm: &RigidArm, set: &MinimalSet) -> Option<Self> {
        let count = arm.links.len() as f64;
        let mass_kg = arm.links.iter().map(|l| l.mass_kg.abs()).sum::<f64>() / count;
        let length_m = arm.links.iter().map(gyration).sum::<f64>() / count;
        (mass_kg > 0.0 && length_m > 0.0 && !set.is_empty()).then_some(Self { mass_kg, length_m })
    }
}

/// An orthonormal basis of the symmetric matrices.
fn directions() -> impl Iterator<Item = Matrix4<f64>> {
    (0..4).flat_map(|i| (i..4).map(move |j| (i, j))).map(|(i, j)| {
        let mut error = Matrix4::zeros();
        let size = if i == j { 1.0 } else { FRAC_1_SQRT_2 };
        (error[(i, j)], error[(j, i)]) = (size, size);
        error
    })
}

/// What a description may be wrong by even where it gives next to nothing.
struct Least {
    mass_kg: f64,
    radius_m: f64,
}

impl Least {
    /// A root `L` of the pseudo-inertia `J = L L'` of the nearest real body that is heavy and thick enough.
    fn root_of(&self, link: &InertialParameters) -> Matrix4<f64> {
        let body = link.nearest_physical();
        let mass = body.mass_kg.max(self.mass_kg);
        let eigen = body.second_moment_com_kgm2().symmetric_eigen();
        let thick = eigen.eigenvalues.map(|x| x.max(mass * self.radius_m.powi(2)));
        InertialParameters::pseudo_inertia_root(mass, body.com_m(), &eigen.eigenvectors, &thick)
    }
}
