//! Physical consistency: the links and effects that a real arm could have, nearest to an estimate.
//!
//! A link is real when its pseudo-inertia is positive semidefinite (Wensing, Kim, Slotine 2018;
//! Traversaro et al. 2016), friction and rotor inertia when they are not negative. With `θ` the ten
//! standard parameters of every link and the parameters of the effects, `E θ` what is estimated,
//! `x̂` the estimate and `W` its information matrix:
//!
//! ```text
//! g(θ) = ½ (E θ - x̂)ᵀ W (E θ - x̂)                     half the squared distance in standard errors
//! d(θ) = Σ_links  tr(J₀⁻¹J) - log det(J₀⁻¹J) - 4        nearness to the links J₀ of the URDF
//! ```
//!
//! * When real links and effects have exactly the estimated values, the answer is the one of them
//!   with the smallest `d`.
//! * Otherwise it minimises `g + λ d` over the real ones, and the distance is reported. The weight
//!   `λ` (1e-4 unless given) is far below what data can tell, but not zero: the smallest `g` may only
//!   be approached by ever heavier links (a first moment without inertia is that of an infinite mass
//!   at no distance), which no one wants.
//!
//! `d` is the entropic divergence of Lee, Wensing, Park (2020): it depends on neither units nor frames,
//! its Hessian is half the affine-invariant metric of Lee and Park (2018), and it is the barrier of the
//! cone at the same time ([`barrier`]).
//!
//! References: P. M. Wensing, S. Kim, J.-J. E. Slotine, Linear matrix inequalities for physically
//! consistent inertial parameter identification, IEEE RA-L 3(1), 2018. S. Traversaro et al.,
//! Identification of fully physical consistent inertial parameters using optimization on manifolds,
//! IROS 2016. T. Lee, F. C. Park, A geometric algorithm for robust multibody inertial parameter
//! identification, IEEE RA-L 3(3), 2018. T. Lee, P. M. Wensing, F. C. Park, Geometric robot dynamic
//! identification: a convex programming approach, IEEE T-RO 36(2), 2020.

mod barrier;
mod point;
mod scaled;

use armident_dynamics::{RigidArm, constants_from_links};
use armident_kinematics::InertialParameters;
use armident_numeric::{Mat, NumericError};
use nalgebra::{Matrix4, Vector3};

use crate::minimal_set::MinimalSet;
use barrier::{Barrier, Bound, Centre, DualityGap};
use point::{Point, TEN};

/// Default of the weight `λ`, in squared standard errors per unit of divergence.
const WEIGHT: f64 = 1e-4;
/// Effects below this share of a standard error may as well be absent.
const NEXT_TO_NOTHING: f64 = 1e-3;
/// What is merged into a constant and not known otherwise stays near this share of the constant: a
/// description says nothing of it.
const SHARE_OF_MERGED: f64 = 1e-4;
/// A value of more standard errors than this is exact.
const MOST_STANDARD_ERRORS: f64 = 1e9;
/// Estimates farther out than this many standard errors are not the consistent ones.
const FARTHEST_EXACT: f64 = 0.1;
/// Divergence gap of a converged answer, relative to `1 + d`.
const CONVERGED: f64 = 1e-8;
/// The entropic divergence needs a URDF link strictly inside: principal second moments are raised
/// to this share of their mean (a rod's thickness to a hundredth of its length),
const THINNEST: f64 = 1e-4;
/// that mean to this share of what is usual on the arm for the mass (a tenth of the extent),
const SMALLEST: f64 = 1e-2;
/// and masses to this share of the arm's mean.
const LIGHTEST: f64 = 1e-3;
/// Radius of gyration of a body without extent on an arm without extent \[m\].
const SOME_RADIUS: f64 = 0.1;

/// A parameter of an effect on a joint, as an unknown beside the links.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectUnknown {
    /// Entries of the estimate that it adds to, with coefficients: its own entry with 1, or the
    /// entries it is merged into (rotor inertia of the first joint and `U1_33`).
    pub adds_to: Vec<(usize, f64)>,
    /// Whether it must not be negative.
    pub non_negative: bool,
    /// Whether the entries it adds to hold more than it: then it is absent where the links alone
    /// explain them.
    pub merged: bool,
    /// Value to stay near where the estimate leaves a choice; its own estimate when absent (next to
    /// nothing for what is merged into a constant).
    pub prior: Option<f64>,
}

