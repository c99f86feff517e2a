//! Algorithm 1: the varying parts from the minimal constants alone.

use armident_dynamics::{JointGeometry, VaryingParts, varying_parts};

use super::algorithm_m::MinimalSet;

/// `ℓ_j, V_j` of all bodies at positions `q`, from values of the minimal constants.
///
/// Constants outside the set are zero. The entries that enter the inertia matrix and the gravity
/// effort are then right (for `j >= s` all that matter, for `r <= j < s` only `(V_j)₃₃` and the
/// components of `ℓ_j` whose factors in (9), (11) do not vanish); the others need not be. The
/// recursion of Lemma 1 takes the place of the paper's five-step listing, which is the same loop with
/// one entry singled out.
pub fn algorithm1(
    joints: &[JointGeometry],
    set: &MinimalSet,
    values: &[f64],
    q: &[f64],
) -> Vec<VaryingParts> {
    varying_parts(joints, &set.body_constants(values), q)
}
