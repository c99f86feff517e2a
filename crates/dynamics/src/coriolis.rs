//! Coriolis and centrifugal effort from derivatives of the inertia matrix (Lin 1992, eq. 30-32).

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4};

use armident_kinematics::JointKind;
use nalgebra::DMatrix;

use crate::arm::RigidArm;
use crate::inertia_matrix::inertia_matrix;

/// `∂H/∂q_k` at `q`, one n x n matrix per k, exact to round-off.
///
/// No symbols and no small steps: every entry of `H` is a trigonometric polynomial of degree at most
/// 2 in a rotational coordinate and a polynomial of degree at most 2 in a translational one. With the
/// odd parts `g(h) = (H(q+h) - H(q-h))/2`, the former has the derivative `b₁ + 2 b₂` where
/// `b₁ = g(π/2)` and `b₂ = g(π/4) - b₁/√2`; the latter `g(1)`.
pub fn inertia_matrix_derivatives(arm: &RigidArm, q: &[f64]) -> Vec<DMatrix<f64>> {
    let odd = |k: usize, step: f64| {
        let shifted = |by: f64| {
            let mut at = q.to_vec();
            at[k] += by;
            inertia_matrix(arm, &at)
        };
        (shifted(step) - shifted(-step)) * 0.5
    };
    (0..arm.dof())
        .map(|k| match arm.joints[k].kind {
            JointKind::Rotational => {
                let first = odd(k, FRAC_PI_2);
                let second = odd(k, FRAC_PI_4) - &first * FRAC_1_SQRT_2;
                first + second * 2.0
            }
            JointKind::Translational => odd(k, 1.0),
        })
        .collect()
}

/// Coriolis and centrifugal effort `τᶜ(q, q̇)`, length n (30)-(32).
///
/// Costs 4n inertia matrices: a check of Newton-Euler, not a method for simulation.
pub fn coriolis_effort(arm: &RigidArm, q: &[f64], dq: &[f64]) -> Vec<f64> {
    let dh = inertia_matrix_derivatives(arm, q);
    let n = arm.dof();
    let mut effort = vec![0.0; n];
    for i in 0..n {
        for j in 0..n {
            // (32)
            let centrifugal = dh[j][(i, j)] - 0.5 * dh[i][(j, j)];
            effort[i] += centrifugal * dq[j] * dq[j];
            for k in j + 1..n {
                // (31)
                let c = dh[k][(i, j)] + dh[j][(i, k)] - dh[i][(j, k)];
                effort[i] += c * dq[j] * dq[k];
            }
        }
    }
    effort
}
