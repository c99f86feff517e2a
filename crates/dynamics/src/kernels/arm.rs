//! An arm as the kernels need it: constants of the joints, and links with as few parameters as give the same efforts.

use armident_kinematics::InertialParameters;
use nalgebra::{Matrix3, Vector3};
use pulp::Simd;

use crate::arm::{JointGeometry, RigidArm};
use crate::constants::{BodyConstants, carried};
use crate::lanes::{Lanes, Vector};

/// `|cos β|` or `|sin β|` of an exact right angle or none, with the rounding of π.
const ROUNDING: f64 = 1e-15;

/// Angle `β` between the axis of a joint and the one before it. Most are 0 or right angles, which need no products.
pub(super) mod tilt {
    pub(crate) const NONE: u8 = 0;
    pub(crate) const RIGHT: u8 = 1;
    pub(crate) const MINUS_RIGHT: u8 = 2;
    pub(crate) const OBLIQUE: u8 = 3;
}

/// Constants of one joint and its link.
#[derive(Debug, Clone)]
pub(super) struct KernelJoint {
    pub(super) rotational: bool,
    tilt: u8,
    cos_beta: f64,
    sin_beta: f64,
    b: f64,
    d: f64,
    pub(super) theta: f64,
    /// rotational: without mass, z of the first moment and yy of the inertia; translational: without inertia
    pub(super) link: [f64; InertialParameters::COUNT],
}

/// Joints with links that give the efforts of an arm.
///
/// A body that is symmetric about the axis of its joint does not feel the joint turn, and a body without mass does not
/// feel it slide: such parts of each link are put on the link before it, from the tip to the base (Gautier and Khalil 1990).
pub(super) fn joints_of(arm: &RigidArm) -> Vec<KernelJoint> {
    let mut links = arm.links.clone();
    for i in (0..links.len()).rev() {
        let inertia = &links[i].inertia_origin_kgm2;
        let free = if arm.joints[i].kind.is_rotational() {
            let across = inertia[(1, 1)];
            BodyConstants {
                mass_kg: links[i].mass_kg,
                first_moment_kgm: Vector3::new(0.0, 0.0, links[i].first_moment_kgm.z),
                inertia_origin_kgm2: Matrix3::from_diagonal(&Vector3::new(across, across, 0.0)),
            }
        } else {
            BodyConstants {
                mass_kg: 0.0,
                first_moment_kgm: Vector3::zeros(),
                inertia_origin_kgm2: *inertia,
            }
        };
        links[i].mass_kg -= free.mass_kg;
        links[i].first_moment_kgm -= free.first_moment_kgm;
        links[i].inertia_origin_kgm2 -= free.inertia_origin_kgm2;
        if i > 0 {
            links[i - 1] = links[i - 1].plus(&carried(&arm.joints[i], &free));
        }
    }
    arm.joints
        .iter()
        .zip(links)
        .map(|(joint, link)| KernelJoint::new(joint, link.to_array()))
        .collect()
}

impl KernelJoint {
    pub(super) fn new(joint: &JointGeometry, link: [f64; InertialParameters::COUNT]) -> Self {
        let (sin_beta, cos_beta) = joint.frame.beta_rad.sin_cos();
        let tilt = if sin_beta.abs() < ROUNDING && cos_beta > 0.0 {
            tilt::NONE
        } else if cos_beta.abs() < ROUNDING {
            if sin_beta > 0.0 { tilt::RIGHT } else { tilt::MINUS_RIGHT }
        } else {
            tilt::OBLIQUE
        };
        Self {
            rotational: joint.kind.is_rotational(),
            tilt,
            cos_beta,
            sin_beta,
            b: joint.frame.b_m,
            d: joint.frame.d_m,
            theta: joint.frame.theta_rad,
            link,
        }
    }
}

/// What is done with the samples of a block at one joint, compiled for each kind of joint.
pub(super) trait AtJoint {
    fn run<const TURNS: bool, const TILT: u8>(self);
}

/// Runs a step with the kind of the joint known to the compiler.
#[inline(always)]
pub(super) fn at_joint(joint: &KernelJoint, step: impl AtJoint) {
    match (joint.rotational, joint.tilt) {
        (true, tilt::NONE) => step.run::<true, { tilt::NONE }>(),
        (true, tilt::RIGHT) => step.run::<true, { tilt::RIGHT }>(),
        (true, tilt::MINUS_RIGHT) => step.run::<true, { tilt::MINUS_RIGHT }>(),
        (true, _) => step.run::<true, { tilt::OBLIQUE }>(),
        (false, _) => step.run::<false, { tilt::OBLIQUE }>(),
    }
}

/// Constants of a joint in all lanes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame<S: Simd, const TURNS: bool, const TILT: u8> {
    cos_beta: Lanes<S>,
    sin_beta: Lanes<S>,
    b: Lanes<S>,
    d: Lanes<S>,
    apart: bool,
}