impl EffectUnknown {
    /// First entry that it adds to, with the coefficient.
    fn own_entry(&self) -> Option<(usize, f64)> {
        self.adds_to.iter().copied().find(|&(_, coefficient)| coefficient != 0.0)
    }

    /// Whether the estimate has it at zero.
    fn is_zero(&self, estimated: &[f64]) -> bool {
        self.own_entry().is_some_and(|(row, _)| estimated[row] == 0.0)
    }

    /// Standard error of its first entry were all others known; 0 when it was not measured.
    fn standard_error(&self, root: &Mat<f64>) -> f64 {
        let Some((row, coefficient)) = self.own_entry() else { return 0.0 };
        let information: f64 = (0..root.nrows()).map(|i| root[(i, row)].powi(2)).sum();
        if information > 0.0 { (information.sqrt() * coefficient).abs().recip() } else { 0.0 }
    }
}

/// Which links and effects an estimate is to be explained by.
#[derive(Debug, Clone)]
pub struct ConsistencyProblem {
    prior: Vec<InertialParameters>,
    effects: Vec<EffectUnknown>,
    weight: f64,
    /// `E`, rows of the estimate by `10 n` parameters and one column per effect
    map: Mat<f64>,
}

/// Links and effects that a real arm could have.
#[derive(Debug, Clone)]
pub struct Consistent {
    /// The links, each in its own frame.
    pub links: Vec<InertialParameters>,
    /// The effects, in the order of the problem.
    pub effects: Vec<f64>,
    /// `E θ`: the estimate made consistent, in its order.
    pub estimated: Vec<f64>,
    /// `((E θ - x̂)ᵀ W (E θ - x̂))^½`; round-off when [`Self::exact`].
    pub distance_in_standard_errors: f64,
    /// Lower bound of that distance over all consistent links up to [`Self::gap_holds_to`]: the
    /// certificate. 0 when exact.
    pub distance_at_least: f64,
    /// Whether the estimate itself is consistent.
    pub exact: bool,
    /// Duality gap of half the squared distance, in squared standard errors.
    pub duality_gap: f64,
    /// Size of the links up to which the gap holds: mean of `tr(J₀⁻¹J) / 4`, 1 for the URDF.
    pub gap_holds_to: f64,
    /// Entropic divergence of the links from the URDF's.
    pub divergence: f64,
    /// How far `g / λ + d` is above its smallest value, at most; 0 when exact.
    pub divergence_gap: f64,
    /// Smallest eigenvalue of every link's pseudo-inertia (entries in kg, kg m and kg m2).
    pub smallest_eigenvalues: Vec<f64>,
    /// Joints, from 0, whose URDF link no real body has: replaced by
    /// [`InertialParameters::nearest_physical`] first.
    pub prior_projected: Vec<usize>,
    /// Joints, from 0, whose URDF link has no mass or no thickness: a tiny one is used instead.
    pub prior_thickened: Vec<usize>,
    /// The weight `λ` used: the one asked for, or what round-off leaves of it.
    pub weight: f64,
    /// Newton steps.
    pub steps: usize,
    /// Whether `divergence_gap` is below 1e-8 of `1 + divergence`; if not, the gaps still hold.
    pub converged: bool,
}

/// Why no consistent set can be computed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ConsistencyError {
    /// Vectors and matrices that do not fit.
    #[error("{what} has {found} entries, expected {expected}")]
    Size {
        /// Which one.
        what: &'static str,
        /// Its size.
        found: usize,
        /// The size that fits.
        expected: usize,
    },
    /// A URDF link, prior or coefficient that is not finite.
    #[error("{what} of joint or effect {index} (from 1) is not finite")]
    NotFinite {
        /// Which number.
        what: &'static str,
        /// Joint or effect, from 1.
        index: usize,
    },
    /// The estimate or its information is not finite.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

