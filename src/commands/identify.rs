//! `armident identify`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use armident_dynamics::RigidArm;
use armident_effects::EVERYDAY;
use armident_ident::algorithm2::{Algorithm2Estimate, PLAN_SCHEMA, Plan, algorithm2};
use armident_ident::{
    ArmModel, BatchEstimate, BatchFit, BatchProblem, BatchSettings, Chosen, Consistent, Coupling,
    CouplingFound, DriveGain, DriveGains, JointFit, KnownLoad, MinimalSet, Recorded, Term,
    without_loads,
};
use armident_page::{Correlation, Drawing, Role};
use armident_recording::{Motion, Quantity, Recording};
use armident_report::{
    ConsistencyReport, ConstantRow, DriveGainRow, EffectRow, EndogeneityRow, FitReport, FitRows,
    IdentifyReport, LoadRow, MergedRow, StepRow,
};

use super::recordings;
use crate::args::{CouplingArg, IdentifyArgs, PriorArg};
use crate::failure::{Failure, Outcome};
use crate::progress::Progress;
use crate::{output, page, robot};

pub(crate) fn run(args: &IdentifyArgs) -> Result<Outcome, Failure> {
    // a folder without recordings is refused below, where it is known whether it holds a plan
    let files = recordings::expand(&args.recordings).unwrap_or_default();
    let inputs = files.iter().chain(&args.holdout).chain([&args.robot]).map(PathBuf::as_path);
    output::protect(
        inputs,
        [args.output.json.as_ref(), args.save_model.as_ref(), args.page.report.as_ref()],
    )?;
    args.page.check()?;
    let with_plan: Vec<PathBuf> =
        args.recordings.iter().filter_map(|p| recordings::plan_in(p)).collect();
    let Identified { report, model, read, correlation } = match &with_plan[..] {
        [] => batch(args)?,
        [plan] if args.recordings.len() == 1 => by_algorithm2(args, plan)?,
        _ => {
            return Err(Failure::new(
                "a folder with a plan cannot be combined with other recordings",
                args.recordings[0].display(),
                Some(
                    "identify one planned folder at a time, or name its CSV files for a batch fit",
                ),
            ));
        }
    };
    if let Some(path) = &args.save_model {
        model.save(path).map_err(|error| Failure::unwritable(path, &error))?;
    }
    output::say_all(&args.output, "note", &report.notes);
    let [train, holdout] = &read;
    let recorded = [(train.as_slice(), Role::Training), (holdout.as_slice(), Role::Holdout)];
    let models = [("URDF alone", &model.before()), ("model", &model)];
    let used = [&args.robot].into_iter().chain(&files).chain(&args.holdout);
    let used = used.chain(&args.reading.mapping).chain(&with_plan);
    let drawing = page::of_models(&args.page, &models, &recorded, report.cutoff_hz, used)?
        .map(|drawing| Drawing { correlation, ..drawing });
    let text = report.text(output::bars());
    let warnings = &report.warnings;
    page::write_result(&args.page, &args.output, &text, &report, warnings, drawing.as_ref())
}

/// What an identification leaves: the result, the model, and what a page draws.
struct Identified {
    report: IdentifyReport,
    model: ArmModel,
    /// fitted, and kept out
    read: [Vec<Recording>; 2],
    correlation: Option<Correlation>,
}

