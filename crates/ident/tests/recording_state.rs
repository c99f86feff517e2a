//! States of recordings: merged in any order they give the parameters of all recordings at one time.

#![allow(clippy::unwrap_used, reason = "a failed test may panic")]

use armident_ident::{
    BatchProblem, BatchSettings, MinimalSet, RecordingState, StateColumns, StateError,
};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings};
use armident_recording::{Recording, read_csv};

const CUTOFF_HZ: f64 = 5.0;

fn project(path: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

fn model(arm: &str) -> ArmModel {
    let robot = load_urdf(&project(&format!("urdf/{arm}.urdf"))).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    ArmModel::from_chain(DrivingAxisChain::from_chain(&chain))
}

fn recordings() -> Vec<Recording> {
    ["train", "holdout"]
        .map(|name| read_csv(project(&format!("examples/ur5/{name}.csv"))).unwrap())
        .into()
}

fn states(columns: &StateColumns<'_>) -> Vec<RecordingState> {
    recordings().iter().map(|recording| columns.reduce(recording).unwrap()).collect()
}

fn equal(a: &[f64], b: &[f64]) {
    let size = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-9 * size, "{a} {b}");
    }
}

#[test]
fn merged_states_give_the_parameters_of_all_recordings() {
    let model = model("ur5");
    let columns = StateColumns::new(&model, CUTOFF_HZ).unwrap();
    let mut states = states(&columns);
    let merged = columns.identify(&states).unwrap();
    states.reverse();
    equal(&merged.estimate.values, &columns.identify(&states).unwrap().estimate.values);

    // against the batch problem on the motions themselves
    let names = model.chain.joint_names();
    let settings = MotionSettings { cutoff_hz: Some(CUTOFF_HZ), ..MotionSettings::default() };
    let motions: Vec<Motion> = recordings()
        .iter()
        .map(|r| Motion::from_recording(r, &names, &settings).unwrap().thinned())
        .collect();
    let arm = model.rigid_arm();
    let problem = BatchProblem::new(&arm, &MinimalSet::of(&arm).unwrap());
    let rows = problem.accumulate(&motions.iter().collect::<Vec<_>>());
    let batch = problem.estimate_with(&rows, &BatchSettings::default()).unwrap();
    equal(&batch.values, &merged.estimate.values);
    for k in 0..batch.values.len() {
        let (a, b) = (batch.standard_error(k), merged.estimate.standard_error(k));
        // blocks of time are recordings here: errors of the same size, not the same numbers
        assert!(a.zip(b).is_none_or(|(a, b)| b < 5.0 * a && b > 0.0), "{a:?} {b:?}");
    }
    for (fit, given) in merged.fits.iter().zip(&merged.given_fits) {
        assert!(fit.rmse < given.rmse);
    }
}

/// Numbers are read to the last bit but one.
#[test]
fn states_survive_their_file() {
    let model = model("ur5");
    let columns = StateColumns::new(&model, CUTOFF_HZ).unwrap();
    let states = states(&columns);
    let lines: Vec<String> = states.iter().map(|s| serde_json::to_string(s).unwrap()).collect();
    let read: Vec<RecordingState> =
        lines.iter().map(|line| serde_json::from_str(line).unwrap()).collect();
    let [written, read] = [&states, &read].map(|states| columns.identify(states).unwrap());
    equal(&written.estimate.values, &read.estimate.values);
    assert_eq!(written.rows, read.rows);
}

#[test]
fn states_of_other_arms_and_damaged_ones_are_refused() {
    let (ur5, ur10) = (model("ur5"), model("ur10"));
    let columns = StateColumns::new(&ur5, CUTOFF_HZ).unwrap();
    let state = states(&columns).remove(0);
    let of = |error: Result<(), StateError>| error.unwrap_err().to_string();
    let other = StateColumns::new(&ur10, CUTOFF_HZ).unwrap();
    assert!(of(other.check(&state)).contains("another arm"));
    let slower = StateColumns::new(&ur5, 4.0).unwrap();
    assert!(of(slower.check(&state)).contains("cut-off 5 Hz, expected 4 Hz"));
    let mut cut = state.clone();
    cut.joints[2].triangle.pop();
    assert!(of(columns.check(&cut)).contains("damaged"));
    let mut newer = state;
    newer.schema = "armident.state/2".to_owned();
    assert!(of(columns.check(&newer)).contains("armident.state/2"));
    assert!(matches!(columns.identify(&[]), Err(StateError::None)));
}
