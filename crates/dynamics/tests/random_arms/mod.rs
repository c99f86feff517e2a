//! Random serial arms: the cases that the identities of the crates are tried on.
//!
//! Each arm has 1 to 7 joints, rotational and translational mixed, and belongs to one family:
//! generic geometry; special angles and lengths (parallel, perpendicular, meeting and coincident axes
//! and offsets that cancel); all axes parallel; all axes through one point. Gravity is
//! along joint 1 (either way), across it, oblique, or absent. Some links have no mass, the others are
//! bodies that exist. Failing cases shrink to fewer joints and rounder numbers.

#![allow(dead_code, reason = "each test binary uses its part")]

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};

use armident_dynamics::{JointGeometry, RigidArm};
use armident_kinematics::{DrivingAxisFrame, InertialParameters, JointKind};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// An arm and one state of it: angles in ±π, lengths in ±1 m, speeds and accelerations in ±2.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) arm: RigidArm,
    pub(crate) q: Vec<f64>,
    pub(crate) dq: Vec<f64>,
    pub(crate) ddq: Vec<f64>,
}

/// `count` cases of a fixed sequence (`PROPTEST_RNG_SEED` gives another one).
pub(crate) fn repeated(count: u32) -> ProptestConfig {
    let given = std::env::var("PROPTEST_RNG_SEED").ok().and_then(|text| text.parse().ok());
    ProptestConfig {
        cases: count,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(given.unwrap_or(1992)),
        ..ProptestConfig::default()
    }
}

/// Arms with a state, gravity or not.
pub(crate) fn cases() -> impl Strategy<Value = Case> {
    prop_oneof![4 => with_gravity(gravity()), 1 => with_gravity(Just(Vector3::zeros()))]
}

/// Arms with a state and this gravity.
pub(crate) fn with_gravity(
    gravity: impl Strategy<Value = Vector3<f64>>,
) -> impl Strategy<Value = Case> {
    let joints = prop_oneof![
        family(generic_angle().boxed(), generic_length().boxed()),
        family(special_angle().boxed(), special_length().boxed()),
        family(special_angle().boxed(), special_length().boxed()),
        family(mixed_angle().boxed(), mixed_length().boxed()),
        family(prop_oneof![Just(0.0), Just(PI)].boxed(), mixed_length().boxed()),
        family(mixed_angle().boxed(), Just(0.0).boxed()),
    ];
    (joints, gravity).prop_map(|(joints, gravity_e0)| {
        let mut case = Case {
            arm: RigidArm { joints: Vec::new(), links: Vec::new(), gravity_e0 },
            q: Vec::new(),
            dq: Vec::new(),
            ddq: Vec::new(),
        };
        for (i, (kind, frame, link, [q, dq, ddq])) in joints.into_iter().enumerate() {
            let first = DrivingAxisFrame { b_m: 0.0, d_m: 0.0, beta_rad: 0.0, theta_rad: 0.0 };
            case.arm.joints.push(JointGeometry::new(kind, if i == 0 { first } else { frame }));
            case.arm.links.push(link);
            case.q.push(if kind.is_rotational() { PI * q } else { q });
            case.dq.push(2.0 * dq);
            case.ddq.push(2.0 * ddq);
        }
        case
    })
}

/// Gravity along joint 1 (either way), across it and oblique.
pub(crate) fn gravity() -> impl Strategy<Value = Vector3<f64>> {
    prop_oneof![
        Just(Vector3::new(0.0, 0.0, -9.81)),
        Just(Vector3::new(0.0, 0.0, 9.81)),
        Just(Vector3::new(0.0, -9.81, 0.0)),
        Just(Vector3::new(3.0, -4.0, -8.0)),
    ]
}

type Joint = (JointKind, DrivingAxisFrame, InertialParameters, [f64; 3]);

fn family(angle: BoxedStrategy<f64>, length: BoxedStrategy<f64>) -> BoxedStrategy<Vec<Joint>> {
    let kind = prop_oneof![2 => Just(JointKind::Rotational), 1 => Just(JointKind::Translational)];
    let frame = (length.clone(), length, angle.clone(), angle).prop_map(
        |(b_m, d_m, beta_rad, theta_rad)| DrivingAxisFrame { b_m, d_m, beta_rad, theta_rad },
    );
    let link = prop_oneof![1 => Just(InertialParameters::zero()), 4 => physical_link()];
    let joint = (kind, frame, link, prop::array::uniform3(-1.0..1.0));
    prop::collection::vec(joint, 1..=7).boxed()
}

fn generic_angle() -> impl Strategy<Value = f64> {
    prop_oneof![0.3..2.8, -2.8..-0.3]
}

fn special_angle() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![0.0, 0.0, FRAC_PI_2, -FRAC_PI_2, PI, FRAC_PI_3, 0.7])
}

fn mixed_angle() -> impl Strategy<Value = f64> {
    prop_oneof![special_angle(), generic_angle()]
}

fn generic_length() -> impl Strategy<Value = f64> {
    prop_oneof![0.15..0.6, -0.6..-0.15]
}

fn special_length() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![0.0, 0.0, 0.0, 0.3, -0.3])
}

fn mixed_length() -> impl Strategy<Value = f64> {
    prop_oneof![special_length(), generic_length()]
}

/// A body of positive mass: 0.2 to 5 kg within 0.3 m, full inertia that fulfils the triangle inequality.
pub(crate) fn physical_link() -> impl Strategy<Value = InertialParameters> {
    let spread = || prop::array::uniform3(0.001..0.05);
    (0.2..5.0, prop::array::uniform3(-0.3..0.3), spread(), prop::array::uniform3(-PI..PI)).prop_map(
        |(mass_kg, com_m, [x, y, z], [roll, pitch, yaw])| {
            let principal = Matrix3::from_diagonal(&Vector3::new(y + z, x + z, x + y));
            let axes = Rotation3::from_euler_angles(roll, pitch, yaw);
            let inertia = axes * principal * axes.transpose();
            InertialParameters::from_com(
                mass_kg,
                Vector3::from(com_m),
                (inertia + inertia.transpose()) * 0.5,
            )
        },
    )
}

/// Largest absolute entry.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |size: f64, value| size.max(value.abs()))
}

/// Equal to `tolerance` of the largest expected entry, or of 1 where that is smaller: masses, lengths
/// and speeds of the cases are of order 1, and a sum of such terms may cancel.
#[track_caller]
pub(crate) fn assert_close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let allowed = tolerance * largest(expected).max(1.0);
    for (index, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f - e).abs() <= allowed, "{what}, entry {index}: found {f}, expected {e}");
    }
}
