//! What the robot description says of the constants, and how far it is believed.
//!
//! Links `π ~ N(π₀, D)` with a diagonal `D` give constants `x = T π ~ N(T π₀, T D Tᵀ)`: the belief in a
//! constant follows from that in the links it is made of, with all its correlations.

use armident_dynamics::RigidArm;
use armident_kinematics::InertialParameters;
use armident_numeric::{Mat, NumericError, PseudoInverse};

use crate::minimal_set::MinimalSet;

/// A link the description gives next to nothing for may still have this share of the mean link's
/// mass and length.
const FLOOR: f64 = 0.1;
/// Widening of the constants that rotor inertia is part of, about which a description says nothing.
pub(crate) const UNKNOWN: f64 = 1e3;
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
    /// Every number of every link known to `relative` of its size; `with_rotor` lists the constants
    /// that also hold a rotor's inertia. None when no link has mass: there is nothing to believe.
    ///
    /// The size of a mass is the mass, of a first moment mass times length, of an inertia mass times
    /// length squared, with the radius of gyration about the frame origin for a length.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    pub(crate) fn of(
        arm: &RigidArm,
        set: &MinimalSet,
        with_rotor: &[usize],
        relative: f64,
    ) -> Result<Option<Self>, NumericError> {
        let Some(mut spread) = spread_of_links(arm, set, relative, 0.0) else { return Ok(None) };
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

/// Columns of `T D^(1/2)`, one per number of a link: what each of them, off by its standard deviation,
/// does to the constants. None when no link has mass.
///
/// With a `load`, the last link may carry a body of this many times the mean link's mass, of its length,
/// that the description does not know.
pub(crate) fn spread_of_links(
    arm: &RigidArm,
    set: &MinimalSet,
    relative: f64,
    load: f64,
) -> Option<Vec<Vec<f64>>> {
    let count = arm.links.len() as f64;
    let gyration = |link: &InertialParameters| {
        let half_trace = 0.5 * link.inertia_origin_kgm2.trace().abs();
        if link.mass_kg == 0.0 { 0.0 } else { (half_trace / link.mass_kg.abs()).sqrt() }
    };
    let mean_mass = arm.links.iter().map(|l| l.mass_kg.abs()).sum::<f64>() / count;
    let mean_length = arm.links.iter().map(gyration).sum::<f64>() / count;
    if mean_mass == 0.0 || mean_length == 0.0 || set.is_empty() {
        return None;
    }
    let mut spread: Vec<Vec<f64>> = Vec::with_capacity(10 * (arm.links.len() + 1));
    let last = arm.links.len() - 1;
    let load = (load > 0.0).then_some((last, load * mean_mass, mean_length));
    let own = arm.links.iter().enumerate().map(|(i, link)| {
        let mass = relative * link.mass_kg.abs().max(FLOOR * mean_mass);
        (i, mass, gyration(link).max(FLOOR * mean_length))
    });
    for (i, mass, length) in own.chain(load) {
        for number in 0..InertialParameters::COUNT {
            let mut unit = [0.0; InertialParameters::COUNT];
            unit[number] = match number {
                0 => mass,
                1..4 => mass * length,
                _ => mass * length * length,
            };
            let mut alone = arm.clone();
            alone.links.fill(InertialParameters::zero());
            alone.links[i] = InertialParameters::from_array(&unit);
            spread.push(set.values(&alone.constants()));
        }
    }
    Some(spread)
}
