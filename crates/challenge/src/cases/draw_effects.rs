//! Effects of a case at sizes that can be seen.

use armident_dynamics::RigidArm;
use armident_effects::{DrawContext, JointSize};

use crate::cases::exact_motion::Exact;
use crate::cases::request::CaseRequest;
use crate::cases::scene::{Scene, TRAINING};
use crate::cases::sizes::{Sizing, size};
use crate::error::ChallengeError;
use crate::hidden::hidden_effect::{Hidden, HiddenEffect, Sized};
use crate::random::RandomStream;

/// Draws of joints and sizes before an effect counts as invisible on this arm.
const MOST_DRAWS: usize = 60;
/// The same where each draw is several integrations.
const MOST_TRANSMISSION_DRAWS: usize = 10;

/// Effects of a case with sizes that show on the planned motions; nothing if some do not.
pub(crate) fn draw_effects(
    scene: &Scene<'_>,
    request: &CaseRequest,
    hidden: &[Hidden],
    noise: &[f64],
    random: &mut RandomStream,
) -> Result<Option<Vec<Sized>>, ChallengeError> {
    let true_arm = RigidArm::from_chain(&scene.chain);
    let chain = &scene.robot.chain;
    let context = DrawContext {
        arm: &true_arm,
        link_in_e: chain.joints.iter().map(|joint| joint.child_link_in_e).collect(),
        joints: (0..scene.robot.dof()).map(|joint| joint_size(scene, joint)).collect(),
        duration_s: scene.duration_s,
        recordings: TRAINING,
    };
    let sizing = Sizing::new(scene, noise);
    let mut chosen: Vec<Sized> = Vec::new();
    for &what in hidden {
        let mut found = None;
        let draws = if what.has_transmission() { MOST_TRANSMISSION_DRAWS } else { MOST_DRAWS };
        for _ in 0..draws {
            let drawn =
                HiddenEffect::draw(what, request.perturbed, scene.library, &context, random);
            let Some(effect) = drawn else { continue };
            // two effects on one joint may add up to a third
            let near = |other: &Sized| {
                effect.joints().any(|joint| other.effect.joints().any(|j| j == joint))
            };
            if chosen.iter().any(near) {
                continue;
            }
            found = size(effect, scene, &sizing, request.margin, random)?;
            if found.is_some() {
                break;
            }
        }
        match found {
            Some(sized) => chosen.push(sized),
            None => return Ok(None),
        }
    }
    Ok(Some(chosen))
}

/// Motion and size of a joint, from which sizes of effects follow.
fn joint_size(scene: &Scene<'_>, joint: usize) -> JointSize {
    let plans = &scene.planned[..TRAINING];
    let spread = |pick: fn(&Exact) -> &Vec<Vec<f64>>| {
        let all: Vec<f64> = plans.iter().flat_map(|plan| pick(plan)[joint].clone()).collect();
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        let variance =
            all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / all.len().max(1) as f64;
        [mean, variance.sqrt()]
    };
    let [position_mean, position_deviation] = spread(|plan| &plan.position);
    JointSize {
        kind: scene.robot.chain.joints[joint].kind,
        position_mean,
        position_deviation,
        speed: spread(|plan| &plan.velocity)[1],
        acceleration: spread(|plan| &plan.acceleration)[1],
        noise: scene.sensing.sigma[joint],
        effort_range: scene.range[joint],
        dry_level: scene.level[joint],
        viscous: scene.viscous[joint],
    }
}