impl ConsistencyProblem {
    /// The minimal constants of an arm in the order of the set, then further entries as the effects
    /// name them; the arm's own links are those to stay near.
    pub fn new(arm: &RigidArm, set: &MinimalSet, effects: &[EffectUnknown]) -> Self {
        let standard = TEN * arm.dof();
        let last = effects.iter().flat_map(|e| e.adds_to.iter().map(|&(row, _)| row + 1)).max();
        let rows = set.len().max(last.unwrap_or(0));
        let mut map = Mat::zeros(rows, standard + effects.len());
        for column in 0..standard {
            let mut links = vec![InertialParameters::zero(); arm.dof()];
            let mut unit = [0.0; TEN];
            unit[column % TEN] = 1.0;
            links[column / TEN] = InertialParameters::from_array(&unit);
            let constants = set.values(&constants_from_links(&arm.joints, &links));
            for (row, value) in constants.into_iter().enumerate() {
                map[(row, column)] = value;
            }
        }
        for (k, effect) in effects.iter().enumerate() {
            for &(row, coefficient) in &effect.adds_to {
                map[(row, standard + k)] += coefficient;
            }
        }
        Self { prior: arm.links.clone(), effects: effects.to_vec(), weight: WEIGHT, map }
    }

    /// The same with another weight `λ`, in squared standard errors per unit of divergence.
    ///
    /// Values that are not positive are taken as the smallest positive one.
    #[must_use]
    pub fn with_weight(self, weight: f64) -> Self {
        Self { weight: weight.max(f64::MIN_POSITIVE), ..self }
    }

    /// `E`: what is estimated, by `10 n` standard parameters and the effects.
    pub fn map(&self) -> &Mat<f64> {
        &self.map
    }

    /// The consistent links and effects nearest to an estimate.
    ///
    /// `root` is any matrix with `rootᵀ root` the information matrix of `estimated`:
    /// [`armident_numeric::information_root`] of a covariance, or a triangle. What has no information
    /// is filled in from the URDF, whatever `estimated` says.
    ///
    /// # Errors
    /// [`ConsistencyError`] when sizes do not fit or a number is not finite.
    pub fn nearest(
        &self,
        estimated: &[f64],
        root: &Mat<f64>,
    ) -> Result<Consistent, ConsistencyError> {
        let rows = self.map.nrows();
        let size = |what, found| match found == rows {
            true => Ok(()),
            false => Err(ConsistencyError::Size { what, found, expected: rows }),
        };
        size("the estimate", estimated.len())?;
        size("a row of the information root", root.ncols())?;
        let prior = Prior::of(&self.prior)?;
        let unit = self.resolved(estimated, root);
        let root = &Mat::from_fn(root.nrows(), root.ncols(), |i, j| unit * root[(i, j)]);
        let scales = self.effect_scales(estimated, root)?;
        let barrier = self.barrier(&prior, &scales, estimated, root);
        let centre = barrier.centre(self.weight)?;
        let certificate = barrier.bound(&centre)?;
        let Centre { point, weight, decrement, steps } = centre;
        let found = Found { point, weight, decrement, steps, certificate, exact: false };
        let found = self.exactly(&barrier, found, &scales, estimated, root)?;
        let found = self.consistent(prior, &scales, &barrier, &found);
        Ok(Consistent {
            distance_in_standard_errors: found.distance_in_standard_errors / unit,
            distance_at_least: found.distance_at_least / unit,
            duality_gap: found.duality_gap / unit / unit,
            ..found
        })
    }

    /// `g` in the unknowns of the barrier: effects are `centre + scale t`.
    fn barrier(
        &self,
        prior: &Prior,
        scales: &[(f64, f64)],
        estimated: &[f64],
        root: &Mat<f64>,
    ) -> Barrier {
        let standard = TEN * self.prior.len();
        let mut map = self.map.clone();
        let mut target = estimated.to_vec();
        for (k, &(centre, scale)) in scales.iter().enumerate() {
            for (row, target) in target.iter_mut().enumerate() {
                *target -= self.map[(row, standard + k)] * centre;
                map[(row, standard + k)] *= scale;
            }
        }
        let bound = |effect: &EffectUnknown| match effect.non_negative {
            true => Bound::NonNegative,
            false => Bound::Free,
        };
        let of_row = |i: usize| (0..root.ncols()).map(|j| root[(i, j)] * target[j]).sum();
        Barrier {
            roots: prior.roots.clone(),
            bounds: self.effects.iter().map(bound).collect(),
            data: root * &map,
            target: (0..root.nrows()).map(of_row).collect(),
        }
    }

