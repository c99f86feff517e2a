//! What changed between two sets of recordings.

use std::collections::BTreeSet;

use serde_json::Value;

use super::{changed, diagnose, diagnosed, named, recordings, set};
use crate::tool::{list, number, run_in, scratch, string, text};

/// What the reference shows too is no finding; what came after it is.
#[test]
fn only_the_change_is_diagnosed() {
    let before = recordings("diagnose_before", &["viscous_friction:elbow_joint=3"]);
    let after = recordings(
        "diagnose_after",
        &["viscous_friction:elbow_joint=3", "coulomb_friction:wrist_1_joint=1.5"],
    );
    let elbow = ("viscous_friction".to_owned(), "elbow_joint".to_owned());
    let wrist = ("coulomb_friction".to_owned(), "wrist_1_joint".to_owned());
    assert_eq!(named(&diagnosed(&after)), BTreeSet::from([elbow, wrist.clone()]));
    let reference = before.join("train.csv");
    let more = ["--reference", text(&reference), "--holdout", "holdout.csv"];
    let change = diagnose(&after, &more).fine().json();
    assert_eq!(named(&change), BTreeSet::from([wrist]));
    let error = |key: &str, joint: &str| number(&change["fit"]["holdout"][key][joint]);
    // the elbow's friction is known before; the wrist's is not
    assert!(error("before", "elbow_joint") < 0.3, "{}", error("before", "elbow_joint"));
    assert!(error("after", "wrist_1_joint") < 0.3 * error("before", "wrist_1_joint"));
}

/// A pendulum whose efforts follow a curve that no law of the library has, before and after: what is left
/// unexplained is said, and a heavier bob is found all the same. Its mass by itself is not: a pendulum shows
/// its moment. Its friction bends at speeds that the reference does not reach: no change either.
#[test]
fn a_load_on_an_imperfect_pendulum() {
    let folder = scratch("diagnose_pendulum");
    let urdf = |mass: f64| {
        format!(
            "<robot name=\"pendulum\"><link name=\"base\"/><link name=\"arm\"><inertial>\
             <origin xyz=\"0 0 -0.5\"/><mass value=\"{mass}\"/><inertia ixx=\"0.02\" ixy=\"0\" ixz=\"0\" \
             iyy=\"0.02\" iyz=\"0\" izz=\"0.01\"/></inertial></link><joint name=\"servo\" type=\"revolute\">\
             <parent link=\"base\"/><child link=\"arm\"/><axis xyz=\"0 1 0\"/>\
             <limit lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"20\"/></joint></robot>"
        )
    };
    let make = |name: &str, mass: f64, sines: [(f64, f64); 3], seed: &str| {
        std::fs::write(folder.join("made.urdf"), urdf(mass)).unwrap();
        let mut trajectory = "t,servo/position,servo/velocity\n".to_owned();
        for k in 0..4000 {
            let t = f64::from(k) / 200.0;
            let q: f64 = sines.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let v: f64 = sines.iter().map(|(a, w)| a * w * (w * t).cos()).sum();
            trajectory += &format!("{t},{q},{v}\n");
        }
        std::fs::write(folder.join("trajectory.csv"), trajectory).unwrap();
        let args =
            ["simulate", "made.urdf", "trajectory.csv", "-o", "train.csv", "-q", "--seed", seed];
        let more = ["--torque-noise", "0.05", "--effect", "coulomb_friction:servo=0.8"];
        run_in(&folder, &[&args[..], &more].concat()).fine();
        changed(&folder, &format!("{name}.csv"), |h, row| {
            let value = |name: &str| -> f64 {
                let place = h.iter().position(|x| *x == name).unwrap();
                row[place].parse().unwrap()
            };
            let (q, effort) = (value("servo/position"), value("servo/effort"));
            let v = value("servo/velocity");
            let bent = effort
                + 0.06 * effort * (4.0 * q).sin() * effort.abs().sqrt()
                + 3.0 * (v.abs() - 3.0).max(0.0) * v.signum();
            Some(set(h, row, "servo/effort", &bent.to_string()))
        });
    };
    make("before", 2.0, [(0.5, 0.9), (0.4, 2.3), (0.2, 4.1)], "1");
    make("same", 2.0, [(0.6, 0.7), (0.3, 2.9), (0.2, 3.7)], "2");
    make("loaded", 2.8, [(0.6, 0.7), (0.3, 2.9), (0.2, 3.7)], "3");
    make("faster", 2.0, [(0.6, 1.4), (0.5, 4.3), (0.3, 6.1)], "4");
    std::fs::write(folder.join("arm.urdf"), urdf(2.0)).unwrap();
    let change = |after: &str| -> Value {
        let args =
            ["diagnose", "arm.urdf", after, "--reference", "before.csv", "-q", "--json", "-"];
        run_in(&folder, &args).fine().json()
    };
    let same = change("same.csv");
    assert_eq!(named(&same), BTreeSet::new());
    let sentence = string(&same["sentence"]);
    assert!(sentence.contains("no change"), "{sentence}");
    assert!(same["beyond_reference"].is_null());
    let faster = change("faster.csv");
    assert_eq!(named(&faster), BTreeSet::new());
    // the sines before, at their fastest, all in step
    let fastest = number(&faster["beyond_reference"]["servo"]);
    assert!((1.5..2.2).contains(&fastest), "{fastest}");
    let loaded = change("loaded.csv");
    let findings = list(&loaded["findings"]);
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!(findings[0]["link"], "arm");
    let parameters = &findings[0]["parameters"];
    assert!(parameters["delta_mass"].is_null(), "{parameters}");
    // a load that cannot be weighed
    assert_eq!(list(&findings[0]["alternatives"])[0]["effect"], "payload");
    let moment = number(&parameters["delta_mcz"]["value"]);
    assert!((moment + 0.4).abs() < 0.1, "{moment}");
}
