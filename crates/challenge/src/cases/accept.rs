//! Other answers that are the same effort.

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_effects::{
    Effect, JointMotion, LocationKind, MotionScale, Scope, Where, WholeArmMotion, directions_with,
};

use crate::cases::exact_motion::{Exact, rms};
use crate::cases::observer::Observer;
use crate::cases::scene::Scene;
use crate::contract::truth::Named;
use crate::hidden::hidden_effect::HiddenEffect;

/// Largest residual of a torque fitted by another law, over noise.
const SAME: f64 = 0.15;

/// Sets of findings that are the same effort as a hidden effect: by their laws, or because another law
/// alone reproduces it on these motions.
pub(crate) fn accepted(
    hidden: &HiddenEffect,
    scene: &Scene<'_>,
    observer: &Observer,
    motions: &[&Exact],
    torque: &[f64],
) -> Vec<Vec<Named>> {
    let (joint, last) = (hidden.joint(), scene.robot.dof() - 1);
    let holds = |on: Where| match on {
        Where::AnyJoint => true,
        Where::FirstJoint => joint == 0,
        Where::LastJoint => joint == last,
    };
    let equivalents = hidden.law().equivalents.iter().filter(|set| holds(set.on));
    let mut sets: Vec<Vec<Named>> = equivalents
        .map(|set| set.laws.iter().map(|slug| located(slug, joint, scene)).collect())
        .collect();
    if hidden.variant().is_some() || hidden.window_s().is_some() {
        return sets;
    }
    for effect in scene.library.named() {
        let law = effect.law();
        if law.slug == hidden.slug() || hidden.law().tolerates(law.slug) {
            continue;
        }
        match law.scope {
            Scope::Joint => {
                let fits = joint_columns(effect, joint, scene, observer, motions);
                let same = |columns: &Vec<Vec<f64>>| {
                    !columns.is_empty() && observer.unexplained(torque, columns) < SAME
                };
                if fits.iter().any(same) {
                    sets.push(vec![located(law.slug, joint, scene)]);
                }
            }
            Scope::Link | Scope::ThroughJoint | Scope::Arm if law.fits_alone => {
                let places = if law.scope == Scope::Arm { 1 } else { last + 1 };
                for joint in 0..places {
                    let columns = arm_columns(effect, joint, scene, observer, motions);
                    if observer.unexplained(torque, &columns) < SAME {
                        sets.push(vec![located(law.slug, joint, scene)]);
                    }
                }
            }
            _ => {}
        }
    }
    sets
}

/// A law with its location on a joint.
fn located(slug: &str, joint: usize, scene: &Scene<'_>) -> Named {
    let location = scene.library.law(slug).map_or(LocationKind::Joints, |law| law.location);
    let joints = match location {
        LocationKind::Joints | LocationKind::Link => vec![scene.robot.names[joint].clone()],
        LocationKind::AllJoints => scene.robot.names.clone(),
        LocationKind::TipLink | LocationKind::Arm => Vec::new(),
    };
    let link = scene.robot.chain.joints[joint].child_link.clone();
    let link = (location == LocationKind::Link).then_some(link);
    Named { effect: slug.to_owned(), joints, link }
}

/// Columns of a law on one joint for each of its shapes, on the rows of the observer.
fn joint_columns(
    law: &dyn Effect,
    joint: usize,
    scene: &Scene<'_>,
    observer: &Observer,
    motions: &[&Exact],
) -> Vec<Vec<Vec<f64>>> {
    let arm = RigidArm::from_chain(&scene.chain);
    let loads: Vec<Vec<f64>> = motions.iter().map(|m| rigid(&arm, m)[joint].clone()).collect();
    let directions: Vec<Vec<f64>> =
        motions.iter().map(|m| directions_with(&m.velocity[joint], f64::MIN_POSITIVE)).collect();
    let of_motion = |k: usize| JointMotion {
        kind: arm.joints[joint].kind,
        time_s: &motions[k].time_s,
        position: &motions[k].position[joint],
        velocity: &motions[k].velocity[joint],
        acceleration: &motions[k].acceleration[joint],
        direction: &directions[k],
        rigid_effort: &loads[k],
        temperature_c: &[],
    };
    let position = &motions[0].position[joint];
    let mean = position.iter().sum::<f64>() / position.len().max(1) as f64;
    let off: Vec<f64> = position.iter().map(|q| q - mean).collect();
    let scale = MotionScale {
        kind: arm.joints[joint].kind,
        speed_rms: rms(&motions[0].velocity[joint]),
        position_deviation: rms(&off),
        duration_s: scene.duration_s,
        temperature_c: None,
    };
    law.shapes(&scale)
        .iter()
        .map(|shape| {
            let by_motion: Vec<Vec<Vec<f64>>> =
                (0..motions.len()).map(|k| law.columns(shape, &of_motion(k))).collect();
            let count = by_motion.iter().map(Vec::len).min().unwrap_or(0);
            (0..count)
                .map(|c| {
                    let torque: Vec<Vec<Vec<f64>>> = by_motion
                        .iter()
                        .map(|columns| {
                            let mut joints = vec![vec![0.0; columns[c].len()]; arm.dof()];
                            joints[joint].clone_from(&columns[c]);
                            joints
                        })
                        .collect();
                    observer.rows_of(&torque)
                })
                .collect()
        })
        .collect()
}

/// Columns of a law of the whole arm, on the rows of the observer.
fn arm_columns(
    law: &dyn Effect,
    joint: usize,
    scene: &Scene<'_>,
    observer: &Observer,
    motions: &[&Exact],
) -> Vec<Vec<f64>> {
    let arm = RigidArm::from_chain(&scene.chain);
    let by_motion: Vec<_> = motions
        .iter()
        .map(|motion| {
            let rigid_effort = rigid(&arm, motion);
            law.arm_columns(
                joint,
                &WholeArmMotion {
                    arm: &arm,
                    base_from_e0: scene.chain.base_from_e0,
                    tip_in_last_m: scene.chain.tip_in_e.translation.vector,
                    rate_hz: motion.time_s.len() as f64 / scene.duration_s,
                    position: &motion.position,
                    velocity: &motion.velocity,
                    acceleration: &motion.acceleration,
                    rigid_effort: &rigid_effort,
                },
            )
        })
        .collect();
    let count = by_motion.iter().map(Vec::len).min().unwrap_or(0);
    (0..count)
        .map(|c| {
            let torque: Vec<Vec<Vec<f64>>> = by_motion.iter().map(|m| m[c].clone()).collect();
            observer.rows_of(&torque)
        })
        .collect()
}

fn rigid(arm: &RigidArm, motion: &Exact) -> Vec<Vec<f64>> {
    let Exact { position, velocity, acceleration, .. } = motion;
    inverse_dynamics_of_motion(arm, position, velocity, acceleration)
}
