//! Theorem 2 and Algorithm M on random arms and on the small arms that refute wrong readings.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use armident_dynamics::{
    BodyConstants, CompositeBody, JointGeometry, RigidArm, gravity_effort, inertia_matrix,
    inertia_matrix_of, inverse_dynamics, varying_parts,
};
use armident_ident::{ConstantKind, MinimalSet};
use armident_kinematics::{DrivingAxisFrame, InertialParameters, JointKind};
use nalgebra::Vector3;
use proptest::prelude::*;
use random_arms::{Case, assert_close, gravity, repeated, with_gravity};

#[path = "../../dynamics/tests/random_arms/mod.rs"]
mod random_arms;

/// Of the largest entry; round-off is below 1e-13, regrouped constants included.
const TOLERANCE: f64 = 1e-12;

fn set_of(arm: &RigidArm) -> MinimalSet {
    MinimalSet::of(arm).unwrap()
}

/// Composite bodies by Algorithm 1 from the constants of the set alone: `ĉ = k + ℓ`, `Ĵ = U + V`.
fn algorithm_1(arm: &RigidArm, bodies: &[BodyConstants], q: &[f64]) -> Vec<CompositeBody> {
    varying_parts(&arm.joints, bodies, q)
        .iter()
        .zip(bodies)
        .map(|(part, body)| CompositeBody {
            mass: body.mass_kg,
            first_moment: body.first_moment_kgm + part.first_moment,
            inertia: body.inertia_origin_kgm2 + part.inertia,
        })
        .collect()
}

/// (11) from composite bodies at hand.
fn gravity_of(arm: &RigidArm, q: &[f64], bodies: &[CompositeBody]) -> Vec<f64> {
    let gravity = arm.gravity_in_frames(&arm.poses(q));
    (arm.joints.iter().zip(bodies).zip(gravity))
        .map(|((joint, body), g)| match joint.kind {
            JointKind::Rotational => g.x * body.first_moment.y - g.y * body.first_moment.x,
            JointKind::Translational => -g.z * body.mass,
        })
        .collect()
}

/// The minimal constants alone give `H`, gravity and effort: as links, as columns, by Algorithm 1.
fn assert_sufficient(set: &MinimalSet, case: &Case) {
    let Case { arm, q, dq, ddq } = case;
    let values = set.values(&arm.constants());
    let bodies = set.body_constants(&values);
    let again = set.values(&bodies);
    assert_close("values", &again, &values, TOLERANCE);

    let (h, gravity) = (inertia_matrix(arm, q), gravity_effort(arm, q));
    let effort = inverse_dynamics(arm, q, dq, ddq);

    let minimal = arm.with_constants(&bodies);
    assert_close("H", inertia_matrix(&minimal, q).as_slice(), h.as_slice(), TOLERANCE);
    assert_close("gravity", &gravity_effort(&minimal, q), &gravity, TOLERANCE);
    assert_close("effort", &inverse_dynamics(&minimal, q, dq, ddq), &effort, TOLERANCE);

    let composite = algorithm_1(arm, &bodies, q);
    let by_9 = inertia_matrix_of(arm, &arm.poses(q), &composite);
    assert_close("H by Algorithm 1", by_9.as_slice(), h.as_slice(), TOLERANCE);
    assert_close("gravity by (11)", &gravity_of(arm, q, &composite), &gravity, TOLERANCE);

    if !set.is_empty() {
        let by_columns: Vec<f64> = set
            .columns()
            .regressor(arm, q, dq, ddq)
            .chunks(set.len())
            .map(|row| row.iter().zip(&values).map(|(y, x)| y * x).sum())
            .collect();
        assert_close("Y x", &by_columns, &effort, TOLERANCE);
    }
}

fn assert_labels_unique(set: &MinimalSet) {
    let labels = set.labels();
    assert_eq!(labels.iter().collect::<BTreeSet<_>>().len(), labels.len(), "{labels:?}");
    assert_eq!(set.len() + set.dropped.len(), set.theorem.constants.len());
}

// ---- the zero-gravity rule

/// `p = (O_j - P) · z_j` where `P` on axis `j` is the point all axes before `j` pass through, read at
/// one position.
fn concurrent_at(arm: &RigidArm, j: usize, q: &[f64]) -> Option<f64> {
    let poses = arm.poses(q);
    // axes and origins before j as seen from O_j in E_j: P = t z_j with the least distances
    let lines: Vec<_> = (0..j).map(|m| arm.axis_in_frames(&poses, m)[j - m]).collect();
    let away = |u: &Vector3<f64>, v: Vector3<f64>| v - u * u.dot(&v);
    let (mut across, mut along) = (0.0, 0.0);
    for (u, s) in &lines {
        let z = away(u, Vector3::z());
        across += z.norm_squared();
        along += z.dot(&away(u, -s));
    }
    let t = along / across;
    let meets = |(u, s): &(Vector3<f64>, Vector3<f64>)| away(u, Vector3::z() * t + s).norm() < 1e-9;
    lines.iter().all(meets).then_some(-t)
}

