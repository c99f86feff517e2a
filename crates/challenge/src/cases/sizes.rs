//! Sizes at which effects are visible.

use armident_effects::{Baseline, Law, Library, Scope};
use armident_simulation::SimulatedArm;

use crate::cases::exact_motion::{Exact, rms};
use crate::cases::observer::{Observer, Projection};
use crate::cases::scene::{Scene, efforts_of};
use crate::contract::kind::CaseKind;
use crate::error::ChallengeError;
use crate::hidden::hidden_effect::{HiddenEffect, Sized};
use crate::random::RandomStream;

/// Naming margins that are drawn, and those that are kept.
const DRAWN: [f64; 2] = [1.9, 11.0];
const KEPT: [f64; 2] = [1.5, 16.0];
/// Factor within which a margin is kept that was asked for.
const AS_ASKED: f64 = 1.3;
/// The same on the planned motions, from which the simulated ones differ a little.
const AS_ASKED_PLANNED: f64 = 1.2;
/// Rounds of sizing, and how near the drawn margin is near enough.
const ROUNDS: usize = 5;
const NEAR: f64 = 1.15;
/// Rounds where each is an integration.
const TRANSMISSION_ROUNDS: usize = 3;

/// Largest RMS torque of an effect over the given range of the joint: what is larger would be seen
/// without any tool.
const MOST_TORQUE: f64 = 0.5;

/// Least travel that an effect needs to build up, in encoder counts: what builds up within a few is dry friction with
/// stiction, whatever its margin over plain friction, which has none.
const RESOLVED_COUNTS: f64 = 10.0;

/// RMS of an effect's torque over noise on the most affected joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Visibility {
    pub(crate) observability: f64,
    pub(crate) naming_margin: f64,
    pub(crate) raw_ratio: f64,
}

/// What sizes are judged on: the planned motions.
pub(crate) struct Sizing {
    observer: Observer,
    bodies: Observer,
}

impl Sizing {
    /// Against this noise.
    pub(crate) fn new(scene: &Scene<'_>, sigma: &[f64]) -> Self {
        let motions: Vec<&Exact> = scene.planned[..2].iter().collect();
        let arm = armident_dynamics::RigidArm::from_chain(&scene.chain);
        let body_sigma = with_background(scene, &motions, sigma);
        Self {
            observer: Observer::new(&arm, &motions, sigma),
            bodies: Observer::new(&arm, &motions, &body_sigma),
        }
    }

    fn observer(&self, effect: &HiddenEffect) -> &Observer {
        if effect.is_body() { &self.bodies } else { &self.observer }
    }
}

/// Noise of a wrong body in a field case: the torque of all other inertial errors is some. The same before and after a
/// change, they are none.
pub(crate) fn with_background(scene: &Scene<'_>, motions: &[&Exact], sigma: &[f64]) -> Vec<f64> {
    if scene.background == 0.0 || scene.kind == CaseKind::Change {
        return sigma.to_vec();
    }
    let efforts = |arm: &armident_dynamics::RigidArm, motion: &Exact| {
        let Exact { position, velocity, acceleration, .. } = motion;
        armident_dynamics::inverse_dynamics_of_motion(arm, position, velocity, acceleration)
    };
    let (given, actual) =
        (scene.robot.arm(), armident_dynamics::RigidArm::from_chain(&scene.chain));
    let mut squares = vec![0.0; sigma.len()];
    for motion in motions {
        let (a, b) = (efforts(&given, motion), efforts(&actual, motion));
        for (j, square) in squares.iter_mut().enumerate() {
            let difference: Vec<f64> = a[j].iter().zip(&b[j]).map(|(a, b)| a - b).collect();
            *square += rms(&difference).powi(2) / motions.len() as f64;
        }
    }
    sigma.iter().zip(squares).map(|(sigma, square)| (sigma * sigma + square).sqrt()).collect()
}

/// Naming margins that are kept.
pub(crate) fn kept(asked: Option<f64>) -> [f64; 2] {
    asked.map_or(KEPT, |margin| [margin / AS_ASKED, margin * AS_ASKED])
}

fn kept_when_planned(asked: Option<f64>) -> [f64; 2] {
    let around = |margin: f64| [margin / AS_ASKED_PLANNED, margin * AS_ASKED_PLANNED];
    asked.map_or([KEPT[0] * 1.1, KEPT[1]], around)
}

