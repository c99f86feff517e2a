//! Planned experiments, by Algorithm 2.

use std::path::{Path, PathBuf};

use armident_ident::experiment::{PLAN_SCHEMA, Plan};
use armident_ident::{PlannedIdentification, PlannedRequest, identify_planned as identified};
use armident_recording::Recording;
use armident_report::IdentifyReport;

use super::batch::failure;
use super::{Identified, IdentifyOptions};
use crate::failure::Failure;
use crate::recordings::notes;
use crate::robot::{ChainOptions, GivenRobot, chain_warnings};

/// Name of the plan in the folders of trajectories and of recordings.
pub const PLAN_FILE: &str = "plan.json";

/// The plan file of a folder, if it has one.
pub fn plan_in(path: &Path) -> Option<PathBuf> {
    let plan = path.join(PLAN_FILE);
    (path.is_dir() && plan.is_file()).then_some(plan)
}

/// A plan, and the files that its recordings are in.
#[derive(Debug, Clone)]
pub struct PlannedRecordings {
    plan: Plan,
    path: PathBuf,
    /// One file an experiment.
    pub files: Vec<PathBuf>,
}

impl PlannedRecordings {
    /// Reads the plan of a folder of recordings.
    ///
    /// # Errors
    /// A file that is no plan.
    pub fn of(plan_path: &Path) -> Result<Self, Failure> {
        let plan = read_plan(plan_path)?;
        let folder = plan_path.parent().unwrap_or(Path::new("."));
        let files = plan.experiments.iter().map(|e| folder.join(format!("{}.csv", e.id))).collect();
        Ok(Self { plan, path: plan_path.to_owned(), files })
    }
}

/// Identifies an arm from recordings of a plan, one an experiment, by Algorithm 2.
///
/// # Errors
/// A plan of another arm; recordings that cannot be used.
pub fn identify_planned(
    robot: &GivenRobot,
    planned: &PlannedRecordings,
    recordings: Vec<Recording>,
    options: &IdentifyOptions,
) -> Result<Identified, Failure> {
    let PlannedRecordings { plan, path: plan_path, .. } = planned;
    let folder = plan_path.parent().unwrap_or(Path::new("."));
    let mut model = robot.arm(Some(&plan.joints))?;
    // the plan knows how the arm was mounted and cut out of its robot
    let chosen = robot.chain_options();
    if chosen.gravity.is_none() && chosen.tip.is_none() && !robot.is_model() {
        let chain = ChainOptions {
            base: Some(plan.base_link.clone()),
            tip: Some(plan.tip_link.clone()),
            lock: plan.locked.clone().into_iter().collect(),
            gravity: Some(plan.gravity),
            snap_rpy_rad: chosen.snap_rpy_rad,
        };
        model = robot.with_chain(chain).arm(None)?;
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
    let request = PlannedRequest {
        model: &model,
        plan,
        recordings: &recordings,
        cutoff_hz: options.cutoff_hz,
        project: !options.raw_estimate,
    };
    let mut found = identified(&request).map_err(|error| failure(error, [&recordings, &[]]))?;
    found.model.provenance.push(format!("Algorithm 2 on {}", folder.display()));
    let mut report = IdentifyReport::of_planned(&found);
    report.recordings = recordings.iter().map(|r| r.source.clone()).collect();
    report.warnings = chain_warnings(&model);
    report.warnings.extend(step_warnings(&found));
    report.warnings.extend(report.consistency.iter().flat_map(|links| links.warnings()));
    report.notes = notes(&found.motions);
    Ok(Identified {
        report,
        model: found.model,
        training: recordings,
        holdout: Vec::new(),
        correlation: None,
    })
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