/// Joints whose `(k_j)_x, (k_j)_y` cannot be determined without gravity, with `p`.
fn undetermined_without_gravity(set: &MinimalSet, arm: &RigidArm) -> Vec<(usize, f64)> {
    let Some(s) = set.theorem.s else { return Vec::new() };
    let n = arm.dof();
    let turns = |j: usize| arm.joints[j].kind.is_rotational();
    (s..n)
        .take_while(|&j| (0..j).all(turns))
        .filter(|&j| turns(j))
        .filter_map(|j| {
            let at = |by: f64| -> Option<f64> {
                let q: Vec<f64> = (0..n).map(|i| by * (1.0 + 0.37 * i as f64)).collect();
                concurrent_at(arm, j, &q)
            };
            let (p, also, again) = (at(0.3)?, at(-1.1)?, at(2.3)?);
            assert!((p - also).abs() < 1e-9 && (p - again).abs() < 1e-9);
            Some((j, p))
        })
        .collect()
}

proptest! {
    #![proptest_config(repeated(2000))]

    /// With gravity the size of Theorem 2 is the rank, and its constants suffice.
    #[test]
    fn theorem_2_is_minimal_under_gravity(case in with_gravity(gravity())) {
        let set = set_of(&case.arm);
        prop_assert_eq!(set.theorem.constants.len(), set.rank.rank, "{:?}", set.rank);
        prop_assert!(set.dropped.is_empty(), "{:?}", set.dropped);
        prop_assert!(set.is_confirmed(), "{}", set.sufficiency_error);
        assert_labels_unique(&set);
        assert_sufficient(&set, &case);
    }
}

proptest! {
    #![proptest_config(repeated(1000))]

    /// Without gravity Algorithm M drops exactly what the zero-gravity rule names, and regroups it as
    /// the rule says.
    #[test]
    fn algorithm_m_follows_the_zero_gravity_rule(case in with_gravity(Just(Vector3::zeros()))) {
        let set = set_of(&case.arm);
        prop_assert!(set.is_confirmed(), "{:?} {}", set.rank, set.sufficiency_error);
        assert_labels_unique(&set);
        assert_sufficient(&set, &case);

        let undetermined = undetermined_without_gravity(&set, &case.arm);
        prop_assert_eq!(set.dropped.len(), 2 * undetermined.len());
        for dropped in &set.dropped {
            let joint = dropped.constant.joint;
            let p = undetermined.iter().find(|(j, _)| *j == joint).map(|&(_, p)| p);
            prop_assert!(p.is_some(), "{}", dropped.constant);
            let goes_to = match dropped.constant.quantity {
                ConstantKind::Kx => ConstantKind::U13,
                ConstantKind::Ky => ConstantKind::U23,
                other => panic!("dropped {other:?}"),
            };
            let mut coefficient = 0.0;
            for &(kept, factor) in &dropped.regrouped_into {
                let kept = set.constants[kept];
                prop_assert_eq!((kept.joint, kept.quantity), (joint, goes_to));
                coefficient = factor;
            }
            prop_assert!((coefficient + p.unwrap()).abs() < 1e-8, "{coefficient} {p:?}");
        }
    }
}

// ---- small arms with known sets

const DOWN: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);
const NONE: Vector3<f64> = Vector3::new(0.0, 0.0, 0.0);

/// An arm from `(kind, b, d', β, θ')` per joint; joint 1 has its zeros.
fn arm(joints: &[(char, [f64; 4])], gravity_e0: Vector3<f64>) -> RigidArm {
    let link =
        InertialParameters::from_array(&[2.0, 0.11, -0.23, 0.31, 0.5, 0.02, -0.03, 0.6, 0.05, 0.7]);
    RigidArm {
        joints: joints
            .iter()
            .map(|&(letter, [b_m, d_m, beta_rad, theta_rad])| {
                let kind =
                    if letter == 'R' { JointKind::Rotational } else { JointKind::Translational };
                JointGeometry::new(kind, DrivingAxisFrame { b_m, d_m, beta_rad, theta_rad })
            })
            .collect(),
        links: vec![link; joints.len()],
        gravity_e0,
    }
}

const FIRST: [f64; 4] = [0.0; 4];

/// Size of the set, with rank and sufficiency confirmed.
#[track_caller]
fn size(arm: &RigidArm) -> usize {
    let set = set_of(arm);
    assert!(set.is_confirmed(), "{:?} {}", set.rank, set.sufficiency_error);
    set.len()
}

#[test]
fn translations_before_r_count_in_condition_b() {
    // a horizontal slide carries a vertical rotation; gravity across joint 1
    let g = Vector3::new(0.0, -9.81, 0.0);
    let slide_then_turn = arm(&[('P', FIRST), ('R', [0.0, 0.0, -FRAC_PI_2, 0.0])], g);
    let set = set_of(&slide_then_turn);
    assert_eq!(set.labels(), ["U2_33", "k2_x", "k2_y", "m1"]);
    assert_eq!(size(&slide_then_turn), 4);
}

#[test]
fn condition_c_checks_all_previous_rotations() {
    let beside_then_coincident =
        arm(&[('R', FIRST), ('R', [0.3, 0.0, 0.0, 0.0]), ('R', FIRST)], DOWN);
    assert_eq!(size(&beside_then_coincident), 7);
}

