//! The kernels against the functions of one sample, in every width of lanes that this processor or the compiler has.

#[path = "../../tests/random_arms/mod.rs"]
mod random_arms;

use std::path::Path;

use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use proptest::prelude::*;
use pulp::{Scalar, Scalar128b, Scalar256b, Scalar512b, Simd, WithSimd};
use random_arms::{assert_close, cases, repeated};

use super::{Columns, Efforts, InertiaMatrices, Rows, upper_triangle};
use crate::lanes::{BLOCK, Column};
use crate::sin_cos::sin_cos_of_column;
use crate::{
    RigidArm, composite_bodies, inertia_matrix, inertia_matrix_of, inverse_dynamics,
    standard_regressor,
};

/// What is equal in exact arithmetic, as a fraction of the largest entry.
const EXACT: f64 = 1e-12;

/// `run` on one lane, on two, four and eight lanes that the compiler makes of scalar code, and on those of the processor.
fn on_every_width<Op: WithSimd>(
    mut run: impl FnMut() -> Op,
    mut check: impl FnMut(&str, Op::Output),
) {
    check("1 lane", Scalar.vectorize(run()));
    check("2 lanes", Scalar128b.vectorize(run()));
    check("4 lanes", Scalar256b.vectorize(run()));
    check("8 lanes", Scalar512b.vectorize(run()));
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        check("AVX2", Simd::vectorize(simd, run()));
        check("AVX2, 2 lanes", Simd::vectorize(pulp::x86::V3_128b(simd), run()));
        check("AVX2, 8 lanes", Simd::vectorize(pulp::x86::V3_512b(simd), run()));
    }
    #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
    if let Some(simd) = pulp::x86::V4::try_new() {
        check("AVX-512", Simd::vectorize(simd, run()));
    }
}

/// A motion in which every sample and joint differs.
fn motion(arm: &RigidArm, samples: usize) -> [Vec<Vec<f64>>; 3] {
    [0.0, 1.0, 2.0].map(|phase| {
        let column = |j: usize| {
            let wave =
                move |t: usize| (phase + 1.3 * j as f64 + 0.37 * t as f64).sin() * (1.0 + phase);
            (0..samples).map(wave).collect()
        };
        (0..arm.dof()).map(column).collect()
    })
}

fn sample(columns: &[Vec<f64>], t: usize) -> Vec<f64> {
    columns.iter().map(|column| column[t]).collect()
}

fn views(columns: &[Vec<f64>]) -> Vec<&[f64]> {
    columns.iter().map(Vec::as_slice).collect()
}

/// Inertia matrix by (9) and (10) as they are printed.
fn printed_matrix(arm: &RigidArm, q: &[f64]) -> Vec<f64> {
    let poses = arm.poses(q);
    inertia_matrix_of(arm, &poses, &composite_bodies(arm, &poses)).as_slice().to_vec()
}

