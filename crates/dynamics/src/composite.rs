//! Composite bodies: body `i` is the links `i..n` frozen together (Lin 1992, eq. 5-7).

use nalgebra::{Matrix3, Vector3};

use crate::arm::{JointPose, RigidArm};
use crate::real::Real;

/// `Σ(a) = (a·a) 1 - a aᵀ = -[a×][a×]`.
#[inline(always)]
pub fn sigma<T: Real>(a: &Vector3<T>) -> Matrix3<T> {
    let aa = a.dot(a);
    let mut m = -(a * a.transpose());
    for i in 0..3 {
        m[(i, i)] += aa;
    }
    m
}

/// `Π(a, b) = 2 (a·b) 1 - (a bᵀ + b aᵀ) = -[a×][b×] - [b×][a×]`.
#[inline(always)]
pub fn pi<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> Matrix3<T> {
    let ab = a.dot(b);
    let mut m = -(a * b.transpose() + b * a.transpose());
    for i in 0..3 {
        m[(i, i)] += ab + ab;
    }
    m
}

/// Mass, first moment and inertia of a composite body about `O_i`, in `E_i`.
#[derive(Debug, Clone, Copy)]
pub struct CompositeBody<T> {
    /// `m̂_i` \[kg\] (5).
    pub mass: f64,
    /// `ĉ_i`, mass times centre of mass \[kg m\] (6).
    pub first_moment: Vector3<T>,
    /// `Ĵ_i` \[kg m2\] (7).
    pub inertia: Matrix3<T>,
}

/// Composite bodies 1..n at the given joint poses, from the tip to the base.
///
/// The sums (5)-(7) by recursion: `m̂_i = m_i + m̂_p`, `ĉ_i = m_i c_i + R ĉ_p + m̂_p s`,
/// `Ĵ_i = J_i + R Ĵ_p Rᵀ + m̂_p Σ(s) + Π(s, R ĉ_p)` with `p = i + 1`.
pub fn composite_bodies<T: Real>(arm: &RigidArm, poses: &[JointPose<T>]) -> Vec<CompositeBody<T>> {
    let mut bodies = Vec::with_capacity(arm.dof());
    composite_bodies_into(arm, poses, &mut bodies);
    bodies
}

/// [`composite_bodies`] into memory that is kept between samples.
pub(crate) fn composite_bodies_into<T: Real>(
    arm: &RigidArm,
    poses: &[JointPose<T>],
    bodies: &mut Vec<CompositeBody<T>>,
) {
    bodies.clear();
    bodies.extend(arm.links.iter().map(|link| CompositeBody {
        mass: link.mass_kg,
        first_moment: link.first_moment_kgm.map(T::splat),
        inertia: link.inertia_origin_kgm2.map(T::splat),
    }));
    for p in (1..bodies.len()).rev() {
        let (outer, pose) = (bodies[p], &poses[p]);
        let mass = T::splat(outer.mass);
        let turned = pose.to_parent(&outer.first_moment);
        let body = &mut bodies[p - 1];
        body.mass += outer.mass;
        body.first_moment += turned + pose.s * mass;
        body.inertia +=
            pose.tensor_to_parent(&outer.inertia) + sigma(&pose.s) * mass + pi(&pose.s, &turned);
    }
}
