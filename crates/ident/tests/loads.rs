//! Known loads, gains of drives and shared transmissions, on a UR5 of which everything is known.

#![allow(clippy::unwrap_used, reason = "tests")]

mod bench;

use armident_dynamics::inverse_dynamics_of_motion;
use armident_ident::estimators::{Estimator, TrainingData, Wls};
use armident_ident::{
    BatchEstimate, BatchProblem, BatchSettings, Coupling, KnownLoad, StructureSearch, without_loads,
};
use armident_kinematics::InertialParameters;
use armident_model::ArmModel;
use armident_motion::Motion;
use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use bench::{Bench, Sines};

const SAMPLES: u32 = 1500;
const MASS_KG: f64 = 2.0;
const CENTRE_M: [f64; 3] = [0.02, -0.03, 0.06];
/// N m/A.
const GAINS: [f64; 6] = [13.2, 12.1, 9.7, 6.1, 5.5, 4.9];

/// What a simulated recording has.
#[derive(Clone, Copy, Default)]
struct Case {
    name: &'static str,
    loaded: bool,
    in_currents: bool,
    /// viscous and Coulomb friction of a shaft that the last two joints share
    shared: [f64; 2],
    noise: f64,
    seed: u64,
}

impl Bench {
    fn names(&self) -> Vec<&str> {
        self.model.chain.joint_names()
    }

    fn motion(&self, case: &Case) -> Motion {
        let sines = Sines::new(SAMPLES, if case.loaded { 0.7 } else { 0.0 });
        let Sines { time_s: time, q, dq, ddq } = &sines;
        let mut arm = self.arm.clone();
        if case.loaded {
            let point =
                InertialParameters::from_com(MASS_KG, Vector3::from(CENTRE_M), Matrix3::zeros());
            let in_joint = point.expressed_in(&self.model.chain.joints[5].child_link_in_e);
            arm.links[5] = arm.links[5].plus(&in_joint);
        }
        let mut effort = inverse_dynamics_of_motion(&arm, q, dq, ddq);
        let normal = Normal::new(0.0, 1.0).unwrap();
        let mut random = Pcg64::seed_from_u64(case.seed);
        for t in 0..time.len() {
            let shaft = dq[4][t] + dq[5][t];
            let shared = case.shared[0] * shaft + case.shared[1] * shaft.signum();
            for j in 0..6 {
                let size = [6.0, 6.0, 4.0, 1.0, 1.0, 1.0][j];
                effort[j][t] += size * (dq[j][t] + 0.8 * dq[j][t].signum());
                if j >= 4 {
                    effort[j][t] += shared;
                }
                effort[j][t] += case.noise * size * normal.sample(&mut random);
                if case.in_currents {
                    effort[j][t] /= GAINS[j];
                }
            }
        }
        self.recorded(case.name, &sines, &effort)
    }

    fn load(&self, centre_m: Option<[f64; 3]>, error_m: f64) -> KnownLoad {
        KnownLoad::new(&self.model.chain, "heavy", MASS_KG, centre_m, error_m)
    }
}

const EMPTY: Case = Case {
    name: "empty",
    loaded: false,
    in_currents: false,
    shared: [0.0; 2],
    noise: 0.01,
    seed: 1,
};
const HEAVY: Case = Case { name: "heavy", loaded: true, seed: 2, ..EMPTY };

/// Weighted least squares with standard errors from blocks.
fn weighted(
    bench: &Bench,
    problem: &BatchProblem,
    motions: &[&Motion],
    settings: &BatchSettings,
) -> BatchEstimate {
    let rows = problem.accumulate(motions);
    let data = TrainingData { model: &bench.model, motions, rows: &rows };
    Wls.fit(problem, &data, settings).unwrap()
}

/// Values of the constants, their true ones, and the factor of the 95 % interval with their errors.
fn constants(bench: &Bench, problem: &BatchProblem, motions: &[Motion]) -> Vec<[f64; 3]> {
    let all: Vec<&Motion> = motions.iter().collect();
    let settings = BatchSettings { link_prior: None, ..BatchSettings::default() };
    let found = weighted(bench, problem, &all, &settings);
    let truth = bench.set.values(&bench.arm.constants());
    (0..bench.set.len())
        .map(|k| {
            let error = found.quantile_95 * found.standard_error(k).unwrap();
            // the rotor of the first joint is part of its constant and absent here
            [found.values[k], truth[k], error]
        })
        .collect()
}