#[test]
fn condition_c_checks_accumulated_offsets() {
    let offset_before_slide = arm(&[('R', FIRST), ('P', [0.3, 0.0, 0.0, 0.0]), ('R', FIRST)], DOWN);
    assert_eq!(size(&offset_before_slide), 5);
}

#[test]
fn condition_c_lets_offsets_cancel() {
    let there_and_back =
        arm(&[('R', FIRST), ('P', [0.3, 0.0, 0.0, 0.0]), ('R', [-0.3, 0.0, 0.0, 0.0])], DOWN);
    assert_eq!(size(&there_and_back), 3);
}

#[test]
fn absent_gravity_counts_as_parallel() {
    assert_eq!(size(&arm(&[('R', FIRST)], NONE)), 1);
    assert_eq!(size(&arm(&[('R', FIRST)], DOWN)), 1);
    assert_eq!(size(&arm(&[('R', FIRST)], Vector3::new(9.81, 0.0, 0.0))), 3);
}

#[test]
fn meeting_axes_without_gravity_lose_first_moment() {
    for d in [0.4, 0.0] {
        let meeting = arm(&[('R', FIRST), ('R', [0.0, d, FRAC_PI_3, 0.7])], NONE);
        let set = set_of(&meeting);
        assert_eq!((set.theorem.constants.len(), size(&meeting)), (8, 6));
        let labels: Vec<String> = set.dropped.iter().map(|d| d.constant.label()).collect();
        assert_eq!(labels, ["k2_x", "k2_y"]);
        // (U_2)_13 <- (U_2)_13 - p (k_2)_x, (U_2)_23 <- (U_2)_23 - p (k_2)_y with p = d'
        for (dropped, into) in set.dropped.iter().zip(["U2_13", "U2_23"]) {
            let regrouped: Vec<(String, f64)> = dropped
                .regrouped_into
                .iter()
                .map(|&(kept, factor)| (set.constants[kept].label(), factor))
                .collect();
            if d == 0.0 {
                assert!(regrouped.is_empty(), "{regrouped:?}");
            } else {
                assert_eq!(regrouped.len(), 1);
                assert_eq!(regrouped[0].0, into);
                assert!((regrouped[0].1 + d).abs() < 1e-9, "{regrouped:?}");
            }
        }
    }
}

/// Arms at zero gravity that look like the rule's but keep all of Theorem 2.
#[test]
fn theorem_2_is_exact_without_gravity_or_fixed_point() {
    let skew = arm(&[('R', FIRST), ('R', [0.2, 0.1, FRAC_PI_3, 0.0])], NONE);
    // the slide moves the point where the two rotations meet
    let slide_first = arm(
        &[('P', FIRST), ('R', [0.0, 0.0, FRAC_PI_2, 0.3]), ('R', [0.0, 0.2, FRAC_PI_3, 0.7])],
        NONE,
    );
    // axes 1 and 2 parallel and apart, 3 meets 2
    let parallel_first =
        arm(&[('R', FIRST), ('R', [0.3, 0.0, 0.0, 0.0]), ('R', [0.0, 0.2, FRAC_PI_3, 0.7])], NONE);
    for (arm, count) in [(skew, 8), (slide_first, 1 + 3 + 7), (parallel_first, 1 + 3 + 7)] {
        let set = set_of(&arm);
        assert_eq!((set.theorem.constants.len(), size(&arm)), (count, count));
        assert!(set.dropped.is_empty());
    }
}

#[test]
fn axial_translation_keeps_first_moment() {
    // R R P R, slide along axis 4, axes 1, 2, 4 through one point
    let joints = [
        ('R', FIRST),
        ('R', [0.0, 0.0, FRAC_PI_2, 0.0]),
        ('P', [0.0, 0.0, FRAC_PI_2, 0.0]),
        ('R', FIRST),
    ];
    let set = set_of(&arm(&joints, NONE));
    assert!(set.is_confirmed());
    let dropped: Vec<String> = set.dropped.iter().map(|d| d.constant.label()).collect();
    assert_eq!(dropped, ["k2_x", "k2_y"]);
    assert_eq!(set.len() + 2, 1 + 7 + 1 + 3 + 7);
}

#[test]
fn translational_arm_has_only_masses() {
    let slides = arm(
        &[('P', FIRST), ('P', [0.1, 0.0, FRAC_PI_2, 0.0]), ('P', [0.0, 0.2, FRAC_PI_3, 0.4])],
        DOWN,
    );
    let set = set_of(&slides);
    assert_eq!(set.labels(), ["m1", "m2", "m3"]);
    assert_eq!((set.theorem.r, set.theorem.s), (None, None));
    assert_eq!(size(&slides), 3);
}

/// Antiparallel is parallel, for axes and for gravity.
#[test]
fn antiparallel_axes_are_parallel() {
    let flipped = arm(&[('R', FIRST), ('R', [0.3, 0.1, std::f64::consts::PI, 0.2])], -DOWN);
    assert_eq!(set_of(&flipped).theorem.s, None);
    assert_eq!(size(&flipped), 4);
}
