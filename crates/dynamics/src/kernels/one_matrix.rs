//! Inertia matrix of one sample: here the lanes are joints, whose axes go through the same rotations from link to link.

use pulp::{Arch, Simd, WithSimd};

use super::arm::{Pose, tilt};
use crate::arm::{JointPose, RigidArm};
use crate::composite::CompositeBody;
use crate::lanes::{Lanes, lanes, store};
use crate::sin_cos::EIGHT;

/// Inertia matrix (9), (10) from poses and composite bodies; `h` has n² entries.
pub(crate) fn inertia_matrix_from_bodies(
    arm: &RigidArm,
    poses: &[JointPose],
    bodies: &[CompositeBody],
    h: &mut [f64],
) {
    Arch::new().dispatch(OneMatrix { arm, poses, bodies, h });
}

struct OneMatrix<'a> {
    arm: &'a RigidArm,
    poses: &'a [JointPose],
    bodies: &'a [CompositeBody],
    h: &'a mut [f64],
}

/// Row `i`: a one in lane `i`.
const UNITS: [[f64; EIGHT]; EIGHT] = {
    let mut units = [[0.0; EIGHT]; EIGHT];
    let mut i = 0;
    while i < EIGHT {
        units[i][i] = 1.0;
        i += 1;
    }
    units
};

impl WithSimd for OneMatrix<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let n = self.arm.dof();
        for first in (0..n).step_by(S::F64_LANES) {
            self.columns_from(simd, first, n);
        }
    }
}

impl OneMatrix<'_> {
    /// Entries of the joints `first ..` that are in the lanes, with all later joints.
    #[inline(always)]
    fn columns_from<S: Simd>(&mut self, simd: S, first: usize, n: usize) {
        let number = |x: f64| Lanes::splat(simd, x);
        let zero = number(0.0);
        // `u` and `u × s` of rotational joints, 0 and `u` of translational ones, in the frame of link i (42)
        let (mut u, mut v) = ([zero; 3], [zero; 3]);
        for i in first..n {
            let (pose, body) = (&self.poses[i], &self.bodies[i]);
            let turns = self.arm.joints[i].kind.is_rotational();
            if i > first {
                let s = [number(pose.s.x), number(pose.s.y), number(pose.s.z)];
                v = [
                    u[1].times_plus(s[2], u[2].times_from(s[1], v[0])),
                    u[2].times_plus(s[0], u[0].times_from(s[2], v[1])),
                    u[0].times_plus(s[1], u[1].times_from(s[0], v[2])),
                ];
                let turn =
                    Pose::<S, { tilt::OBLIQUE }>::of_rotation(simd, pose.cosines_and_sines());
                (u, v) = (turn.to_child(u), turn.to_child(v));
            }
            if i - first < S::F64_LANES {
                let unit = lanes(simd, &UNITS[i - first])(0);
                if turns { u[2] = u[2] + unit } else { v[2] = v[2] + unit }
            }
            let [cx, cy] = [number(body.first_moment.x), number(body.first_moment.y)];
            let entries = if turns {
                let j = body.inertia.column(2);
                let moment = u[0].times_plus(number(j.x), u[1] * number(j.y));
                let moment = u[2].times_plus(number(j.z), moment);
                v[1].times_plus(cx, v[0].times_from(cy, moment))
            } else {
                v[2].times_plus(number(body.mass), u[0].times_plus(cy, -(u[1] * cx)))
            };
            let mut row = [0.0; EIGHT];
            store(&mut row, 0, entries);
            for (lane, entry) in row.iter().enumerate().take(S::F64_LANES.min(i + 1 - first)) {
                self.h[n * i + first + lane] = *entry;
                self.h[n * (first + lane) + i] = *entry;
            }
        }
    }
}
