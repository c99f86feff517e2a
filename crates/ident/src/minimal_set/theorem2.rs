//! Theorem 2 of Lin 1992: which constants can be known, read off the geometry.

use std::collections::BTreeMap;

use armident_dynamics::RigidArm;
use nalgebra::Vector3;

use super::constant::{Constant, ConstantKind};

/// Tolerance of parallel directions (unit vectors) and accumulated offsets \[m\] on a snapped chain,
/// where what is meant to be zero is zero to round-off.
const EXACT: f64 = 1e-9;

/// The structure the theorem reads off an arm, joints counted from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Theorem2 {
    /// First rotational joint.
    pub r: Option<usize>,
    /// First rotational joint after r whose axis is not parallel to that of r.
    pub s: Option<usize>,
    /// For rotational `r <= j < s`: whether `(k_j)_x, (k_j)_y` matter.
    pub delta: BTreeMap<usize, bool>,
    /// For translational `r < i < s`: whether `u_i` is not parallel to `u_r`.
    pub sigma: BTreeMap<usize, bool>,
    /// The constants with the item (1-5) of the theorem that lists them.
    pub constants: Vec<(u8, Constant)>,
}

impl Theorem2 {
    /// Applies the theorem to an arm with its gravity.
    pub fn of(arm: &RigidArm) -> Self {
        let n = arm.dof();
        let poses = arm.poses(&vec![0.0; n]);
        let turns: Vec<bool> = arm.joints.iter().map(|j| j.kind.is_rotational()).collect();
        let r = turns.iter().position(|&t| t);
        // axes r..n in every later frame; relative directions of r..s are constant: read at q = 0
        let from_r = r.map(|r| arm.axis_in_frames(&poses, r));
        let axis_of_r = |i: usize| match (&from_r, r) {
            (Some(all), Some(r)) => all[i - r].0,
            _ => Vector3::z(),
        };
        let along_z = |u: Vector3<f64>| u.x.hypot(u.y) <= EXACT;
        let s = r.and_then(|r| (r + 1..n).find(|&j| turns[j] && !along_z(axis_of_r(j))));
        let (r_end, s_end) = (r.unwrap_or(n), s.unwrap_or(n));

        let mut delta = BTreeMap::new();
        for j in (r_end..s_end).filter(|&j| turns[j]) {
            delta.insert(j, !first_moments_vanish(arm, &poses, &turns, r_end, j));
        }
        let mut sigma = BTreeMap::new();
        for i in (r_end..s_end).filter(|&i| i > r_end && !turns[i]) {
            sigma.insert(i, !along_z(axis_of_r(i)));
        }

        let mut constants = Vec::new();
        let mut list = |item: u8, joint: usize, quantities: &[ConstantKind]| {
            constants
                .extend(quantities.iter().map(|&quantity| (item, Constant { joint, quantity })));
        };
        use ConstantKind::{C1, C2, Kx, Ky, Kz, Mass, U11MinusU22, U12, U13, U23, U33};
        for (&j, &matters) in &delta {
            list(1, j, if matters { &[U33, Kx, Ky] } else { &[U33] });
        }
        for j in (s_end..n).filter(|&j| turns[j]) {
            list(2, j, &[U11MinusU22, U33, U12, U13, U23, Kx, Ky]);
        }
        for i in (0..n).filter(|&i| !turns[i]) {
            list(3, i, &[Mass]);
        }
        for i in (s_end..n).filter(|&i| !turns[i]) {
            list(4, i, &[Kx, Ky, Kz]);
        }
        for (&i, &across) in &sigma {
            if across {
                let u = axis_of_r(i);
                list(5, i, &[C1(u), C2(u)]);
            }
        }
        Self { r, s, delta, sigma, constants }
    }
}

/// `δ_j = 0`: gravity along the axes (or absent), every joint before j parallel to r, and every
/// rotational axis r..j on one line as seen from `O_j`.
fn first_moments_vanish(
    arm: &RigidArm,
    poses: &[armident_dynamics::JointPose],
    turns: &[bool],
    r: usize,
    j: usize,
) -> bool {
    let parallel_to_z = |v: Vector3<f64>| v.x.hypot(v.y) <= EXACT;
    // (a), in E_r where the axis is z
    let gravity = arm.gravity_in_frames(poses)[r];
    let size = gravity.norm();
    let gravity_along = size == 0.0 || parallel_to_z(gravity / size);
    // (b), also the translational joints before r; parallel in E_j, where u_j = ±u_r = z
    let all_parallel = (0..j).all(|k| parallel_to_z(arm.axis_in_frames(poses, k)[j - k].0));
    // (c), from the accumulated position; testing at q = 0 is enough given (b)
    let on_one_line =
        (r..j).filter(|&m| turns[m]).all(|m| parallel_to_z(arm.axis_in_frames(poses, m)[j - m].1));
    gravity_along && all_parallel && on_one_line
}