impl<S: Simd, const TURNS: bool, const TILT: u8> Frame<S, TURNS, TILT> {
    #[inline(always)]
    pub(super) fn of(simd: S, joint: &KernelJoint) -> Self {
        let number = |x| Lanes::splat(simd, x);
        Self {
            cos_beta: number(joint.cos_beta),
            sin_beta: number(joint.sin_beta),
            b: number(joint.b),
            d: number(joint.d),
            apart: joint.b != 0.0,
        }
    }

    /// The frame at one position; only translational joints use `q`.
    #[inline(always)]
    pub(super) fn at(
        &self,
        sin: Lanes<S>,
        cos: Lanes<S>,
        q: impl FnOnce() -> Lanes<S>,
    ) -> Pose<S, TILT> {
        Pose {
            cos_beta: self.cos_beta,
            sin_beta: self.sin_beta,
            sin,
            cos,
            b: self.b,
            d: if TURNS { self.d } else { self.d + q() },
            apart: self.apart,
        }
    }
}

/// Pose of a frame in the one before it: `s = b x + d z`, x of the frame before, z of this one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose<S: Simd, const TILT: u8> {
    cos_beta: Lanes<S>,
    sin_beta: Lanes<S>,
    sin: Lanes<S>,
    cos: Lanes<S>,
    pub(super) b: Lanes<S>,
    pub(super) d: Lanes<S>,
    /// whether `b` is not 0
    pub(super) apart: bool,
}

impl<S: Simd, const TILT: u8> Pose<S, TILT> {
    /// Rotation alone, the same in all lanes: `cos θ`, `sin θ`, `cos β`, `sin β`.
    #[inline(always)]
    pub(super) fn of_rotation(simd: S, [cos, sin, cos_beta, sin_beta]: [f64; 4]) -> Self {
        let number = |x| Lanes::splat(simd, x);
        Self {
            cos_beta: number(cos_beta),
            sin_beta: number(sin_beta),
            sin: number(sin),
            cos: number(cos),
            b: number(0.0),
            d: number(0.0),
            apart: false,
        }
    }

    /// Components in the frame before to components in this one.
    #[inline(always)]
    pub(super) fn to_child(self, [x, y, z]: Vector<S>) -> Vector<S> {
        let (c, s) = (self.cos_beta, self.sin_beta);
        let (y, z) = match TILT {
            tilt::NONE => (y, z),
            tilt::RIGHT => (z, -y),
            tilt::MINUS_RIGHT => (-z, y),
            _ => (c.times_plus(y, s * z), s.times_from(y, c * z)),
        };
        let (c, s) = (self.cos, self.sin);
        [c.times_plus(x, s * y), s.times_from(x, c * y), z]
    }

    /// Components in this frame to components in the one before.
    #[inline(always)]
    pub(super) fn to_parent(self, [x, y, z]: Vector<S>) -> Vector<S> {
        let (c, s) = (self.cos, self.sin);
        let (x, y) = (s.times_from(y, c * x), s.times_plus(x, c * y));
        let (c, s) = (self.cos_beta, self.sin_beta);
        match TILT {
            tilt::NONE => [x, y, z],
            tilt::RIGHT => [x, -z, y],
            tilt::MINUS_RIGHT => [x, z, -y],
            _ => [x, s.times_from(z, c * y), s.times_plus(y, c * z)],
        }
    }

    /// A symmetric tensor in this frame to one in the frame before, as xx, xy, xz, yy, yz, zz: `[xx, xy, yy]`, `[xz, yz]` and `zz`
    /// of this frame.
    #[inline(always)]
    pub(super) fn tensor_to_parent(
        self,
        along: [Lanes<S>; 3],
        [xz, yz]: [Lanes<S>; 2],
        zz: Lanes<S>,
    ) -> [Lanes<S>; 6] {
        let (c, s) = (self.cos, self.sin);
        let [xx, xy, yy] = turned(c, s, along);
        let (xz, yz) = (s.times_from(yz, c * xz), s.times_plus(xz, c * yz));
        let (c, s) = (self.cos_beta, self.sin_beta);
        match TILT {
            tilt::NONE => [xx, xy, xz, yy, yz, zz],
            tilt::RIGHT => [xx, -xz, xy, zz, -yz, yy],
            tilt::MINUS_RIGHT => [xx, xz, -xy, zz, -yz, yy],
            _ => {
                let [yy, yz, zz] = turned(c, s, [yy, yz, zz]);
                let (xy, xz) = (s.times_from(xz, c * xy), s.times_plus(xy, c * xz));
                [xx, xy, xz, yy, yz, zz]
            }
        }
    }
}

/// `[xx, xy, yy]` of a plane after it is turned by the angle with this cosine and sine.
#[inline(always)]
fn turned<S: Simd>(c: Lanes<S>, s: Lanes<S>, [xx, xy, yy]: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
    let x = s.times_from(xy, c * xx);
    let y = s.times_from(yy, c * xy);
    let turned_xx = s.times_from(y, c * x);
    [turned_xx, s.times_plus(x, c * y), (xx + yy) - turned_xx]
}
