//! Ordinary motion, by the batch fit.

use std::path::PathBuf;

use armident_ident::{
    BatchEstimate, BatchFit, BatchProblem, BatchSettings, BendFound, Chosen, Coupling,
    CouplingFound, DriveGain, DriveGains, KnownLoad, LAWS, MinimalSet, Recorded, Sought, Term,
    without_loads,
};
use armident_model::ArmModel;
use armident_motion::Motion;
use armident_page::Correlation;
use armident_recording::{Quantity, Recording};
use armident_report::{
    ConsistencyReport, DriveGainRow, EffectRow, EndogeneityRow, FitReport, IdentifyReport,
    MergedRow, PayloadRow,
};

use super::{Identified, add_consistent, by_joint, constant_row, fit_rows};
use crate::args::{CouplingArg, IdentifyArgs, PriorArg, ViscousArg};
use crate::commands::recordings;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::robot;

pub(super) fn batch(args: &IdentifyArgs) -> Result<Identified, Failure> {
    let train_files = recordings::expand(&args.recordings)?;
    let holdout_files = recordings::expand(&args.holdout)?;
    let mut train = recordings::read_all(&train_files, &args.reading, &args.output)?;
    let mut holdout = recordings::read_all(&holdout_files, &args.reading, &args.output)?;
    let recorded = recordings::joints_with_position(&train);
    let (model, unused) = robot::load_links(&args.robot, &args.chain, Some(&recorded))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let cutoff_hz = armident_motion::common_cutoff_hz(&train, &joints, args.cutoff_hz)?;
    let loads = payloads(args, &model, &[(&train_files, &train), (&holdout_files, &holdout)])?;

    let arm = model.rigid_arm();
    let set = MinimalSet::of(&arm)?;
    let mut problem = BatchProblem::new(&arm, &set).with_loads(&loads);
    let progress = Progress::of(&args.output, "filtering recordings");
    let drives = drive_gains(&mut problem, &loads, cutoff_hz, &joints, [&mut train, &mut holdout])?;
    let without_loads = |recordings: &[Recording]| -> Result<Vec<Motion>, Failure> {
        let motions = recordings::motions_with_effort(recordings, &joints, cutoff_hz)?;
        Ok(motions.into_iter().map(|m| without_loads(&arm, m, &loads).thinned()).collect())
    };
    let train_motions = without_loads(&train)?;
    let holdout_motions = without_loads(&holdout)?;
    let settings = BatchSettings {
        link_prior: match args.prior {
            PriorArg::Urdf => BatchSettings::default().link_prior,
            PriorArg::None => None,
        },
        ..BatchSettings::default()
    };
    let method = args.method.method();
    let mut notes = recordings::notes(train_motions.iter().chain(&holdout_motions));
    notes.extend(unused);
    let unreported = armident_ident::unreported(&train, &joints);
    problem = problem.with_unreported(unreported.iter().map(Option::is_some).collect());
    drop(progress);
    let progress = Progress::of(&args.output, "selecting model structure");
    let motions: Vec<&Motion> = train_motions.iter().collect();
    let sought = Sought {
        couplings: args.coupling == CouplingArg::Auto,
        bends: args.viscous == ViscousArg::Auto,
    };
    let Chosen { couplings, bends, settings } = problem.choose(&motions, &settings, sought)?;
    for CouplingFound { coupling, gain } in &couplings {
        let [a, b] = coupling.joints().map(|joint| joints[joint]);
        notes.push(format!(
            "{a} and {b}: coupled transmission included (ratio {}, cross-validated error {:.0} % lower)",
            coupling.ratio,
            100.0 * gain
        ));
    }
    for ((joint, turn), kind) in
        joints.iter().zip(problem.turns.iter().flatten()).zip(&model.chain.joints)
    {
        if turn.presliding_travel() > 0.0 {
            notes.push(format!(
                "{joint}: presliding friction included (travel {:.2} {}, selected by cross-validation)",
                1e3 * turn.presliding_travel(),
                if kind.kind.is_rotational() { "mrad" } else { "mm" }
            ));
        }
    }
    for BendFound { joint, in_errors } in &bends {
        notes.push(format!(
            "{}: sublinear viscous friction included (t = {in_errors:.0}); disable with --viscous linear",
            joints[*joint]
        ));
    }
    drop(progress);
    let progress = Progress::of(&args.output, "fitting");
    let fitted = BatchFit::of(
        &problem,
        &model,
        method,
        &settings,
        Recorded { recordings: &train, motions: &train_motions },
        Recorded { recordings: &holdout, motions: &holdout_motions },
    )?;
    let cross_validation = if args.cross_validate {
        fitted.cross_validation(&problem, &model, method, &settings)?
    } else {
        None
    };
    let recorded_velocities = fitted.velocity_gain.is_some();
    let velocities =
        if recorded_velocities || cutoff_hz.is_none() { "recorded" } else { "position" };
    if let Some(gain) = fitted.velocity_gain {
        notes.push(format!(
            "using recorded velocities (error {:.1} % lower than with differentiated positions)",
            100.0 * gain
        ));
    }
    let BatchFit { rows, estimate, holdout_rows, .. } = &fitted;
    drop(progress);
    let progress = Progress::of(&args.output, "projecting to consistent links");

    let consistent =
        if args.raw_estimate { None } else { Some(problem.nearest_consistent(estimate)?) };
    let values = consistent.as_ref().map_or(&estimate.values, |c| &c.estimated);
    let shown = problem.shown(rows, values);
    for ((name, stuck), shown) in joints.iter().zip(&unreported).zip(&shown) {
        let (Some(stuck), Some(shown)) = (stuck, shown) else { continue };
        notes.push(format!(
            "{name}: effort column has a dead zone (one value in {:.0} % of the moving samples); the column counts as a \
             single sample. It shows {:.1} % of the modelled effort, and predictions of it are scaled accordingly",
            100.0 * stuck,
            100.0 * shown.share
        ));
    }
    drop(progress);
    let of_urdf = set.values(&arm.constants());
    let urdf_terms: Vec<f64> = problem
        .terms
        .iter()
        .map(|term| match *term {
            Term::Constant(k) => of_urdf[k],
            Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => 0.0,
        })
        .collect();
    let trained = problem.fit_as_shown(rows, values, &shown);
    let mut effort_noise = estimate.effort_noise.clone();
    for ((noise, fit), shown) in effort_noise.iter_mut().zip(&trained).zip(&shown) {
        // in terms of the column, as its predictions are
        if shown.is_some() {
            *noise = fit.rmse;
        }
    }
    let fit = FitReport {
        train: fit_rows(&trained, &joints),
        holdout: holdout_rows
            .as_ref()
            .map(|r| fit_rows(&problem.fit_as_shown(r, values, &shown), &joints)),
        urdf: fit_rows(&problem.fit(holdout_rows.as_ref().unwrap_or(rows), &urdf_terms), &joints),
    };
    let mut constants = Vec::new();
    let mut effects = Vec::new();
    for (k, term) in problem.terms.iter().enumerate() {
        let (value, error) = (estimate.values[k], estimate.standard_error(k));
        match *term {
            Term::Load { .. } => {}
            // a constant has no bound, so its error is always there
            Term::Constant(c) => constants.push(constant_row(
                &set,
                c,
                &joints,
                of_urdf[c],
                error.map(|error| (value, error, estimate.quantile_95)),
                estimate.undetermined[k],
                estimate.from_prior[k],
            )),
            Term::Effect { joint, .. }
            | Term::Shared { coupling: Coupling { first: joint, .. }, .. } => {
                let Some(parameter) = term.parameter() else { continue };
                let (effect, other_joint) = match *term {
                    Term::Effect { effect, .. } => (LAWS[effect].law().slug, None),
                    _ => (Coupling::SLUG, Some(names[joint + 1].clone())),
                };
                effects.push(EffectRow {
                    effect: effect.to_owned(),
                    joint: names[joint].clone(),
                    other_joint,
                    parameter: parameter.name.to_owned(),
                    unit: parameter.unit(model.chain.joints[joint].kind).to_owned(),
                    value,
                    standard_error: error,
                    admissible: parameter.admissible.allows(value),
                    at_bound: estimate.at_bound[k],
                    undetermined: estimate.undetermined[k],
                });
            }
        }
    }
    let merged = problem
        .merged
        .iter()
        .map(|m| MergedRow {
            term: problem.label(&m.term, &joints),
            into: m
                .into
                .iter()
                .map(|&(k, factor)| (problem.label(&problem.terms[k], &joints), factor))
                .collect(),
        })
        .collect();
    let mut warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();
    if drives.as_ref().is_some_and(|gains| !gains.absolute) {
        warnings.push(
            "drive gains are known only relative to each other: no recording has a known payload \
             (--payload) and no joint an effort in N m or N. They are scaled to match the URDF \
             inertias; all constants share this scale [only-ratios]"
                .to_owned(),
        );
    }
    if estimate.rank < problem.terms.len() {
        let open: Vec<String> = (0..problem.terms.len())
            .filter(|&k| estimate.undetermined[k] > 1e-3)
            .map(|k| problem.label(&problem.terms[k], &joints))
            .collect();
        warnings.push(format!(
            "the recordings identify {} of {} parameters; not identified: combinations of {} \
             [not-determined]",
            estimate.rank,
            problem.terms.len(),
            open.join(", ")
        ));
    }
    let consistency = consistent.as_ref().map(|c| ConsistencyReport::of(c, &joints));
    add_consistent(&mut constants, &set, consistent.as_ref());
    warnings.extend(consistency.iter().flat_map(ConsistencyReport::warnings));
    let report = IdentifyReport {
        schema: IdentifyReport::SCHEMA.to_owned(),
        method: "batch".to_owned(),
        estimator: Some(method.name().to_owned()),
        robot: model.chain.robot.clone(),
        recordings: train.iter().map(|r| r.source.clone()).collect(),
        holdout_recordings: holdout.iter().map(|r| r.source.clone()).collect(),
        joints: names.clone(),
        cutoff_hz,
        velocities: velocities.to_owned(),
        prior_scale: settings.link_prior,
        consistency,
        constants,
        effects,
        merged,
        drive_gains: gain_rows(drives.as_ref(), &model),
        payloads: payload_rows(&problem, &loads, &model, estimate),
        steps: Vec::new(),
        rank: estimate.rank,
        parameters: problem.terms.len(),
        condition: estimate.condition,
        rows: estimate.rows,
        effective_sample_share: estimate.independent_share,
        effort_noise: by_joint(&effort_noise, &joints),
        not_significant: (0..problem.terms.len())
            .filter(|&k| !estimate.is_essential(k))
            .map(|k| problem.label(&problem.terms[k], &joints))
            .collect(),
        endogeneity: fitted.endogeneity.map(|found| EndogeneityRow {
            term: problem.label(&problem.terms[found.term], &joints),
            t: found.t,
            p: found.p,
        }),
        cross_validation: cross_validation.as_ref().map(|fits| fit_rows(fits, &joints)),
        fit,
        warnings,
        notes,
    };
    let turns = problem.turns.clone();
    let mut found = match &consistent {
        Some(consistent) => ArmModel {
            effects: problem.consistent_effects(consistent, &joints),
            ..model.with_links(&consistent.links)
        },
        None => ArmModel {
            effects: problem.effects(&estimate.values, &joints),
            ..set.applied_to(model, &problem.constants(&estimate.values))
        },
    };
    found.cutoff_hz = cutoff_hz;
    found.recorded_velocities = recorded_velocities;
    found.reversals = turns;
    found.effort_noise = Some(effort_noise);
    found.shown = shown.iter().any(Option::is_some).then_some(shown);
    found.provenance.push(format!("fitted to {}", report.recordings.join(", ")));
    let correlation = Correlation {
        labels: problem.terms.iter().map(|term| problem.label(term, &joints)).collect(),
        rows: correlations(estimate),
    };
    Ok(Identified { report, model: found, correlation: Some(correlation), read: [train, holdout] })
}

