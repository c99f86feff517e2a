//! Recursive Newton-Euler inverse dynamics: an independent check of composite bodies, and the
//! fast computation of the effort of a whole motion.

use nalgebra::{Matrix3, Vector3};

use crate::arm::{JointPose, RigidArm};
use crate::motion::ArmMotion;

/// Motion of link `i` in `E_i`, the factors of its ten parameters.
#[derive(Debug, Clone, Copy)]
pub struct LinkMotion {
    /// Angular velocity \[rad/s\].
    pub angular_velocity: Vector3<f64>,
    /// Angular acceleration [rad/s2].
    pub angular_acceleration: Vector3<f64>,
    /// Acceleration of `O_i` minus gravity \[m/s2\].
    pub acceleration: Vector3<f64>,
    /// `B = [dw×] + [w×][w×]` \[1/s2\]: a point `r` of the link has the acceleration `a + B r`.
    pub gradient: Matrix3<f64>,
}

impl LinkMotion {
    #[inline(always)]
    fn of(w: Vector3<f64>, dw: Vector3<f64>, acceleration: Vector3<f64>) -> Self {
        let (xx, yy, zz) = (w.x * w.x, w.y * w.y, w.z * w.z);
        let (xy, xz, yz) = (w.x * w.y, w.x * w.z, w.y * w.z);
        let gradient = Matrix3::new(
            -(yy + zz),
            xy - dw.z,
            xz + dw.y,
            xy + dw.z,
            -(xx + zz),
            yz - dw.x,
            xz - dw.y,
            yz + dw.x,
            -(xx + yy),
        );
        Self { angular_velocity: w, angular_acceleration: dw, acceleration, gradient }
    }
}

/// Outward pass: motions of links 1..n (Luh, Walker, Paul 1980, in driving-axis frames) at the joints' poses.
#[inline(always)]
fn outward(
    arm: &RigidArm,
    poses: &[JointPose],
    dq: &[f64],
    ddq: &[f64],
    motions: &mut Vec<LinkMotion>,
) {
    motions.clear();
    let zero = Vector3::zeros();
    let mut last = LinkMotion::of(zero, zero, -arm.gravity_e0);
    for (((joint, pose), &dq), &ddq) in arm.joints.iter().zip(poses).zip(dq).zip(ddq) {
        let moved = last.acceleration + last.gradient * pose.s;
        let mut w = pose.to_child(&last.angular_velocity);
        let mut dw = pose.to_child(&last.angular_acceleration);
        let mut a = pose.to_child(&moved);
        if joint.kind.is_rotational() {
            // w x (z dq) = (w_y, -w_x, 0) dq
            dw.x += w.y * dq;
            dw.y -= w.x * dq;
            dw.z += ddq;
            w.z += dq;
        } else {
            let twice = dq + dq;
            a.x += w.y * twice;
            a.y -= w.x * twice;
            a.z += ddq;
        }
        last = LinkMotion::of(w, dw, a);
        motions.push(last);
    }
}

/// Scratch memory of [`inverse_dynamics_into`] and of the regressor: no allocation per sample.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// Poses of the joints of the last sample.
    pub poses: Vec<JointPose>,
    /// Motions of the links of the last sample.
    pub motions: Vec<LinkMotion>,
}

impl Sweep {
    /// Scratch for `dof` joints.
    pub fn new(dof: usize) -> Self {
        Self { poses: Vec::with_capacity(dof), motions: Vec::with_capacity(dof) }
    }

    /// Poses and link motions of one sample.
    #[inline(always)]
    pub fn run(&mut self, arm: &RigidArm, q: &[f64], dq: &[f64], ddq: &[f64]) {
        arm.poses_into(q, &mut self.poses);
        outward(arm, &self.poses, dq, ddq, &mut self.motions);
    }
}

/// Effort `τ` of one sample: `q`, `dq`, `ddq` and the result have length n.
#[doc(alias = "RNEA")]
pub fn inverse_dynamics(arm: &RigidArm, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
    let mut effort = vec![0.0; arm.dof()];
    inverse_dynamics_into(arm, q, dq, ddq, &mut Sweep::new(arm.dof()), &mut effort);
    effort
}

/// [`inverse_dynamics`] without allocation; `effort` has length n.
#[inline(always)]
pub fn inverse_dynamics_into(
    arm: &RigidArm,
    q: &[f64],
    dq: &[f64],
    ddq: &[f64],
    sweep: &mut Sweep,
    effort: &mut [f64],
) {
    sweep.run(arm, q, dq, ddq);
    efforts_of(arm, sweep, effort);
}

/// Inward pass: efforts from the motions of the links.
#[inline(always)]
fn efforts_of(arm: &RigidArm, sweep: &Sweep, effort: &mut [f64]) {
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for i in (0..arm.dof()).rev() {
        let motion = &sweep.motions[i];
        let LinkMotion { angular_velocity: w, angular_acceleration: dw, acceleration: a, gradient } =
            motion;
        let (mass, mc) = (arm.links[i].mass_kg, &arm.links[i].first_moment_kgm);
        let inertia = &arm.links[i].inertia_origin_kgm2;
        force += a * mass + gradient * mc;
        moment += inertia * dw + w.cross(&(inertia * w)) + mc.cross(a);
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
    ArmMotion::new(q, dq, ddq).efforts(arm)
}
