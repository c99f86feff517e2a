//! Physical consistency: exact where the estimate is consistent, nearest where it is not.

#![allow(clippy::unwrap_used, reason = "tests")]

use armident_ident::{ConsistencyError, ConsistencyProblem, Consistent, EffectUnknown, MinimalSet};
use armident_kinematics::InertialParameters;
use armident_numeric::Mat;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

#[path = "../examples/consistency_judge_inputs.rs"]
mod cases;

use cases::{CASES, Estimated, arm, bidiagonal, effects, estimated, judges, times};

const ARMS: [&str; 15] = [
    "planar_2r",
    "planar_3r",
    "scara",
    "gantry",
    "cylindrical",
    "stanford",
    "puma560",
    "irb140",
    "ur5",
    "ur10",
    "tx40",
    "kinova_gen3",
    "panda",
    "iiwa14",
    "xarm7",
];

fn distance(case: &Estimated, values: &[f64]) -> f64 {
    let left: Vec<f64> = values.iter().zip(&case.values).map(|(a, b)| a - b).collect();
    times(&case.root, &left).iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// What holds of every answer, whatever was asked.
fn assert_consistent(found: &Consistent, effects: &[EffectUnknown]) {
    for (joint, link) in found.links.iter().enumerate() {
        assert!(link.is_physical(), "link {}: {link:?}", joint + 1);
        assert!(link.mass_kg > 0.0);
    }
    for (effect, value) in effects.iter().zip(&found.effects) {
        assert!(value.is_finite() && (!effect.non_negative || *value >= 0.0));
    }
    assert!(found.duality_gap >= 0.0 && found.duality_gap.is_finite());
    assert!(found.distance_at_least <= found.distance_in_standard_errors);
    assert!(found.steps <= 200);
}

/// Every arm's own constants are consistent, also those with links that no real body has: the
/// minimal constants of the Stanford arm of the paper are those of other, real links.
#[test]
fn consistent_constants_are_returned_unchanged() {
    for name in ARMS {
        let arm = arm(name);
        let set = MinimalSet::of(&arm).unwrap();
        let values = set.values(&arm.constants());
        let size = values.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        let errors: Vec<f64> = values.iter().map(|x| 1e-3 * x.abs().max(0.01 * size)).collect();
        let found = ConsistencyProblem::new(&arm, &set, &[])
            .nearest(&values, &bidiagonal(&errors))
            .unwrap();
        assert_consistent(&found, &[]);
        assert!(found.exact && found.converged, "{name}: {found:?}");
        assert!(found.distance_in_standard_errors < 1e-9, "{name}");
        let again = set.values(&arm.with_links(found.links.clone()).constants());
        for (a, b) in again.iter().zip(&values) {
            assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-3 * size), "{name}: {a} {b}");
        }
        // where the links are real they are the nearest to themselves
        let projected: &[usize] = match name {
            "stanford" => &[0],
            "puma560" => &[2],
            _ => &[],
        };
        assert_eq!(found.prior_projected, projected, "{name}");
        if found.prior_projected.is_empty() && found.prior_thickened.is_empty() {
            assert!(found.divergence.abs() < 1e-9, "{name}: {}", found.divergence);
        }
    }
}

