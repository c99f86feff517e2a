//! Recursive Newton-Euler inverse dynamics: an independent check of composite bodies, and the
//! fast computation of the effort of a whole motion.

use nalgebra::Vector3;

use crate::arm::{JointPose, RigidArm};
use crate::kernels::{Columns, efforts_into};
use crate::real::Real;

/// Motion of link `i` in `E_i`, the factors of its ten parameters.
#[derive(Debug, Clone, Copy)]
pub struct LinkMotion<T> {
    /// Angular velocity \[rad/s\].
    pub angular_velocity: Vector3<T>,
    /// Angular acceleration [rad/s2].
    pub angular_acceleration: Vector3<T>,
    /// Acceleration of `O_i` minus gravity \[m/s2\].
    pub acceleration: Vector3<T>,
}

/// Outward pass: motions of links 1..n (Luh, Walker, Paul 1980, in driving-axis frames), with the joints'
/// poses by their index.
#[inline(always)]
fn outward<T: Real>(
    arm: &RigidArm,
    pose: impl Fn(usize) -> JointPose<T>,
    dq: &[T],
    ddq: &[T],
    poses: &mut Vec<JointPose<T>>,
    motions: &mut Vec<LinkMotion<T>>,
) {
    poses.clear();
    motions.clear();
    let zero = Vector3::from_element(T::splat(0.0));
    let mut last = LinkMotion {
        angular_velocity: zero,
        angular_acceleration: zero,
        acceleration: -arm.gravity_e0.map(T::splat),
    };
    for (i, joint) in arm.joints.iter().enumerate() {
        let pose = pose(i);
        let (w, dw) = (&last.angular_velocity, &last.angular_acceleration);
        let moved = last.acceleration + dw.cross(&pose.s) + w.cross(&w.cross(&pose.s));
        let mut w = pose.to_child(w);
        let mut dw = pose.to_child(dw);
        let mut a = pose.to_child(&moved);
        if joint.kind.is_rotational() {
            // w x (z dq) = (w_y, -w_x, 0) dq
            dw.x += w.y * dq[i];
            dw.y -= w.x * dq[i];
            dw.z += ddq[i];
            w.z += dq[i];
        } else {
            let twice = dq[i] + dq[i];
            a.x += w.y * twice;
            a.y -= w.x * twice;
            a.z += ddq[i];
        }
        last = LinkMotion { angular_velocity: w, angular_acceleration: dw, acceleration: a };
        poses.push(pose);
        motions.push(last);
    }
}

/// Scratch memory of [`inverse_dynamics_into`] and of the regressor: no allocation per sample.
#[derive(Debug, Clone)]
pub struct Sweep<T> {
    /// Poses of the joints of the last sample.
    pub poses: Vec<JointPose<T>>,
    /// Motions of the links of the last sample.
    pub motions: Vec<LinkMotion<T>>,
}

impl<T: Real> Sweep<T> {
    /// Scratch for `dof` joints.
    pub fn new(dof: usize) -> Self {
        Self { poses: Vec::with_capacity(dof), motions: Vec::with_capacity(dof) }
    }

    /// Poses and link motions of one sample (or one batch).
    #[inline(always)]
    pub fn run(&mut self, arm: &RigidArm, q: &[T], dq: &[T], ddq: &[T]) {
        outward(arm, |i| arm.joints[i].at(q[i]), dq, ddq, &mut self.poses, &mut self.motions);
    }
}

/// Effort `τ` of one sample: `q`, `dq`, `ddq` and the result have length n.
#[doc(alias = "RNEA")]
pub fn inverse_dynamics<T: Real>(arm: &RigidArm, q: &[T], dq: &[T], ddq: &[T]) -> Vec<T> {
    let mut effort = vec![T::splat(0.0); arm.dof()];
    inverse_dynamics_into(arm, q, dq, ddq, &mut Sweep::new(arm.dof()), &mut effort);
    effort
}

/// [`inverse_dynamics`] without allocation; `effort` has length n.
#[inline(always)]
pub fn inverse_dynamics_into<T: Real>(
    arm: &RigidArm,
    q: &[T],
    dq: &[T],
    ddq: &[T],
    sweep: &mut Sweep<T>,
    effort: &mut [T],
) {
    sweep.run(arm, q, dq, ddq);
    efforts_of(arm, sweep, effort);
}

/// Inward pass: efforts from the motions of the links.
#[inline(always)]
pub(crate) fn efforts_of<T: Real>(arm: &RigidArm, sweep: &Sweep<T>, effort: &mut [T]) {
    let zero = Vector3::from_element(T::splat(0.0));
    let (mut force, mut moment) = (zero, zero);
    for i in (0..arm.dof()).rev() {
        let LinkMotion { angular_velocity: w, angular_acceleration: dw, acceleration: a } =
            sweep.motions[i];
        let link = &arm.links[i];
        let mc = link.first_moment_kgm.map(T::splat);
        let inertia = link.inertia_origin_kgm2.map(T::splat);
        force += a * T::splat(link.mass_kg) + dw.cross(&mc) + w.cross(&w.cross(&mc));
        moment += inertia * dw + w.cross(&(inertia * w)) + mc.cross(&a);
        effort[i] = if arm.joints[i].kind.is_rotational() { moment.z } else { force.z };
        let pose = &sweep.poses[i];
        force = pose.to_parent(&force);
        moment = pose.to_parent(&moment) + pose.s.cross(&force);
    }
}

/// Effort of a whole motion, joint-major: `q[j][t]` in, `effort[j][t]` out.
///
/// Samples are the lanes of a processor's registers; memory is the result alone.
///
/// # Panics
/// When the three inputs do not have n columns of one length.
pub fn inverse_dynamics_of_motion(
    arm: &RigidArm,
    q: &[Vec<f64>],
    dq: &[Vec<f64>],
    ddq: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let n = arm.dof();
    assert!(q.len() == n && dq.len() == n && ddq.len() == n, "one column per joint");
    let [q, dq, ddq] =
        [q, dq, ddq].map(|columns| columns.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let mut effort = vec![vec![0.0; q[0].len()]; n];
    let columns = Columns { q: &q, dq: &dq, ddq: &ddq, angles: None };
    efforts_into(arm, &columns, 0, &mut effort);
    effort
}
