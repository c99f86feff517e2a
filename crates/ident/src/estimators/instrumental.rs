//! Instrumental variables: noise in the regressors does not bias the estimate.
//!
//! Method: two-stage weighted least squares (IDIM-IV). The instruments are the regressors of the simulated arm, which
//! follows the recorded motion under a controller: they move alike and have none of the noise. The difference from
//! weighted least squares is tested for endogeneity (Durbin-Wu-Hausman).
//!
//! References: A. Janot, P.-O. Vandanjon, M. Gautier, A generic instrumental variable approach for industrial robot
//! identification, IEEE T-CST 22 (2014), and A revised Durbin-Wu-Hausman test for industrial robot identification,
//! Control Eng. Practice 48 (2016).

use armident_model::ArmModel;
use armident_motion::{DerivativeSource, Motion, MotionSettings};
use armident_numeric::AccumulatedQr;
use armident_simulation::{SimulatedArm, SimulationError, TrackingGains, Trajectory, track};

use super::estimator::{Estimator, EstimatorError, TrainingData};
use crate::regression::{
    BatchEstimate, BatchProblem, BatchSettings, Endogeneity, EstimateNote, JointRows,
};
use armident_inference::{FEWEST_BLOCKS, standard_error, student_t_tail};

/// Bandwidth of the simulated controller, as a share of the cut-off: above the motion, below the noise.
const LOOP_OVER_CUTOFF: f64 = 0.5;
/// Slowest control cycle of the simulation \[Hz\].
const CONTROL_HZ: f64 = 500.0;

/// Weighted instrumental variables (`iv`).
#[derive(Debug, Clone, Copy)]
pub struct Instrumental;

impl Estimator for Instrumental {
    fn name(&self) -> &'static str {
        "iv"
    }

    fn title(&self) -> &'static str {
        "instrumental variables"
    }

    fn description(&self) -> &'static str {
        "instrumental variables from the simulated arm, with an endogeneity test"
    }

    fn fit(
        &self,
        problem: &BatchProblem,
        data: &TrainingData<'_>,
        settings: &BatchSettings,
    ) -> Result<BatchEstimate, EstimatorError> {
        let TrainingData { model, motions, rows } = *data;
        let weighted = problem.estimate_with(rows, settings)?;
        let simulated: Vec<Motion> = motions
            .iter()
            .map(|motion| {
                // links found by least squares need not be ones of a body; the description's will do for
                // instruments, which only have to move alike
                let found =
                    problem.set().applied_to(model.clone(), &problem.constants(&weighted.values));
                simulated(problem, &found, &weighted.values, motion)
                    .or_else(|_| simulated(problem, model, &weighted.values, motion))
            })
            .collect::<Result<_, _>>()
            .map_err(no_instruments)?;
        let stacked = problem.accumulate_with(
            motions,
            |index, joint, effort| {
                let mut all = problem.columns(joint, &simulated[index]);
                all.extend(problem.columns(joint, motions[index]));
                (all, effort.to_vec())
            },
            |joint| 2 * problem.by_joint[joint].len(),
        );
        let projected = |rows: &JointRows| JointRows {
            triangles: rows.triangles.iter().map(first_stage).collect(),
            ..rows.clone()
        };
        let regularisation = problem.regularisation(settings)?;
        let noise = weighted.effort_noise.clone();
        let mut found = problem.solve_at_noise(&projected(&stacked), &regularisation, noise)?;
        let of_iv =
            problem.with_block_errors(&stacked, &regularisation, &mut found, 1.0, projected)?;
        let mut same_noise = weighted.clone();
        let of_ls =
            problem
                .with_block_errors(rows, &regularisation, &mut same_noise, 1.0, |r| r.clone())?;
        found.train = problem.fit(rows, &found.values);
        let blocks = of_iv.len().min(of_ls.len());
        if blocks < FEWEST_BLOCKS {
            return Ok(found);
        }
        // the difference of both, block by block
        let difference = |k: usize| -> (f64, f64) {
            let squares: f64 = of_iv.iter().zip(&of_ls).map(|(a, b)| (a[k] - b[k]).powi(2)).sum();
            let error = standard_error(squares, blocks);
            (found.values[k] - weighted.values[k], error)
        };
        let freedom = (blocks - 1) as f64;
        let tested = (0..problem.terms.len())
            .filter(|&k| !found.at_bound[k] && !weighted.at_bound[k])
            .map(|k| (k, difference(k)))
            .filter(|(_, (_, error))| *error > 0.0)
            .map(|(k, (off, error))| (k, off / error))
            .collect::<Vec<_>>();
        let count = tested.len() as f64;
        let worst = tested.into_iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let endogeneity = worst.map(|(term, t)| Endogeneity {
            term,
            t,
            p: (2.0 * count * student_t_tail(t.abs(), freedom)).min(1.0),
        });
        found.notes.extend(endogeneity.map(EstimateNote::Endogeneity));
        Ok(found)
    }
}