/// `g + λ d` of other consistent links is never smaller, and their distance is never below the
/// certified bound: mixtures with random bodies and with the URDF, near and far.
#[test]
fn projection_is_nearest_consistent_set() {
    let mut random = Pcg64::seed_from_u64(5);
    for (name, noise) in [("scara", 0.4), ("ur5", 0.1), ("irb140", 0.05), ("xarm7", 0.1)] {
        let case = estimated(name, true, noise, 11);
        let arm = arm(name);
        let (list, true_effects) = effects(&arm, &MinimalSet::of(&arm).unwrap());
        let found = case.problem.nearest(&case.values, &case.root).unwrap();
        assert_consistent(&found, &list);
        assert!(!found.exact && found.converged, "{name}: {found:?}");
        let theta: Vec<f64> = (found.links.iter().flat_map(InertialParameters::to_array))
            .chain(found.effects.clone())
            .collect();
        let best = 0.5 * found.distance_in_standard_errors.powi(2);
        for trial in 0..300 {
            let shares: Vec<f64> =
                true_effects.iter().map(|p| p * random.random_range(0.5..1.5)).collect();
            let other: Vec<f64> = (arm.links.iter())
                .flat_map(|link| {
                    let half: [f64; 9] = std::array::from_fn(|_| random.random_range(-0.3..0.3));
                    let half = Matrix3::from_row_slice(&half);
                    let moment = half * half.transpose() * (0.1 * link.mass_kg);
                    let body = InertialParameters::from_com(
                        link.mass_kg * random.random_range(0.2..3.0),
                        Vector3::from_fn(|_, _| random.random_range(-0.3..0.3)),
                        Matrix3::identity() * moment.trace() - moment,
                    );
                    if trial % 3 == 0 { link.to_array() } else { body.to_array() }
                })
                .chain(shares)
                .collect();
            for share in [1e-4, 1e-2, 0.3, 1.0] {
                let mixed: Vec<f64> =
                    theta.iter().zip(&other).map(|(a, b)| a + share * (b - a)).collect();
                let there = distance(&case, &times(case.problem.map(), &mixed));
                assert!(there >= found.distance_at_least, "{name}");
                // convexity: the divergence of the mixture is at most the share of the other's
                assert!(0.5 * there * there >= best - 1e-6 * share * 1e4, "{name}");
            }
        }
    }
}

/// The weight changes what is reported by less than anyone can measure.
#[test]
fn regularising_weight_is_negligible() {
    for (name, noise) in [("ur5", 0.1), ("irb140", 0.03), ("iiwa14", 0.1), ("panda", 0.1)] {
        let case = estimated(name, false, noise, 2);
        let found = case.problem.nearest(&case.values, &case.root).unwrap();
        assert!(!found.exact, "{name}");
        let slack = found.distance_in_standard_errors - found.distance_at_least;
        println!(
            "{name}: {:.6} standard errors, certified to {slack:.1e}, {} steps",
            found.distance_in_standard_errors, found.steps
        );
        assert!(slack < 0.2, "{name}: {slack:e}");
    }
}

#[test]
fn negative_effects_are_projected_to_zero() {
    let arm = arm("planar_2r");
    let set = MinimalSet::of(&arm).unwrap();
    let rows = set.len();
    let friction = |row| EffectUnknown {
        adds_to: vec![(row, 1.0)],
        non_negative: true,
        merged: false,
        prior: None,
    };
    let list = [friction(rows), friction(rows + 1)];
    let problem = ConsistencyProblem::new(&arm, &set, &list);
    let mut values = set.values(&arm.constants());
    values.extend([0.0, 0.3]);
    let root = bidiagonal(&vec![0.01; rows + 2]);
    // found to be absent: exactly so
    let found = problem.nearest(&values, &root).unwrap();
    assert!(found.exact && found.effects == [0.0, found.effects[1]]);
    assert!((found.effects[1] - 0.3).abs() < 1e-12);
    // the same when the zero is a bound of the estimator and not measured
    let mut blind = root.clone();
    for row in 0..blind.nrows() {
        blind[(row, rows)] = 0.0;
    }
    let found = problem.nearest(&values, &blind).unwrap();
    assert!(found.exact && found.effects[0] == 0.0);
    // two standard errors below zero: the other entries move with it as far as they are correlated
    values[rows] = -0.02;
    let found = problem.nearest(&values, &root).unwrap();
    assert!(!found.exact && found.effects[0] >= 0.0 && found.effects[0] < 1e-6);
    let expected = nearest_with_fixed(&root, rows, 0.02);
    assert!(
        (found.distance_in_standard_errors - expected).abs() < 1e-5,
        "{} {expected}",
        found.distance_in_standard_errors
    );
}

/// Distance when one entry has to move by `shift` and the others may follow: Schur complement.
fn nearest_with_fixed(root: &Mat<f64>, entry: usize, shift: f64) -> f64 {
    // the covariance of a single entry is the inverse of its Schur complement
    let k = root.ncols();
    let mut solution = vec![0.0; k];
    // Rᵀ z = e, then |z|² is the variance
    for i in 0..k {
        let known: f64 = (0..i).map(|j| root[(j, i)] * solution[j]).sum();
        solution[i] = (f64::from(u8::from(i == entry)) - known) / root[(i, i)];
    }
    shift / solution.iter().map(|z| z * z).sum::<f64>().sqrt()
}

