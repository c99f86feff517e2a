//! Composite bodies: body `i` is the links `i..n` frozen together (Lin 1992, eq. 5-7).

use nalgebra::{Matrix3, Vector3};

use crate::arm::{JointPose, RigidArm};

/// `Σ(a) = (a·a) 1 - a aᵀ = -[a×][a×]`.
#[inline(always)]
pub fn sigma(a: &Vector3<f64>) -> Matrix3<f64> {
    let aa = a.dot(a);
    let mut m = -(a * a.transpose());
    for i in 0..3 {
        m[(i, i)] += aa;
    }
    m
}

/// `Π(a, b) = 2 (a·b) 1 - (a bᵀ + b aᵀ) = -[a×][b×] - [b×][a×]`.
#[inline(always)]
pub fn pi(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    let (xx, yy, zz) = (2.0 * a.x * b.x, 2.0 * a.y * b.y, 2.0 * a.z * b.z);
    let (xy, xz, yz) = (a.x * b.y + a.y * b.x, a.x * b.z + a.z * b.x, a.y * b.z + a.z * b.y);
    Matrix3::new(yy + zz, -xy, -xz, -xy, xx + zz, -yz, -xz, -yz, xx + yy)
}

/// Mass, first moment and inertia of a composite body about `O_i`, in `E_i`.
#[derive(Debug, Clone, Copy)]
pub struct CompositeBody {
    /// `m̂_i` \[kg\] (5).
    pub mass: f64,
    /// `ĉ_i`, mass times centre of mass \[kg m\] (6).
    pub first_moment: Vector3<f64>,
    /// `Ĵ_i` \[kg m2\] (7).
    pub inertia: Matrix3<f64>,
}

/// Composite bodies 1..n at the given joint poses, from the tip to the base.
///
/// The sums (5)-(7) by recursion: `m̂_i = m_i + m̂_p`, `ĉ_i = m_i c_i + R ĉ_p + m̂_p s`,
/// `Ĵ_i = J_i + R Ĵ_p Rᵀ + m̂_p Σ(s) + Π(s, R ĉ_p)` with `p = i + 1`.
pub fn composite_bodies(arm: &RigidArm, poses: &[JointPose]) -> Vec<CompositeBody> {
    let mut bodies = Vec::with_capacity(arm.dof());
    composite_bodies_into(arm, poses, &mut bodies);
    bodies
}

/// [`composite_bodies`] into memory that is kept between samples.
pub(crate) fn composite_bodies_into(
    arm: &RigidArm,
    poses: &[JointPose],
    bodies: &mut Vec<CompositeBody>,
) {
    bodies.clear();
    bodies.extend(arm.links.iter().map(|link| CompositeBody {
        mass: link.mass_kg,
        first_moment: link.first_moment_kgm,
        inertia: link.inertia_origin_kgm2,
    }));
    for p in (1..bodies.len()).rev() {
        let (outer, pose) = (bodies[p], &poses[p]);
        let mass = outer.mass;
        let turned = pose.to_parent(&outer.first_moment);
        let body = &mut bodies[p - 1];
        body.mass += outer.mass;
        body.first_moment += turned + pose.s * mass;
        // m Σ(s) = Π(s, m s / 2)
        body.inertia +=
            pose.tensor_to_parent(&outer.inertia) + pi(&pose.s, &(turned + pose.s * (0.5 * mass)));
    }
}
