//! One fit of motions: source of velocities, estimator, hold-out, cross-validation.
//!
//! Method: recorded velocities are used where all recordings have them and weighted least squares explains the efforts
//! clearly better with them than with differentiated positions.
//!
//! References: own.

use armident_model::ArmModel;
use armident_motion::{Motion, with_recorded_velocity};
use armident_numeric::NumericError;
use armident_recording::Recording;

use crate::estimators::{Estimator, EstimatorError, TrainingData};
use crate::regression::{BatchEstimate, BatchProblem, BatchSettings, JointFit, JointRows};

/// Recorded velocities are used when they lower the joints' errors by more than this share (geometric
/// mean): a lag would raise them, and less is not worth another source.
const VELOCITY_GAIN: f64 = 0.01;

/// Recordings with their motions, in the same order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Recorded<'a> {
    /// as read
    pub(super) recordings: &'a [Recording],
    /// of all joints of the arm, with efforts
    pub(super) motions: &'a [Motion],
}

/// A fit and what it was made of.
pub(super) struct Fitted {
    pub(super) rows: JointRows,
    pub(super) estimate: BatchEstimate,
    /// none without hold-out
    pub(super) holdout_rows: Option<JointRows>,
    /// share by which recorded velocities lower the error; none where differentiated positions are used
    pub(super) velocity_gain: Option<f64>,
    /// motions with the velocities that were used
    pub(super) train: Vec<Motion>,
    pub(super) holdout: Vec<Motion>,
}

/// Fits the training motions, and forms the rows of the hold-out.
pub(super) fn fit(
    problem: &BatchProblem,
    model: &ArmModel,
    estimator: &dyn Estimator,
    settings: &BatchSettings,
    [train, holdout]: [Recorded<'_>; 2],
) -> Result<Fitted, EstimatorError> {
    let with_recorded = |of: Recorded<'_>| -> Option<Vec<Motion>> {
        let pairs = of.motions.iter().zip(of.recordings);
        pairs.map(|(motion, recording)| with_recorded_velocity(motion, recording)).collect()
    };
    let other = with_recorded(train).zip(with_recorded(holdout));
    let rows_of = |motions: &[Motion]| problem.accumulate(&motions.iter().collect::<Vec<_>>());
    let mut rows = rows_of(train.motions);
    let mut velocity_gain = None;
    if let Some((motions, _)) = &other {
        let recorded = rows_of(motions);
        let off = log_error(problem, settings, &recorded)? - log_error(problem, settings, &rows)?;
        if off < -VELOCITY_GAIN {
            velocity_gain = Some(1.0 - off.exp());
            rows = recorded;
        }
    }
    let (train, holdout) = match (other, velocity_gain) {
        (Some(recorded), Some(_)) => recorded,
        _ => (train.motions.to_vec(), holdout.motions.to_vec()),
    };
    let motions: Vec<&Motion> = train.iter().collect();
    let data = TrainingData { model, motions: &motions, rows: &rows };
    let estimate = estimator.fit(problem, &data, settings)?;
    let holdout_rows = (!holdout.is_empty()).then(|| rows_of(&holdout));
    Ok(Fitted { rows, estimate, holdout_rows, velocity_gain, train, holdout })
}

/// Mean logarithm of the training errors of the joints without a dead zone.
fn log_error(
    problem: &BatchProblem,
    settings: &BatchSettings,
    rows: &JointRows,
) -> Result<f64, NumericError> {
    let fits = problem.estimate_with(rows, settings)?.train;
    let joints =
        fits.iter().zip(&problem.has_dead_zone).filter(|(_, has_dead_zone)| !**has_dead_zone);
    let logarithms: Vec<f64> = joints.map(|(fit, _)| fit.rmse.ln()).collect();
    Ok(logarithms.iter().sum::<f64>() / logarithms.len().max(1) as f64)
}

/// Each recording predicted by a fit to the others, pooled over the recordings.
pub(super) fn cross_validate(
    problem: &BatchProblem,
    model: &ArmModel,
    estimator: &dyn Estimator,
    settings: &BatchSettings,
    motions: &[&Motion],
) -> Result<Vec<JointFit>, EstimatorError> {
    let mut pooled = vec![(0.0, 0.0, 0.0); problem.arm().dof()];
    for left_out in 0..motions.len() {
        let others: Vec<&Motion> =
            (0..motions.len()).filter(|k| *k != left_out).map(|k| motions[k]).collect();
        let fitted = problem.accumulate(&others);
        let data = TrainingData { model, motions: &others, rows: &fitted };
        let estimate = estimator.fit(problem, &data, settings)?;
        let dead_zones = problem.dead_zones(&fitted, &estimate.values);
        let rows = problem.accumulate(&motions[left_out..=left_out]);
        let fits = problem.fit_through_dead_zones(&rows, &estimate.values, &dead_zones);
        for (joint, fit) in fits.iter().enumerate() {
            let count = rows.effort[joint].0 as f64;
            let squares = count * fit.rmse * fit.rmse;
            let sum = &mut pooled[joint];
            *sum = (sum.0 + count, sum.1 + squares, sum.2 + squares / fit.relative.powi(2));
        }
    }
    Ok(pooled
        .into_iter()
        .map(|(count, squares, varying)| JointFit {
            rmse: (squares / count).sqrt(),
            relative: (squares / varying).sqrt(),
        })
        .collect())
}
