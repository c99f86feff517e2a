//! What the robot description says of the constants, and how far it is believed.
//!
//! A link of pseudo-inertia `J = L Lᵀ` is off by `L X Lᵀ` with `X` symmetric, its diagonal normal with the
//! standard deviation `r`, the rest with `r / √2`: every second moment of mass, along every line, is known
//! to `r` of its size, and the mass too. It depends on neither units nor frames: `tr((J⁻¹ dJ)²)` is the
//! metric of Lee, Park (2018) that the physical consistency uses too. Errors of each number apart, relative to
//! mass times length squared, would doubt a slender link's thickness as much as its length.
//!
//! Links `π ~ N(π₀, D)` give constants `x = T π ~ N(T π₀, T D Tᵀ)`: the belief in a constant follows from
//! that in the links it is made of, with all its correlations.
//!
//! How large `r` is, the recordings say: where the description and they speak of the same constants, they are
//! as far apart as the links are off ([`BatchProblem::doubt_of_links`]).
//!
//! References: T. Lee, F. C. Park, A geometric algorithm for robust multibody inertial parameter
//! identification, IEEE RA-L 3(3), 2018.

use std::f64::consts::FRAC_1_SQRT_2;

use armident_dynamics::RigidArm;
use armident_kinematics::InertialParameters;
use armident_numeric::{Mat, NumericError, PseudoInverse};
use nalgebra::Matrix4;

use crate::batch::{self, BatchProblem, BatchSettings, Beliefs, Term, TermPrior, triangle_of};
use crate::minimal_set::MinimalSet;
use crate::rows::JointRows;

/// A link the description gives next to nothing for may still have this share of the mean link's
/// mass, and be as thick as this share of its length.
const FLOOR: f64 = 0.1;
/// Widening of the constants that rotor inertia is part of, about which a description says nothing.
pub(crate) const UNKNOWN: f64 = 1e3;
/// Doubts `r` that are tried: from the best that vendors' numbers are, to links that say nothing.
const LEAST_DOUBT: f64 = 0.1;
const MOST_DOUBT: f64 = 3.0;
/// Steps between them, each of 12 %: an arm's constants hardly tell them apart.
const DOUBTS: usize = 30;
/// Twice the logarithm of the evidence that a larger doubt may be behind the likeliest: one standard error of
/// a parameter. What is believed too far is claimed too surely.
const ONE_STANDARD_ERROR: f64 = 1.0;
/// Cut of the decomposition of `T D Tᵀ`; constants of a minimal set are independent.
const RANK_CUT: f64 = 1e-12;

/// Belief in the constants as rows of least squares: `B x ≈ B x₀` with residuals of variance 1.
#[derive(Debug, Clone)]
pub(crate) struct LinkPrior {
    /// `x₀`.
    pub(crate) mean: Vec<f64>,
    /// `B`, with `BᵀB` the inverse of the covariance of the constants.
    pub(crate) rows: Vec<Vec<f64>>,
}

impl LinkPrior {
    /// Second moments of mass of every link known to `relative`; `with_rotor` lists the constants
    /// that also hold a rotor's inertia. None when no link has mass: there is nothing to believe.
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

impl BatchProblem<'_> {
    /// How far the links are off the description, as accumulated recordings have it: the largest `r` that is
    /// within a standard error of the likeliest. None where the description gives no link a mass: there is
    /// nothing to believe.
    ///
    /// With the effects projected out, the constants `x` and the prior's `N(x₀, r² C)` give efforts the
    /// density `|r² C|^(-1/2) |A' A + C⁻¹/r²|^(-1/2) exp(-S/2)`, `S` the squares left by both together
    /// (MacKay 1992, Bayesian interpolation, eq. 2.9); each joint's noise is that of the fit with the given
    /// settings, and dependent samples count for less.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub(crate) fn doubt_of_links(
        &self,
        rows: &JointRows,
        settings: &BatchSettings,
    ) -> Result<Option<f64>, NumericError> {
        // the prior's rows are in proportion to 1/r
        let Some(TermPrior { mean, rows: at_one }) = self.believed_links(1.0)? else {
            return Ok(None);
        };
        let noise = self.estimate_with(rows, settings)?.effort_noise;
        let besides = TermPrior { mean, rows: self.load_prior() };
        let besides = Beliefs { bound: None, prior: Some(besides) };
        let (recorded, _) = self.information(rows, &noise, &besides);
        let at_one = triangle_of(&at_one, self.terms.len());
        let terms: Vec<usize> = (0..self.terms.len()).collect();
        let constants = self.terms.iter().filter(|t| matches!(t, Term::Constant(_))).count() as f64;
        let step = (MOST_DOUBT / LEAST_DOUBT).powf((DOUBTS as f64).recip());
        let doubts: Vec<f64> = (0..=DOUBTS).map(|k| LEAST_DOUBT * step.powi(k as i32)).collect();
        let evidence = doubts
            .iter()
            .map(|&doubt| {
                let mut all = recorded.clone();
                all.merge_weighted(&at_one, &terms, 1.0 / (doubt * rows.share.sqrt()));
                let root = all.root(1.0);
                let diagonal = (0..root.nrows()).map(|k| root[(k, k)].abs());
                let determinant: f64 = diagonal.map(|d| d.max(f64::MIN_POSITIVE).ln()).sum();
                let left = rows.share * all.solve(batch::RANK_CUT)?.residual_sum_of_squares;
                Ok(-2.0 * (constants * doubt.ln() + determinant) - left)
            })
            .collect::<Result<Vec<f64>, NumericError>>()?;
        let most = evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let near = |k: &usize| evidence[*k] >= most - ONE_STANDARD_ERROR;
        Ok((0..=DOUBTS).rev().find(near).map(|k| doubts[k]))
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

/// The same where every number of a link may be wrong by itself, as a slip of a pen makes it: the mass
/// relative to the mass, a first moment to mass times length, an inertia to mass times length squared, with the
/// radius of gyration about the frame origin for a length. That is what a check of columns has to reckon with:
/// on pieces of real recordings it tells wrong columns better than relative errors of moments do.
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
    /// None where there is nothing to believe: no link has mass, or no constant matters.
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
