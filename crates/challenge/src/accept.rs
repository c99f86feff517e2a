//! Other answers that are the same torque.

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_effects::{
    ArmMotion, Effect, JointMotion, LIBRARY, MotionScale, Scope, directions_with,
};

use crate::draft::Draft;
use crate::generate::Scene;
use crate::observe::Observer;
use crate::recorder::{Exact, rms};
use crate::truth::Named;

/// What another law may leave of the torque, over noise.
const SAME: f64 = 0.15;

/// Sets of findings that are the same torque as an effect: by their laws, or because another law
/// alone reproduces it on these motions.
pub(crate) fn accepted(
    draft: &Draft,
    scene: &Scene<'_>,
    observer: &Observer,
    motions: &[&Exact],
    torque: &[f64],
) -> Vec<Vec<Named>> {
    let name = &scene.robot.names[draft.joint];
    let last = scene.robot.dof() - 1;
    let on_joint =
        |slug: &str| Named { effect: slug.to_owned(), joints: vec![name.clone()], link: None };
    let on_body = |slug: &str| Named {
        link: Some(scene.robot.chain.joints[draft.joint].child_link.clone()),
        ..on_joint(slug)
    };
    let mut sets = match draft.slug {
        "asymmetric_coulomb_friction" => {
            vec![vec![on_joint("coulomb_friction"), on_joint("torque_offset")]]
        }
        "payload" => vec![vec![on_body("link_inertia_error")]],
        "link_inertia_error" if draft.joint == last => vec![vec![on_body("payload")]],
        "rotor_inertia" if draft.joint == 0 => vec![vec![on_body("link_inertia_error")]],
        _ => Vec::new(),
    };
    if draft.own.is_some() || draft.window_s.is_some() {
        return sets;
    }
    for law in LIBRARY {
        let slug = law.law().slug;
        let tolerated = draft.tolerated().contains(&slug);
        if slug == draft.slug || tolerated || slug == "payload" {
            continue;
        }
        match law.law().scope {
            Scope::Joint => {
                let fits = joint_columns(*law, draft.joint, scene, observer, motions);
                let same = |columns: &Vec<Vec<f64>>| {
                    !columns.is_empty() && observer.unexplained(torque, columns) < SAME
                };
                if fits.iter().any(same) {
                    sets.push(vec![on_joint(slug)]);
                }
            }
            Scope::Link | Scope::ThroughJoint | Scope::Arm if is_smooth(slug) => {
                let places = if law.law().scope == Scope::Arm { 1 } else { last + 1 };
                for joint in 0..places {
                    let columns = arm_columns(*law, joint, scene, observer, motions);
                    if observer.unexplained(torque, &columns) < SAME {
                        sets.push(vec![place(slug, joint, scene)]);
                    }
                }
            }
            _ => {}
        }
    }
    sets
}

/// Laws of the whole arm whose columns are exact enough to be compared.
fn is_smooth(slug: &str) -> bool {
    matches!(slug, "link_inertia_error" | "encoder_offset" | "gravity_direction")
}

fn place(slug: &str, joint: usize, scene: &Scene<'_>) -> Named {
    let link = scene.robot.chain.joints[joint].child_link.clone();
    Named {
        effect: slug.to_owned(),
        joints: if slug == "gravity_direction" {
            Vec::new()
        } else {
            vec![scene.robot.names[joint].clone()]
        },
        link: (slug == "link_inertia_error").then_some(link),
    }
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
    };
    let position = &motions[0].position[joint];
    let mean = position.iter().sum::<f64>() / position.len().max(1) as f64;
    let off: Vec<f64> = position.iter().map(|q| q - mean).collect();
    let scale = MotionScale {
        kind: arm.joints[joint].kind,
        speed_rms: rms(&motions[0].velocity[joint]),
        position_deviation: rms(&off),
        duration_s: scene.duration_s,
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
                &ArmMotion {
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