#[test]
fn massless_urdf_links_are_allowed() {
    for massless in 0..7 {
        let arm = arm("panda");
        let mut links = arm.links.clone();
        links[massless] = InertialParameters::zero();
        let arm = arm.with_links(links);
        let set = MinimalSet::of(&arm).unwrap();
        let values = set.values(&arm.constants());
        let found = ConsistencyProblem::new(&arm, &set, &[])
            .nearest(&values, &bidiagonal(&vec![1e-3; values.len()]))
            .unwrap();
        assert_consistent(&found, &[]);
        assert!(found.prior_thickened.contains(&massless));
        println!(
            "link {}: {:.1e} standard errors",
            massless + 1,
            found.distance_in_standard_errors
        );
        // a last link without any inertia is on the boundary: nearly met
        assert!(found.exact || found.distance_in_standard_errors < 0.02);
    }
}

#[test]
fn mismatched_inputs_are_rejected() {
    let case = estimated("planar_2r", false, 0.1, 1);
    let short = case.problem.nearest(&case.values[1..], &case.root);
    assert!(matches!(short, Err(ConsistencyError::Size { found: 5, expected: 6, .. })));
    let mut values = case.values.clone();
    values[2] = f64::NAN;
    let error = case.problem.nearest(&values, &case.root).unwrap_err();
    assert!(matches!(error, ConsistencyError::Numeric(_)), "{error}");
    let mut links = arm("planar_2r").links;
    links[1].mass_kg = f64::INFINITY;
    let broken = arm("planar_2r").with_links(links);
    let set = MinimalSet::of(&arm("planar_2r")).unwrap();
    let error =
        ConsistencyProblem::new(&broken, &set, &[]).nearest(&case.values, &case.root).unwrap_err();
    assert_eq!(error.to_string(), "the link of joint or effect 2 (from 1) is not finite");
}

/// Rotor inertia that only adds to a constant of the links is left out where the links alone have the
/// constant, and is there where they cannot.
#[test]
fn merged_rotor_inertia_is_used_only_if_needed() {
    let arm = arm("planar_2r");
    let set = MinimalSet::of(&arm).unwrap();
    let rotor =
        EffectUnknown { adds_to: vec![(0, 1.0)], non_negative: true, merged: true, prior: None };
    let problem = ConsistencyProblem::new(&arm, &set, &[rotor]);
    let root = bidiagonal(&vec![1e-3; set.len()]);
    let values = set.values(&arm.constants());
    let found = problem.nearest(&values, &root).unwrap();
    assert!(found.exact && found.effects == [0.0]);

    // both joints' inertia far beyond what the first moments and the URDF ask for: still links
    let mut heavy = values;
    heavy[0] += 50.0;
    let found = problem.nearest(&heavy, &root).unwrap();
    assert!(found.exact && found.effects == [0.0] && found.links.iter().all(|l| l.is_physical()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: RngSeed::Fixed(1992), ..ProptestConfig::default() })]
    /// Any priors, any estimate, any information: an answer, real links, a finite certificate.
    #[test]
    fn projection_always_ends_with_consistent_links(
        name in prop::sample::select(vec!["planar_2r", "scara", "cylindrical", "stanford", "panda"]),
        seed in any::<u64>(),
        log_error in -4.0..1.0_f64,
        kinds in prop::collection::vec(0..5_u8, 7),
        unmeasured in 0.0..0.5_f64,
    ) {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut draw = |range: f64| random.random_range(-range..range);
        let arm = arm(name);
        let links = arm.links.iter().zip(&kinds).map(|(link, kind)| match kind {
            0 => InertialParameters::zero(),
            1 => InertialParameters::from_array(&std::array::from_fn(|_| draw(1.0))),
            2 => InertialParameters::from_com(
                link.mass_kg, link.com_m(), Matrix3::zeros()),
            3 => InertialParameters::from_com(1e6 * link.mass_kg, link.com_m(), Matrix3::identity()),
            _ => *link,
        }).collect();
        let arm = arm.with_links(links);
        let set = MinimalSet::of(&arm).unwrap();
        let (list, _) = effects(&arm, &set);
        let problem = ConsistencyProblem::new(&arm, &set, &list);
        let rows = problem.map().nrows();
        let values: Vec<f64> = (0..rows).map(|_| draw(1.0)).collect();
        let mix = Mat::from_fn(rows, rows, |i, j| {
            10_f64.powf(-log_error) * (draw(0.3) + f64::from(u8::from(i == j)))
        });
        let kept: Vec<bool> = (0..rows).map(|_| draw(0.5) + 0.5 > unmeasured).collect();
        let root = Mat::from_fn(rows, rows, |i, j| if kept[i] { mix[(i, j)] } else { 0.0 });
        let found = problem.nearest(&values, &root).unwrap();
        for link in &found.links {
            prop_assert!(link.is_physical(), "{link:?}");
        }
        for (effect, value) in list.iter().zip(&found.effects) {
            prop_assert!(value.is_finite() && (!effect.non_negative || *value >= 0.0));
        }
        // with links far from the URDF the numbers may be exhausted, and it says so
        prop_assert!(found.converged || found.divergence > 100.0, "{found:?}");
        prop_assert!(found.distance_at_least <= found.distance_in_standard_errors);
        // on the path the gap is the weight times the degree of the cones and the size it covers
        let degree = (4 * found.links.len()) as f64;
        let size = degree * found.gap_holds_to;
        let limit = found.weight * (degree + list.len() as f64 + size);
        prop_assert!(!found.converged || found.duality_gap <= 1.1 * limit + 1e-3 * (1.0 + found.distance_in_standard_errors), "{limit:e} {found:?}");
    }
}

