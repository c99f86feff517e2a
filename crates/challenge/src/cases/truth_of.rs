//! The truth of a case, from what was simulated.

use std::collections::BTreeMap;

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_effects::{ArmFrames, BASELINE, Baseline, Effect, LinkInertiaError, LocationKind};
use armident_kinematics::InertialParameters;
use serde_json::json;

use crate::cases::accept::accepted;
use crate::cases::exact_motion::{Exact, rms};
use crate::cases::observer::{Observer, Projection};
use crate::cases::request::CaseRequest;
use crate::cases::scene::{FILES, Scene, efforts_of, replacing};
use crate::cases::simulate::Made;
use crate::cases::sizes::{effect_torque, kept, visibility, with_background};
use crate::contract::kind::CaseKind;
use crate::contract::truth::{
    BaselineFriction, Named, NoiseTruth, PerJoint, SampleRate, TrueEffect, Truth,
};
use crate::error::ChallengeError;
use crate::hidden::hidden_effect::Sized;

/// Baseline friction counts from this ratio to noise on.
const COUNTED: f64 = 1.2;
/// Joints whose effort changes by this share of the noise are affected.
const AFFECTED: f64 = 0.3;

/// What noise and stick phases of baseline friction leave to a careful user \[N m or N\].
pub(crate) fn effective_noise(scene: &Scene<'_>, hidden: &[Sized], made: &Made) -> Vec<f64> {
    let of_joint = |(j, name): (usize, &String)| {
        let sigma = scene.sensing.sigma[j];
        let Some(attainable) =
            made.holdout.attainable_rmse.get(name).filter(|_| scene.kind.is_field())
        else {
            return sigma;
        };
        // a hidden law that sticks harder is not masked by how hard it sticks
        let own = hidden.iter().filter(|sized| sized.effect.joint() == j);
        let sticking: f64 = own.map(|sized| sized.effect.breakaway(sized.size)).product();
        let of_stick_phases = (attainable.powi(2) - sigma.powi(2)).max(0.0);
        (sigma.powi(2) + of_stick_phases / sticking.powi(2)).sqrt()
    };
    scene.robot.names.iter().enumerate().map(of_joint).collect()
}

/// The truth; nothing if some effect is not visible enough, or too much, in what was recorded.
pub(crate) fn truth_of(
    scene: &Scene<'_>,
    hidden: &[Sized],
    made: &Made,
    effective: &[f64],
    request: &CaseRequest,
) -> Result<Option<Truth>, ChallengeError> {
    let names = &scene.robot.names;
    let named = |values: &[f64]| -> PerJoint {
        names.iter().cloned().zip(values.iter().copied()).collect()
    };
    let sigma = &scene.sensing.sigma;
    let motions: Vec<&Exact> = made.exact[..2].iter().collect();
    let arm = RigidArm::from_chain(&scene.chain);
    let observer = Observer::new(&arm, &motions, effective);
    let body_noise = if scene.kind.is_field() {
        with_background(scene, &motions, effective)
    } else {
        effective.to_vec()
    };
    let bodies = Observer::new(&arm, &motions, &body_noise);
    let mut effects = Vec::new();
    let [least, most] = kept(request.margin);
    for (k, sized) in hidden.iter().enumerate() {
        let torque = effect_torque(scene, hidden, k, &motions)?;
        let watching = if sized.effect.is_body() { &bodies } else { &observer };
        let seen = visibility(&sized.effect, scene, watching, &motions, &torque);
        if !(least..=most).contains(&seen.naming_margin) {
            return Ok(None);
        }
        let rows = observer.rows_of(&torque);
        let accept = accepted(&sized.effect, scene, &observer, &motions, &rows);
        let mut effect = described(sized, scene, accept);
        effect.observability = Some(seen.observability);
        effect.naming_margin = Some(seen.naming_margin);
        effect.raw_ratio = Some(seen.raw_ratio);
        effects.push(effect);
    }
    let observability =
        effects.iter().filter_map(|effect| effect.observability).fold(0.0, f64::max);
    let tip = &scene.robot.chain.tip_link;
    let rates = FILES.iter().zip(scene.rates_hz).map(|(file, rate)| ((*file).to_owned(), rate));
    Ok(Some(Truth {
        schema: "armident.challenge/1".to_owned(),
        kind: scene.kind.is_field().then(|| scene.kind.name().to_owned()),
        case: request.name.clone(),
        robot: request.robot.clone(),
        tip_link: tip.clone(),
        effects,
        baseline: baseline(scene, hidden, &observer, &motions),
        // errors that were there before are no change
        background_inertial_error: match scene.kind {
            CaseKind::Change => 0.0,
            _ => scene.background,
        },
        affected_joints: affected(scene, made),
        bodies: scene.robot.bodies(),
        noise: NoiseTruth {
            effort_sigma: named(sigma),
            effective_sigma: if scene.kind.is_field() { named(effective) } else { BTreeMap::new() },
            effort_fraction: scene.noise_share,
            effort_colour: scene.sensing.colour,
            encoder_resolution: named(&scene.sensing.count),
            velocity: scene.sensing.velocity.clone(),
        },
        sample_rate: if scene.kind.is_field() {
            SampleRate::PerFile(rates.collect())
        } else {
            SampleRate::All(scene.rates_hz[0])
        },
        difficulties: scene.faults.names(),
        dirt: scene.kind.is_field().then(|| {
            json!({
                "clock_jitter_of_step": scene.sensing.jitter,
                "lost_samples": scene.sensing.lost,
                "effort_lag_s": made.effort_lag_s,
                "effort_lag_over_noise": made.lag_over_noise,
                "velocity_recorded": scene.sensing.velocity.is_some(),
                "effort_clock_drift": scene.faults.effort_clock,
                "effort_low_pass_hz": scene.faults.low_pass_hz,
            })
        }),
        holdout: made.holdout.clone(),
        exam: Some(made.exam.clone()),
        observability,
        checks: Some(json!({ "law_residual_over_noise": law_residual(scene, hidden, made)? })),
    }))
}

