//! Planned experiments, by Algorithm 2.

use std::path::{Path, PathBuf};

use armident_dynamics::RigidArm;
use armident_effects::BASELINE;
use armident_ident::algorithm2::{Algorithm2Estimate, PLAN_SCHEMA, Plan, algorithm2};
use armident_ident::{JointFit, MinimalSet};
use armident_model::ArmModel;
use armident_motion::Motion;
use armident_recording::Recording;
use armident_report::{
    ConsistencyReport, ConstantRow, EffectRow, FitReport, FitRows, IdentifyReport, StepRow,
};

use super::{Identified, add_consistent, by_joint, constant_row, fit_rows};
use crate::args::IdentifyArgs;
use crate::commands::recordings;
use crate::failure::Failure;
use crate::robot;

pub(super) fn by_algorithm2(args: &IdentifyArgs, plan_path: &Path) -> Result<Identified, Failure> {
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
                "plan and chain have different joints: {}; {}",
                plan.joints.join(", "),
                names.join(", ")
            ),
            plan_path.display(),
            Some("use the robot and chain options of the plan"),
        ));
    }
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let files: Vec<PathBuf> =
        plan.experiments.iter().map(|e| folder.join(format!("{}.csv", e.id))).collect();
    let recordings: Vec<Recording> = recordings::read_all(&files, &args.reading, &args.output)?;
    let cutoff_hz = armident_motion::common_cutoff_hz(&recordings, &joints, args.cutoff_hz)?;
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
        None => set.applied_to(model, &values),
    };
    found.cutoff_hz = cutoff_hz;
    found.effort_noise = (estimate.effort_noise.iter().all(|s| s.is_finite()))
        .then(|| estimate.effort_noise.clone());
    found.provenance.push(format!("Algorithm 2 on {}", folder.display()));
    let report = IdentifyReport {
        schema: IdentifyReport::SCHEMA.to_owned(),
        method: "algorithm2".to_owned(),
        estimator: None,
        not_significant: Vec::new(),
        endogeneity: None,
        cross_validation: None,
        robot: found.chain.robot.clone(),
        recordings: recordings.iter().map(|r| r.source.clone()).collect(),
        holdout_recordings: Vec::new(),
        joints: names.clone(),
        cutoff_hz,
        velocities: if cutoff_hz.is_some() { "position" } else { "recorded" }.to_owned(),
        prior_scale: None,
        consistency,
        constants,
        effects: own_friction(&found, &estimate),
        merged: Vec::new(),
        drive_gains: Vec::new(),
        payloads: Vec::new(),
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
        parameters: set.len(),
        condition: estimate.steps.iter().map(|s| s.condition).fold(0.0, f64::max),
        rows: estimate.steps.iter().map(|s| s.rows).sum(),
        effective_sample_share: motions.iter().map(Motion::independent_share).fold(1.0, f64::min),
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
    let hint = Some("create the plan again with `armident plan`");
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::new(format!("cannot read: {error}"), path.display(), hint))?;
    let plan: Plan = serde_json::from_str(&text).map_err(|error| {
        Failure::new(
            format!("invalid plan: {error}"),
            format!("{}, line {}", path.display(), error.line()),
            hint,
        )
    })?;
    if plan.schema == PLAN_SCHEMA {
        return Ok(plan);
    }
    Err(Failure::new(
        format!("expected schema `{PLAN_SCHEMA}`, found `{}`", plan.schema),
        path.display(),
        hint,
    ))
}

fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

fn algorithm2_warnings(
    model: &ArmModel,
    set: &MinimalSet,
    estimate: &Algorithm2Estimate,
) -> Vec<String> {
    let mut warnings: Vec<String> = model.chain.warnings.iter().map(ToString::to_string).collect();
    for step in estimate.steps.iter().filter(|s| s.rank < s.columns) {
        warnings.push(format!(
            "step {} (joint `{}`) is rank deficient ({} of {}): {} are not separately identified [not-determined]",
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
        warnings
            .push(format!("no step of the plan identifies {} [not-determined]", open.join(", ")));
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
        for (effect, (value, standard_error)) in BASELINE[..2].iter().zip(friction) {
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
