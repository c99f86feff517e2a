//! Cost of the nearest consistent links: seven links, constants with noise of three sizes; and of public
//! recordings, where `../shared/data` has them.

#![allow(clippy::unwrap_used, reason = "a bench without its arm has nothing to measure")]
#![allow(clippy::print_stderr, reason = "what was solved stands beside its time")]

use std::path::Path;

use armident_dynamics::RigidArm;
use armident_ident::{BatchProblem, ConsistencyProblem, EffectUnknown, MinimalSet};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_motion::{Motion, MotionSettings};
use armident_numeric::Mat;
use armident_recording::read_csv;
use divan::{Bencher, black_box};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn main() {
    divan::main();
}

/// With 0.1 % real links have the constants; with 30 % their nearest ones are several standard errors
/// away. Beside the constants every joint has viscous and Coulomb friction and an offset.
#[divan::bench(args = [("panda", 0.001), ("panda", 0.03), ("panda", 0.3), ("xarm7", 0.03), ("ur5", 0.03)])]
fn nearest(bencher: Bencher<'_, '_>, (name, noise): (&str, f64)) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../urdf/{name}.urdf"));
    let robot = load_urdf(&path).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    let arm = RigidArm::from_chain(&DrivingAxisChain::from_chain(&chain));
    let set = MinimalSet::of(&arm).unwrap();
    let mut values = set.values(&arm.constants());
    let effects: Vec<EffectUnknown> = (0..3 * arm.dof())
        .map(|k| EffectUnknown {
            adds_to: vec![(set.len() + k, 1.0)],
            non_negative: k % 3 < 2,
            merged: false,
            prior: None,
        })
        .collect();
    values.resize(set.len() + effects.len(), 0.5);
    let size = values.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    let errors: Vec<f64> = values.iter().map(|x| noise * x.abs().max(0.01 * size)).collect();
    let mut random = Pcg64::seed_from_u64(7);
    for (x, error) in values.iter_mut().zip(&errors) {
        *x += error * random.random_range(-1.7..1.7);
    }
    let root =
        Mat::from_fn(values.len(), values.len(), |i, j| if i == j { 1.0 / errors[i] } else { 0.0 });
    let problem = ConsistencyProblem::new(&arm, &set, &effects);
    bencher.bench_local(|| black_box(problem.nearest(&values, &root).unwrap()));
}

/// What was estimated from a public recording, with the filter of its description.
#[divan::bench(args = [("panda-unisa", 4.0), ("ur10-unisa", 8.0), ("staubli-tx40", 30.0)])]
fn nearest_to_recorded(bencher: Bencher<'_, '_>, (set, cutoff_hz): (&str, f64)) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(set);
    let Ok(recording) = read_csv(folder.join("train.csv")) else {
        eprintln!("{} is not there", folder.display());
        return;
    };
    let urdf = std::fs::read_dir(&folder)
        .unwrap()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .find(|path| path.extension().is_some_and(|end| end == "urdf"))
        .unwrap();
    let joints: Vec<String> = recording.joints.iter().map(|j| j.name.clone()).collect();
    let selection = ChainSelection { recorded_joints: Some(joints), ..ChainSelection::default() };
    let chain = SerialChain::from_description(&load_urdf(&urdf).unwrap(), &selection).unwrap();
    let chain = DrivingAxisChain::from_chain(&chain);
    let names: Vec<&str> = chain.joints.iter().map(|j| j.name.as_str()).collect();
    let settings = MotionSettings { cutoff_hz: Some(cutoff_hz), ..MotionSettings::default() };
    let motion = Motion::from_recording(&recording, &names, &settings).unwrap();
    let arm = RigidArm::from_chain(&chain);
    let minimal = MinimalSet::of(&arm).unwrap();
    let problem = BatchProblem::new(&arm, &minimal);
    let estimate = problem.estimate(&problem.accumulate(&[&motion])).unwrap();
    let found = problem.nearest_consistent(&estimate).unwrap();
    eprintln!(
        "{set}: {} steps, distance {:.3} (at least {:.3}), converged: {}",
        found.steps, found.distance_in_standard_errors, found.distance_at_least, found.converged
    );
    bencher.bench_local(|| black_box(problem.nearest_consistent(&estimate).unwrap()));
}
