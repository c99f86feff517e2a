//! Forward dynamics: the motion that efforts cause.

use nalgebra::DVector;

use crate::arm::RigidArm;
use crate::inertia_matrix::inertia_matrix;
use crate::newton_euler::inverse_dynamics;

/// An inertia matrix that is not positive definite has no forward dynamics.
#[derive(Debug, Clone, thiserror::Error)]
#[error(
    "the inertia matrix is not positive definite at q = {q:?}: the inertial parameters are unphysical or some joint moves no mass"
)]
pub struct NotPositiveDefinite {
    /// Joint positions \[rad or m\].
    pub q: Vec<f64>,
}

/// Accelerations `q̈` from `H q̈ + τᶜ + τᵍ = τ` (29); all arguments have length n.
///
/// # Errors
/// [`NotPositiveDefinite`] when `H(q)` has no Cholesky factor.
pub fn forward_dynamics(
    arm: &RigidArm,
    q: &[f64],
    dq: &[f64],
    effort: &[f64],
) -> Result<Vec<f64>, NotPositiveDefinite> {
    let bias = inverse_dynamics(arm, q, dq, &vec![0.0; arm.dof()]);
    let driving = DVector::from_iterator(arm.dof(), effort.iter().zip(bias).map(|(e, b)| e - b));
    let factor =
        inertia_matrix(arm, q).cholesky().ok_or_else(|| NotPositiveDefinite { q: q.to_vec() })?;
    Ok(factor.solve(&driving).as_slice().to_vec())
}

/// Kinetic plus potential energy \[J\]; the potential is zero where the arm's mass is in `O_0`.
#[doc(alias = "hamiltonian")]
pub fn energy(arm: &RigidArm, q: &[f64], dq: &[f64]) -> f64 {
    let v = DVector::from_column_slice(dq);
    let kinetic = 0.5 * v.dot(&(inertia_matrix(arm, q) * &v));
    // V = -g0 . (sum of first moments about O_0): the composite first moment of body 1 carried to O_0
    let poses = arm.poses(q);
    let bodies = crate::composite::composite_bodies(arm, &poses);
    let moment = poses[0].to_parent(&bodies[0].first_moment) + poses[0].s * bodies[0].mass;
    kinetic - arm.gravity_e0.dot(&moment)
}