/// All kernels at all widths against one sample at a time.
fn check_arm(arm: &RigidArm, samples: usize) {
    let [q, dq, ddq] = motion(arm, samples);
    let n = arm.dof();
    let (of_q, of_dq, of_ddq) = (views(&q), views(&dq), views(&ddq));
    let columns = Columns { q: &of_q, dq: &of_dq, ddq: &of_ddq };
    let at = |t: usize| (sample(&q, t), sample(&dq, t), sample(&ddq, t));
    let expected: Vec<(Vec<f64>, Vec<f64>, Vec<f64>)> = (0..samples)
        .map(|t| {
            let (q, dq, ddq) = at(t);
            let matrix = printed_matrix(arm, &q);
            assert_close("one matrix", inertia_matrix(arm, &q).as_slice(), &matrix, EXACT);
            let efforts = inverse_dynamics(arm, &q, &dq, &ddq);
            (efforts, standard_regressor(arm, &q, &dq, &ddq), matrix)
        })
        .collect();
    for least in [0, n - 1] {
        let run = || EffortsOf { arm, columns: &columns, least };
        on_every_width(run, |width, found| {
            for (t, (efforts, ..)) in expected.iter().enumerate() {
                let (found, expected) = (&sample(&found, t)[least..], &efforts[least..]);
                assert_close(&format!("effort, {width}, sample {t}"), found, expected, EXACT);
            }
        });
    }
    on_every_width(
        || MatricesOf { arm, columns: &columns },
        |width, found| {
            for (t, (_, _, matrix)) in expected.iter().enumerate() {
                for i in 0..n {
                    let found: Vec<f64> =
                        (i..n).map(|k| found[upper_triangle(n, i, k)][t]).collect();
                    let what = format!("inertia matrix, {width}, sample {t}, row {i}");
                    assert_close(&what, &found, &matrix[i * n + i..(i + 1) * n], EXACT);
                }
            }
        },
    );
    // only what a chain of rotational joints needs, and all
    for lean in [true, false] {
        let wanted = vec![
            [1, 2, 4, 5, 6, 8, 9].into_iter().fold([!lean; 10], |mut wanted, k| {
                wanted[k] = true;
                wanted
            });
            n
        ];
        let run = || RowsOf { arm, columns: &columns, wanted: &wanted };
        on_every_width(run, |width, found| {
            for (t, (_, regressor, _)) in expected.iter().enumerate() {
                for joint in 0..n {
                    let places = (10 * joint..10 * n).filter(|k| wanted[k / 10][k % 10]);
                    let (found, expected): (Vec<f64>, Vec<f64>) = places
                        .map(|k| (found[joint * 10 * n + k][t], regressor[joint * 10 * n + k]))
                        .unzip();
                    let what = format!("regressor, {width}, sample {t}, joint {joint}");
                    assert_close(&what, &found, &expected, EXACT);
                }
            }
        });
    }
}

/// Kernels with the results that they write to.
struct EffortsOf<'a> {
    arm: &'a RigidArm,
    columns: &'a Columns<'a>,
    least: usize,
}

impl WithSimd for EffortsOf<'_> {
    type Output = Vec<Vec<f64>>;

    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { arm, columns, least } = self;
        let mut effort = vec![vec![f64::NAN; columns.samples()]; arm.dof()];
        Efforts { arm, columns, least, effort: &mut effort }.with_simd(simd);
        effort
    }
}

struct MatricesOf<'a> {
    arm: &'a RigidArm,
    columns: &'a Columns<'a>,
}

impl WithSimd for MatricesOf<'_> {
    type Output = Vec<Vec<f64>>;

    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let (arm, columns, n) = (self.arm, self.columns, self.arm.dof());
        let mut matrix = vec![vec![f64::NAN; columns.samples()]; n * (n + 1) / 2];
        InertiaMatrices { arm, columns, matrix: &mut matrix }.with_simd(simd);
        matrix
    }
}

struct RowsOf<'a> {
    arm: &'a RigidArm,
    columns: &'a Columns<'a>,
    wanted: &'a [super::Wanted],
}

impl WithSimd for RowsOf<'_> {
    type Output = Vec<Vec<f64>>;

    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let (arm, columns, wanted, n) = (self.arm, self.columns, self.wanted, self.arm.dof());
        let mut rows = vec![vec![f64::NAN; columns.samples()]; 10 * n * n];
        let each = |joint: usize, first: usize, samples: usize, row: &[Column]| {
            for (k, column) in row.iter().enumerate().skip(10 * joint) {
                rows[joint * 10 * n + k][first..first + samples]
                    .copy_from_slice(&column[..samples]);
            }
        };
        Rows { arm, columns, rows: 0..n, wanted, each }.with_simd(simd);
        rows
    }
}

struct Angles<'a> {
    theta: f64,
    q: &'a [f64],
}