    /// Factor that takes standard errors of next to nothing (exact efforts) to a share of the values
    /// that numbers can resolve, the same for all; 1 as a rule.
    fn resolved(&self, estimated: &[f64], root: &Mat<f64>) -> f64 {
        let largest = (0..root.ncols())
            .flat_map(|j| (0..root.nrows()).map(move |i| (root[(i, j)] * estimated[j]).abs()))
            .fold(0.0_f64, f64::max);
        (MOST_STANDARD_ERRORS / largest).min(1.0)
    }

    /// From the end of the path to a point that meets the estimate, if there is one, and with it to
    /// effects that are nothing where they are next to nothing.
    fn exactly(
        &self,
        barrier: &Barrier,
        found: Found,
        scales: &[(f64, f64)],
        estimated: &[f64],
        root: &Mat<f64>,
    ) -> Result<Found, NumericError> {
        let each = |chosen: &dyn Fn(usize, &EffectUnknown) -> bool| -> Vec<bool> {
            let list = self.effects.iter().enumerate();
            list.map(|(k, effect)| effect.non_negative && chosen(k, effect)).collect()
        };
        if barrier.distance(&found.point) < FARTHEST_EXACT {
            // what the estimate has at zero is on the boundary, and stays there
            let absent = each(&|_, effect| !effect.merged && effect.is_zero(estimated));
            let without_merged = each(&|k, effect| effect.merged || absent[k]);
            for absent in [without_merged, absent, vec![false; self.effects.len()]] {
                if let Some(point) = barrier.meet(&found.point, &barrier.target, &absent)? {
                    return Ok(Found { point, exact: true, ..found });
                }
            }
        }
        let mut found = found;
        let little = |k: usize, effect: &EffectUnknown| {
            let (error, value) =
                (effect.standard_error(root), found.point.effects[k] * scales[k].1);
            !effect.merged && error > 0.0 && value < NEXT_TO_NOTHING * error
        };
        let little = each(&little);
        for (t, _) in found.point.effects.iter_mut().zip(&little).filter(|(_, little)| **little) {
            *t = 0.0;
        }
        // the same values of what is measured by the links alone
        let merged = each(&|k, effect| effect.merged || little[k]);
        if merged != little
            && let Some(point) =
                barrier.meet(&found.point, &barrier.value(&found.point), &merged)?
        {
            found.point = point;
        }
        Ok(found)
    }

    fn consistent(
        &self,
        prior: Prior,
        scales: &[(f64, f64)],
        barrier: &Barrier,
        found: &Found,
    ) -> Consistent {
        let Found { point, weight, decrement, steps, certificate, exact } = found;
        let links = point.links(&prior.roots);
        let effects: Vec<f64> = (scales.iter().zip(&point.effects))
            .map(|(&(centre, scale), t)| centre + scale * t)
            .collect();
        let theta: Vec<f64> =
            links.iter().flat_map(InertialParameters::to_array).chain(effects.clone()).collect();
        let estimated = (0..self.map.nrows())
            .map(|row| theta.iter().enumerate().map(|(j, x)| self.map[(row, j)] * x).sum())
            .collect();
        let distance = barrier.distance(point);
        let misfit = 0.5 * distance * distance;
        let gap = if *exact { misfit } else { (misfit - certificate.at_least).max(0.0) };
        let divergence = barrier.divergence(point);
        let divergence_gap = if *exact { 0.0 } else { self_concordant_gap(*decrement) };
        Consistent {
            smallest_eigenvalues: links
                .iter()
                .map(InertialParameters::smallest_pseudo_inertia_eigenvalue)
                .collect(),
            links,
            effects,
            estimated,
            distance_in_standard_errors: distance,
            distance_at_least: (2.0 * (misfit - gap)).max(0.0).sqrt(),
            exact: *exact,
            duality_gap: gap,
            gap_holds_to: certificate.size / (4 * self.prior.len().max(1)) as f64,
            divergence,
            divergence_gap,
            weight: *weight,
            prior_projected: prior.projected,
            prior_thickened: prior.thickened,
            steps: *steps,
            converged: divergence_gap <= CONVERGED * (1.0 + divergence),
        }
    }

