//! The estimators against each other on a bundled recording of an arm that is known.

use std::path::{Path, PathBuf};

use armident_ident::estimators::{ALL, TrainingData};
use armident_ident::{BatchProblem, BatchSettings, MinimalSet};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings};
use armident_recording::read_csv;

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// Coulomb levels of the recording, as `examples/make_ur5_recordings.rs` put them in.
const COULOMB: [f64; 6] = [4.2, 5.1, 3.3, 0.90, 0.75, 0.70];

#[test]
fn every_estimator_finds_coulomb_friction_within_errors() {
    let robot = load_urdf(&project("urdf/ur5.urdf")).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let recording = read_csv(project("examples/ur5/train.csv")).unwrap();
    let motion = Motion::from_recording(&recording, &names, &MotionSettings::default()).unwrap();
    let arm = model.rigid_arm();
    let set = MinimalSet::of(&arm).unwrap();
    let mut problem = BatchProblem::new(&arm, &set);
    problem.choose_reversal_speeds(&[&motion]).unwrap();
    let settings = BatchSettings::default();
    let (mut inside, mut all) = (0, 0);
    let rows = problem.accumulate(&[&motion]);
    let data = TrainingData { model: &model, motions: &[&motion], rows: &rows };
    for estimator in ALL {
        let found = estimator.fit(&problem, &data, &settings).unwrap();
        let name = estimator.name();
        assert_eq!(found.endogeneity().is_some(), name == "iv");
        if let Some(tested) = found.endogeneity() {
            assert!(tested.p > 0.05, "encoders of 17 bits are no noise: {tested:?}");
        }
        for (joint, level) in COULOMB.iter().enumerate() {
            let label = format!("coulomb_friction({})", names[joint]);
            let k = (0..problem.terms.len())
                .find(|&k| problem.label(&problem.terms[k], &names) == label)
                .unwrap();
            let error = found.standard_error(k).unwrap();
            assert!(error > 0.0 && error < 0.2 * level, "{name} {label}: {error}");
            let off = (found.values[k] - level).abs();
            assert!(off < 0.05 * level, "{name} {label}: {off}");
            inside += usize::from(off <= found.quantile_95 * error);
            all += 1;
        }
        // nineteen degrees of freedom of twenty blocks
        assert!((found.quantile_95 - 2.09).abs() < 0.2, "{}", found.quantile_95);
    }
    assert!(inside * 100 >= all * 80, "{inside} of {all}");
}