fn share_inside(rows: &[[f64; 3]]) -> f64 {
    let inside = rows.iter().filter(|[found, truth, error]| (found - truth).abs() <= *error);
    inside.count() as f64 / rows.len() as f64
}

#[test]
fn known_load_does_not_bias_constants() {
    let bench = Bench::new();
    let motions = [bench.motion(&EMPTY), bench.motion(&HEAVY)];
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    // with the load ignored the constants would be those of neither arm
    let off = |rows: &[[f64; 3]]| rows.iter().map(|r| (r[0] - r[1]).powi(2)).sum::<f64>().sqrt();
    let ignored = off(&constants(&bench, &problem, &motions));
    let load = bench.load(Some(CENTRE_M), 0.0);
    let without = motions.map(|m| without_loads(&bench.arm, m, std::slice::from_ref(&load)));
    let found = constants(&bench, &problem, &without);
    let share = share_inside(&found);
    assert!(share > 0.85, "{share}");
    assert!(off(&found) < 0.1 * ignored, "{} {ignored}", off(&found));
}

#[test]
fn unknown_load_centre_is_estimated() {
    let bench = Bench::new();
    let loads = [bench.load(None, 0.0)];
    let motions =
        [bench.motion(&EMPTY), bench.motion(&HEAVY)].map(|m| without_loads(&bench.arm, m, &loads));
    let problem = BatchProblem::new(&bench.arm, &bench.set).with_loads(&loads);
    let share = share_inside(&constants(&bench, &problem, &motions));
    assert!(share > 0.85, "{share}");
    let all: Vec<&Motion> = motions.iter().collect();
    let found = weighted(&bench, &problem, &all, &BatchSettings::default());
    let centre = Vector3::from(problem.centre_of(&loads[0], &found.values));
    let to_link = bench.model.chain.joints[5].child_link_in_e.inverse();
    let off = to_link.transform_point(&centre.into()).coords - Vector3::from(CENTRE_M);
    assert!(off.norm() < 0.003, "{off}");
}

/// Six gains in ten recordings: their 95 % intervals hold all but a few of the sixty true ones.
#[test]
fn drive_gain_intervals_have_nominal_coverage() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let load = bench.load(Some(CENTRE_M), 0.0);
    let mut inside = 0;
    for seed in 0..10 {
        let cases = [EMPTY, HEAVY].map(|case| Case {
            in_currents: true,
            seed: case.seed + 10 * seed,
            ..case
        });
        let motions = cases.map(|case| bench.motion(&case));
        let all: Vec<&Motion> = motions.iter().collect();
        let found = problem.drive_gains(&all, &[true; 6], std::slice::from_ref(&load)).unwrap();
        assert!(found.absolute);
        for (gain, truth) in found.joints.iter().zip(GAINS) {
            let gain = gain.unwrap();
            let [low, high] = gain.interval_95.unwrap();
            assert!((gain.value / truth - 1.0).abs() < 0.2, "{gain:?} for {truth}");
            inside += usize::from((low..=high).contains(&truth));
        }
        // what a model keeps says the same
        let names = ["a", "b", "c", "d", "e", "f"];
        let known = found.known(&names).unwrap();
        for (joint, gain) in names.iter().zip(&found.joints) {
            let (value, error) = known.of(joint).unwrap();
            let gain = gain.unwrap();
            let relative = gain.standard_error.unwrap() / gain.value.abs();
            assert_eq!(value, gain.value);
            assert!((error / relative - 1.0).abs() < 0.05, "{error} {relative}");
        }
    }
    // 57 expected; 50 or fewer of 60 in one of 10 000
    assert!(inside > 50, "{inside} of 60");
}

/// Efforts that are recorded 8 % too large: the known load requires less, on all joints together.
#[test]
fn known_load_contradicts_scaled_efforts() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let load = bench.load(Some(CENTRE_M), 0.0);
    for scale in [1.0, 1.08] {
        let motions = [EMPTY, HEAVY].map(|case| {
            let mut motion = bench.motion(&case);
            for efforts in [&mut motion.effort, &mut motion.effort_filtered] {
                efforts.as_mut().unwrap().iter_mut().flatten().for_each(|e| *e *= scale);
            }
            motion
        });
        let all: Vec<&Motion> = motions.iter().collect();
        let found = problem.drive_gains(&all, &[true; 6], std::slice::from_ref(&load)).unwrap();
        let (gain, error) = found.common().unwrap();
        assert!((gain * scale).ln().abs() < 4.0 * error, "{gain} +- {error} for {scale}");
        assert!(error < 0.02, "{error}");
    }
}

