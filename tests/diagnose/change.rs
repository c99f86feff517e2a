//! What changed between two sets of recordings.

use std::collections::BTreeSet;

use serde_json::Value;

use super::{changed, diagnose, diagnosed, named, recordings, set};
use crate::tool::{list, number, run_in, scratch, string, text};

/// What the reference shows too is no finding; what came after it is.
#[test]
fn reports_only_the_change() {
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

/// Friction falls when an arm warms up: that is said with its sign, and the load beside it is weighed all the same. The
/// model is simulated with what is left, against the URDF as against the model of the arm before.
#[test]
fn reports_lower_friction() {
    let of = |viscous: f64, level: f64, more: &[&str]| -> Vec<String> {
        let joints = ["elbow_joint", "shoulder_lift_joint"];
        let friction = joints.iter().flat_map(|joint| {
            [
                format!("viscous_friction:{joint}={}", 10.0 * viscous),
                format!("coulomb_friction:{joint}={}", 9.0 * level),
            ]
        });
        friction.chain(more.iter().map(ToString::to_string)).collect()
    };
    let folder = |test: &str, effects: &[String]| {
        recordings(test, &effects.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let before = folder("diagnose_cold", &of(1.0, 1.0, &[]));
    let after = folder("diagnose_warm", &of(0.5, 0.6, &["payload:wrist_3_joint=0.8,0.02,0,0.05"]));
    let reference = before.join("train.csv");
    let model = before.join("model.json");
    diagnose(&before, &["--save-model", "model.json"]).fine();
    let against = |more: &[&str], robot: &std::path::Path| -> (Value, String) {
        let args = ["diagnose", text(robot), "train.csv", "--holdout", "holdout.csv", "-q"];
        let args = [&args, more].concat();
        let json = [&args[..], &["--json", "-", "--traces"]].concat();
        let json = run_in(&after, &json).fine().json();
        (json, run_in(&after, &args).fine().stdout)
    };
    let urdf = super::urdf();
    let since = against(&["--reference", text(&reference), "--save-model", "warm.json"], &urdf);
    let known = against(&[], &model);
    for (diagnosis, said) in [since, known] {
        let findings = list(&diagnosis["findings"]);
        assert!(findings.iter().all(|f| f["confirmed"] == true), "{said}");
        let of = |effect: &str, joint: &str, parameter: &str| -> f64 {
            let at = |f: &&Value| f["effect"] == effect && f["joints"][0] == joint;
            let found = findings.iter().find(at).unwrap_or_else(|| panic!("{effect}: {said}"));
            number(&found["parameters"][parameter]["value"])
        };
        for joint in ["elbow_joint", "shoulder_lift_joint"] {
            let viscous = of("viscous_friction", joint, "coefficient");
            let level = of("coulomb_friction", joint, "level");
            assert!((viscous + 5.0).abs() < 0.5 && (level + 3.6).abs() < 0.4, "{viscous} {level}");
            for law in ["viscous", "Coulomb"] {
                assert!(said.contains(&format!("lower {law} friction on {joint}")), "{said}");
            }
        }
        assert_eq!(findings.len(), 5, "{said}");
        // what is left without the finding is the change, not all of the friction: it drives
        let viscous =
            |f: &Value| f["effect"] == "viscous_friction" && f["joints"][0] == "elbow_joint";
        let k = findings.iter().position(viscous).unwrap();
        let view = &diagnosis["drawing"]["findings"][k]["views"][0];
        assert!(string(&view["over"]).starts_with("speed of elbow_joint"), "{view}");
        let (speed, left) = (list(&view["x"]), list(&view["without"]));
        let fastest = number(&left[left.len() - 1]) / number(&speed[speed.len() - 1]);
        assert!((fastest + 5.0).abs() < 1.0, "{fastest}");
        let mass = of("payload", "wrist_3_joint", "mass");
        assert!((mass - 0.8).abs() < 0.05, "{mass}");
        let replayed = |when: &str| number(&diagnosis["replay"][when]["elbow_joint"]);
        assert!(replayed("after") < 0.2 * replayed("before"), "{said}");
    }
    // a model file like any other
    let args = ["validate", "warm.json", "holdout.csv", "-q", "--json", "-"];
    let validated = run_in(&after, &args).fine().json();
    assert!(validated["replay_after"].is_object());
    // without a reference there is nothing to be less of
    let least = recordings("diagnose_less", &[]);
    changed(&least, "train.csv", |h, row| {
        let value = |name: &str| -> f64 {
            let place = h.iter().position(|x| *x == name).unwrap();
            row[place].parse().unwrap()
        };
        let effort = value("elbow_joint/effort") - 3.0 * value("elbow_joint/velocity");
        Some(set(h, row, "elbow_joint/effort", &effort.to_string()))
    });
    let alone = diagnose(&least, &[]).fine().json();
    assert_eq!(alone["verdict"], "mismatch");
    for finding in list(&alone["findings"]) {
        let level = &finding["parameters"]["coefficient"]["value"];
        assert!(level.as_f64().is_none_or(|level| level >= 0.0), "{finding}");
    }
}

/// A load on a link of the middle is named there. What the motion does not show of it is not told: a joint that turns
/// about a level axis shows the moment of its link, and the mass only where the joints before it lift it.
#[test]
fn finds_payload_on_middle_link() {
    let before = recordings("diagnose_unloaded", &[]).join("holdout.csv");
    let loaded = |test: &str, load: &str| -> Value {
        let folder = recordings(test, &[&format!("link_inertia_error:{load}")]);
        let change = diagnose(&folder, &["--reference", text(&before)]).fine().json();
        let findings = list(&change["findings"]);
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert_eq!(findings[0]["effect"], "link_inertia_error");
        findings[0].clone()
    };
    let holds = |finding: &Value, name: &str, truth: f64| {
        let said = &finding["parameters"][name];
        let (value, error) = (number(&said["value"]), number(&said["stderr"]));
        assert!((value - truth).abs() < 3.0 * error && error < 0.1, "{name} {value} {error}");
    };
    let forearm = loaded("diagnose_forearm", "elbow_joint=1.5,0.3,0,0");
    assert_eq!(forearm["link"], "link_3");
    holds(&forearm, "delta_mass", 1.5);
    holds(&forearm, "delta_mcx", 0.3);
    let upper_arm = loaded("diagnose_upper_arm", "shoulder_lift_joint=2,0.5,0,0");
    assert_eq!(upper_arm["link"], "link_2");
    assert!(upper_arm["parameters"]["delta_mass"].is_null(), "{upper_arm}");
    holds(&upper_arm, "delta_mcx", 0.5);
}

/// A ripple that was there before is no change, also where the noise of the reference hides it: then it is told that it
/// may have come, and that the reference does not show it.
#[test]
fn noisy_reference_is_inconclusive() {
    let ripple = ["torque_ripple:elbow_joint=2,7,0,0,0"];
    let folder = recordings("diagnose_open", &ripple);
    let (urdf, trajectory) = (super::urdf(), crate::shared::project("examples/ur5/holdout.csv"));
    let simulated = ["simulate", text(&urdf), text(&trajectory), "-o", "before.csv", "-q"];
    // 1.4 N m in 4 N m of noise: less than the 0.6 of it that a name asks for
    let noise = ["--torque-noise", "4", "--encoder-bits", "19", "--effect", ripple[0]];
    run_in(&folder, &[&simulated[..], &noise].concat()).fine();
    let change =
        diagnose(&folder, &["--reference", "before.csv", "--report", "change.html"]).fine().json();
    assert_eq!(named(&change), BTreeSet::new());
    let doubtful = list(&change["inconclusive_changes"]);
    assert_eq!(doubtful.len(), 1, "{doubtful:?}");
    assert_eq!(
        (&doubtful[0]["effect"], &doubtful[0]["joints"][0], &doubtful[0]["maybe_in_reference"]),
        (&"torque_ripple".into(), &"elbow_joint".into(), &true.into())
    );
    let args = ["diagnose", text(&urdf), "train.csv", "-q", "--reference", "before.csv"];
    let said = run_in(&folder, &args).fine().stdout;
    let line = "Inconclusive, the reference does not rule out that this was already present: torque ripple on elbow_joint";
    assert!(said.contains(line), "{said}");
    let page = std::fs::read_to_string(folder.join("change.html")).unwrap();
    assert!(page.contains("To decide whether torque ripple on elbow_joint changed"));
    // one without that noise shows it
    let known = diagnose(&folder, &["--reference", "holdout.csv"]).fine().json();
    assert_eq!(named(&known), BTreeSet::new());
    assert!(known["inconclusive_changes"].is_null());
}

/// A pendulum whose efforts follow a curve that no law of the library has, before and after: what is left
/// unexplained is said, and a heavier bob is found all the same. Its mass by itself is not: a pendulum shows
/// its moment. Its friction bends at speeds that the reference does not reach: no change either.
#[test]
fn finds_payload_despite_model_discrepancy() {
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
    let none = sentence.starts_with("no ") && sentence.contains("change since the reference");
    assert!(none, "{sentence}");
    assert!(same["reference_max_speed"].is_null());
    let faster = change("faster.csv");
    assert_eq!(named(&faster), BTreeSet::new());
    // the sines before, at their fastest, all in step
    let fastest = number(&faster["reference_max_speed"]["servo"]);
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