/// The same problems by CVXPY with Clarabel (tests/judges/consistency.py).
#[test]
fn independent_solver_agrees_with_projection() {
    let answers: Value =
        serde_json::from_str(&std::fs::read_to_string(judges().join("consistency.json")).unwrap())
            .unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let numbers =
        |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().map(number).collect() };
    let (mut exact, mut distant) = (0, 0);
    for (k, &(name, with_effects, noise, seed, weight)) in CASES.iter().enumerate() {
        let answer = &answers[k];
        let case = estimated(name, with_effects, noise, seed);
        let found = case.problem.nearest(&case.values, &case.root).unwrap();
        let smallest = number(&answer["stage_1"]["distance"]);
        assert!(found.converged, "{name}: {found:?}");
        assert!(found.distance_at_least <= smallest + 1e-6, "{name}: {found:?} {smallest}");
        assert!(found.distance_in_standard_errors >= smallest - 1e-6, "{name} {smallest}");
        // the weight costs next to nothing
        assert!(found.distance_in_standard_errors <= smallest + 0.01, "{name} {smallest}");
        let theta = |found: &Consistent| -> Vec<f64> {
            let links = found.links.iter().flat_map(InertialParameters::to_array);
            links.chain(found.effects.clone()).collect()
        };
        let close = |found: &Consistent, judge: &Value, what: &str| {
            let (found, judge) = (theta(found), numbers(&judge["theta"]));
            let size = judge.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            for (a, b) in found.iter().zip(&judge) {
                assert!((a - b).abs() < 1e-4 * size, "{name}, {what}: {a} {b}");
            }
        };
        assert_eq!(found.exact, !answer["nearest"].is_null(), "{name}");
        if found.exact {
            exact += 1;
            let least = number(&answer["nearest"]["divergence"]);
            assert!((found.divergence - least).abs() < 1e-5 * least, "{name} {found:?} {least}");
            close(&found, &answer["nearest"], "nearest");
        } else {
            distant += 1;
            let weighted = case.problem.clone().with_weight(weight);
            let found = weighted.nearest(&case.values, &case.root).unwrap();
            let objective =
                0.5 * found.distance_in_standard_errors.powi(2) + weight * found.divergence;
            let least = number(&answer["weighted"]["objective"]);
            assert!((objective - least).abs() < 1e-6 * least, "{name}: {objective} {least}");
            close(&found, &answer["weighted"], "weighted");
        }
    }
    assert!(exact > 0 && distant > 0, "{exact} {distant}");
}
