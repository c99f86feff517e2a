//! The simulation and recording of a case.

use armident_recording::Recording;
use armident_simulation::track;

use crate::arms::excitation::gains;
use crate::cases::exact_motion::{Exact, exact_at, rms};
use crate::cases::floors::{Taken, floors};
use crate::cases::scene::{AFTER, FILES, Scene};
use crate::cases::sensors::{Efforts, instants, lag, record};
use crate::contract::kind::CaseKind;
use crate::contract::truth::Floors;
use crate::error::ChallengeError;
use crate::hidden::hidden_effect::Sized;
use crate::random::RandomStream;

/// Largest change by the lag of the effort channel over noise.
const MOST_LAG: f64 = 0.45;
/// Share of the effort range that controllers meet unprepared.
const UNKNOWN_SHARE: f64 = 0.08;

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

/// Moves the true arm along all plans, records, and finds the floors.
pub(crate) fn simulate(
    scene: &Scene<'_>,
    effects: &[Sized],
    random: &mut RandomStream,
) -> Result<Made, ChallengeError> {
    let robot = scene.robot;
    let given = robot.arm();
    let unknown: Vec<f64> = (0..robot.dof())
        .map(|j| {
            let dry = if scene.kind.is_field() { 2.0 * scene.level[j] } else { 0.0 };
            let special: f64 = effects.iter().map(|sized| sized.torque[j]).sum();
            UNKNOWN_SHARE * scene.range[j] + dry + special
        })
        .collect();
    let gains = gains(robot, &scene.plans[0], &unknown);
    let mut exact = Vec::new();
    let mut moved = Vec::new();
    for (file, plan) in scene.plans.iter().enumerate() {
        let arm = scene.arm(effects, file, None)?;
        let motion = track(&arm, &given, plan, &gains)?;
        let (rate_hz, duration_s) = (scene.rates_hz[file], scene.duration_s);
        let at = instants(rate_hz, duration_s, &scene.sensing, random);
        exact.push(exact_at(&motion, &at));
        moved.push(motion);
    }
    let lag_over_noise = |lag_s: f64| {
        let each = exact.iter().map(|motion| lag_error(motion, &scene.sensing.sigma, lag_s));
        each.fold(0.0, f64::max)
    };
    // the lag stays below half the noise
    let over = lag_over_noise(scene.sensing.effort_lag_s);
    let lag_s = scene.sensing.effort_lag_s * (MOST_LAG / over).min(1.0);
    let (lag_s, lag_over_noise) = (lag_s, lag_over_noise(lag_s));
    let mut recorded = Vec::new();
    // floors are of even clocks without a drive filter: the same noise, and none of the faults that a model can undo
    let mut plain = Vec::new();
    for (file, motion) in exact.iter().enumerate() {
        let faults = &scene.faults;
        let mut twin = random.clone();
        let efforts =
            Efforts { exact: &motion.effort, lag_s, faults: &faults.without_clocks(), file };
        plain.push(record(&moved[file], motion, &scene.sensing, &efforts, FILES[file], &mut twin)?);
        let fast = 1.0 + faults.effort_clock;
        let at: Vec<f64> = motion.time_s.iter().map(|t| t * fast).collect();
        let sampled = exact_at(&moved[file], &at);
        let exact = if faults.effort_clock == 0.0 { &motion.effort } else { &sampled.effort };
        let lag_s = lag_s.max(faults.low_pass_s());
        let efforts = Efforts { exact, lag_s, faults, file };
        recorded.push(record(&moved[file], motion, &scene.sensing, &efforts, FILES[file], random)?);
    }
    let names = &robot.names;
    let floor = |file: usize, whole: bool| -> Result<Floors, ChallengeError> {
        let taken = Taken::new(&exact[file], &plain[file], whole);
        let mut floors = floors(&taken, &scene.arm(effects, file, None)?, &given, names)?;
        floors.urdf_rmse = Taken::new(&exact[file], &recorded[file], whole).rmse_of(&given, names);
        Ok(floors)
    };
    let (mut holdout, exam) = (floor(2, true)?, floor(3, false)?);
    if scene.kind == CaseKind::Change {
        // what the arm was before is no URDF
        holdout.urdf_rmse.clear();
        holdout.urdf_rmse_practical.clear();
    }
    let before = recorded.split_off(AFTER);
    let recorded: [Recording; AFTER] = <[Recording; AFTER]>::try_from(recorded)
        .map_err(|_| ChallengeError::Robot { reason: "a recording is missing".to_owned() })?;
    Ok(Made { exact, recorded, before, holdout, exam, effort_lag_s: lag_s, lag_over_noise })
}

/// RMS change by the lag of the effort channel over noise, on the most affected joint.
fn lag_error(motion: &Exact, sigma: &[f64], lag_s: f64) -> f64 {
    (0..sigma.len())
        .map(|j| {
            let effort = &motion.effort[j];
            let lagged = lag(&motion.time_s, effort, lag_s);
            let change: Vec<f64> = lagged.iter().zip(effort).map(|(a, b)| a - b).collect();
            rms(&change) / sigma[j]
        })
        .fold(0.0, f64::max)
}
