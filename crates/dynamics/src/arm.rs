//! The rigid-body model: driving-axis geometry, links and gravity.

use armident_kinematics::{DrivingAxisChain, DrivingAxisFrame, InertialParameters, JointKind};
use nalgebra::{Matrix3, Vector3};

use crate::sin_cos::{EIGHT, sines_and_cosines};

/// Constant geometry of one joint in driving-axis form (Lin 1992, eq. 3 and 4).
#[derive(Debug, Clone, Copy)]
pub struct JointGeometry {
    /// Rotation or translation.
    pub kind: JointKind,
    /// The four constants.
    pub frame: DrivingAxisFrame,
    cos_beta: f64,
    sin_beta: f64,
}

impl JointGeometry {
    /// Geometry of a joint from its frame constants.
    pub fn new(kind: JointKind, frame: DrivingAxisFrame) -> Self {
        let (sin_beta, cos_beta) = frame.beta_rad.sin_cos();
        Self { kind, frame, cos_beta, sin_beta }
    }

    /// `R_b = (0, -Sβ, Cβ)ᵀ`, the axis of this joint in the frame before it (26).
    pub fn axis_in_parent(&self) -> Vector3<f64> {
        Vector3::new(0.0, -self.sin_beta, self.cos_beta)
    }

    /// Length `d = d'` (R) or `d' + q` (P).
    pub fn offset_m(&self, q: f64) -> f64 {
        match self.kind {
            JointKind::Rotational => self.frame.d_m,
            JointKind::Translational => q + self.frame.d_m,
        }
    }

    /// The joint at position `q` \[rad or m\].
    pub fn at(&self, q: f64) -> JointPose {
        self.at_angle(q, self.angle(q).sin_cos())
    }

    /// `θ = θ' + q` (R) or `θ'` (P).
    fn angle(&self, q: f64) -> f64 {
        let theta = self.frame.theta_rad;
        if self.kind.is_rotational() { theta + q } else { theta }
    }

    /// The joint at position `q` \[rad or m\], where the sine and cosine of `θ` are known.
    #[inline(always)]
    fn at_angle(&self, q: f64, (sin_theta, cos_theta): (f64, f64)) -> JointPose {
        let (cos_beta, sin_beta) = (self.cos_beta, self.sin_beta);
        let d = self.offset_m(q);
        JointPose {
            cos_theta,
            sin_theta,
            cos_beta,
            sin_beta,
            s: Vector3::new(self.frame.b_m, -d * sin_beta, d * cos_beta),
        }
    }
}

/// Pose of frame `E_i` in `E_{i-1}` at one joint position.
#[derive(Debug, Clone, Copy)]
pub struct JointPose {
    cos_theta: f64,
    sin_theta: f64,
    cos_beta: f64,
    sin_beta: f64,
    /// `s_{i-1}^i`, the origin of `E_i` seen from that of `E_{i-1}`, in `E_{i-1}` (3).
    pub s: Vector3<f64>,
}

impl JointPose {
    /// `Rᵀ v`: components in `E_{i-1}` to components in `E_i`.
    #[inline(always)]
    pub fn to_child(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let y = self.cos_beta * v.y + self.sin_beta * v.z;
        let z = self.cos_beta * v.z - self.sin_beta * v.y;
        Vector3::new(
            self.cos_theta * v.x + self.sin_theta * y,
            self.cos_theta * y - self.sin_theta * v.x,
            z,
        )
    }

    /// `R v`: components in `E_i` to components in `E_{i-1}`.
    #[inline(always)]
    pub fn to_parent(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let x = self.cos_theta * v.x - self.sin_theta * v.y;
        let y = self.sin_theta * v.x + self.cos_theta * v.y;
        Vector3::new(
            x,
            self.cos_beta * y - self.sin_beta * v.z,
            self.sin_beta * y + self.cos_beta * v.z,
        )
    }

    /// `cos θ`, `sin θ`, `cos β`, `sin β`.
    #[inline(always)]
    pub(crate) fn cosines_and_sines(&self) -> [f64; 4] {
        [self.cos_theta, self.sin_theta, self.cos_beta, self.sin_beta]
    }

    /// `R` itself (4).
    pub fn rotation(&self) -> Matrix3<f64> {
        let (z, o) = (0.0, 1.0);
        Matrix3::from_columns(&[
            self.to_parent(&Vector3::new(o, z, z)),
            self.to_parent(&Vector3::new(z, o, z)),
            self.to_parent(&Vector3::new(z, z, o)),
        ])
    }

