//! The prior of the inertia constants: that of the links (`armident_model::link_errors`), in the constants.
//!
//! Links `π ~ N(π₀, D)` give constants `x = T π ~ N(T π₀, T D Tᵀ)`: the prior of a constant follows from that of the links
//! it is made of, with all its correlations.
//!
//! Source: own, from the prior on the links.

use crate::minimal_set::MinimalSet;
use armident_dynamics::RigidArm;
use armident_kinematics::InertialParameters;
use armident_model::{LEAST_SHARE, LinkError, MeanLink, link_errors, radius_of_gyration_m};
use armident_numeric::{Mat, NumericError, PseudoInverse};

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
    if set.is_empty() {
        return None;
    }
    let in_constants = |error: LinkError| {
        let change = error.change.to_array().map(|x| x * relative);
        alone(arm, set, error.link, InertialParameters::from_array(&change))
    };
    Some(link_errors(&arm.links)?.into_iter().map(in_constants).collect())
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
    let mean = MeanLink::of(&arm.links).filter(|_| !set.is_empty())?;
    let mut spread: Vec<Vec<f64>> = Vec::with_capacity(10 * (arm.links.len() + 1));
    let last = arm.links.len() - 1;
    let load = (load > 0.0).then_some((last, load * mean.mass_kg, mean.length_m));
    let own = arm.links.iter().enumerate().map(|(i, link)| {
        let mass = relative * link.mass_kg.abs().max(LEAST_SHARE * mean.mass_kg);
        (i, mass, radius_of_gyration_m(link).max(LEAST_SHARE * mean.length_m))
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
