//! The answer of a case, from what was simulated.

use std::collections::BTreeMap;

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_effects::ArmFrames;
use armident_kinematics::InertialParameters;
use armident_recording::Recording;
use serde_json::json;

use crate::accept::accepted;
use crate::error::ChallengeError;
use crate::generate::{CaseKind, CaseRequest, FILES, Scene, efforts_of};
use crate::observe::{Observer, Plain, Projection};
use crate::recorder::{Exact, rms};
use crate::sizes::{Sized, effect_torque, is_body, kept, visibility, with_background};
use crate::truth::{
    EverydayFriction, Floors, Named, NoiseTruth, PerJoint, SampleRate, TrueEffect, Truth,
};

/// Everyday friction counts from this ratio to noise on.
const COUNTED: f64 = 1.2;
/// Joints whose effort changes by this share of the noise are affected.
const AFFECTED: f64 = 0.3;

/// What was simulated and recorded.
pub(crate) struct Made {
    pub(crate) exact: Vec<Exact>,
    pub(crate) recorded: [Recording; 4],
    /// From before a change.
    pub(crate) before: Vec<Recording>,
    pub(crate) holdout: Floors,
    pub(crate) exam: Floors,
    pub(crate) effort_lag_s: f64,
    pub(crate) lag_over_noise: f64,
}

/// What noise and stick phases of everyday friction leave to a careful user \[N m or N\].
pub(crate) fn effective_noise(scene: &Scene<'_>, drafts: &[Sized], made: &Made) -> Vec<f64> {
    let of_joint = |(j, name): (usize, &String)| {
        let sigma = scene.sensing.sigma[j];
        let Some(attainable) =
            made.holdout.attainable_rmse.get(name).filter(|_| scene.kind.is_field())
        else {
            return sigma;
        };
        // a concealed law that sticks harder is not hidden by how hard it sticks
        let own = drafts.iter().filter(|sized| sized.draft.joint == j);
        let sticking: f64 = own.map(|sized| sized.draft.sticking(sized.x)).product();
        let of_stick_phases = (attainable.powi(2) - sigma.powi(2)).max(0.0);
        (sigma.powi(2) + of_stick_phases / sticking.powi(2)).sqrt()
    };
    scene.robot.names.iter().enumerate().map(of_joint).collect()
}

/// The answer; nothing if some effect is not visible enough, or too much, in what was recorded.
pub(crate) fn truth_of(
    scene: &Scene<'_>,
    drafts: &[Sized],
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
    for (k, sized) in drafts.iter().enumerate() {
        let torque = effect_torque(scene, drafts, k, &motions)?;
        let watching = if is_body(&sized.draft) { &bodies } else { &observer };
        let seen = visibility(&sized.draft, scene, watching, &motions, &torque);
        if !(least..=most).contains(&seen.naming_margin) {
            return Ok(None);
        }
        let rows = observer.rows_of(&torque);
        let accept = accepted(&sized.draft, scene, &observer, &motions, &rows);
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
        everyday: everyday(scene, drafts, &observer, &motions),
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
        dirt: scene.kind.is_field().then(|| {
            json!({
                "clock_jitter_of_step": scene.sensing.jitter,
                "lost_samples": scene.sensing.lost,
                "effort_lag_s": made.effort_lag_s,
                "effort_lag_over_noise": made.lag_over_noise,
                "velocity_recorded": scene.sensing.velocity.is_some(),
            })
        }),
        holdout: made.holdout.clone(),
        exam: Some(made.exam.clone()),
        observability,
        checks: Some(json!({ "law_residual_over_noise": law_residual(scene, drafts, made)? })),
    }))
}

