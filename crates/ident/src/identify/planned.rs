//! Identification from planned experiments, by Algorithm 2.

use armident_dynamics::RigidArm;
use armident_effects::{BASELINE, Law};
use armident_model::ArmModel;
use armident_motion::{Motion, common_cutoff_hz};
use armident_recording::Recording;

use super::error::IdentifyError;
use super::motions::motions_with_effort;
use crate::consistency::Consistent;
use crate::experiment::{Algorithm2Estimate, Plan, algorithm2};
use crate::minimal_set::MinimalSet;
use crate::regression::JointFit;

/// Recordings of planned experiments.
#[derive(Debug, Clone, Copy)]
pub struct PlannedRequest<'a> {
    /// The given model.
    pub model: &'a ArmModel,
    /// The plan.
    pub plan: &'a Plan,
    /// One recording an experiment, in the order of the plan.
    pub recordings: &'a [Recording],
    /// Cut-off of the low-pass \[Hz\]; none: from the spectrum of the motion, and no low-pass where exact accelerations are
    /// recorded.
    pub cutoff_hz: Option<f64>,
    /// Whether the estimate is projected to physically consistent links.
    pub project: bool,
}

/// Constants of an arm by Algorithm 2.
#[derive(Debug, Clone)]
pub struct PlannedIdentification {
    /// The identified model; constants that no step seeks are those of the given model.
    pub model: ArmModel,
    /// The minimal set of the arm.
    pub set: MinimalSet,
    /// The estimate, in the order of the set.
    pub estimate: Algorithm2Estimate,
    /// Values of the given model, in the order of the set.
    pub given_values: Vec<f64>,
    /// The consistent links nearest to the estimate; none unless sought.
    pub consistent: Option<Consistent>,
    /// Viscous and Coulomb friction found beside the constants.
    pub friction: Vec<JointFriction>,
    /// Rigid-body effort error of the model per joint, on the filtered effort.
    pub train_error: Vec<JointFit>,
    /// The same of the given model.
    pub given_error: Vec<JointFit>,
    /// Cut-off of the low-pass \[Hz\]; none without one.
    pub cutoff_hz: Option<f64>,
    /// Motions of the recordings.
    pub motions: Vec<Motion>,
}

/// A parameter of friction found by steps (58) and (60).
#[derive(Debug, Clone, Copy)]
pub struct JointFriction {
    /// The law, of one parameter.
    pub law: &'static Law,
    /// Joint, from 0.
    pub joint: usize,
    /// Estimate, in the unit of the parameter.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Runs Algorithm 2, projects, and builds the model.
///
/// # Errors
/// [`IdentifyError`].
pub fn identify_planned(
    request: &PlannedRequest<'_>,
) -> Result<PlannedIdentification, IdentifyError> {
    let PlannedRequest { model, plan, recordings, .. } = *request;
    let joints = model.chain.joint_names();
    let cutoff_hz = common_cutoff_hz(recordings, &joints, request.cutoff_hz)?;
    let motions = motions_with_effort(recordings, &joints, cutoff_hz)?;
    let arm = model.rigid_arm();
    let set = MinimalSet::of(&arm)?;
    let estimate = algorithm2(&arm, &set, plan, &motions)?;
    let given_values = set.values(&arm.constants());
    let values: Vec<f64> = (estimate.values.iter().zip(&given_values))
        .map(|(&found, &given)| if found.is_finite() { found } else { given })
        .collect();
    let consistent =
        if request.project { Some(estimate.nearest_consistent(&arm, &set)?) } else { None };
    let mut found = match &consistent {
        Some(consistent) => model.clone().with_links(&consistent.links),
        None => set.applied_to(model.clone(), &values),
    };
    found.cutoff_hz = cutoff_hz;
    found.effort_noise = (estimate.effort_noise.iter().all(|s| s.is_finite()))
        .then(|| estimate.effort_noise.clone());
    Ok(PlannedIdentification {
        friction: friction(model, &estimate),
        train_error: rigid_errors(&found.rigid_arm(), &motions),
        given_error: rigid_errors(&arm, &motions),
        model: found,
        set,
        estimate,
        given_values,
        consistent,
        cutoff_hz,
        motions,
    })
}

/// Viscous and Coulomb friction that steps (58) and (60) found beside the constants.
fn friction(model: &ArmModel, estimate: &Algorithm2Estimate) -> Vec<JointFriction> {
    let mut all: Vec<JointFriction> = Vec::new();
    for step in &estimate.steps {
        let joint = model.chain.joints.iter().position(|j| j.name == step.observed);
        let (Some(friction), Some(joint)) = (step.friction, joint) else { continue };
        for (effect, (value, standard_error)) in BASELINE[..2].iter().zip(friction) {
            let law = effect.law();
            // several steps may move one joint: the smallest standard error counts
            let is_same = |f: &JointFriction| f.law.slug == law.slug && f.joint == joint;
            if let Some(earlier) = all.iter().position(is_same) {
                if all[earlier].standard_error <= standard_error {
                    continue;
                }
                all.remove(earlier);
            }
            all.push(JointFriction { law, joint, value, standard_error });
        }
    }
    all
}

/// Rigid-body effort error on motions, on the filtered effort.
fn rigid_errors(arm: &RigidArm, motions: &[Motion]) -> Vec<JointFit> {
    let mut squares = vec![(0.0, 0.0, 0.0, 0.0); arm.dof()];
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
    squares
        .iter()
        .map(|(count, sum, square, residual)| JointFit {
            rmse: (residual / count).sqrt(),
            relative: (residual / (square - sum * sum / count)).sqrt(),
        })
        .collect()
}
