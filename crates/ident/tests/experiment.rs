//! Algorithm 2: equations against the general regressor, exact recovery, honest standard errors.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_ident::MinimalSet;
use armident_ident::experiment::{Plan, PlanSettings, algorithm2, plan, single_motion_row, tasks};
use armident_kinematics::{
    AxisPair, ChainSelection, DrivingAxisChain, DrivingAxisJoint, JointLimits, SerialChain,
    load_urdf,
};
use armident_motion::{Motion, MotionSettings};
use armident_recording::{JointChannels, Recording};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use random_arms::{Case, cases, repeated};

#[path = "../../dynamics/tests/random_arms/mod.rs"]
mod random_arms;

fn chain(name: &str, gravity: [f64; 3]) -> DrivingAxisChain {
    let path = format!("{}/../../urdf/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
    let robot = load_urdf(path.as_ref()).unwrap();
    let selection = ChainSelection { gravity_base: gravity, ..ChainSelection::default() };
    DrivingAxisChain::from_chain(&SerialChain::from_description(&robot, &selection).unwrap())
}

const DOWN: [f64; 3] = [0.0, 0.0, -9.81];

/// Exact recordings of all experiments, with white effort noise where asked for.
fn recordings(arm: &RigidArm, plan: &Plan, noise: f64, seed: u64) -> Vec<Motion> {
    let mut random = Pcg64::seed_from_u64(seed);
    let normal = Normal::new(0.0, noise).unwrap();
    plan.experiments
        .iter()
        .map(|experiment| {
            let planned = plan.trajectory(experiment);
            let column = |pick: fn(&(f64, f64, f64)) -> f64| -> Vec<Vec<f64>> {
                planned.joints.iter().map(|j| j.iter().map(pick).collect()).collect()
            };
            let (q, dq, ddq) = (column(|s| s.0), column(|s| s.1), column(|s| s.2));
            let effort = inverse_dynamics_of_motion(arm, &q, &dq, &ddq);
            let joints = plan
                .joints
                .iter()
                .enumerate()
                .map(|(j, name)| {
                    let mut channels = JointChannels::new(name);
                    channels.position = Some(q[j].clone());
                    channels.velocity = Some(dq[j].clone());
                    channels.acceleration = Some(ddq[j].clone());
                    let noisy = effort[j].iter().map(|e| e + normal.sample(&mut random)).collect();
                    channels.effort = Some(noisy);
                    channels
                })
                .collect();
            let recording = Recording::new(&experiment.id, planned.time_s, joints).unwrap();
            let names: Vec<&str> = plan.joints.iter().map(String::as_str).collect();
            Motion::from_recording(&recording, &names, &MotionSettings::default()).unwrap()
        })
        .collect()
}

#[test]
fn equations_55_to_61_are_rows_of_regressor() {
    for name in ["stanford", "scara", "gantry", "puma560", "cylindrical"] {
        for gravity in [DOWN, [3.0, -2.0, 5.0], [0.0; 3]] {
            let arm = RigidArm::from_chain(&chain(name, gravity));
            let set = MinimalSet::of(&arm).unwrap();
            let mut random = Pcg64::seed_from_u64(3);
            let mut checked = 0;
            for task in tasks(&arm, &set) {
                for &moving in task.movers.iter().chain(&task.further_movers) {
                    let q: Vec<f64> =
                        (0..arm.dof()).map(|_| random.random_range(-2.0..2.0)).collect();
                    let (speed, acceleration) =
                        (random.random_range(-2.0..2.0), random.random_range(-5.0..5.0));
                    let (mut dq, mut ddq) = (vec![0.0; arm.dof()], vec![0.0; arm.dof()]);
                    (dq[moving], ddq[moving]) = (speed, acceleration);
                    let constants: Vec<_> =
                        task.unknowns.iter().map(|&k| set.constants[k]).collect();
                    let row = single_motion_row(
                        &arm,
                        moving,
                        task.observed,
                        &q,
                        speed,
                        acceleration,
                        &constants,
                    );
                    let general = set.columns().regressor(&arm, &q, &dq, &ddq);
                    for (&k, x) in task.unknowns.iter().zip(row) {
                        let expected = general[task.observed * set.len() + k];
                        assert!(
                            (x - expected).abs() < 1e-11,
                            "{name} {} {}: {x} {expected}",
                            task.step,
                            set.constants[k]
                        );
                        checked += 1;
                    }
                }
            }
            assert!(checked > 0, "{name}");
        }
    }
}

#[test]
fn exact_efforts_determine_all_constants_of_bundled_arms() {
    for name in [
        "stanford",
        "puma560",
        "scara",
        "cylindrical",
        "gantry",
        "planar_2r",
        "planar_3r",
        "ur5",
        "ur10",
        "panda",
        "iiwa14",
        "kinova_gen3",
        "xarm7",
        "tx40",
        "irb140",
    ] {
        let chain = chain(name, DOWN);
        let arm = RigidArm::from_chain(&chain);
        let set = MinimalSet::of(&arm).unwrap();
        let plan = plan(&chain, &set, &PlanSettings::default()).unwrap();
        assert_eq!(plan.notes, Vec::<String>::new(), "{name}");
        let found = algorithm2(&arm, &set, &plan, &recordings(&arm, &plan, 0.0, 0)).unwrap();
        let truth = set.values(&arm.constants());
        for (k, (f, t)) in found.values.iter().zip(&truth).enumerate() {
            assert!((f - t).abs() < 1e-9, "{name} {}: {f} {t}", set.constants[k]);
        }
        let worst = found.steps.iter().map(|s| s.condition).fold(0.0, f64::max);
        assert!(worst < 1e3, "{name}: condition {worst}");
    }
}

/// A small fixed sample of the study in docs/studies: 40 seeds, pooled over 33 constants. The exact
/// band of the pooled share is [0.92, 0.98]; 1320 intervals of which some 33 are independent.
#[test]
fn stanford_intervals_have_nominal_coverage() {
    let chain = chain("stanford", DOWN);
    let arm = RigidArm::from_chain(&chain);
    let set = MinimalSet::of(&arm).unwrap();
    let plan = plan(&chain, &set, &PlanSettings::default()).unwrap();
    let truth = set.values(&arm.constants());
    let seeds = 40;
    let (mut covered, mut squares) = (0, 0.0);
    for seed in 0..seeds {
        let found = algorithm2(&arm, &set, &plan, &recordings(&arm, &plan, 0.1, seed)).unwrap();
        for k in 0..set.len() {
            let z = (found.values[k] - truth[k]) / found.standard_error(k);
            squares += z * z;
            covered += usize::from(z.abs() <= found.quantile_95[k]);
        }
    }
    let total = seeds as usize * set.len();
    let share = covered as f64 / total as f64;
    let spread = (squares / total as f64).sqrt();
    assert!((0.92..=0.98).contains(&share), "coverage {share}");
    assert!((0.9..=1.1).contains(&spread), "standardised errors have SD {spread}");
}

/// A chain without limits around a random arm.
fn chain_of(arm: &RigidArm) -> DrivingAxisChain {
    let joints: Vec<DrivingAxisJoint> = arm
        .joints
        .iter()
        .zip(&arm.links)
        .enumerate()
        .map(|(i, (joint, link))| DrivingAxisJoint {
            name: format!("j{}", i + 1),
            kind: joint.kind,
            frame: joint.frame,
            link: *link,
            child_link: format!("l{}", i + 1),
            body_links: vec![format!("l{}", i + 1)],
            child_link_in_e: nalgebra::Isometry3::identity(),
            shapes: Vec::new(),
            limits: JointLimits::default(),
            dynamics: None,
        })
        .collect();
    DrivingAxisChain {
        robot: "random".to_owned(),
        source: "random".to_owned(),
        base_link: "l0".to_owned(),
        tip_link: format!("l{}", joints.len()),
        tip_in_e: nalgebra::Isometry3::identity(),
        base_shapes: Vec::new(),
        locked: std::collections::BTreeMap::new(),
        base_from_e0: nalgebra::Isometry3::identity(),
        gravity_base: arm.gravity_e0,
        gravity_e0: arm.gravity_e0,
        axis_pairs: vec![AxisPair::Skew; joints.len() - 1],
        joints,
        snap_error: 0.0,
        ignored: Vec::new(),
        warnings: Vec::new(),
    }
}

proptest::proptest! {
    #![proptest_config(repeated(120))]

    /// Random arms of 1 to 7 joints, special geometry and zero gravity among them: exact efforts give
    /// every constant, to 1e-9 of the arm's largest one times the steps' condition numbers.
    #[test]
    fn exact_efforts_determine_all_constants_of_random_arms(Case { arm, .. } in cases()) {
        let chain = chain_of(&arm);
        let set = MinimalSet::of(&arm).unwrap();
        let settings = PlanSettings { rate_hz: 50.0, ..PlanSettings::default() };
        let plan = plan(&chain, &set, &settings).unwrap();
        proptest::prop_assert!(plan.notes.is_empty(), "{:?}", plan.notes);
        let found = algorithm2(&arm, &set, &plan, &recordings(&arm, &plan, 0.0, 0)).unwrap();
        let truth = set.values(&arm.constants());
        let scale = truth.iter().fold(1.0_f64, |a, x| a.max(x.abs()));
        for (k, (f, t)) in found.values.iter().zip(&truth).enumerate() {
            proptest::prop_assert!(
                (f - t).abs() < 1e-9 * scale,
                "{}: {f} {t}, gravity {:?}", set.constants[k], arm.gravity_e0
            );
        }
    }
}