impl WithSimd for Angles<'_> {
    type Output = [Column; 2];

    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let [mut q, mut sin, mut cos] = [[0.0; BLOCK]; 3];
        q[..self.q.len()].copy_from_slice(self.q);
        sin_cos_of_column(simd, self.theta, &q, &mut sin, &mut cos);
        [sin, cos]
    }
}

#[test]
fn kernels_equal_single_samples_on_every_arm() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf");
    let mut arms = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "urdf") {
            let robot = load_urdf(&path).unwrap();
            let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
            let arm = RigidArm::from_chain(&DrivingAxisChain::from_chain(&chain));
            check_arm(&arm, 2 * BLOCK + 5);
            arms += 1;
        }
    }
    assert!(arms > 10, "{arms}");
}

/// Whole blocks, and every number of samples beyond one.
#[test]
fn kernels_equal_single_samples_for_every_length() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf/panda.urdf");
    let robot = load_urdf(&path).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    let arm = RigidArm::from_chain(&DrivingAxisChain::from_chain(&chain));
    for samples in (0..=BLOCK + 1).chain([2 * BLOCK]) {
        check_arm(&arm, samples);
    }
}

proptest! {
    #![proptest_config(repeated(150))]

    #[test]
    fn kernels_equal_single_samples_on_random_arms(case in cases(), samples in 1..12_usize) {
        check_arm(&case.arm, samples);
    }

    /// More joints than a register has lanes.
    #[test]
    fn kernels_equal_single_samples_on_long_arms(case in cases(), more in cases()) {
        let mut arm = case.arm;
        for _ in 0..2 {
            arm.joints.extend(more.arm.joints.clone());
            arm.links.extend(more.arm.links.clone());
        }
        check_arm(&arm, 5);
    }

    /// A sample's effort has the same bits wherever it stands.
    #[test]
    fn sample_is_independent_of_its_neighbours(case in cases(), first in 0..40_usize) {
        let arm = &case.arm;
        let all = motion(arm, 80);
        let tail = all.each_ref().map(|of| of.iter().map(|c| c[first..].to_vec()).collect::<Vec<_>>());
        let [whole, part] = [&all, &tail].map(|[q, dq, ddq]| {
            let (q, dq, ddq) = (views(q), views(dq), views(ddq));
            let mut effort = vec![vec![0.0; q[0].len()]; arm.dof()];
            let columns = Columns { q: &q, dq: &dq, ddq: &ddq };
            super::efforts_into(arm, &columns, 0, &mut effort);
            effort
        });
        for (whole, part) in whole.iter().zip(&part) {
            prop_assert_eq!(&whole[first..], &part[..]);
        }
    }

    /// Small angles, multiples of right angles, large ones, and those that go to the standard library.
    #[test]
    fn sines_equal_those_of_the_standard_library(
        quarters in -60_000..60_000_i32, offset in -1e-9..1e-9, angle in -3e5..3e5, theta in -4.0..4.0,
    ) {
        let right = std::f64::consts::FRAC_PI_2;
        let q = [f64::from(quarters) * right - theta, f64::from(quarters) * right + offset, angle, 0.0, theta];
        on_every_width(|| Angles { theta, q: &q }, |width, [sin, cos]| {
            for (t, q) in q.iter().enumerate() {
                let (s, c) = (theta + q).sin_cos();
                let error = (sin[t] - s).abs().max((cos[t] - c).abs());
                assert!(error <= 4e-16, "{width}, angle {}: error {error}", theta + q);
            }
        });
    }
}

#[test]
fn angles_without_a_value_have_no_sine() {
    let q = [f64::NAN, f64::INFINITY, 0.5];
    on_every_width(
        || Angles { theta: 0.0, q: &q },
        |width, [sin, cos]| {
            assert!(sin[0].is_nan() && cos[1].is_nan(), "{width}");
            assert_eq!(sin[2].to_bits(), sin[2].abs().to_bits());
            assert!((sin[2] - 0.5_f64.sin()).abs() < 2e-16, "{width}");
        },
    );
}
