//! The six arms with numbers from an independent program (its rigid-body dynamics agree with
//! Pinocchio 4.1): frames, links, constants, minimal set, and the model at five states.

use std::path::Path;

use armident_dynamics::{
    RigidArm, coriolis_effort, gravity_effort, inertia_matrix, inverse_dynamics,
};
use armident_ident::MinimalSet;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use serde_json::Value;

use crate::shared::shared;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        Value::Number(n) => vec![n.as_f64().unwrap()],
        other => panic!("not a number: {other}"),
    }
}

fn assert_close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= tolerance, "{what}: found {f}, expected {e}");
    }
}

fn row_major(m: &nalgebra::Matrix3<f64>) -> Vec<f64> {
    m.transpose().as_slice().to_vec()
}

fn pose_rows(pose: &nalgebra::Isometry3<f64>) -> Vec<f64> {
    pose.to_homogeneous().transpose().as_slice().to_vec()
}

fn check(path: &Path) {
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let text = |key: &str| golden[key].as_str().unwrap().to_owned();
    let tolerance = if text("robot") == "ur5" { 1e-7 } else { 1e-9 };
    let robot = load_urdf(&path.with_extension("urdf")).unwrap();
    let gravity = numbers(&golden["gravity"]);
    let selection = ChainSelection {
        base: Some(text("base_link")),
        tip: Some(text("tip_link")),
        gravity_base: [gravity[0], gravity[1], gravity[2]],
        ..ChainSelection::default()
    };
    let chain = SerialChain::from_description(&robot, &selection).unwrap();
    let chain = DrivingAxisChain::from_chain(&chain);

    assert_eq!(chain.types(), text("types"));
    let pairs: Vec<&str> = chain.axis_pairs.iter().map(|p| p.name()).collect();
    assert_eq!(serde_json::json!(pairs), golden["axis_pairs"]);
    assert_eq!(serde_json::json!(chain.joint_names()), golden["joint_names"]);
    assert_eq!(serde_json::json!(chain.locked), golden["locked"]);
    assert_close("E0", &pose_rows(&chain.base_from_e0), &numbers(&golden["E0_in_base"]), 1e-9);
    assert_close("g", chain.gravity_e0.as_slice(), &numbers(&golden["gravity_E0"]), 1e-9);
    assert!(chain.snap_error < 1e-6);
    for (joint, (dh, link)) in chain
        .joints
        .iter()
        .zip(golden["dh"].as_array().unwrap().iter().zip(golden["links"].as_array().unwrap()))
    {
        let f = joint.frame;
        let expected = [&dh["b"], &dh["d"], &dh["beta"], &dh["theta"]].map(|v| v.as_f64().unwrap());
        assert_close(&joint.name, &[f.b_m, f.d_m, f.beta_rad, f.theta_rad], &expected, tolerance);
        assert_close("mass", &[joint.link.mass_kg], &numbers(&link["mass"]), tolerance);
        assert_close("com", joint.link.com_m().as_slice(), &numbers(&link["com"]), tolerance);
        let inertia = row_major(&joint.link.inertia_com_kgm2());
        assert_close("inertia", &inertia, &numbers(&link["inertia_com"]), tolerance);
        let pose = pose_rows(&joint.child_link_in_e);
        assert_close("child link", &pose, &numbers(&link["child_link_in_E"]), 1e-7);
    }

    let arm = RigidArm::from_chain(&chain);
    let bodies = arm.constants();
    for (body, expected) in bodies.iter().zip(golden["constants"].as_array().unwrap()) {
        assert_close("mhat", &[body.mass_kg], &numbers(&expected["mhat"]), tolerance);
        assert_close("k", body.first_moment_kgm.as_slice(), &numbers(&expected["k"]), tolerance);
        let u = row_major(&body.inertia_origin_kgm2);
        assert_close("U", &u, &numbers(&expected["U"]), tolerance);
    }

    let set = MinimalSet::of(&arm).unwrap();
    let joint_number = |index: Option<usize>| serde_json::json!(index.map(|i| i + 1));
    assert_eq!(joint_number(set.theorem.r), golden["r"]);
    assert_eq!(joint_number(set.theorem.s), golden["s"]);
    for (found, key) in [(&set.theorem.delta, "delta"), (&set.theorem.sigma, "sigma")] {
        let found: serde_json::Map<String, Value> =
            found.iter().map(|(j, &d)| ((j + 1).to_string(), Value::from(u8::from(d)))).collect();
        assert_eq!(Value::Object(found), golden[key]);
    }
    let expected = golden["theorem2"].as_array().unwrap();
    assert_eq!(set.theorem.constants.len(), expected.len());
    for ((item, constant), expected) in set.theorem.constants.iter().zip(expected) {
        assert_eq!(constant.label(), expected["label"]);
        assert_eq!(u64::from(*item), expected["item"].as_u64().unwrap());
        let value = constant.value(&bodies);
        assert_close(&constant.label(), &[value], &numbers(&expected["value"]), tolerance);
    }
    let expected = golden["minimal"].as_array().unwrap();
    let labels: Vec<&str> = expected.iter().map(|e| e["label"].as_str().unwrap()).collect();
    assert_eq!(set.labels(), labels);
    assert!(set.is_confirmed(), "{:?}", set.rank);
    assert_eq!(Value::from(set.rank.rank), golden["rank_numeric"]);
    assert_eq!(set.dropped.len(), golden["dropped"].as_array().unwrap().len());

    let minimal_arm = arm.with_constants(&set.body_constants(&set.values(&bodies)));
    for state in golden["states"].as_array().unwrap() {
        let at = |key: &str| numbers(&state[key]);
        let (q, dq, ddq) = (at("q"), at("dq"), at("ddq"));
        let largest = |v: &[f64]| v.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for arm in [&arm, &minimal_arm] {
            let h = inertia_matrix(arm, &q);
            assert_close("H", h.as_slice(), &at("H"), 1e-8 * largest(&at("H")));
            let gravity = gravity_effort(arm, &q);
            assert_close("gravity", &gravity, &at("gravity"), 1e-8 * largest(&at("gravity")));
            let tolerance = 1e-8 * largest(&at("tau"));
            let tau = inverse_dynamics(arm, &q, &dq, &ddq);
            assert_close("tau by Newton-Euler", &tau, &at("tau"), tolerance);
            // (29): H ddq + Coriolis + gravity
            let inertial = &h * nalgebra::DVector::from_column_slice(&ddq);
            let coriolis = coriolis_effort(arm, &q, &dq);
            let sum: Vec<f64> =
                (0..q.len()).map(|i| inertial[i] + coriolis[i] + gravity[i]).collect();
            assert_close("tau by (29)-(32)", &sum, &at("tau"), tolerance);
        }
    }
}

#[test]
fn golden_arms_match() {
    let Some(folder) = shared("golden_arms", "golden") else { return };
    for arm in ["stanford", "puma560", "scara", "gantry", "ur5", "panda"] {
        check(&folder.join(format!("{arm}.json")));
    }
}
