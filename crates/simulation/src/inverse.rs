//! Motion in, efforts out.

use armident_dynamics::inverse_dynamics_of_motion;
use armident_recording::Recording;

use crate::error::SimulationError;
use crate::simulated_arm::SimulatedArm;
use crate::trajectory::Trajectory;

/// The efforts of a motion: `M(q) q̈ + b(q, q̇) + Fc sign(q̇)`, exact in every sample.
///
/// At rest, where `q̇` is exactly zero, the dry friction is whatever holds the joint within `±Fc`
/// and no function of the motion; zero is written there, with a note.
///
/// # Errors
/// A trajectory of other joints than the arm's, or one that is inconsistent; efforts beyond the
/// range of floating-point numbers.
pub fn inverse(arm: &SimulatedArm, trajectory: &Trajectory) -> Result<Recording, SimulationError> {
    let mut recording = trajectory.recording()?;
    if trajectory.joints != arm.joints() {
        return Err(SimulationError::OtherJoints {
            what: "the trajectory",
            found: trajectory.joints.clone(),
            known: arm.joints().to_vec(),
        });
    }
    let Trajectory { position, velocity, acceleration, .. } = trajectory;
    let mut effort = inverse_dynamics_of_motion(arm.rigid(), position, velocity, acceleration);
    for (j, effort) in effort.iter_mut().enumerate() {
        let (friction, inertia) = (arm.dry_friction(j), arm.added_inertia(j));
        let mut resting = 0;
        for (t, effort) in effort.iter_mut().enumerate() {
            let v = velocity[j][t];
            let direction = if v == 0.0 { 0.0 } else { v.signum() };
            resting += usize::from(v == 0.0);
            *effort += arm.smooth_effort(j, position[j][t], v)
                + inertia * acceleration[j][t]
                + friction * direction;
        }
        if friction > 0.0 && resting > 0 {
            recording.notes.push(format!(
                "{} rests in {resting} of {} samples: its dry friction is written as zero there",
                arm.joints()[j],
                trajectory.len()
            ));
        }
    }
    for (joint, effort) in recording.joints.iter_mut().zip(effort) {
        if let Some(t) = effort.iter().position(|value| !value.is_finite()) {
            let (joint, time_s) = (joint.name.clone(), recording.time_s[t]);
            return Err(SimulationError::Overflow { joint, time_s });
        }
        joint.effort = Some(effort);
    }
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use armident_dynamics::inverse_dynamics;

    use super::*;
    use crate::test_arms::{effect, harmonic, planar, stanford};

    #[test]
    fn agrees_with_inverse_dynamics_in_every_sample() {
        let effects = [
            effect("viscous_friction", "joint_1", 0.7),
            effect("coulomb_friction", "joint_2", 3.0),
            effect("coulomb_friction", "joint_2", 1.0),
            effect("torque_offset", "joint_3", -2.0),
            effect("rotor_inertia", "joint_6", 0.3),
        ];
        let arm = stanford(&effects);
        let trajectory = harmonic(arm.joints(), 101, 0.01);
        let recording = inverse(&arm, &trajectory).unwrap();
        for t in 0..trajectory.len() {
            let at = |columns: &[Vec<f64>]| columns.iter().map(|c| c[t]).collect::<Vec<_>>();
            let (v, a) = (at(&trajectory.velocity), at(&trajectory.acceleration));
            let mut expected = inverse_dynamics(arm.rigid(), &at(&trajectory.position), &v, &a);
            expected[0] += 0.7 * v[0];
            expected[1] += 4.0 * v[1].signum();
            expected[2] -= 2.0;
            expected[5] += 0.3 * a[5];
            for (joint, expected) in recording.joints.iter().zip(expected) {
                let found = joint.effort.as_ref().unwrap()[t];
                assert!((found - expected).abs() < 1e-10, "{found} {expected}");
            }
        }
        assert!(recording.notes.is_empty());
    }

    #[test]
    fn friction_at_rest_is_zero_and_noted() {
        let arm = planar(&[effect("coulomb_friction", "joint_2", 5.0)]);
        let mut trajectory = harmonic(arm.joints(), 20, 0.01);
        trajectory.velocity[1].fill(0.0);
        let with = inverse(&arm, &trajectory).unwrap();
        let without = inverse(&planar(&[]), &trajectory).unwrap();
        assert_eq!(with.joints, without.joints);
        assert_eq!(
            with.notes,
            ["joint_2 rests in 20 of 20 samples: its dry friction is written as zero there"]
        );
    }
}
