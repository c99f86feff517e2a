//! What a joint has to move: its inertia and all other efforts on it, about a motion of its link.

use armident_dynamics::{ArmMotion, RigidArm};

/// Inertia of a joint and all other efforts on it, about a motion of its link.
#[derive(Debug, Clone)]
pub struct Load {
    /// Inertia about the joint at each sample \[kg m² or kg\].
    pub inertia: Vec<f64>,
    pub(crate) bias: Vec<f64>,
    /// change of `bias` with the position of the link: a soft spring lets it fall far from its motor
    pub(crate) slope: Vec<f64>,
    /// and with its velocity, in which it is linear: other joints in motion take energy from a link that rings, or
    /// give it some
    pub(crate) drag: Vec<f64>,
    pub(crate) position: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
}

impl Load {
    /// About a link that follows its motor.
    pub fn of(
        motion: &ArmMotion<'_>,
        arm: &RigidArm,
        joint: usize,
        position: &[f64],
        velocity: &[f64],
    ) -> Self {
        let one = vec![1.0; position.len()];
        let unit = motion.with_acceleration(joint, &one).effort_on(arm, joint);
        let mut load = Self::about(motion, arm, joint, position, velocity, Vec::new());
        load.inertia = unit.iter().zip(&load.bias).map(|(a, b)| (a - b).max(1e-9)).collect();
        load
    }

    /// Change of the efforts on the joint at the first sample with the position of its link.
    pub fn slope_at_start(&self) -> f64 {
        self.slope[0]
    }

    /// About another motion of the link; the inertia about a joint does not depend on its own position.
    pub fn moved(
        &self,
        motion: &ArmMotion<'_>,
        arm: &RigidArm,
        joint: usize,
        position: &[f64],
        velocity: &[f64],
    ) -> Self {
        Self::about(motion, arm, joint, position, velocity, self.inertia.clone())
    }

    /// All efforts on a joint but that of its own acceleration, and how they change with its motion.
    fn about(
        motion: &ArmMotion<'_>,
        arm: &RigidArm,
        joint: usize,
        position: &[f64],
        velocity: &[f64],
        inertia: Vec<f64>,
    ) -> Self {
        const STEP: f64 = 1e-4;
        let none = vec![0.0; position.len()];
        let bias_at = |position: &[f64], velocity: &[f64]| {
            motion.with_joint(joint, [position, velocity, &none]).effort_on(arm, joint)
        };
        let bias = bias_at(position, velocity);
        let beside = |of: &[f64]| -> Vec<f64> { of.iter().map(|x| x + STEP).collect() };
        let change = |moved: Vec<f64>| -> Vec<f64> {
            moved.iter().zip(&bias).map(|(a, b)| (a - b) / STEP).collect()
        };
        Self {
            slope: change(bias_at(&beside(position), velocity)),
            drag: change(bias_at(position, &beside(velocity))),
            inertia,
            bias,
            position: position.to_vec(),
            velocity: velocity.to_vec(),
        }
    }
}