/// Scales an effect until its naming margin on the planned motions is near the one asked for, or one drawn
/// by chance; nothing if it cannot be.
pub(crate) fn size(
    effect: HiddenEffect,
    scene: &Scene<'_>,
    sizing: &Sizing,
    asked: Option<f64>,
    random: &mut RandomStream,
) -> Result<Option<Sized>, ChallengeError> {
    let drawn = random.log_between(DRAWN[0], DRAWN[1]);
    let wanted = asked.unwrap_or(drawn);
    let [low, high] = kept_when_planned(asked);
    let motions: Vec<&Exact> = scene.planned[..2].iter().collect();
    let [start, most] = effect.sizes();
    let mut sized = Sized { size: start.min(most), effect, torque: Vec::new() };
    let rounds = if sized.effect.has_transmission() { TRANSMISSION_ROUNDS } else { ROUNDS };
    for round in 0..rounds {
        let one = std::slice::from_ref(&sized);
        let torque = effect_torque(scene, one, 0, &motions)?;
        let seen =
            visibility(&sized.effect, scene, sizing.observer(&sized.effect), &motions, &torque);
        let mean = |j: usize| rms(&torque.iter().flat_map(|m| m[j].clone()).collect::<Vec<_>>());
        sized.torque = (0..scene.robot.dof()).map(mean).collect();
        let factor = wanted / seen.naming_margin.max(1e-12);
        let near = (1.0 / NEAR..NEAR).contains(&factor);
        let stuck = factor > 1.0 && sized.size >= most;
        if near || stuck || round + 1 == rounds {
            let plausible = (0..sized.torque.len()).all(|j| {
                sized.torque[j] < MOST_TORQUE * scene.range[j].max(scene.sensing.sigma[j])
            });
            let resolved = sized.effect.travel(sized.size)
                >= RESOLVED_COUNTS * scene.sensing.count[sized.effect.joint()];
            let kept = plausible && resolved && (low..high).contains(&seen.naming_margin);
            return Ok(kept.then_some(sized));
        }
        sized.size = (sized.size * factor.clamp(0.02, 50.0)).min(most);
    }
    Ok(None)
}

/// What one of the effects adds to the efforts of the training recordings.
pub(crate) fn effect_torque(
    scene: &Scene<'_>,
    effects: &[Sized],
    which: usize,
    motions: &[&Exact],
) -> Result<Vec<Vec<Vec<f64>>>, ChallengeError> {
    let mut torque = Vec::new();
    for (file, motion) in motions.iter().enumerate() {
        let with = scene.arm(effects, file, None)?;
        let without = scene.arm(effects, file, Some(which))?;
        torque.push(difference(&with, &without, motion)?);
    }
    Ok(torque)
}

fn difference(
    with: &SimulatedArm,
    without: &SimulatedArm,
    motion: &Exact,
) -> Result<Vec<Vec<f64>>, ChallengeError> {
    let (with, without) = (efforts_of(with, motion)?, efforts_of(without, motion)?);
    let one = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
    Ok(with.iter().zip(&without).map(one).collect())
}

/// How visible a torque is by the rules of the challenge.
pub(crate) fn visibility(
    effect: &HiddenEffect,
    scene: &Scene<'_>,
    observer: &Observer,
    motions: &[&Exact],
    torque: &[Vec<Vec<f64>>],
) -> Visibility {
    let rows = observer.rows_of(torque);
    let active = effect.window_s().map(|window| {
        let inside: Vec<Vec<f64>> = motions
            .iter()
            .enumerate()
            .map(|(file, motion)| {
                let now = |t: &f64| (window[0]..=window[1]).contains(t);
                let counts =
                    |t: &f64| f64::from(u8::from(effect.recording() == Some(file) && now(t)));
                motion.time_s.iter().map(counts).collect()
            })
            .collect();
        observer.mask_of(&inside)
    });
    let active = active.as_deref();
    let own = own_joints(effect);
    let itself = own_baseline(scene.library, effect.law());
    let base = !effect.is_body();
    let others = own.clone();
    let strict = Projection {
        base,
        plain: Box::new(move |joint, which| !(own.contains(&joint) && itself == Some(which))),
    };
    let plain = Projection { base, plain: Box::new(move |joint, _| !others.contains(&joint)) };
    let nothing = Projection { base: false, plain: Box::new(|_, _| false) };
    let naming_margin = observer.visible(&rows, &strict, active);
    Visibility {
        observability: if scene.kind.is_field() {
            naming_margin
        } else {
            observer.visible(&rows, &plain, active)
        },
        naming_margin,
        raw_ratio: observer.visible(&rows, &nothing, active),
    }
}

/// Joints whose own effort the effect is.
fn own_joints(effect: &HiddenEffect) -> Vec<usize> {
    match effect.law().scope {
        Scope::Arm | Scope::Link => Vec::new(),
        Scope::Joint | Scope::Neighbours | Scope::ThroughJoint => effect.joints().collect(),
    }
}

/// The baseline term that is the effort of a law, or what it has beyond the law it contains.
fn own_baseline(library: &Library, law: &Law) -> Option<Baseline> {
    let beyond = law.equivalents.iter().flat_map(|set| set.laws);
    let beyond = beyond.filter(|slug| !law.contains.contains(slug));
    law.baseline.or_else(|| beyond.filter_map(|slug| library.law(slug)?.baseline).next())
}
