//! Lemma 1: the configuration-independent constants `m̂, k, U` of each composite body, and the
//! varying parts `ℓ, V` (Lin 1992, eq. 12-27 and 36).
//!
//! `ĉ_i = k_i + ℓ_i`, `Ĵ_i = U_i + V_i`. The ten numbers `(m̂_i, k_i, U_i)` of every joint are an
//! invertible linear function of the standard parameters of the links.

use armident_kinematics::{InertialParameters, JointKind};
use nalgebra::{Matrix3, Vector3};

use crate::arm::{JointGeometry, JointPose, RigidArm};
use crate::composite::{pi, sigma};

/// `m̂_i, k_i, U_i` of composite body `i`, in `E_i`.
///
/// The same ten numbers as [`InertialParameters`], of another body: mass, first moment, inertia.
pub type BodyConstants = InertialParameters;

/// Constants of body `p` carried to the frame before it, without the link there: what (18), (20)
/// and (22), (24) add to `(m_i, m_i c_i, I_i + m_i Σ(c_i))`.
pub(crate) fn carried(joint: &JointGeometry, outer: &BodyConstants) -> BodyConstants {
    let (m, k, u) = (outer.mass_kg, outer.first_moment_kgm, outer.inertia_origin_kgm2);
    // at q = 0; for a rotational joint only rotation-invariant combinations are used
    let pose: JointPose = joint.at(0.0);
    match joint.kind {
        JointKind::Rotational => {
            let axis_moment = joint.axis_in_parent() * k.z;
            let invariant = Matrix3::from_diagonal(&Vector3::new(u[(1, 1)], u[(1, 1)], u[(2, 2)]));
            BodyConstants {
                mass_kg: m,
                // (18)
                first_moment_kgm: pose.s * m + axis_moment,
                // (20)
                inertia_origin_kgm2: sigma(&pose.s) * m
                    + pose.tensor_to_parent(&invariant)
                    + pi(&pose.s, &axis_moment),
            }
        }
        JointKind::Translational => {
            let b = Vector3::new(joint.frame.b_m, 0.0, 0.0);
            let turned = pose.to_parent(&k);
            BodyConstants {
                mass_kg: m,
                // (22)
                first_moment_kgm: b * m + turned,
                // (24)
                inertia_origin_kgm2: pose.tensor_to_parent(&u) + sigma(&b) * m + pi(&b, &turned),
            }
        }
    }
}

/// Constants of all bodies from the links, tip to base (14)-(24).
pub fn constants_from_links(
    joints: &[JointGeometry],
    links: &[InertialParameters],
) -> Vec<BodyConstants> {
    let mut constants = links.to_vec();
    for p in (1..constants.len()).rev() {
        constants[p - 1] = constants[p - 1].plus(&carried(&joints[p], &constants[p]));
    }
    constants
}

/// The links that have the given constants: the inverse of [`constants_from_links`].
pub fn links_from_constants(
    joints: &[JointGeometry],
    constants: &[BodyConstants],
) -> Vec<InertialParameters> {
    let mut links = constants.to_vec();
    for p in 1..links.len() {
        let added = carried(&joints[p], &constants[p]);
        let link = &mut links[p - 1];
        link.mass_kg -= added.mass_kg;
        link.first_moment_kgm -= added.first_moment_kgm;
        link.inertia_origin_kgm2 -= added.inertia_origin_kgm2;
    }
    links
}

/// The configuration-dependent parts of one composite body, in `E_i`.
#[derive(Debug, Clone, Copy)]
pub struct VaryingParts {
    /// `ℓ_i` \[kg m\].
    pub first_moment: Vector3<f64>,
    /// `V_i` \[kg m2\].
    pub inertia: Matrix3<f64>,
}

/// `W(U)`: the part of `U` of a rotational joint that turns with it.
fn turning_part(u: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::new(
        u[(0, 0)] - u[(1, 1)],
        u[(0, 1)],
        u[(0, 2)],
        u[(0, 1)],
        0.0,
        u[(1, 2)],
        u[(0, 2)],
        u[(1, 2)],
        0.0,
    )
}

/// `ℓ_i, V_i` of all bodies at positions `q` (length n): (19), (21), (23), (36).
///
/// Fed with the constants of Theorem 2 alone (all others zero) this is Algorithm 1: the entries
/// that enter `H` and `τᵍ` are then right, the others need not be.
pub fn varying_parts(
    joints: &[JointGeometry],
    constants: &[BodyConstants],
    q: &[f64],
) -> Vec<VaryingParts> {
    let zero = 0.0;
    let none = VaryingParts {
        first_moment: Vector3::from_element(zero),
        inertia: Matrix3::from_element(zero),
    };
    let mut parts = vec![none; joints.len()];
    for p in (1..joints.len()).rev() {
        let (joint, outer) = (&joints[p], &constants[p]);
        let pose = joint.at(q[p]);
        let k = outer.first_moment_kgm;
        let VaryingParts { first_moment: l, inertia: v } = parts[p];
        parts[p - 1] = match joint.kind {
            JointKind::Rotational => {
                // (19)
                let turning = Vector3::new(l.x + k.x, l.y + k.y, l.z);
                let first_moment = pose.to_parent(&turning);
                // (21)
                let inertia = pose
                    .tensor_to_parent(&(v + turning_part(&outer.inertia_origin_kgm2)))
                    + pi(&pose.s, &first_moment);
                VaryingParts { first_moment, inertia }
            }
            JointKind::Translational => {
                let m = outer.mass_kg;
                let b = joint.frame.b_m;
                let d = joint.offset_m(q[p]);
                let (sin, cos) = joint.frame.theta_rad.sin_cos();
                let c = k + l;
                // T_p of (36)
                let (mdd, md) = (m * d * d, m * d);
                let t12 = b * (sin * l.x - cos * l.y);
                let t13 = -b * cos * (l.z + md);
                let t23 = b * sin * (l.z + md);
                let t = Matrix3::new(
                    mdd - 2.0 * b * sin * l.y,
                    t12,
                    t13,
                    t12,
                    mdd + 2.0 * b * cos * l.x,
                    t23,
                    t13,
                    t23,
                    2.0 * b * (cos * l.x - sin * l.y),
                );
                let slide = Matrix3::new(
                    2.0 * d * c.z,
                    zero,
                    -d * c.x,
                    zero,
                    2.0 * d * c.z,
                    -d * c.y,
                    -d * c.x,
                    -d * c.y,
                    zero,
                );
                VaryingParts {
                    // (23)
                    first_moment: pose.to_parent(&Vector3::new(l.x, l.y, l.z + md)),
                    inertia: pose.tensor_to_parent(&(v + t + slide)),
                }
            }
        };
    }
    parts
}

impl RigidArm {
    /// `m̂, k, U` of all bodies.
    pub fn constants(&self) -> Vec<BodyConstants> {
        constants_from_links(&self.joints, &self.links)
    }

    /// The same geometry with links that have these constants.
    #[must_use]
    pub fn with_constants(&self, constants: &[BodyConstants]) -> Self {
        self.with_links(links_from_constants(&self.joints, constants))
    }
}
