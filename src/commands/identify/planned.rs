//! Planned experiments, by Algorithm 2.

use std::path::{Path, PathBuf};

use armident_ident::experiment::{PLAN_SCHEMA, Plan};
use armident_ident::{PlannedIdentification, PlannedRequest, identify_planned};
use armident_recording::Recording;

use super::batch::failure;
use super::{Identified, report};
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
    let files: Vec<PathBuf> =
        plan.experiments.iter().map(|e| folder.join(format!("{}.csv", e.id))).collect();
    let recordings: Vec<Recording> = recordings::read_all(&files, &args.reading, &args.output)?;
    let request = PlannedRequest {
        model: &model,
        plan: &plan,
        recordings: &recordings,
        cutoff_hz: args.cutoff_hz,
        project: !args.raw_estimate,
    };
    let mut found =
        identify_planned(&request).map_err(|error| failure(error, [&recordings, &[]]))?;
    found.model.provenance.push(format!("Algorithm 2 on {}", folder.display()));
    let mut report = report::of_planned(&found);
    report.recordings = recordings.iter().map(|r| r.source.clone()).collect();
    report.warnings = model.chain.warnings.iter().map(ToString::to_string).collect();
    report.warnings.extend(step_warnings(&found));
    report.warnings.extend(report.consistency.iter().flat_map(|links| links.warnings()));
    report.notes = recordings::notes(&found.motions);
    Ok(Identified { report, model: found.model, read: [recordings, Vec::new()], correlation: None })
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

/// Constants that the plan or its recordings do not determine.
fn step_warnings(found: &PlannedIdentification) -> Vec<String> {
    let estimate = &found.estimate;
    let deficient = estimate.steps.iter().filter(|s| s.rank < s.columns).map(|step| {
        format!(
            "step {} (joint `{}`) is rank deficient ({} of {}): {} are not separately identified [not-determined]",
            step.step,
            step.observed,
            step.rank,
            step.columns,
            step.unknowns.join(", ")
        )
    });
    let mut warnings: Vec<String> = deficient.collect();
    let open: Vec<String> = (0..found.set.len())
        .filter(|&k| !estimate.values[k].is_finite())
        .map(|k| found.set.constants[k].label())
        .collect();
    if !open.is_empty() {
        warnings
            .push(format!("no step of the plan identifies {} [not-determined]", open.join(", ")));
    }
    warnings
}
