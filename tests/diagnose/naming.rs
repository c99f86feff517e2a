//! What is concealed is named, where it is, and nothing else is.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::{
    JOINTS, changed, diagnose, diagnosed, holdout_error, named, pairs, recordings, set, simulate,
    urdf,
};
use crate::shared::{project, shared};
use crate::tool::{list, number, read_json, run_in, scratch, string};

/// One effect: named, on its joint, with its parameter; the hold-out error falls to the noise.
#[track_caller]
fn one_effect(slug: &str, joint: &str, parameters: &str, parameter: &str, truth: f64) {
    let effect = format!("{slug}:{joint}={parameters}");
    let folder = recordings(&format!("diagnose_{slug}"), &[&effect]);
    let diagnosis = diagnosed(&folder);
    assert_eq!(diagnosis["verdict"], "mismatch", "{slug}");
    assert_eq!(named(&diagnosis), pairs(&[(slug, joint)]));
    let finding = &diagnosis["findings"][0];
    assert!(number(&finding["confidence"]) > 0.9, "{slug}");
    let estimate = &finding["parameters"][parameter];
    let off = (number(&estimate["value"]) - truth).abs();
    assert!(off < 0.03 * truth.abs(), "{slug}: {estimate}, true {truth}");
    let [before, rigid, after] =
        ["before", "rigid", "after"].map(|of| holdout_error(&diagnosis, of, joint));
    assert!(after < 0.5 * before && after < 0.5 * rigid, "{slug}: {before} {rigid} {after}");
    let noise = number(&diagnosis["effort_noise"][joint]);
    assert!(after < 1.5 * noise, "{slug}: {after} left, noise {noise}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn finds_joint_spring() {
    one_effect("joint_spring", "elbow_joint", "6,1.0", "stiffness", 6.0);
}

#[test]
fn finds_quadratic_drag() {
    one_effect("quadratic_drag", "wrist_1_joint", "2", "coefficient", 2.0);
}

#[test]
fn finds_friction() {
    one_effect("coulomb_friction", "shoulder_pan_joint", "3", "level", 3.0);
}

#[test]
fn finds_rotor_inertia() {
    one_effect("rotor_inertia", "wrist_2_joint", "0.4", "inertia", 0.4);
}

/// What belongs to the whole robot is not put on a joint, what belongs to a link is put on the link.
#[test]
fn findings_have_their_location() {
    let folder = recordings("diagnose_delay", &["time_delay:wrist_1_joint=0.015"]);
    let diagnosis = diagnosed(&folder);
    assert_eq!(named(&diagnosis), pairs(&[("time_delay", "")]));
    let delay = number(&diagnosis["findings"][0]["parameters"]["delay"]["value"]);
    assert!((delay - 0.015).abs() < 1e-3, "{delay}");

    let folder = recordings("diagnose_payload", &["payload:wrist_3_joint=1.5,0,0.02,0.05"]);
    let diagnosis = diagnosed(&folder);
    let findings = list(&diagnosis["findings"]);
    assert_eq!(findings.len(), 1, "{findings:?}");
    // the same thing: a load is an inertial error of the last link
    assert!(["payload", "link_inertia_error"].contains(&string(&findings[0]["effect"])));
    assert!(findings[0]["link"].is_string());
    assert_eq!(findings[0]["joints"][0], "wrist_3_joint");
    // nearly all of the error of the hold-out is its
    let gain = number(&findings[0]["evidence"]["holdout_gain"]);
    assert!(findings[0]["confirmed"] == true && 0.5 < gain && gain < 1.0, "{gain}");
}

/// A trajectory of the bundled example with one temperature on all drives, which rises by 3 K.
fn warm(trajectory: &str, temperature_c: f64, to: &Path) {
    let planned =
        std::fs::read_to_string(project(&format!("examples/ur5/{trajectory}.csv"))).unwrap();
    let rows = planned.lines().count() - 1;
    let mut content = String::new();
    for (row, line) in planned.lines().enumerate() {
        content += line;
        for joint in JOINTS {
            match row {
                0 => content += &format!(",{joint}/temperature"),
                _ => {
                    let now_c = temperature_c + (3.0 * row as f64 / rows as f64).round();
                    content += &format!(",{now_c}");
                }
            }
        }
        content += "\n";
    }
    std::fs::write(to, content).unwrap();
}

/// Friction that falls with the recorded temperature is named by it; where the drives warm up and friction does not fall, it is
/// viscous friction.
#[test]
fn finds_friction_by_temperature() {
    let laws = [
        ("friction_temperature:elbow_joint=6,-0.15,40", "friction_temperature"),
        ("viscous_friction:elbow_joint=6", "viscous_friction"),
    ];
    for (k, (law, slug)) in laws.into_iter().enumerate() {
        let folder = scratch(&format!("friction_by_temperature_{k}"));
        for (seed, (trajectory, at_c, name)) in
            [("train", 28.0, "cold"), ("train", 46.0, "train"), ("holdout", 37.0, "holdout")]
                .into_iter()
                .enumerate()
        {
            let motion = folder.join(format!("{name}_motion.csv"));
            warm(trajectory, at_c, &motion);
            let recorded = folder.join(format!("{name}.csv"));
            simulate(&motion, &recorded, &seed.to_string(), &[law]);
        }
        let found = diagnose(&folder, &["cold.csv", "--holdout", "holdout.csv"]).fine().json();
        assert_eq!(named(&found), pairs(&[(slug, "elbow_joint")]));
        let parameters = &list(&found["findings"])[0]["parameters"];
        let of = |name: &str| number(&parameters[name]["value"]);
        if slug == "friction_temperature" {
            let at_40 = of("coefficient")
                + of("coefficient_per_kelvin") * (40.0 - of("reference_temperature"));
            assert!((at_40 - 6.0).abs() < 0.1, "{at_40}");
            assert!((of("coefficient_per_kelvin") + 0.15).abs() < 0.01, "{parameters}");
        }
    }
}

/// Nothing concealed, nothing found; and the fields are those of the contract.
#[test]
fn null_recording_has_no_finding() {
    let folder = recordings("diagnose_clean", &[]);
    let diagnosis = diagnosed(&folder);
    assert_eq!(diagnosis["schema"], "armident.diagnosis/2");
    assert_eq!(diagnosis["verdict"], "match");
    assert!(list(&diagnosis["findings"]).is_empty());
    for joint in JOINTS {
        let [before, after] = ["before", "after"].map(|of| holdout_error(&diagnosis, of, joint));
        assert!(after < 1.1 * before, "{joint}: {before} {after}");
    }
}

/// A development case with its answer: all of it, and nothing that is neither there nor tolerated.
#[track_caller]
fn development_case(name: &str) {
    let Some(case) = shared(&format!("diagnose, {name}"), &format!("challenge/dev/{name}")) else {
        return;
    };
    let args = ["diagnose", "robot.urdf", "train_1.csv", "train_2.csv", "--holdout", "holdout.csv"];
    let diagnosis = run_in(&case, &[&args[..], &["--json", "-", "-q"]].concat()).fine().json();
    let truth = read_json(&case.join("truth.json"));
    let pair = |e: &Value| (string(&e["effect"]).to_owned(), string(&e["joints"][0]).to_owned());
    let effects = list(&truth["effects"]);
    let expected: BTreeSet<_> = effects.iter().map(pair).collect();
    let tolerated: BTreeSet<_> = effects
        .iter()
        .flat_map(|e| list(&e["tolerate"]))
        .chain(truth["everyday"].as_array().into_iter().flatten())
        .map(pair)
        .collect();
    let named = named(&diagnosis);
    assert!(expected.is_subset(&named), "{name}: {named:?}");
    let wrong: Vec<_> =
        named.iter().filter(|n| !expected.contains(n) && !tolerated.contains(n)).collect();
    assert!(wrong.is_empty(), "{name}: {wrong:?}");
    assert_eq!(diagnosis["verdict"] == "match", named.is_empty());
}

#[test]
fn development_case_without_effect() {
    development_case("d01");
}

#[test]
fn development_case_friction() {
    development_case("d05");
}

#[test]
fn development_case_rotor() {
    development_case("d12");
}

#[test]
fn development_case_field() {
    development_case("f03");
}

/// Where two laws fit alike, both are said, and the motion that tells them apart.
#[test]
fn payload_has_link_error_as_alternative() {
    let folder = recordings("diagnose_alternatives", &["payload:wrist_3_joint=1.5,0,0.02,0.05"]);
    let run = diagnose(&folder, &["--next-motion", "next"]);
    let diagnosis = run.fine().json();
    let finding = &diagnosis["findings"][0];
    let other: Vec<&str> =
        list(&finding["alternatives"]).iter().map(|a| string(&a["effect"])).collect();
    let names = [string(&finding["effect"])].iter().chain(&other).copied().collect::<BTreeSet<_>>();
    assert!(names.is_superset(&BTreeSet::from(["payload", "link_inertia_error"])), "{names:?}");
    // no motion tells a load from its link, and that is said
    let next = &diagnosis["next_motion"];
    assert!(next.is_object());
    assert!(next["file"].is_null() == (number(&next["separated"]) == 0.0));
    assert_eq!(folder.join("next/next_motion.csv").exists(), !next["file"].is_null());
}

/// Links that are all off by a few per cent are no single effect, and no match.
#[test]
fn small_link_errors_are_not_single_effects() {
    let folder = recordings("diagnose_all_links", &[]);
    let mut made = String::new();
    let mut off = [1.1, 0.92, 1.12].iter().cycle();
    for line in std::fs::read_to_string(urdf()).unwrap().lines() {
        let mass = line.split_once("<mass value=\"").and_then(|(_, rest)| rest.split_once('"'));
        match mass {
            Some((mass, _)) => {
                let changed = mass.parse::<f64>().unwrap() * off.next().unwrap();
                made += &line.replace(mass, &changed.to_string());
            }
            None => made += line,
        }
        made.push('\n');
    }
    std::fs::write(folder.join("off.urdf"), made).unwrap();
    let args = ["diagnose", "off.urdf", "train.csv", "-q", "--json", "-"];
    let diagnosis = run_in(&folder, &args).fine().json();
    assert_eq!(named(&diagnosis), BTreeSet::new());
    assert_eq!(diagnosis["verdict"], "mismatch");
    let sentence = string(&diagnosis["sentence"]);
    assert!(sentence.contains("no single effect"), "{sentence}");
    let on: Vec<&str> = list(&diagnosis["link_errors_material_on"]).iter().map(string).collect();
    assert!(on.contains(&"shoulder_lift_joint"), "{on:?}");
    // whose masses carry no more effort than the noise
    assert!(!on.contains(&"wrist_3_joint"), "{on:?}");
}

/// A narrow detent far above the noise of its joint, beside everyday friction: what no law explains must not
/// make its joint unimportant before it is described.
#[test]
fn detent_is_unmodelled_dynamics() {
    let friction: Vec<String> = JOINTS
        .iter()
        .flat_map(|j| [format!("coulomb_friction:{j}=1.5"), format!("viscous_friction:{j}=1.2")])
        .collect();
    let folder =
        recordings("diagnose_detent", &friction.iter().map(String::as_str).collect::<Vec<_>>());
    changed(&folder, "train.csv", |h, row| {
        let value = |name: &str| -> f64 {
            row[h.iter().position(|x| *x == name).unwrap()].parse().unwrap()
        };
        let (q, effort) = (value("elbow_joint/position"), value("elbow_joint/effort"));
        let detent = 4.0 * (-((q - 1.5) / 0.2).powi(2)).exp() * (25.0 * (q - 1.5)).sin();
        Some(set(h, row, "elbow_joint/effort", &(effort + detent).to_string()))
    });
    let diagnosis = diagnose(&folder, &[]).fine().json();
    let described = ("unmodelled".to_owned(), "elbow_joint".to_owned());
    assert!(named(&diagnosis).contains(&described), "{:?}", named(&diagnosis));
    let finding =
        list(&diagnosis["findings"]).iter().find(|f| f["effect"] == "unmodelled").unwrap();
    assert_eq!(finding["evidence"]["variables"], serde_json::json!(["elbow_joint/position"]));
    let left = number(&diagnosis["fit"]["train"]["after"]["elbow_joint"]);
    assert!(left < 0.5, "{left}");
}