fn no_instruments(error: SimulationError) -> EstimatorError {
    EstimatorError::Unsuitable {
        estimator: Instrumental.name(),
        message: format!(
            "cannot simulate instruments: neither the least-squares model nor the URDF can be simulated: {error}"
        ),
        hint: "use --method wls, or --prior urdf: a link without mass cannot be simulated"
            .to_owned(),
        source: Some(Box::new(error)),
    }
}

/// Rows of the columns projected on their instruments: from `[Z X | y]`, what of `[X | y]` lies along `Z`.
fn first_stage(stacked: &AccumulatedQr) -> AccumulatedQr {
    let p = stacked.unknowns() / 2;
    let order: Vec<usize> = (0..=2 * p).collect();
    let triangle = stacked.reordered(&order);
    let mut projected = AccumulatedQr::new(p);
    let rows: Vec<Vec<f64>> =
        (0..p).map(|i| (p..=2 * p).map(|j| triangle[(i, j)]).collect()).collect();
    projected.push_rows(&rows);
    projected
}

/// The motion of an arm with the friction found, driven by a controller along the recorded motion: the
/// same motion, but for the noise that the loop does not follow and the derivatives make.
fn simulated(
    problem: &BatchProblem,
    model: &ArmModel,
    values: &[f64],
    motion: &Motion,
) -> Result<Motion, SimulationError> {
    let names: Vec<&str> = motion.joints.iter().map(String::as_str).collect();
    let arm = SimulatedArm::new(model.rigid_arm(), &names, &problem.effects(values, &names))?;
    let trajectory = Trajectory {
        joints: motion.joints.clone(),
        time_s: motion.time_s.clone(),
        position: motion.position.clone(),
        velocity: motion.velocity.clone(),
        acceleration: motion.acceleration.clone(),
        source: motion.source.clone(),
        notes: Vec::new(),
    };
    let start: Vec<f64> = motion.position.iter().map(|q| q[0]).collect();
    let cutoff_hz = motion.filter.as_ref().map(|f| f.cutoff_hz());
    let bandwidth_hz = LOOP_OVER_CUTOFF * cutoff_hz.unwrap_or(0.1 * motion.rate_hz);
    let gains = TrackingGains::of_bandwidth(arm.rigid(), &start, bandwidth_hz);
    // efforts held over a slow control cycle throw a light joint off before they are set again
    let finer = (CONTROL_HZ / motion.rate_hz).ceil().max(1.0);
    let trajectory = match finer {
        1.0 => trajectory,
        _ => trajectory.resampled(finer * motion.rate_hz)?,
    };
    let moved = track(&arm, arm.rigid(), &trajectory, &gains)?;
    let settings = MotionSettings {
        cutoff_hz,
        derivatives: DerivativeSource::Recorded,
        ..MotionSettings::default()
    };
    let mut instruments = Motion::from_recording(&moved, &names, &settings)?;
    let step = (instruments.rate_hz / motion.rate_hz).round().max(1.0) as usize;
    // a grid of its own may have a sample more or less
    for columns in
        [&mut instruments.position, &mut instruments.velocity, &mut instruments.acceleration]
    {
        for column in columns.iter_mut() {
            *column = column.iter().step_by(step).copied().collect();
            let last = column.last().copied().unwrap_or_default();
            column.resize(motion.len(), last);
        }
    }
    // the columns of the instruments go through the filter of the recorded ones
    let mut aligned = motion.clone();
    aligned.position = instruments.position;
    aligned.velocity = instruments.velocity;
    aligned.acceleration = instruments.acceleration;
    Ok(aligned.without_fine())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise in the regressor attenuates least squares, and not instrumental variables.
    #[test]
    fn instruments_remove_attenuation_bias() {
        let (mut stacked, mut plain) = (AccumulatedQr::new(2), AccumulatedQr::new(1));
        for t in 0..4000 {
            let t = f64::from(t);
            let clean = (0.01 * t).sin();
            let noisy = clean + 0.6 * (1.7 * t * t).sin();
            stacked.push_rows(&[vec![clean, noisy, 2.0 * clean]]);
            plain.push_rows(&[vec![noisy, 2.0 * clean]]);
        }
        let by_instruments = first_stage(&stacked).solve(1e-12).unwrap().solution[0];
        let by_squares = plain.solve(1e-12).unwrap().solution[0];
        assert!((by_instruments - 2.0).abs() < 0.05, "{by_instruments}");
        assert!(by_squares < 1.7, "{by_squares}");
    }
}
