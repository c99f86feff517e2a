//! Motion of the links, joint by joint outward.

use pulp::Simd;

use super::arm::Pose;
use crate::lanes::{Lanes, Vector};

/// Angular velocity, angular acceleration, and acceleration of the origin minus gravity of a link, in its frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkMotion<S: Simd> {
    pub(super) w: Vector<S>,
    pub(super) dw: Vector<S>,
    pub(super) a: Vector<S>,
}

/// Accelerations in a link are `a + B r`, `B = [dw×] + [w×][w×]`; with the products of `w` it is all that forces and moments need.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rates<S: Simd> {
    /// rows of `B`
    pub(super) b: [Vector<S>; 3],
    /// `w_x w_y`, `w_x w_z`, `w_y w_z`
    pub(super) xy: Lanes<S>,
    pub(super) xz: Lanes<S>,
    pub(super) yz: Lanes<S>,
}

impl<S: Simd> Rates<S> {
    #[inline(always)]
    pub(super) fn of(&LinkMotion { w: [x, y, z], dw, .. }: &LinkMotion<S>) -> Self {
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let (xx, yy) = (x * x, y * y);
        Self {
            b: [
                [-z.times_plus(z, yy), xy - dw[2], xz + dw[1]],
                [xy + dw[2], -z.times_plus(z, xx), yz - dw[0]],
                [xz - dw[1], yz + dw[0], -(xx + yy)],
            ],
            xy,
            xz,
            yz,
        }
    }
}

/// Motion of the links before the first joint: none, and gravity is an acceleration upward.
#[inline(always)]
pub(super) fn at_base<S: Simd>(simd: S, gravity: &[f64; 3]) -> LinkMotion<S> {
    let none = [Lanes::splat(simd, 0.0); 3];
    let up = |g: f64| Lanes::splat(simd, -g);
    LinkMotion { w: none, dw: none, a: [up(gravity[0]), up(gravity[1]), up(gravity[2])] }
}

/// Motion of the next link, and its rates.
#[inline(always)]
pub(super) fn next<S: Simd, const TURNS: bool, const TILT: u8>(
    pose: &Pose<S, TILT>,
    before: &LinkMotion<S>,
    dq: Lanes<S>,
    ddq: Lanes<S>,
) -> (LinkMotion<S>, Rates<S>) {
    let LinkMotion { w, dw, mut a } = *before;
    if pose.apart {
        let [x, y, z] = w;
        a[0] = pose.b.times_from(z.times_plus(z, y * y), a[0]);
        a[1] = pose.b.times_plus(x.times_plus(y, dw[2]), a[1]);
        a[2] = pose.b.times_plus(x.times_plus(z, -dw[1]), a[2]);
    }
    let (mut w, mut dw, mut a) = (pose.to_child(w), pose.to_child(dw), pose.to_child(a));
    if TURNS {
        // w × z dq = (w_y, -w_x, 0) dq
        dw[0] = w[1].times_plus(dq, dw[0]);
        dw[1] = w[0].times_from(dq, dw[1]);
        dw[2] = dw[2] + ddq;
        w[2] = w[2] + dq;
    } else {
        let twice = dq + dq;
        a[0] = w[1].times_plus(twice, a[0]);
        a[1] = w[0].times_from(twice, a[1]);
        a[2] = a[2] + ddq;
    }
    let rates = Rates::of(&LinkMotion { w, dw, a });
    // points of the joint's axis move alike on both links
    for k in 0..3 {
        a[k] = pose.d.times_plus(rates.b[k][2], a[k]);
    }
    (LinkMotion { w, dw, a }, rates)
}