    /// `R M Rᵀ` for a symmetric tensor in `E_i`: turned about z by `θ`, then about x by `β`.
    #[inline(always)]
    pub fn tensor_to_parent(&self, m: &Matrix3<f64>) -> Matrix3<f64> {
        let (c, s) = (self.cos_theta, self.sin_theta);
        let [xx, xy, yy] = turned(c, s, [m[(0, 0)], m[(0, 1)], m[(1, 1)]]);
        let (xz, yz) = (c * m[(0, 2)] - s * m[(1, 2)], s * m[(0, 2)] + c * m[(1, 2)]);
        let (c, s) = (self.cos_beta, self.sin_beta);
        let [yy, yz, zz] = turned(c, s, [yy, yz, m[(2, 2)]]);
        let (xy, xz) = (c * xy - s * xz, s * xy + c * xz);
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }
}

/// `[xx, xy, yy]` of a plane that turns by the angle with this cosine and sine; its trace stays.
#[inline(always)]
fn turned(c: f64, s: f64, [xx, xy, yy]: [f64; 3]) -> [f64; 3] {
    let (x, y) = (c * xx - s * xy, c * xy - s * yy);
    let turned_xx = c * x - s * y;
    [turned_xx, s * x + c * y, xx + yy - turned_xx]
}

/// A rigid serial arm: geometry, links and gravity for the inverse dynamics.
#[derive(Debug, Clone)]
pub struct RigidArm {
    /// Geometry of joints 1..n.
    pub joints: Vec<JointGeometry>,
    /// Links in `E_i`, as many as joints.
    pub links: Vec<InertialParameters>,
    /// Gravity acceleration in `E_0` \[m/s2\].
    pub gravity_e0: Vector3<f64>,
}

impl RigidArm {
    /// Geometry, links and gravity of a chain.
    pub fn from_chain(chain: &DrivingAxisChain) -> Self {
        Self {
            joints: chain.joints.iter().map(|j| JointGeometry::new(j.kind, j.frame)).collect(),
            links: chain.joints.iter().map(|j| j.link).collect(),
            gravity_e0: chain.gravity_e0,
        }
    }

    /// The same arm with other links.
    ///
    /// # Panics
    /// When the number of links is not that of the joints.
    #[must_use]
    pub fn with_links(&self, links: Vec<InertialParameters>) -> Self {
        assert_eq!(links.len(), self.joints.len(), "one link per joint");
        Self { links, ..self.clone() }
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Poses of all joints at `q` (length n).
    pub fn poses(&self, q: &[f64]) -> Vec<JointPose> {
        let mut poses = Vec::with_capacity(self.dof());
        self.poses_into(q, &mut poses);
        poses
    }

    /// [`Self::poses`] into memory that is kept between samples.
    pub(crate) fn poses_into(&self, q: &[f64], poses: &mut Vec<JointPose>) {
        poses.clear();
        for (joints, q) in self.joints.chunks(EIGHT).zip(q.chunks(EIGHT)) {
            let mut angles = [0.0; EIGHT];
            for ((angle, joint), &q) in angles.iter_mut().zip(joints).zip(q) {
                *angle = joint.angle(q);
            }
            let (sin, cos) = sines_and_cosines(&angles);
            let angles = sin.into_iter().zip(cos);
            poses.extend(joints.iter().zip(q).zip(angles).map(|((j, &q), at)| j.at_angle(q, at)));
        }
    }

    /// Gravity acceleration in each `E_i`, i = 1..n.
    pub fn gravity_in_frames(&self, poses: &[JointPose]) -> Vec<Vector3<f64>> {
        let mut gravity = self.gravity_e0;
        poses
            .iter()
            .map(|pose| {
                gravity = pose.to_child(&gravity);
                gravity
            })
            .collect()
    }

    /// Direction `u_m` of joint `m` and position `s_m^i` of `O_i` from `O_m`, both in every `E_i`,
    /// i = m..n (42); entry 0 belongs to `i = m`.
    pub fn axis_in_frames(
        &self,
        poses: &[JointPose],
        m: usize,
    ) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let (zero, one) = (0.0, 1.0);
        let mut axis = Vector3::new(zero, zero, one);
        let mut reach = Vector3::new(zero, zero, zero);
        let mut all = vec![(axis, reach)];
        for pose in &poses[m + 1..] {
            axis = pose.to_child(&axis);
            reach = pose.to_child(&(reach + pose.s));
            all.push((axis, reach));
        }
        all
    }
}
