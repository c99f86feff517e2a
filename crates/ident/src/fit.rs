//! One fit of recordings: source of velocities, method, hold-out, cross-validation.

use armident_motion::{Motion, with_recorded_velocity};
use armident_numeric::NumericError;
use armident_recording::Recording;

use crate::batch::{BatchEstimate, BatchProblem, BatchSettings, JointFit};
use crate::methods::{Endogeneity, Method, MethodError};
use crate::rows::JointRows;
use armident_model::ArmModel;

/// Recorded velocities are taken when they lower the joints' errors by more than this share (geometric
/// mean): a lag would raise them, and less is not worth another source.
const VELOCITY_GAIN: f64 = 0.01;

/// Recordings with their motions, in the same order.
#[derive(Debug, Clone, Copy)]
pub struct Recorded<'a> {
    /// As read.
    pub recordings: &'a [Recording],
    /// Their motions, of all joints of the arm, with efforts.
    pub motions: &'a [Motion],
}

/// A batch fit.
#[derive(Debug, Clone)]
pub struct BatchFit {
    /// Rows of the training recordings.
    pub rows: JointRows,
    /// What was found.
    pub estimate: BatchEstimate,
    /// Rows of the hold-out recordings; none without any.
    pub holdout_rows: Option<JointRows>,
    /// Share by which recorded velocities lower the error; none where differentiated positions are used.
    pub velocity_gain: Option<f64>,
    /// Least squares against instruments; with [`Method::Iv`].
    pub endogeneity: Option<Endogeneity>,
    /// Training motions with the velocities that were used.
    pub motions: Vec<Motion>,
}

impl BatchFit {
    /// Fits by `method`, with recorded velocities where all recordings have them and the efforts are
    /// explained better so.
    ///
    /// # Errors
    /// [`MethodError`].
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn of(
        problem: &BatchProblem<'_>,
        model: &ArmModel,
        method: Method,
        settings: &BatchSettings,
        train: Recorded<'_>,
        holdout: Recorded<'_>,
    ) -> Result<Self, MethodError> {
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
            let off =
                log_error(problem, settings, &recorded)? - log_error(problem, settings, &rows)?;
            if off < -VELOCITY_GAIN {
                velocity_gain = Some(1.0 - off.exp());
                rows = recorded;
            }
        }
        let (train, holdout) = match (&other, velocity_gain) {
            (Some((train, holdout)), Some(_)) => (&train[..], &holdout[..]),
            _ => (train.motions, holdout.motions),
        };
        let all: Vec<&Motion> = train.iter().collect();
        let (rows, estimate, endogeneity) =
            problem.solve_rows_by(rows, method, model, &all, settings)?;
        let holdout_rows =
            (!holdout.is_empty()).then(|| problem.accumulate(&holdout.iter().collect::<Vec<_>>()));
        let motions = train.to_vec();
        Ok(Self { rows, estimate, holdout_rows, velocity_gain, endogeneity, motions })
    }

    /// Errors on each training recording of a fit to the others; none for one recording. Costs a fit a
    /// recording.
    ///
    /// # Errors
    /// [`MethodError`].
    pub fn cross_validation(
        &self,
        problem: &BatchProblem<'_>,
        model: &ArmModel,
        method: Method,
        settings: &BatchSettings,
    ) -> Result<Option<Vec<JointFit>>, MethodError> {
        let all: Vec<&Motion> = self.motions.iter().collect();
        (all.len() > 1)
            .then(|| cross_validation(problem, model, method, settings, &all))
            .transpose()
    }
}

/// Mean logarithm of the training errors of the joints whose efforts are reported.
fn log_error(
    problem: &BatchProblem<'_>,
    settings: &BatchSettings,
    rows: &JointRows,
) -> Result<f64, NumericError> {
    let fits = problem.estimate_with(rows, settings)?.train;
    let reported = fits.iter().zip(&problem.unreported).filter(|(_, unreported)| !**unreported);
    let logarithms: Vec<f64> = reported.map(|(fit, _)| fit.rmse.ln()).collect();
    Ok(logarithms.iter().sum::<f64>() / logarithms.len().max(1) as f64)
}

/// Each recording predicted by a fit to the others, pooled over the recordings.
fn cross_validation(
    problem: &BatchProblem<'_>,
    model: &ArmModel,
    method: Method,
    settings: &BatchSettings,
    motions: &[&Motion],
) -> Result<Vec<JointFit>, MethodError> {
    let mut pooled = vec![(0.0, 0.0, 0.0); problem.arm().dof()];
    for left_out in 0..motions.len() {
        let others: Vec<&Motion> =
            (0..motions.len()).filter(|k| *k != left_out).map(|k| motions[k]).collect();
        let (fitted, estimate, _) = problem.solve_by(method, model, &others, settings)?;
        let shown = problem.shown(&fitted, &estimate.values);
        let rows = problem.accumulate(&motions[left_out..=left_out]);
        let fits = problem.fit_as_shown(&rows, &estimate.values, &shown);
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