fn described(sized: &Sized, scene: &Scene<'_>, accept: Vec<Vec<Named>>) -> TrueEffect {
    let draft = &sized.draft;
    let names = &scene.robot.names;
    let chain = &scene.robot.chain;
    let joints: Vec<String> = match draft.slug {
        "gravity_direction" | "external_contact" => Vec::new(),
        "time_delay" => names.clone(),
        _ => [Some(draft.joint), draft.other]
            .into_iter()
            .flatten()
            .map(|j| names[j].clone())
            .collect(),
    };
    let link = match draft.slug {
        "payload" | "link_inertia_error" => Some(chain.joints[draft.joint].child_link.clone()),
        "external_contact" => Some(chain.tip_link.clone()),
        _ => None,
    };
    let mut values = draft.parameters(sized.x);
    if draft.slug == "link_inertia_error" && scene.kind != CaseKind::Change {
        // what the link is off the URDF by, and not only what was made wrong of it
        for (value, error) in values.iter_mut().zip(background_of(scene, draft.joint)) {
            *value += error;
        }
    }
    let own = draft.own.map(|law| law.law());
    let parameters: PerJoint = match armident_effects::effect(draft.slug) {
        Some(law) => law.law().parameters.iter().map(|p| p.name.to_owned()).zip(values).collect(),
        None => values.into_iter().enumerate().map(|(k, value)| (format!("p{k}"), value)).collect(),
    };
    let tolerate = draft.tolerated().iter().map(|slug| Named {
        effect: (*slug).to_owned(),
        // any link may stand beside a wrong one
        joints: if is_body(draft) { Vec::new() } else { joints.clone() },
        link: None,
    });
    let name = &names[draft.joint];
    let variables = match own.filter(|_| draft.slug == "unlisted") {
        Some(law) if law.formula.contains(") v") => {
            vec![format!("{name}/position"), format!("{name}/velocity")]
        }
        Some(_) => vec![format!("{name}/position")],
        None => Vec::new(),
    };
    TrueEffect {
        effect: draft.slug.to_owned(),
        tolerate: tolerate.collect(),
        joints,
        link,
        window: draft.window_s,
        recording: draft.recording.map(|file| FILES[file].to_owned()),
        parameters,
        variables,
        law: own.map(|law| format!("{}: {}", law.title, law.formula)),
        main_parameters: draft.main_parameters().iter().map(ToString::to_string).collect(),
        accept,
        observability: None,
        naming_margin: None,
        raw_ratio: None,
    }
}

/// Errors of mass and first moment that a link has as all links have them, in its URDF frame \[kg, kg m\].
fn background_of(scene: &Scene<'_>, joint: usize) -> [f64; 4] {
    let believed = &scene.robot.chain;
    let (real, of_urdf) =
        (scene.chain.joints[joint].link.to_array(), believed.joints[joint].link.to_array());
    let error = std::array::from_fn(|k| real[k] - of_urdf[k]);
    let in_e = ArmFrames::of_chain(believed).link_in_e[joint];
    let in_link = InertialParameters::from_array(&error).expressed_in(&in_e.inverse()).to_array();
    std::array::from_fn(|k| in_link[k])
}

fn everyday(
    scene: &Scene<'_>,
    drafts: &[Sized],
    observer: &Observer,
    motions: &[&Exact],
) -> Vec<EverydayFriction> {
    let mut list = Vec::new();
    if !scene.kind.is_field() {
        return list;
    }
    for (j, name) in scene.robot.names.iter().enumerate() {
        for (slug, parameter, which) in [
            ("viscous_friction", "coefficient", Plain::Viscous),
            ("coulomb_friction", "level", Plain::Coulomb),
        ] {
            let special = drafts
                .iter()
                .find(|sized| sized.draft.joint == j && sized.draft.replaces() == Some(slug));
            // of a change, by what the friction is another one
            let before = match scene.kind {
                CaseKind::Change => scene.friction(drafts, slug, j, FILES.len() - 1),
                _ => 0.0,
            };
            let value = scene.friction(drafts, slug, j, 0) - before;
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
                            *x = value * if which == Plain::Viscous { *v } else { direction };
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
            list.push(EverydayFriction {
                effect: slug.to_owned(),
                joints: vec![name.clone()],
                parameters: [(parameter.to_owned(), value)].into(),
                covered_by: special.map(|sized| sized.draft.slug.to_owned()),
                observability: seen,
                counted: seen.is_none_or(|seen| seen >= COUNTED),
            });
        }
    }
    list
}

/// Joints whose effort is not what the believed arm takes.
fn affected(scene: &Scene<'_>, made: &Made) -> Vec<String> {
    let believed = scene.robot.arm();
    let changed = |j: usize| {
        made.exact[..3].iter().any(|motion| {
            let Exact { position, velocity, acceleration, effort, .. } = motion;
            let rigid = inverse_dynamics_of_motion(&believed, position, velocity, acceleration);
            let change: Vec<f64> = effort[j].iter().zip(&rigid[j]).map(|(a, b)| a - b).collect();
            rms(&change) > AFFECTED * scene.sensing.sigma[j]
        })
    };
    let names = scene.robot.names.iter().enumerate();
    names.filter(|(j, _)| changed(*j)).map(|(_, name)| name.clone()).collect()
}

/// Largest difference between what was simulated and what the laws say, over noise, where joints move.
fn law_residual(scene: &Scene<'_>, drafts: &[Sized], made: &Made) -> Result<f64, ChallengeError> {
    let arm = scene.arm(drafts, 2, None)?;
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
