//! Writes the input of `tests/judges/consistency.py`: the problems that an independent solver is given too.
//!
//! ```text
//! cargo run -p armident-ident --example consistency_judge_inputs
//! ```

#![allow(clippy::unwrap_used, reason = "cases of a test")]
#![allow(dead_code, reason = "tests/consistency.rs uses the rest")]

use std::path::{Path, PathBuf};

use armident_dynamics::RigidArm;
use armident_ident::{ConsistencyProblem, EffectUnknown, MinimalSet};
use armident_kinematics::{
    ChainSelection, DrivingAxisChain, InertialParameters, SerialChain, load_urdf,
};
use armident_numeric::Mat;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::{Value, json};

/// Arm, effects, noise, seed, weight of the second judge.
pub(crate) const CASES: [(&str, bool, f64, u64, f64); 6] = [
    ("planar_2r", true, 1.0, 1, 1e-2),
    ("scara", true, 0.5, 3, 1e-2),
    ("gantry", false, 0.1, 2, 1e-2),
    ("irb140", true, 0.05, 4, 1e-2),
    ("iiwa14", true, 0.05, 5, 1e-2),
    ("xarm7", false, 0.004, 6, 1e-2),
];

fn main() {
    let cases: Vec<Value> = CASES
        .iter()
        .map(|&(name, with_effects, noise, seed, weight)| {
            let case = estimated(name, with_effects, noise, seed);
            let arm = arm(name);
            let map = case.problem.map();
            let entries: Vec<(usize, usize, f64)> = (0..map.nrows())
                .flat_map(|i| (0..map.ncols()).map(move |j| (i, j, map[(i, j)])))
                .filter(|e| e.2 != 0.0)
                .collect();
            let list = if with_effects {
                effects(&arm, &MinimalSet::of(&arm).unwrap()).0
            } else {
                Vec::new()
            };
            json!({
                "arm": name, "effects": with_effects, "noise": noise, "seed": seed,
                "weight": weight,
                "links": arm.links.iter().map(|l| l.to_array()).collect::<Vec<_>>(),
                // scale of a parameter that must not be negative, null for any other
                "scales": list.iter().map(|e| e.prior).collect::<Vec<_>>(),
                "map": entries,
                "estimate": case.values,
                "standard_errors": case.standard_errors,
            })
        })
        .collect();
    std::fs::write(judges().join("consistency_inputs.json"), json!(cases).to_string() + "\n")
        .unwrap();
}

pub(crate) fn judges() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges")
}

pub(crate) fn arm(name: &str) -> RigidArm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../urdf/{name}.urdf"));
    let robot = load_urdf(&path).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    RigidArm::from_chain(&DrivingAxisChain::from_chain(&chain))
}

/// Viscous and Coulomb friction and torque offset of every joint with entries of their own after
/// the constants, and rotor inertia of joint 1 in the first constant; their true values.
pub(crate) fn effects(arm: &RigidArm, set: &MinimalSet) -> (Vec<EffectUnknown>, Vec<f64>) {
    let mut list = Vec::new();
    let mut values = Vec::new();
    let mut row = set.len();
    for joint in 0..arm.dof() {
        let size = 2.0 / (1.0 + joint as f64);
        for (non_negative, value) in [(true, 0.5 * size), (true, size), (false, -0.1 * size)] {
            let prior = non_negative.then_some(value);
            list.push(EffectUnknown {
                adds_to: vec![(row, 1.0)],
                non_negative,
                merged: false,
                prior,
            });
            values.push(value);
            row += 1;
        }
    }
    list.push(EffectUnknown {
        adds_to: vec![(0, 1.0)],
        non_negative: true,
        merged: false,
        prior: Some(0.01),
    });
    values.push(0.01);
    (list, values)
}

/// An estimate with its information: truth of the URDF and noise of a share of every value.
pub(crate) struct Estimated {
    pub(crate) problem: ConsistencyProblem,
    pub(crate) values: Vec<f64>,
    pub(crate) root: Mat<f64>,
    pub(crate) standard_errors: Vec<f64>,
}

/// Root of an information matrix with correlated neighbours.
pub(crate) fn bidiagonal(standard_errors: &[f64]) -> Mat<f64> {
    let k = standard_errors.len();
    Mat::from_fn(k, k, |i, j| match j {
        _ if i == j => 1.0 / standard_errors[j],
        _ if i + 1 == j => 0.5 / standard_errors[j],
        _ => 0.0,
    })
}

pub(crate) fn estimated(name: &str, with_effects: bool, noise: f64, seed: u64) -> Estimated {
    let arm = arm(name);
    let set = MinimalSet::of(&arm).unwrap();
    let (list, values) = if with_effects { effects(&arm, &set) } else { (Vec::new(), Vec::new()) };
    let problem = ConsistencyProblem::new(&arm, &set, &list);
    let theta: Vec<f64> =
        arm.links.iter().flat_map(InertialParameters::to_array).chain(values).collect();
    let truth = times(problem.map(), &theta);
    let size = truth.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    let standard_errors: Vec<f64> =
        truth.iter().map(|x| noise * x.abs().max(0.01 * size)).collect();
    let mut random = Pcg64::seed_from_u64(seed);
    let values = truth
        .iter()
        .zip(&standard_errors)
        .map(|(x, e)| x + e * random.random_range(-1.7..1.7))
        .collect();
    Estimated { problem, values, root: bidiagonal(&standard_errors), standard_errors }
}

pub(crate) fn times(a: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..a.nrows()).map(|i| (0..a.ncols()).map(|j| a[(i, j)] * x[j]).sum()).collect()
}