fn batch(args: &IdentifyArgs) -> Result<Identified, Failure> {
    let train_files = recordings::expand(&args.recordings)?;
    let holdout_files = recordings::expand(&args.holdout)?;
    let mut train = recordings::read_all(&train_files, &args.reading, &args.output)?;
    let mut holdout = recordings::read_all(&holdout_files, &args.reading, &args.output)?;
    let recorded = recordings::joints_with_position(&train);
    let model = robot::load(&args.robot, &args.chain, Some(&recorded))?;
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let cutoff_hz = armident_recording::common_cutoff_hz(&train, &joints, args.cutoff_hz)?;
    let loads = payloads(args, &model, &[(&train_files, &train), (&holdout_files, &holdout)])?;

    let arm = model.rigid_arm();
    let set = MinimalSet::of(&arm)?;
    let mut problem = BatchProblem::new(&arm, &set).with_loads(&loads);
    let progress = Progress::of(&args.output, "forming motions");
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
    drop(progress);
    let progress = Progress::of(&args.output, "choosing by stretches left out");
    let motions: Vec<&Motion> = train_motions.iter().collect();
    let Chosen { couplings, settings } =
        problem.choose(&motions, &settings, args.coupling == CouplingArg::Auto)?;
    for CouplingFound { coupling, gain } in &couplings {
        let [a, b] = coupling.joints().map(|joint| joints[joint]);
        notes.push(format!(
            "{a} and {b} share a transmission (ratio {}): the error of stretches left out of the fit is \
             {:.0} % lower with it",
            coupling.ratio,
            100.0 * gain
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
            "recorded velocities explain the efforts better than differentiated positions do \
             (error {:.1} % lower): they are used",
            100.0 * gain
        ));
    }
    let BatchFit { rows, estimate, holdout_rows, .. } = &fitted;
    drop(progress);
    let progress = Progress::of(&args.output, "seeking the nearest real links");

    let consistent =
        if args.raw_estimate { None } else { Some(problem.nearest_consistent(estimate)?) };
    let values = consistent.as_ref().map_or(&estimate.values, |c| &c.estimated);

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
    let fit = FitReport {
        train: fit_rows(&problem.fit(rows, values), &joints),
        holdout: holdout_rows.as_ref().map(|r| fit_rows(&problem.fit(r, values), &joints)),
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
                    Term::Effect { effect, .. } => (EVERYDAY[effect].law().slug, None),
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
            "only the ratios of the drive gains are known: no recording has a known load \
             (--payload) and no joint an effort in N m or N; their size is set so that the URDF's \
             inertias fit, and all constants hang on it [only-ratios]"
                .to_owned(),
        );
    }
    if estimate.rank < problem.terms.len() {
        let open: Vec<String> = (0..problem.terms.len())
            .filter(|&k| estimate.undetermined[k] > 1e-3)
            .map(|k| problem.label(&problem.terms[k], &joints))
            .collect();
        warnings.push(format!(
            "the recordings determine {} of {} unknowns; open are combinations of {} \
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
        schema: "armident.identify/1",
        method: "batch",
        estimator: Some(method.name()),
        robot: model.chain.robot.clone(),
        recordings: train.iter().map(|r| r.source.clone()).collect(),
        holdout_recordings: holdout.iter().map(|r| r.source.clone()).collect(),
        joints: names.clone(),
        cutoff_hz,
        velocities,
        link_prior: settings.link_prior,
        consistency,
        constants,
        effects,
        merged,
        drive_gains: gain_rows(drives.as_ref(), &model),
        loads: load_rows(&problem, &loads, &model, estimate),
        steps: Vec::new(),
        rank: estimate.rank,
        unknowns: problem.terms.len(),
        condition: estimate.condition,
        rows: estimate.rows,
        independent_share: estimate.independent_share,
        effort_noise: by_joint(&estimate.effort_noise, &joints),
        not_essential: (0..problem.terms.len())
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
    let speed_resolution = problem.speed_resolution.clone();
    let mut found = match &consistent {
        Some(consistent) => ArmModel {
            effects: problem.consistent_effects(consistent, &joints),
            ..model.with_links(&consistent.links)
        },
        None => ArmModel {
            effects: problem.effects(&estimate.values, &joints),
            ..model.with_constants(&set, &problem.constants(&estimate.values))
        },
    };
    found.cutoff_hz = cutoff_hz;
    found.recorded_velocities = recorded_velocities;
    found.speed_resolution = speed_resolution;
    found.effort_noise = Some(estimate.effort_noise.clone());
    found.provenance.push(format!("fitted to {}", report.recordings.join(", ")));
    let correlation = Correlation {
        labels: problem.terms.iter().map(|term| problem.label(term, &joints)).collect(),
        rows: correlations(estimate),
    };
    Ok(Identified { report, model: found, correlation: Some(correlation), read: [train, holdout] })
}

/// The loads of the command line, in their recordings.
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
                "the load is in a recording that is not read",
                place,
                Some(format!("name one of {}", known.join(", "))),
            ));
        };
        if given.mass_kg <= 0.0 {
            return Err(Failure::new(
                format!("the mass of the load must be above zero, found {} kg", given.mass_kg),
                place,
                Some("give mass=KG, weighed; leave --payload away for a recording without a load"),
            ));
        }
        if given.com_error_m < 0.0 {
            return Err(Failure::new(
                format!("com_error must not be negative, found {} m", given.com_error_m),
                place,
                Some("give the standard deviation of each coordinate of com, m"),
            ));
        }
        if given.com_error_m > 0.0 && given.com_m.is_none() {
            return Err(Failure::new(
                "com_error is given without com",
                place,
                Some("give com=X:Y:Z too, or neither: then the centre is found"),
            ));
        }
        if loads.iter().any(|load| load.is_on(&recording.source)) {
            return Err(Failure::new(
                "the recording has a load already",
                place,
                Some("give one --payload a recording: the mass and centre of all of it"),
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

/// Where currents stand in the place of efforts: the gains of the drives, and the recordings with the
/// efforts that these make of the currents. None where all joints have efforts.
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
                    format!("joint `{joint}` has an effort here and only a current elsewhere"),
                    &recording.source,
                    Some(
                        "give recordings with the same channels, or make efforts of the currents with --mapping FILE",
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
    problem.choose_speed_resolution(&motions)?;
    let gains = problem.drive_gains(&motions, &is_current, loads)?;
    let open: Vec<String> = (joints.iter().zip(&gains.joints))
        .filter(|(_, gain)| gain.is_some_and(|gain| !gain.is_determined()))
        .map(|(joint, _)| format!("`{joint}`"))
        .collect();
    if !open.is_empty() {
        let sources: Vec<&str> = train.iter().map(|r| r.source.as_str()).collect();
        return Err(Failure::new(
            format!(
                "the currents of {} do not tell the gains of these drives (95 % interval over a factor of ten)",
                open.join(", ")
            ),
            sources.join(", "),
            Some(
                "make efforts of them with the gains of the drives (--mapping FILE), add a recording with a \
                 known load (--payload), or leave joints out with --base and --tip",
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
                },
                used: gain.value * gains.scale_of_description,
            })
        })
        .collect()
}

fn load_rows(
    problem: &BatchProblem<'_>,
    loads: &[KnownLoad],
    model: &ArmModel,
    estimate: &BatchEstimate,
) -> Vec<LoadRow> {
    let in_link = model.chain.joints.last().map(|joint| joint.child_link_in_e.inverse());
    loads
        .iter()
        .map(|load| {
            let centre = problem.centre_of(load, &estimate.values);
            let centre = in_link.map_or(centre, |to| to.transform_point(&centre.into()).into());
            LoadRow {
                recordings: load.sources.clone(),
                mass_kg: load.mass_kg,
                centre_m: centre,
                found: load.centre_error_m > 0.0,
            }
        })
        .collect()
}

fn by_algorithm2(args: &IdentifyArgs, plan_path: &Path) -> Result<Identified, Failure> {
    let plan = read_plan(plan_path)?;
    let folder = plan_path.parent().unwrap_or(Path::new("."));
    let mut model = robot::load(&args.robot, &args.chain, Some(&plan.joints))?;
    // the plan knows how the arm was mounted and cut out of its robot
    if args.chain.gravity.is_none() && args.chain.tip.is_none() && !is_model(&args.robot) {
        let chain = crate::args::ChainArgs {
            base: Some(plan.base_link.clone()),
            tip: Some(plan.tip_link.clone()),
            lock: plan.locked.clone().into_iter().collect(),
            gravity: Some(plan.gravity),
            snap_rpy: args.chain.snap_rpy,
        };
        model = robot::load(&args.robot, &chain, None)?;
    }
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    if names != plan.joints {
        return Err(Failure::new(
            format!(
                "the plan is for the joints {}, the chain has {}",
                plan.joints.join(", "),
                names.join(", ")
            ),
            plan_path.display(),
            Some("give the robot and chain options the plan was made with"),
        ));
    }
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let files: Vec<PathBuf> =
        plan.experiments.iter().map(|e| folder.join(format!("{}.csv", e.id))).collect();
    let recordings: Vec<Recording> = recordings::read_all(&files, &args.reading, &args.output)?;
    let cutoff_hz = armident_recording::common_cutoff_hz(&recordings, &joints, args.cutoff_hz)?;
    let motions = recordings::motions_with_effort(&recordings, &joints, cutoff_hz)?;

    let arm = model.rigid_arm();
    let set = MinimalSet::of(&arm)?;
    let estimate = algorithm2(&arm, &set, &plan, &motions)?;
    let of_urdf = set.values(&arm.constants());
    let mut constants: Vec<ConstantRow> = (0..set.len())
        .map(|k| {
            let value = estimate.values[k];
            let known = value.is_finite();
            constant_row(
                &set,
                k,
                &joints,
                of_urdf[k],
                known.then(|| (value, estimate.standard_error(k), estimate.quantile_95[k])),
                if known { 0.0 } else { 1.0 },
                0.0,
            )
        })
        .collect();
    let values: Vec<f64> = estimate
        .values
        .iter()
        .zip(&of_urdf)
        .map(|(&found, &urdf)| if found.is_finite() { found } else { urdf })
        .collect();
    let consistent =
        if args.raw_estimate { None } else { Some(estimate.nearest_consistent(&arm, &set)?) };
    let consistency = consistent.as_ref().map(|c| ConsistencyReport::of(c, &joints));
    add_consistent(&mut constants, &set, consistent.as_ref());
    let mut report_warnings = algorithm2_warnings(&model, &set, &estimate);
    report_warnings.extend(consistency.iter().flat_map(ConsistencyReport::warnings));
    let urdf_errors = effort_errors(&arm, &motions, &joints);
    let mut found = match &consistent {
        Some(consistent) => model.with_links(&consistent.links),
        None => model.with_constants(&set, &values),
    };
    found.cutoff_hz = cutoff_hz;
    found.effort_noise = (estimate.effort_noise.iter().all(|s| s.is_finite()))
        .then(|| estimate.effort_noise.clone());
    found.provenance.push(format!("Algorithm 2 on {}", folder.display()));
    let report = IdentifyReport {
        schema: "armident.identify/1",
        method: "algorithm2",
        estimator: None,
        not_essential: Vec::new(),
        endogeneity: None,
        cross_validation: None,
        robot: found.chain.robot.clone(),
        recordings: recordings.iter().map(|r| r.source.clone()).collect(),
        holdout_recordings: Vec::new(),
        joints: names.clone(),
        cutoff_hz,
        velocities: if cutoff_hz.is_some() { "position" } else { "recorded" },
        link_prior: None,
        consistency,
        constants,
        effects: own_friction(&found, &estimate),
        merged: Vec::new(),
        drive_gains: Vec::new(),
        loads: Vec::new(),
        steps: estimate
            .steps
            .iter()
            .map(|s| StepRow {
                step: s.step.clone(),
                equation: s.equation.clone(),
                observed: s.observed.clone(),
                unknowns: s.unknowns.clone(),
                rows: s.rows,
                rank: s.rank,
                columns: s.columns,
                condition: s.condition,
                rmse: s.rmse,
            })
            .collect(),
        rank: estimate.values.iter().filter(|v| v.is_finite()).count(),
        unknowns: set.len(),
        condition: estimate.steps.iter().map(|s| s.condition).fold(0.0, f64::max),
        rows: estimate.steps.iter().map(|s| s.rows).sum(),
        independent_share: motions.iter().map(Motion::independent_share).fold(1.0, f64::min),
        effort_noise: by_joint(&estimate.effort_noise, &joints),
        fit: FitReport {
            train: effort_errors(&found.rigid_arm(), &motions, &joints),
            holdout: None,
            urdf: urdf_errors,
        },
        warnings: report_warnings,
        notes: recordings::notes(&motions),
    };
    Ok(Identified { report, model: found, read: [recordings, Vec::new()], correlation: None })
}

fn read_plan(path: &Path) -> Result<Plan, Failure> {
    let hint = Some("write the plan again with `armident plan`");
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::new(format!("cannot read: {error}"), path.display(), hint))?;
    let plan: Plan = serde_json::from_str(&text).map_err(|error| {
        Failure::new(
            format!("the plan is not valid: {error}"),
            format!("{}, line {}", path.display(), error.line()),
            hint,
        )
    })?;
    if plan.schema == PLAN_SCHEMA {
        return Ok(plan);
    }
    Err(Failure::new(
        format!("the plan has schema `{}`, expected `{PLAN_SCHEMA}`", plan.schema),
        path.display(),
        hint,
    ))
}

fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

/// Correlation of every pair of estimates; none of those at their bound, which do not vary.
fn correlations(estimate: &BatchEstimate) -> Vec<Vec<Option<f64>>> {
    let of = |a: usize, b: usize| estimate.covariance[(a, b)];
    let pair = |a, b| {
        let correlation = of(a, b) / (of(a, a) * of(b, b)).sqrt();
        correlation.is_finite().then(|| (100.0 * correlation).round() / 100.0)
    };
    let count = estimate.values.len();
    (0..count).map(|a| (0..count).map(|b| pair(a, b)).collect()).collect()
}

fn constant_row(
    set: &MinimalSet,
    k: usize,
    joints: &[&str],
    urdf: f64,
    found: Option<(f64, f64, f64)>,
    undetermined: f64,
    from_prior: f64,
) -> ConstantRow {
    let constant = &set.constants[k];
    ConstantRow {
        label: constant.label(),
        joint: joints[constant.joint].to_owned(),
        unit: constant.unit(),
        value: found.map(|(value, _, _)| value),
        standard_error: found.map(|(_, error, _)| error),
        interval_95: found.map(|(value, error, t)| [value - t * error, value + t * error]),
        urdf,
        consistent: None,
        from_prior,
        undetermined,
    }
}

/// Values of the real links beside the estimates, which are in the order of the set.
fn add_consistent(rows: &mut [ConstantRow], set: &MinimalSet, found: Option<&Consistent>) {
    let Some(found) = found else { return };
    for (k, constant) in set.constants.iter().enumerate() {
        let label = constant.label();
        if let Some(row) = rows.iter_mut().find(|row| row.label == label) {
            row.consistent = Some(found.estimated[k]);
        }
    }
}

fn algorithm2_warnings(
    model: &ArmModel,
    set: &MinimalSet,
    estimate: &Algorithm2Estimate,
) -> Vec<String> {
    let mut warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();
    for step in estimate.steps.iter().filter(|s| s.rank < s.columns) {
        warnings.push(format!(
            "step {} at joint `{}` has rank {} of {}: {} are not separated [not-determined]",
            step.step,
            step.observed,
            step.rank,
            step.columns,
            step.unknowns.join(", ")
        ));
    }
    let open: Vec<String> = (0..set.len())
        .filter(|&k| !estimate.values[k].is_finite())
        .map(|k| set.constants[k].label())
        .collect();
    if !open.is_empty() {
        warnings.push(format!("no step of the plan seeks {} [not-determined]", open.join(", ")));
    }
    warnings
}

/// Viscous and Coulomb friction that steps (58) and (60) found beside the constants.
fn own_friction(model: &ArmModel, estimate: &Algorithm2Estimate) -> Vec<EffectRow> {
    let mut rows: Vec<EffectRow> = Vec::new();
    for step in &estimate.steps {
        let (Some(friction), Some(joint)) =
            (step.friction, model.chain.joints.iter().find(|j| j.name == step.observed))
        else {
            continue;
        };
        for (effect, (value, standard_error)) in EVERYDAY[..2].iter().zip(friction) {
            let law = effect.law();
            // several steps may move one joint: the most certain word counts
            if let Some(earlier) =
                rows.iter().position(|r| r.effect == law.slug && r.joint == step.observed)
            {
                if rows[earlier].standard_error.is_some_and(|e| e <= standard_error) {
                    continue;
                }
                rows.remove(earlier);
            }
            rows.push(EffectRow {
                effect: law.slug.to_owned(),
                joint: step.observed.clone(),
                other_joint: None,
                parameter: law.parameters[0].name.to_owned(),
                unit: law.parameters[0].unit(joint.kind).to_owned(),
                value,
                standard_error: Some(standard_error),
                at_bound: false,
                // noise of either sign around zero is no wrong sign
                admissible: value >= -3.0 * standard_error,
                undetermined: 0.0,
            });
        }
    }
    rows
}

/// Rigid-body effort error on the motions, on the filtered effort.
fn effort_errors(arm: &RigidArm, motions: &[Motion], joints: &[&str]) -> FitRows {
    let mut squares = vec![(0.0, 0.0, 0.0, 0.0); joints.len()];
    for motion in motions {
        let Some(measured) = &motion.effort_filtered else { continue };
        let mut predicted = armident_dynamics::inverse_dynamics_of_motion(
            arm,
            &motion.position,
            &motion.velocity,
            &motion.acceleration,
        );
        motion.filter_columns(&mut predicted);
        for (joint, total) in squares.iter_mut().enumerate() {
            for (m, p) in measured[joint].iter().zip(&predicted[joint]) {
                total.0 += 1.0;
                total.1 += m;
                total.2 += m * m;
                total.3 += (m - p).powi(2);
            }
        }
    }
    let fits: Vec<JointFit> = squares
        .iter()
        .map(|(count, sum, square, residual)| JointFit {
            rmse: (residual / count).sqrt(),
            relative: (residual / (square - sum * sum / count)).sqrt(),
        })
        .collect();
    fit_rows(&fits, joints)
}

fn fit_rows(fits: &[JointFit], joints: &[&str]) -> FitRows {
    let pick = |value: fn(&JointFit) -> f64| {
        joints.iter().zip(fits).map(|(j, fit)| ((*j).to_owned(), value(fit))).collect()
    };
    FitRows { rmse: pick(|f| f.rmse), relative: pick(|f| f.relative) }
}

fn by_joint(values: &[f64], joints: &[&str]) -> BTreeMap<String, f64> {
    joints.iter().zip(values).map(|(j, v)| ((*j).to_owned(), *v)).collect()
}
