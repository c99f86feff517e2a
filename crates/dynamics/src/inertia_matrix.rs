//! Renaud's inertia matrix and the gravity effort, read off the composite bodies.

use armident_kinematics::JointKind::{Rotational, Translational};
use nalgebra::DMatrix;

use crate::arm::RigidArm;
use crate::composite::{CompositeBody, composite_bodies};
use crate::real::Real;

/// Inertia matrix `H(q)`, n x n symmetric \[kg m2, kg m or kg by the joints' kinds\]
/// (Lin 1992, eq. 9 and 10).
pub fn inertia_matrix<T: Real>(arm: &RigidArm, q: &[T]) -> DMatrix<T> {
    let poses = arm.poses(q);
    let bodies = composite_bodies(arm, &poses);
    inertia_matrix_of(arm, &poses, &bodies)
}

/// [`inertia_matrix`] from composite bodies already at hand.
pub fn inertia_matrix_of<T: Real>(
    arm: &RigidArm,
    poses: &[crate::JointPose<T>],
    bodies: &[CompositeBody<T>],
) -> DMatrix<T> {
    let n = arm.dof();
    let mut h = DMatrix::from_element(n, n, T::splat(0.0));
    for m in 0..n {
        for (i, (u, s)) in (m..n).zip(arm.axis_in_frames(poses, m)) {
            let (c, j) = (&bodies[i].first_moment, &bodies[i].inertia);
            let mass = T::splat(bodies[i].mass);
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
            h[(m, i)] = entry;
            h[(i, m)] = entry;
        }
    }
    h
}

/// Gravity part `τᵍ(q)` of the actuator effort, length n \[N m or N\] (Lin 1992, eq. 11).
pub fn gravity_effort<T: Real>(arm: &RigidArm, q: &[T]) -> Vec<T> {
    let poses = arm.poses(q);
    let bodies = composite_bodies(arm, &poses);
    let gravity = arm.gravity_in_frames(&poses);
    bodies
        .iter()
        .zip(&gravity)
        .zip(&arm.joints)
        .map(|((body, g), joint)| match joint.kind {
            Rotational => g.x * body.first_moment.y - g.y * body.first_moment.x,
            Translational => -g.z * T::splat(body.mass),
        })
        .collect()
}
