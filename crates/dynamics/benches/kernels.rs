//! Cost of the kernels per sample: one sample alone, and a motion in batches.

#![allow(clippy::unwrap_used, reason = "a bench without its arm has nothing to measure")]

use std::path::Path;

use armident_dynamics::{
    ArmMotion, InertiaSweep, RigidArm, Sweep, for_each_regressor_row, inertia_matrices_of_motion,
    inertia_matrix_into, inverse_dynamics_into, inverse_dynamics_of_motion, regressor_row_into,
};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

const ARMS: [&str; 2] = ["panda", "ur5"];
const SAMPLES: usize = 256;

fn main() {
    divan::main();
}

/// An arm with a smooth motion, joint-major: `q`, `q̇`, `q̈` as `[joint][sample]`.
struct Moving {
    arm: RigidArm,
    columns: [Vec<Vec<f64>>; 3],
}

impl Moving {
    fn named(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../urdf/{name}.urdf"));
        let robot = load_urdf(&path).unwrap();
        let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
        let arm = RigidArm::from_chain(&DrivingAxisChain::from_chain(&chain));
        let column = |derivative: i32| -> Vec<Vec<f64>> {
            (0..arm.dof())
                .map(|j| {
                    let rate = 1.0 + 0.3 * j as f64;
                    let phase = f64::from(derivative) * std::f64::consts::FRAC_PI_2;
                    (0..SAMPLES)
                        .map(|t| rate.powi(derivative) * (rate * 0.01 * t as f64 + phase).sin())
                        .collect()
                })
                .collect()
        };
        let columns = [column(0), column(1), column(2)];
        Self { arm, columns }
    }

    fn sample(&self, t: usize) -> [Vec<f64>; 3] {
        self.columns.each_ref().map(|column| column.iter().map(|joint| joint[t]).collect())
    }
}

#[divan::bench(args = ARMS, sample_size = 100, sample_count = 300)]
fn inverse_dynamics_single(bencher: Bencher<'_, '_>, name: &str) {
    let moving = Moving::named(name);
    let n = moving.arm.dof();
    let [q, dq, ddq] = moving.sample(100);
    let (mut sweep, mut effort) = (Sweep::new(n), vec![0.0; n]);
    bencher.counter(ItemsCount::new(1_usize)).bench_local(|| {
        let (q, dq, ddq) = (black_box(&q), black_box(&dq), black_box(&ddq));
        inverse_dynamics_into(&moving.arm, q, dq, ddq, &mut sweep, &mut effort);
        black_box(&effort);
    });
}

#[divan::bench(args = ARMS, sample_count = 300)]
fn inverse_dynamics_motion(bencher: Bencher<'_, '_>, name: &str) {
    let moving = Moving::named(name);
    let [q, dq, ddq] = &moving.columns;
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        inverse_dynamics_of_motion(&moving.arm, black_box(q), black_box(dq), black_box(ddq))
    });
}

#[divan::bench(args = ARMS, sample_size = 100, sample_count = 300)]
fn inertia_matrix_single(bencher: Bencher<'_, '_>, name: &str) {
    let moving = Moving::named(name);
    let [q, ..] = moving.sample(100);
    let n = moving.arm.dof();
    let mut sweep = InertiaSweep::new(n);
    let mut h = vec![0.0; n * n];
    bencher.counter(ItemsCount::new(1_usize)).bench_local(|| {
        inertia_matrix_into(&moving.arm, black_box(&q), &mut sweep, &mut h);
        black_box(&h);
    });
}

#[divan::bench(args = ARMS, sample_size = 100, sample_count = 300)]
fn standard_regressor_single(bencher: Bencher<'_, '_>, name: &str) {
    let moving = Moving::named(name);
    let n = moving.arm.dof();
    let [q, dq, ddq] = moving.sample(100);
    let mut sweep = Sweep::new(n);
    let mut rows = vec![0.0; 10 * n * n];
    bencher.counter(ItemsCount::new(1_usize)).bench_local(|| {
        sweep.run(&moving.arm, black_box(&q), black_box(&dq), black_box(&ddq));
        for (joint, row) in rows.chunks_mut(10 * n).enumerate() {
            regressor_row_into(&moving.arm, &sweep, joint, row);
        }
        black_box(&rows);
    });
}

/// All rows of the standard regressor.
#[divan::bench(args = ARMS, sample_count = 300)]
fn standard_regressor_motion(bencher: Bencher<'_, '_>, name: &str) {
    let moving = Moving::named(name);
    let [q, dq, ddq] = &moving.columns;
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let motion = ArmMotion::new(black_box(q), black_box(dq), black_box(ddq));
        for_each_regressor_row(&moving.arm, &motion, |row| {
            black_box(row);
        });
    });
}

#[divan::bench(args = ARMS, sample_count = 300)]
fn inertia_matrix_motion(bencher: Bencher<'_, '_>, name: &str) {
    let moving = Moving::named(name);
    let [q, ..] = &moving.columns;
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench_local(|| inertia_matrices_of_motion(&moving.arm, black_box(q)));
}
