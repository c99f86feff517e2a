//! Motion in, efforts out.

use armident_dynamics::inverse_dynamics_of_motion;
use armident_effects::DryFriction;
use armident_recording::Recording;

use crate::error::SimulationError;
use crate::simulated_arm::SimulatedArm;
use crate::trajectory::Trajectory;
use crate::transmission::link_motion;

/// The efforts of a motion, as their channels show them: `M(q) q̈ + b(t, q, q̇, z) + F sign(q̇)`, exact in
/// every sample. Deflections follow the travel from sample to sample; links behind a transmission are
/// integrated from rest under the motion of their motors.
///
/// At rest, where `q̇` is exactly zero, the dry friction is whatever holds the joint within `±F`
/// and no function of the motion; zero is written there, with a note.
///
/// # Errors
/// A trajectory of other joints than the arm's, or one that is inconsistent; efforts beyond the
/// range of floating-point numbers; links that cannot be integrated.
pub fn inverse(arm: &SimulatedArm, trajectory: &Trajectory) -> Result<Recording, SimulationError> {
    let mut recording = trajectory.recording()?;
    if trajectory.joints != arm.joints() {
        return Err(SimulationError::OtherJoints {
            what: "the trajectory",
            found: trajectory.joints.clone(),
            known: arm.joints().to_vec(),
        });
    }
    let links = link_motion(arm, trajectory)?;
    let (q, v, a) = (&links.position, &links.velocity, &links.acceleration);
    let rigid = inverse_dynamics_of_motion(arm.rigid(), q, v, a);
    let mut effort = rigid.clone();
    add_contacts(arm, &links, &mut effort);
    // what the gear carries is the rigid body, behind a transmission with the contacts
    let loads =
        |j: usize| if arm.transmission(j).is_some() { effort[j].clone() } else { rigid[j].clone() };
    let loads: Vec<Vec<f64>> = (0..arm.dof()).map(loads).collect();
    for (j, effort) in effort.iter_mut().enumerate() {
        let resting = add_joint_effects(arm, j, trajectory, &loads[j], effort);
        if resting > 0 {
            recording.notes.push(format!(
                "{} is at rest in {resting} of {} samples; dry friction set to zero there",
                arm.joints()[j],
                trajectory.len()
            ));
        }
    }
    for pair in arm.pairs() {
        for t in 0..trajectory.len() {
            let speed =
                trajectory.velocity[pair.b][t] + pair.ratio * trajectory.velocity[pair.a][t];
            let common = pair.viscous * speed + DryFriction::both(pair.coulomb).effort(speed);
            effort[pair.b][t] += common;
            effort[pair.a][t] += pair.ratio * common;
        }
    }
    arm.to_recorded(&trajectory.time_s, &mut effort);
    for (joint, effort) in recording.joints.iter_mut().zip(effort) {
        if let Some(t) = effort.iter().position(|value| !value.is_finite()) {
            let (joint, time_s) = (joint.name.clone(), recording.time_s[t]);
            return Err(SimulationError::Overflow { joint, time_s });
        }
        joint.effort = Some(effort);
    }
    if let Some(temperatures) = arm.temperatures() {
        temperatures.record_in(&mut recording);
    }
    Ok(recording)
}

fn add_contacts(arm: &SimulatedArm, links: &Trajectory, effort: &mut [Vec<f64>]) {
    let mut position = vec![0.0; arm.dof()];
    for (t, &time_s) in links.time_s.iter().enumerate() {
        for (position, column) in position.iter_mut().zip(&links.position) {
            *position = column[t];
        }
        if let Some(contact) = arm.contact_effort(time_s, &position) {
            effort.iter_mut().zip(contact).for_each(|(effort, contact)| effort[t] += contact);
        }
    }
}

/// Adds what the effects on one joint take; gives the number of samples in which it may stick.
fn add_joint_effects(
    arm: &SimulatedArm,
    j: usize,
    trajectory: &Trajectory,
    load: &[f64],
    effort: &mut [f64],
) -> usize {
    let motor = arm.transmission(j).map_or(0.0, |transmission| transmission.motor_inertia);
    let inertia = arm.added_inertia(j) + motor;
    let (q, v) = (&trajectory.position[j], &trajectory.velocity[j]);
    let mut resting = 0;
    for (t, effort) in effort.iter_mut().enumerate() {
        let friction = arm.dry_friction(j, v[t], load[t]);
        resting += usize::from(v[t] == 0.0 && !friction.is_none());
        *effort += arm.smooth_effort(j, trajectory.time_s[t], q[t], v[t])
            + inertia * trajectory.acceleration[j][t]
            + friction.effort(v[t]);
    }
    for (_, law) in arm.deflections().filter(|(joint, _)| *joint == j) {
        let mut deflection = 0.0;
        for (t, effort) in effort.iter_mut().enumerate() {
            let travel = if t > 0 { q[t] - q[t - 1] } else { 0.0 };
            deflection = law.effect.deflection_after(&law.parameters, deflection, travel);
            *effort += law.effect.deflection_effort(&law.parameters, deflection, v[t]);
        }
    }
    resting
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
    fn friction_at_rest_is_zero_with_note() {
        let arm = planar(&[effect("coulomb_friction", "joint_2", 5.0)]);
        let mut trajectory = harmonic(arm.joints(), 20, 0.01);
        trajectory.velocity[1].fill(0.0);
        let with = inverse(&arm, &trajectory).unwrap();
        let without = inverse(&planar(&[]), &trajectory).unwrap();
        assert_eq!(with.joints, without.joints);
        assert_eq!(
            with.notes,
            ["joint_2 is at rest in 20 of 20 samples; dry friction set to zero there"]
        );
    }
}
