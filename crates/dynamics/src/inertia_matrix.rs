//! Renaud's inertia matrix and the gravity effort, read off the composite bodies.

use armident_kinematics::JointKind::{Rotational, Translational};
use nalgebra::{DMatrix, Vector3};

use crate::arm::{JointPose, RigidArm};
use crate::composite::{CompositeBody, composite_bodies, composite_bodies_into};
use crate::kernels::{Columns, inertia_matrices_into, inertia_matrix_from_bodies};

/// Inertia matrix `H(q)`, n x n symmetric \[kg m2, kg m or kg by the joints' kinds\]
/// (Lin 1992, eq. 9 and 10).
pub fn inertia_matrix(arm: &RigidArm, q: &[f64]) -> DMatrix<f64> {
    let n = arm.dof();
    let mut h = DMatrix::from_element(n, n, 0.0);
    inertia_matrix_into(arm, q, &mut InertiaSweep::new(n), h.as_mut_slice());
    h
}

/// Scratch memory of [`inertia_matrix_into`]: no allocation per sample.
#[derive(Debug, Clone)]
pub struct InertiaSweep {
    poses: Vec<JointPose>,
    bodies: Vec<CompositeBody>,
}

impl InertiaSweep {
    /// Scratch for `dof` joints.
    pub fn new(dof: usize) -> Self {
        Self { poses: Vec::with_capacity(dof), bodies: Vec::with_capacity(dof) }
    }
}

/// [`inertia_matrix`] without allocation; `h` has n² entries (the matrix is symmetric, so row- and
/// column-major are the same).
pub fn inertia_matrix_into(arm: &RigidArm, q: &[f64], sweep: &mut InertiaSweep, h: &mut [f64]) {
    arm.poses_into(q, &mut sweep.poses);
    composite_bodies_into(arm, &sweep.poses, &mut sweep.bodies);
    inertia_matrix_from_bodies(arm, &sweep.poses, &sweep.bodies, h);
}

/// [`inertia_matrix`] from composite bodies already at hand: (9) and (10) as they are printed.
pub fn inertia_matrix_of(
    arm: &RigidArm,
    poses: &[JointPose],
    bodies: &[CompositeBody],
) -> DMatrix<f64> {
    let n = arm.dof();
    let mut h = DMatrix::from_element(n, n, 0.0);
    fill(arm, poses, bodies, h.as_mut_slice());
    h
}

/// Inertia matrices at the joint positions `q[joint][sample]` of a motion: the upper triangle row by row, each entry a column
/// of one number a sample (`H_11, H_12 .. H_1n, H_22 .. H_nn`).
///
/// # Panics
/// When there are not n columns of one length.
pub fn inertia_matrices_of_motion(arm: &RigidArm, q: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = arm.dof();
    assert_eq!(q.len(), n, "one column per joint");
    let q: Vec<&[f64]> = q.iter().map(Vec::as_slice).collect();
    let mut matrix = vec![vec![0.0; q[0].len()]; n * (n + 1) / 2];
    inertia_matrices_into(arm, &Columns { q: &q, dq: &q, ddq: &q }, &mut matrix);
    matrix
}

fn fill(arm: &RigidArm, poses: &[JointPose], bodies: &[CompositeBody], h: &mut [f64]) {
    let n = arm.dof();
    let (zero, one) = (0.0, 1.0);
    for m in 0..n {
        let mut u = Vector3::new(zero, zero, one);
        let mut s = Vector3::new(zero, zero, zero);
        for i in m..n {
            if i > m {
                u = poses[i].to_child(&u);
                s = poses[i].to_child(&(s + poses[i].s));
            }
            let (c, j) = (&bodies[i].first_moment, &bodies[i].inertia);
            let mass = bodies[i].mass;
            let a = u.cross(&s);
            let turning = u.y * c.x - u.x * c.y;
            let entry = match (arm.joints[m].kind, arm.joints[i].kind) {
                (Rotational, Rotational) => {
                    u.x * j[(0, 2)] + u.y * j[(1, 2)] + u.z * j[(2, 2)] + a.y * c.x - a.x * c.y
                }
                (Translational, Rotational) => turning,
                (Rotational, Translational) => mass * a.z - turning,
                (Translational, Translational) => mass * u.z,
            };
            h[m * n + i] = entry;
            h[i * n + m] = entry;
        }
    }
}

/// Gravity part `τᵍ(q)` of the actuator effort, length n \[N m or N\] (Lin 1992, eq. 11).
pub fn gravity_effort(arm: &RigidArm, q: &[f64]) -> Vec<f64> {
    let poses = arm.poses(q);
    let bodies = composite_bodies(arm, &poses);
    let gravity = arm.gravity_in_frames(&poses);
    bodies
        .iter()
        .zip(&gravity)
        .zip(&arm.joints)
        .map(|((body, g), joint)| match joint.kind {
            Rotational => g.x * body.first_moment.y - g.y * body.first_moment.x,
            Translational => -g.z * body.mass,
        })
        .collect()
}