fn described(sized: &Sized, scene: &Scene<'_>, accept: Vec<Vec<Named>>) -> TrueEffect {
    let hidden = &sized.effect;
    let law = hidden.law();
    let names = &scene.robot.names;
    let chain = &scene.robot.chain;
    let joints: Vec<String> = match law.location {
        LocationKind::TipLink | LocationKind::Arm => Vec::new(),
        LocationKind::AllJoints => names.clone(),
        LocationKind::Joints | LocationKind::Link => {
            hidden.joints().map(|j| names[j].clone()).collect()
        }
    };
    let link = match law.location {
        LocationKind::Link => Some(chain.joints[hidden.joint()].child_link.clone()),
        LocationKind::TipLink => Some(chain.tip_link.clone()),
        LocationKind::Joints | LocationKind::AllJoints | LocationKind::Arm => None,
    };
    let mut values = hidden.parameters(sized.size);
    if law.slug == LinkInertiaError.slug() && scene.kind != CaseKind::Change {
        // the whole difference of the link from the URDF, its background error included
        for (value, error) in values.iter_mut().zip(background_of(scene, hidden.joint())) {
            *value += error;
        }
    }
    let parameters: PerJoint = match law.parameters {
        [] => values.into_iter().enumerate().map(|(k, value)| (format!("p{k}"), value)).collect(),
        listed => listed.iter().map(|p| p.name.to_owned()).zip(values).collect(),
    };
    let tolerate = law.tolerated().map(|slug| Named {
        effect: slug.to_owned(),
        // any link may be reported beside a wrong one
        joints: if hidden.is_body() { Vec::new() } else { joints.clone() },
        link: None,
    });
    let name = &names[hidden.joint()];
    TrueEffect {
        effect: law.slug.to_owned(),
        tolerate: tolerate.collect(),
        joints,
        link,
        window: hidden.window_s(),
        recording: hidden.recording().map(|file| FILES[file].to_owned()),
        parameters,
        variables: hidden.variables.iter().map(|channel| format!("{name}/{channel}")).collect(),
        law: hidden.variant().map(|law| format!("{}: {}", law.title, law.formula)),
        main_parameters: law
            .parameters
            .iter()
            .filter(|p| p.is_main)
            .map(|p| p.name.to_owned())
            .collect(),
        accept,
        observability: None,
        naming_margin: None,
        raw_ratio: None,
    }
}

