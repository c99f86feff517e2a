//! The rigid-body model: driving-axis geometry, links and gravity.

use armident_kinematics::{DrivingAxisChain, DrivingAxisFrame, InertialParameters, JointKind};
use nalgebra::{Matrix3, Vector3};

use crate::real::Real;

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
    pub fn offset_m<T: Real>(&self, q: T) -> T {
        match self.kind {
            JointKind::Rotational => T::splat(self.frame.d_m),
            JointKind::Translational => q + T::splat(self.frame.d_m),
        }
    }

    /// The joint at position `q` \[rad or m\].
    pub fn at<T: Real>(&self, q: T) -> JointPose<T> {
        self.at_angle(q, self.sin_cos(q))
    }

    /// Sine and cosine of `θ` at position `q` \[rad or m\].
    pub fn sin_cos<T: Real>(&self, q: T) -> (T, T) {
        let theta = T::splat(self.frame.theta_rad);
        if self.kind.is_rotational() { (theta + q).simd_sin_cos() } else { theta.simd_sin_cos() }
    }

    /// The joint at position `q` \[rad or m\], whose [`Self::sin_cos`] is known.
    #[inline(always)]
    pub fn at_angle<T: Real>(&self, q: T, (sin_theta, cos_theta): (T, T)) -> JointPose<T> {
        let (cos_beta, sin_beta) = (T::splat(self.cos_beta), T::splat(self.sin_beta));
        let d = self.offset_m(q);
        JointPose {
            cos_theta,
            sin_theta,
            cos_beta,
            sin_beta,
            s: Vector3::new(T::splat(self.frame.b_m), -d * sin_beta, d * cos_beta),
        }
    }
}

/// Pose of frame `E_i` in `E_{i-1}` at one joint position.
#[derive(Debug, Clone, Copy)]
pub struct JointPose<T> {
    cos_theta: T,
    sin_theta: T,
    cos_beta: T,
    sin_beta: T,
    /// `s_{i-1}^i`, the origin of `E_i` seen from that of `E_{i-1}`, in `E_{i-1}` (3).
    pub s: Vector3<T>,
}

impl<T: Real> JointPose<T> {
    /// `Rᵀ v`: components in `E_{i-1}` to components in `E_i`.
    #[inline(always)]
    pub fn to_child(&self, v: &Vector3<T>) -> Vector3<T> {
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
    pub fn to_parent(&self, v: &Vector3<T>) -> Vector3<T> {
        let x = self.cos_theta * v.x - self.sin_theta * v.y;
        let y = self.sin_theta * v.x + self.cos_theta * v.y;
        Vector3::new(
            x,
            self.cos_beta * y - self.sin_beta * v.z,
            self.sin_beta * y + self.cos_beta * v.z,
        )
    }

    /// `R` itself (4).
    pub fn rotation(&self) -> Matrix3<T> {
        let (z, o) = (T::splat(0.0), T::splat(1.0));
        Matrix3::from_columns(&[
            self.to_parent(&Vector3::new(o, z, z)),
            self.to_parent(&Vector3::new(z, o, z)),
            self.to_parent(&Vector3::new(z, z, o)),
        ])
    }

    /// `R M Rᵀ` for a tensor in `E_i`.
    #[inline(always)]
    pub fn tensor_to_parent(&self, m: &Matrix3<T>) -> Matrix3<T> {
        let half = Matrix3::from_columns(&[
            self.to_parent(&m.column(0).into()),
            self.to_parent(&m.column(1).into()),
            self.to_parent(&m.column(2).into()),
        ])
        .transpose();
        Matrix3::from_columns(&[
            self.to_parent(&half.column(0).into()),
            self.to_parent(&half.column(1).into()),
            self.to_parent(&half.column(2).into()),
        ])
    }
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
    pub fn poses<T: Real>(&self, q: &[T]) -> Vec<JointPose<T>> {
        self.joints.iter().zip(q).map(|(joint, &q)| joint.at(q)).collect()
    }

    /// Gravity acceleration in each `E_i`, i = 1..n.
    pub fn gravity_in_frames<T: Real>(&self, poses: &[JointPose<T>]) -> Vec<Vector3<T>> {
        let mut gravity = self.gravity_e0.map(T::splat);
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
    pub fn axis_in_frames<T: Real>(
        &self,
        poses: &[JointPose<T>],
        m: usize,
    ) -> Vec<(Vector3<T>, Vector3<T>)> {
        let (zero, one) = (T::splat(0.0), T::splat(1.0));
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