/// Known payloads of the command line, matched to their recordings.
fn payloads(
    args: &IdentifyArgs,
    model: &ArmModel,
    read: &[(&Vec<PathBuf>, &Vec<Recording>)],
) -> Result<Vec<KnownLoad>, Failure> {
    let mut loads: Vec<KnownLoad> = Vec::new();
    for given in &args.payload {
        let place = format!("--payload file={}", given.file.display());
        let pairs =
            || read.iter().flat_map(|(files, recordings)| files.iter().zip(recordings.iter()));
        let exact = pairs().find(|(file, _)| **file == given.file);
        let by_name = pairs().find(|(file, _)| file.file_name() == Some(given.file.as_os_str()));
        let Some((_, recording)) = exact.or(by_name) else {
            let known: Vec<String> = pairs().map(|(file, _)| file.display().to_string()).collect();
            return Err(Failure::new(
                "the payload's recording is not among the inputs",
                place,
                Some(format!("use one of {}", known.join(", "))),
            ));
        };
        if given.mass_kg <= 0.0 {
            return Err(Failure::new(
                format!("the payload mass must be positive, found {} kg", given.mass_kg),
                place,
                Some(
                    "pass the weighed mass as mass=KG; omit --payload for a recording without a payload",
                ),
            ));
        }
        if given.com_error_m < 0.0 {
            return Err(Failure::new(
                format!("com_error must not be negative, found {} m", given.com_error_m),
                place,
                Some("pass the standard deviation of each coordinate of com [m]"),
            ));
        }
        if given.com_error_m > 0.0 && given.com_m.is_none() {
            return Err(Failure::new(
                "com_error requires com",
                place,
                Some("pass com=X:Y:Z too, or omit both to estimate the centre of mass"),
            ));
        }
        if loads.iter().any(|load| load.is_on(&recording.source)) {
            return Err(Failure::new(
                "the recording already has a payload",
                place,
                Some("pass one --payload per recording, with the total mass and its centre"),
            ));
        }
        loads.push(KnownLoad::new(
            &model.chain,
            &recording.source,
            given.mass_kg,
            given.com_m,
            given.com_error_m,
        ));
    }
    Ok(loads)
}

