//! A motion of the whole arm: columns of samples that all computations on it share.

use crate::arm::RigidArm;
use crate::kernels::{Columns, efforts_into};

/// Positions, velocities and accelerations of the joints over a motion, joint-major.
#[derive(Debug, Clone)]
pub struct ArmMotion<'a> {
    q: Vec<&'a [f64]>,
    dq: Vec<&'a [f64]>,
    ddq: Vec<&'a [f64]>,
}

impl<'a> ArmMotion<'a> {
    /// Motion of columns of equal length, one per joint: `q[joint][sample]`.
    pub fn new(q: &'a [Vec<f64>], dq: &'a [Vec<f64>], ddq: &'a [Vec<f64>]) -> Self {
        let views = |columns: &'a [Vec<f64>]| columns.iter().map(Vec::as_slice).collect();
        Self { q: views(q), dq: views(dq), ddq: views(ddq) }
    }

    /// The same with another position, velocity and acceleration of one joint.
    pub fn with_joint<'b>(&'b self, joint: usize, [q, dq, ddq]: [&'b [f64]; 3]) -> ArmMotion<'b> {
        let mut moved: ArmMotion<'b> = self.clone();
        (moved.q[joint], moved.dq[joint], moved.ddq[joint]) = (q, dq, ddq);
        moved
    }

    /// The same with another acceleration of one joint.
    pub fn with_acceleration<'b>(&'b self, joint: usize, ddq: &'b [f64]) -> ArmMotion<'b> {
        let mut moved: ArmMotion<'b> = self.clone();
        moved.ddq[joint] = ddq;
        moved
    }

    /// The same with other accelerations of all joints.
    pub fn with_accelerations<'b>(&'b self, ddq: &'b [Vec<f64>]) -> ArmMotion<'b> {
        let mut moved: ArmMotion<'b> = self.clone();
        moved.ddq = ddq.iter().map(Vec::as_slice).collect();
        moved
    }

    /// Number of samples.
    pub(crate) fn samples(&self) -> usize {
        self.q.first().map_or(0, |q| q.len())
    }

    pub(crate) fn columns(&self) -> Columns<'_> {
        let Self { q, dq, ddq } = self;
        Columns { q, dq, ddq }
    }

    /// Effort `τ` over the motion, `[joint][sample]`.
    pub fn efforts(&self, arm: &RigidArm) -> Vec<Vec<f64>> {
        let mut effort = vec![vec![0.0; self.samples()]; arm.dof()];
        efforts_into(arm, &self.columns(), 0, &mut effort);
        effort
    }

    /// Effort of one joint.
    pub fn effort_on(&self, arm: &RigidArm, joint: usize) -> Vec<f64> {
        let mut effort = vec![vec![0.0; self.samples()]; arm.dof()];
        efforts_into(arm, &self.columns(), joint, &mut effort);
        effort.swap_remove(joint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{JointGeometry, inverse_dynamics_of_motion};
    use armident_kinematics::{DrivingAxisFrame, InertialParameters, JointKind};

    #[test]
    fn batch_efforts_equal_inverse_dynamics() {
        let joint = |kind, beta_rad: f64| {
            let frame = DrivingAxisFrame { b_m: 0.3, d_m: 0.1, beta_rad, theta_rad: 0.2 };
            JointGeometry::new(kind, frame)
        };
        let link = |m: f64| {
            InertialParameters::from_array(&[
                m,
                0.1 * m,
                -0.05,
                0.02 * m,
                0.2,
                0.01,
                -0.02,
                0.3,
                0.03,
                0.25,
            ])
        };
        let arm = RigidArm {
            joints: vec![
                joint(JointKind::Rotational, 0.4),
                joint(JointKind::Translational, 1.1),
                joint(JointKind::Rotational, -0.7),
            ],
            links: vec![link(3.0), link(2.0), link(1.0)],
            gravity_e0: nalgebra::Vector3::new(0.3, -0.4, -9.7),
        };
        let wave = |phase: f64| -> Vec<Vec<f64>> {
            let of = |j: usize| {
                (0..11).map(move |t| (0.3 * f64::from(t) + phase + 1.3 * j as f64).sin()).collect()
            };
            (0..3).map(of).collect()
        };
        let (q, dq, ddq) = (wave(0.0), wave(1.0), wave(2.0));
        let motion = ArmMotion::new(&q, &dq, &ddq);
        assert_eq!(motion.efforts(&arm), inverse_dynamics_of_motion(&arm, &q, &dq, &ddq));
        let other = [wave(3.0), wave(4.0), wave(5.0)];
        for joint in 0..3 {
            let (mut q, mut dq, mut ddq) = (q.clone(), dq.clone(), ddq.clone());
            for (columns, other) in [&mut q, &mut dq, &mut ddq].into_iter().zip(&other) {
                columns[joint].clone_from(&other[joint]);
            }
            let expected = inverse_dynamics_of_motion(&arm, &q, &dq, &ddq);
            let of_joint: [&[f64]; 3] = other.each_ref().map(|columns| columns[joint].as_slice());
            let moved = motion.with_joint(joint, of_joint);
            assert_eq!(moved.efforts(&arm), expected);
            assert_eq!(moved.effort_on(&arm, joint), expected[joint]);
            assert_ne!(motion.effort_on(&arm, joint), expected[joint]);
        }
    }
}
