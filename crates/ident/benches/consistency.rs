//! Cost of the nearest consistent links: seven links, constants with noise of three sizes.

#![allow(clippy::unwrap_used, reason = "a bench without its arm has nothing to measure")]

use std::path::Path;

use armident_dynamics::RigidArm;
use armident_ident::{ConsistencyProblem, EffectUnknown, MinimalSet};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_numeric::Mat;
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