/// Drive gains of joints with currents instead of efforts; the recordings get efforts computed from the
/// currents. `None` if all joints have efforts.
fn drive_gains(
    problem: &mut BatchProblem<'_>,
    loads: &[KnownLoad],
    cutoff_hz: Option<f64>,
    joints: &[&str],
    recordings: [&mut Vec<Recording>; 2],
) -> Result<Option<DriveGains>, Failure> {
    let [train, holdout] = recordings;
    let current_only = |recording: &Recording, joint: &str| {
        recording.joint(joint).is_some_and(|channels| {
            channels.channel(Quantity::Effort).is_none()
                && channels.channel(Quantity::Current).is_some()
        })
    };
    let is_current: Vec<bool> =
        joints.iter().map(|joint| train.iter().any(|r| current_only(r, joint))).collect();
    if !is_current.contains(&true) {
        return Ok(None);
    }
    for recording in train.iter().chain(holdout.iter()) {
        for (joint, is_current) in joints.iter().zip(&is_current) {
            let has = recording.joint(joint).is_some_and(|channels| channels.effort.is_some());
            if *is_current && has {
                return Err(Failure::new(
                    format!(
                        "joint `{joint}` has an effort here but only a current in another recording"
                    ),
                    &recording.source,
                    Some(
                        "use recordings with the same channels, or convert currents to efforts with --mapping FILE",
                    ),
                ));
            }
        }
    }
    let fill = |recordings: &mut Vec<Recording>, gain: &dyn Fn(usize) -> f64| {
        for recording in recordings {
            for (j, name) in joints.iter().enumerate().filter(|(j, _)| is_current[*j]) {
                let Some(channels) = recording.joints.iter_mut().find(|c| c.name == *name) else {
                    continue;
                };
                let current = channels.channel(Quantity::Current);
                let effort = current.map(|c| c.iter().map(|i| gain(j) * i).collect());
                *channels.channel_mut(Quantity::Effort) = effort;
            }
        }
    };
    fill(train, &|_| 1.0);
    let motions: Vec<Motion> = recordings::motions_with_effort(train, joints, cutoff_hz)?
        .into_iter()
        .map(Motion::thinned)
        .collect();
    let motions: Vec<&Motion> = motions.iter().collect();
    problem.choose_turning_speeds(&motions)?;
    let gains = problem.drive_gains(&motions, &is_current, loads)?;
    let open: Vec<String> = (joints.iter().zip(&gains.joints))
        .filter(|(_, gain)| gain.is_some_and(|gain| !gain.is_determined()))
        .map(|(joint, _)| format!("`{joint}`"))
        .collect();
    if !open.is_empty() {
        let sources: Vec<&str> = train.iter().map(|r| r.source.as_str()).collect();
        return Err(Failure::new(
            format!(
                "drive gains of {} are not identifiable from the currents (95 % interval over a factor of ten)",
                open.join(", ")
            ),
            sources.join(", "),
            Some(
                "convert currents with known drive gains (--mapping FILE), add a recording with a known \
                 payload (--payload), or exclude joints with --base and --tip",
            ),
        ));
    }
    let of_joint = |j: usize| {
        gains.joints[j].map_or(1.0, |gain: DriveGain| gain.value * gains.scale_of_description)
    };
    fill(train, &of_joint);
    fill(holdout, &of_joint);
    Ok(Some(gains))
}