    /// Centre and scale of every effect.
    fn effect_scales(
        &self,
        estimated: &[f64],
        root: &Mat<f64>,
    ) -> Result<Vec<(f64, f64)>, ConsistencyError> {
        self.effects
            .iter()
            .enumerate()
            .map(|(k, effect)| {
                let value = effect.own_entry().map_or(0.0, |(row, c)| estimated[row] / c);
                let size = value.abs().max(effect.standard_error(root));
                let size = if size > 0.0 { size } else { 1.0 };
                let size = if effect.merged { SHARE_OF_MERGED * size } else { size };
                let known = effect.prior.unwrap_or(value);
                if !known.is_finite() || !size.is_finite() {
                    return Err(ConsistencyError::NotFinite { what: "the value", index: k + 1 });
                }
                Ok(match (effect.non_negative, effect.prior) {
                    (false, _) => (known, known.abs().max(size)),
                    // the divergence needs a positive number to stay near
                    (true, Some(prior)) => (0.0, prior.max(THINNEST * size)),
                    (true, None) => (0.0, size),
                })
            })
            .collect()
    }
}

/// A point with how it was found.
struct Found {
    point: Point,
    weight: f64,
    decrement: f64,
    steps: usize,
    certificate: DualityGap,
    exact: bool,
}

/// Distance in value to the minimum of a self-concordant function (Boyd and Vandenberghe, 9.50).
fn self_concordant_gap(decrement: f64) -> f64 {
    if decrement < 1e-4 {
        decrement * decrement
    } else if decrement < 1.0 {
        -decrement - (-decrement).ln_1p()
    } else {
        f64::INFINITY
    }
}

/// Roots of the URDF's pseudo-inertias, made strictly positive.
struct Prior {
    /// `Λ` with `J₀ = Λ Λᵀ`
    roots: Vec<Matrix4<f64>>,
    projected: Vec<usize>,
    thickened: Vec<usize>,
}

impl Prior {
    fn of(links: &[InertialParameters]) -> Result<Self, ConsistencyError> {
        let mut projected = Vec::new();
        let mut bodies = Vec::new();
        for (joint, link) in links.iter().enumerate() {
            if link.to_array().iter().any(|x| !x.is_finite()) {
                return Err(ConsistencyError::NotFinite { what: "the link", index: joint + 1 });
            }
            if link.is_physical() {
                bodies.push(*link);
            } else {
                projected.push(joint);
                bodies.push(link.nearest_physical());
            }
        }
        let heavy: Vec<&InertialParameters> = bodies.iter().filter(|b| b.mass_kg > 0.0).collect();
        let total: f64 = heavy.iter().map(|b| b.mass_kg).sum();
        let mean_mass = if total > 0.0 { total / heavy.len() as f64 } else { 1.0 };
        let spread: f64 = heavy.iter().map(|b| b.second_moment_com_kgm2().trace().max(0.0)).sum();
        let radius_squared = if spread > 0.0 { spread / total } else { SOME_RADIUS.powi(2) };

        let mut thickened = Vec::new();
        let mut roots = Vec::new();
        for (joint, body) in bodies.iter().enumerate() {
            let massless = body.mass_kg <= LIGHTEST * mean_mass;
            let mass = if massless { LIGHTEST * mean_mass } else { body.mass_kg };
            let eigen = body.second_moment_com_kgm2().symmetric_eigen();
            let mean = eigen.eigenvalues.sum().max(0.0) / 3.0;
            let of_mass = mass * radius_squared / 3.0;
            let floor = if massless { of_mass } else { THINNEST * mean.max(SMALLEST * of_mass) };
            let moments = eigen.eigenvalues.map(|x| x.max(floor));
            if massless || moments != eigen.eigenvalues {
                thickened.push(joint);
            }
            let com = if massless { Vector3::zeros() } else { body.com_m() };
            let axes = &eigen.eigenvectors;
            roots.push(InertialParameters::pseudo_inertia_root(mass, com, axes, &moments));
        }
        Ok(Self { roots, projected, thickened })
    }
}