/// Background errors of mass and first moment of a link, in its URDF frame \[kg, kg m\].
fn background_of(scene: &Scene<'_>, joint: usize) -> [f64; 4] {
    let given = &scene.robot.chain;
    let (real, of_urdf) =
        (scene.chain.joints[joint].link.to_array(), given.joints[joint].link.to_array());
    let error = std::array::from_fn(|k| real[k] - of_urdf[k]);
    let in_e = ArmFrames::of_chain(given).link_in_e[joint];
    let in_link = InertialParameters::from_array(&error).expressed_in(&in_e.inverse()).to_array();
    std::array::from_fn(|k| in_link[k])
}

fn baseline(
    scene: &Scene<'_>,
    hidden: &[Sized],
    observer: &Observer,
    motions: &[&Exact],
) -> Vec<BaselineFriction> {
    let mut list = Vec::new();
    if !scene.kind.is_field() {
        return list;
    }
    for (j, name) in scene.robot.names.iter().enumerate() {
        for law in BASELINE.iter().map(|effect| effect.law()) {
            let (Some(which), [parameter]) = (law.baseline, law.parameters) else { continue };
            if !which.is_friction() {
                continue;
            }
            let special = replacing(hidden, j, which);
            // of a change, the difference of the friction
            let before = match scene.kind {
                CaseKind::Change => scene.friction(hidden, which, j, FILES.len() - 1),
                _ => 0.0,
            };
            let value = scene.friction(hidden, which, j, 0) - before;
            if value == 0.0 {
                continue;
            }
            let seen = special.is_none().then(|| {
                let torque: Vec<Vec<Vec<f64>>> = motions
                    .iter()
                    .map(|motion| {
                        let mut joints = vec![vec![0.0; motion.time_s.len()]; scene.robot.dof()];
                        for (x, v) in joints[j].iter_mut().zip(&motion.velocity[j]) {
                            let direction = if *v == 0.0 { 0.0 } else { v.signum() };
                            *x = value * if which == Baseline::Viscous { *v } else { direction };
                        }
                        joints
                    })
                    .collect();
                let others = Projection {
                    base: true,
                    plain: Box::new(move |joint, plain| joint != j || plain != which),
                };
                observer.visible(&observer.rows_of(&torque), &others, None)
            });
            list.push(BaselineFriction {
                effect: law.slug.to_owned(),
                joints: vec![name.clone()],
                parameters: [(parameter.name.to_owned(), value)].into(),
                covered_by: special.map(|sized| sized.effect.slug().to_owned()),
                observability: seen,
                counted: seen.is_none_or(|seen| seen >= COUNTED),
            });
        }
    }
    list
}

/// Joints whose effort differs from that of the given arm.
fn affected(scene: &Scene<'_>, made: &Made) -> Vec<String> {
    let given = scene.robot.arm();
    let changed = |j: usize| {
        made.exact[..3].iter().any(|motion| {
            let Exact { position, velocity, acceleration, effort, .. } = motion;
            let rigid = inverse_dynamics_of_motion(&given, position, velocity, acceleration);
            let change: Vec<f64> = effort[j].iter().zip(&rigid[j]).map(|(a, b)| a - b).collect();
            rms(&change) > AFFECTED * scene.sensing.sigma[j]
        })
    };
    let names = scene.robot.names.iter().enumerate();
    names.filter(|(j, _)| changed(*j)).map(|(_, name)| name.clone()).collect()
}

/// Largest difference between what was simulated and what the laws say, over noise, where joints move.
fn law_residual(scene: &Scene<'_>, hidden: &[Sized], made: &Made) -> Result<f64, ChallengeError> {
    let arm = scene.arm(hidden, 2, None)?;
    let motion = &made.exact[2];
    let lawful = efforts_of(&arm, motion)?;
    let worst = (0..lawful.len()).map(|j| {
        let fast = 0.05 * rms(&motion.velocity[j]);
        let moving = (0..motion.time_s.len()).filter(|&k| motion.velocity[j][k].abs() > fast);
        let off: Vec<f64> = moving.map(|k| lawful[j][k] - motion.effort[j][k]).collect();
        rms(&off) / scene.sensing.sigma[j]
    });
    Ok(worst.fold(0.0, f64::max))
}
