//! Force and moment on a link.

use pulp::Simd;

use super::arm::Pose;
use crate::lanes::Vector;

/// Force and moment about the origin of a link, in its frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wrench<S: Simd> {
    pub(super) force: Vector<S>,
    pub(super) moment: Vector<S>,
}

/// The same wrench about the origin of the link before, in its frame.
#[inline(always)]
pub(super) fn carried_to_parent<S: Simd, const TILT: u8>(
    pose: &Pose<S, TILT>,
    &Wrench { force, mut moment }: &Wrench<S>,
) -> Wrench<S> {
    // d z × f
    moment[0] = pose.d.times_from(force[1], moment[0]);
    moment[1] = pose.d.times_plus(force[0], moment[1]);
    let (force, mut moment) = (pose.to_parent(force), pose.to_parent(moment));
    // b x × f
    if pose.apart {
        moment[1] = pose.b.times_from(force[2], moment[1]);
        moment[2] = pose.b.times_plus(force[1], moment[2]);
    }
    Wrench { force, moment }
}