fn gain_rows(gains: Option<&DriveGains>, model: &ArmModel) -> Vec<DriveGainRow> {
    let Some(gains) = gains else { return Vec::new() };
    let pairs = model.chain.joints.iter().zip(&gains.joints);
    pairs
        .filter_map(|(joint, gain)| {
            let gain = (*gain)?;
            let rotational = joint.kind.is_rotational();
            Some(DriveGainRow {
                joint: joint.name.clone(),
                value: gain.value,
                standard_error: gain.standard_error,
                interval_95: gain.interval_95,
                unit: match (gains.absolute, rotational) {
                    (true, true) => "N m/A",
                    (true, false) => "N/A",
                    (false, _) => "relative",
                }
                .to_owned(),
                used: gain.value * gains.scale_of_description,
            })
        })
        .collect()
}

fn payload_rows(
    problem: &BatchProblem<'_>,
    loads: &[KnownLoad],
    model: &ArmModel,
    estimate: &BatchEstimate,
) -> Vec<PayloadRow> {
    let in_link = model.chain.joints.last().map(|joint| joint.child_link_in_e.inverse());
    loads
        .iter()
        .map(|load| {
            let centre = problem.centre_of(load, &estimate.values);
            let centre = in_link.map_or(centre, |to| to.transform_point(&centre.into()).into());
            PayloadRow {
                recordings: load.sources.clone(),
                mass_kg: load.mass_kg,
                centre_of_mass_m: centre,
                is_estimated: load.centre_error_m > 0.0,
            }
        })
        .collect()
}

/// Correlation of every pair of estimates; `None` for estimates at their bound.
fn correlations(estimate: &BatchEstimate) -> Vec<Vec<Option<f64>>> {
    let of = |a: usize, b: usize| estimate.covariance[(a, b)];
    let pair = |a, b| {
        let correlation = of(a, b) / (of(a, a) * of(b, b)).sqrt();
        correlation.is_finite().then(|| (100.0 * correlation).round() / 100.0)
    };
    let count = estimate.values.len();
    (0..count).map(|a| (0..count).map(|b| pair(a, b)).collect()).collect()
}