#[test]
fn gain_ratios_are_identified_without_known_load() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let motions = [Case { in_currents: true, ..EMPTY }, Case { in_currents: true, ..HEAVY }]
        .map(|case| bench.motion(&Case { loaded: false, ..case }));
    let all: Vec<&Motion> = motions.iter().collect();
    let found = problem.drive_gains(&all, &[true; 6], &[]).unwrap();
    assert!(!found.absolute);
    assert!(found.known(&["joint"; 6]).is_none());
    let reference = found.joints.iter().position(|g| g.unwrap().standard_error.is_none()).unwrap();
    assert_eq!(found.joints[reference].unwrap().value, 1.0);
    let mut known = 0;
    for (gain, truth) in found.joints.iter().zip(GAINS) {
        let gain = gain.unwrap();
        if gain.standard_error.is_none() {
            continue;
        }
        // the last link is light: what its drive carries besides friction is lost in the noise
        let Some([low, high]) = gain.interval_95 else { continue };
        known += 1;
        let ratio = truth / GAINS[reference];
        let width = high - low;
        assert!((low - width..=high + width).contains(&ratio), "{gain:?} for {ratio}");
    }
    assert!(known >= 3, "{found:?}");
    // the description is right here, so the size it gives is
    assert!((found.scale_of_description / GAINS[reference] - 1.0).abs() < 0.1, "{found:?}");

    // one known effort gives all their size
    let mut in_part = [true; 6];
    in_part[1] = false;
    let mixed: Vec<Motion> = (motions.into_iter())
        .map(|mut motion| {
            for efforts in [&mut motion.effort, &mut motion.effort_filtered] {
                efforts.as_mut().unwrap()[1].iter_mut().for_each(|e| *e *= GAINS[1]);
            }
            motion
        })
        .collect();
    let all: Vec<&Motion> = mixed.iter().collect();
    let found = problem.drive_gains(&all, &in_part, &[]).unwrap();
    assert!(found.absolute && found.joints[1].is_none());
    let gain = found.joints[2].unwrap();
    assert!((gain.value / GAINS[2] - 1.0).abs() < 0.1, "{gain:?}");
}

#[test]
fn detects_coupled_transmission_only_where_present() {
    let bench = Bench::new();
    let settings = BatchSettings::default();
    for (shared, expected) in
        [([0.0; 2], vec![]), ([0.6, 2.0], vec![Coupling { first: 4, ratio: 1.0 }])]
    {
        let motion = bench.motion(&Case { shared, noise: 0.05, ..EMPTY });
        let mut problem = BatchProblem::new(&bench.arm, &bench.set);
        let before = problem.terms.len();
        let chosen = problem.choose_structure(&[&motion], &settings, StructureSearch::ALL).unwrap();
        let found: Vec<Coupling> = chosen.couplings.iter().map(|c| c.coupling).collect();
        assert_eq!(found, expected);
        assert_eq!(problem.terms.len(), before + 2 * expected.len());
        let estimate = weighted(&bench, &problem, &[&motion], &chosen.settings);
        for (k, truth) in (before..problem.terms.len()).zip(shared) {
            let error = estimate.quantile_95 * estimate.standard_error(k).unwrap();
            assert!((estimate.values[k] - truth).abs() < 1.5 * error, "{k}");
        }
        // what is estimated is what the model predicts
        let names = bench.names();
        let values = &estimate.values;
        let model = ArmModel {
            effects: problem.effects(values, &names),
            ..bench.set.applied_to(bench.model.clone(), &problem.constants(values))
        };
        let again = ArmModel::parse(&model.to_json().unwrap(), "text").unwrap();
        let predicted = again.predict_motion(&motion).unwrap();
        let measured = motion.effort.as_ref().unwrap();
        for (joint, fit) in estimate.train.iter().enumerate() {
            let pairs = predicted[joint].iter().zip(&measured[joint]);
            let squares: f64 = pairs.map(|(p, m)| (p - m).powi(2)).sum();
            let rmse = (squares / f64::from(SAMPLES)).sqrt();
            assert!((rmse / fit.rmse - 1.0).abs() < 1e-9, "{joint}: {rmse} {}", fit.rmse);
        }
    }
}
