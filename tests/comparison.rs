//! `report A B`: two results side by side, and the model card of one.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::shared::project;
use crate::tool::{list, number, read_json, run, scratch, string, text};

/// A recording of the UR5 in software, and what identify finds in it.
fn identified(folder: &Path, name: &str, more: &[&str]) -> PathBuf {
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let recording = folder.join(format!("{name}.csv"));
    let args = ["simulate", text(&urdf), text(&train), "-o", text(&recording)];
    run(&[&args[..], &["--torque-noise", "2%", "--encoder-bits", "20"], more].concat()).fine();
    let json = folder.join(format!("{name}.json"));
    let args = ["identify", text(&urdf), text(&recording), "--cutoff-hz", "5"];
    let options = ["--prior", "none", "--coupling", "none", "--viscous", "linear"];
    run(&[&args[..], &options, &["--json", text(&json)]].concat()).fine();
    json
}

/// One friction was added: it is the parameter that differs, by its size; noise alone makes none differ.
#[test]
fn changed_friction_is_what_differs() {
    let folder = scratch("comparison");
    let before = identified(&folder, "before", &["--seed", "1"]);
    let again = identified(&folder, "again", &["--seed", "2"]);
    let effect = ["--seed", "3", "--effect", "coulomb_friction:elbow_joint=4.5"];
    let after = identified(&folder, "after", &effect);

    let compared = run(&["report", text(&before), text(&again), "--json", "-"]).fine().json();
    assert_eq!(compared["verdict"], "equal", "{}", compared["sentence"]);
    let deviations: Vec<f64> = (list(&compared["parameters"]).iter())
        .filter_map(|parameter| parameter["deviation"].as_f64())
        .collect();
    assert!(deviations.len() > 40 && deviations.iter().any(|d| d.abs() > 0.5));

    let compared = run(&["report", text(&before), text(&after), "--json", "-"]).fine().json();
    assert_eq!(compared["verdict"], "different");
    let first = &list(&compared["parameters"])[0];
    assert_eq!(
        (string(&first["parameter"]), string(&first["location"])),
        ("Coulomb friction, level", "elbow_joint")
    );
    let difference = number(&first["values"][1]) - number(&first["values"][0]);
    let error = number(&first["standard_errors"][0]).hypot(number(&first["standard_errors"][1]));
    assert!((difference - 4.5).abs() < 4.0 * error, "{first}");
    assert!((number(&first["deviation"]) - difference / error).abs() < 1e-6);

    let printed = run(&["report", text(&before), text(&after)]).fine().stdout;
    assert!(
        printed.contains("Coulomb friction, level of elbow_joint")
            && printed.contains("Effort error"),
        "{printed}"
    );
    let page = folder.join("compared.html");
    let ran = run(&["report", text(&before), text(&after), "-o", text(&page)]).fine();
    assert!(ran.stdout.contains("compared.html"));
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("Comparison") && html.contains("Coulomb friction, level"));
}

fn diagnosis(findings: &Value) -> String {
    json!({
        "schema": "armident.diagnosis/2", "robot": "arm", "joints": ["a", "b"],
        "recordings": ["day.csv"], "findings": findings,
        "fit": { "train": { "before": {}, "rigid": {}, "after": { "a": 0.5 } }, "holdout": null },
    })
    .to_string()
}

fn finding(effect: &str, joint: &str, value: f64, window: &Value) -> Value {
    json!({
        "effect": effect, "joints": [joint], "confidence": 0.9, "confirmed": true, "window": window,
        "recording": if window.is_null() { Value::Null } else { json!("day") },
        "parameters": { "level": { "value": value, "stderr": 0.3, "unit": "N m" } },
    })
}

#[test]
fn findings_of_one_diagnosis_alone_are_listed() {
    let folder = scratch("comparison_findings");
    let [first, second] = ["first.json", "second.json"].map(|name| folder.join(name));
    let none = Value::Null;
    let of_first = json!([
        finding("coulomb_friction", "a", 1.0, &none),
        finding("viscous_friction", "b", 1.0, &none),
        finding("external_contact", "a", 1.0, &json!([1.0, 2.0])),
    ]);
    let of_second = json!([
        finding("coulomb_friction", "a", 3.1, &none),
        finding("external_contact", "a", 1.0, &json!([1.5, 2.5])),
        finding("external_contact", "a", 1.0, &json!([5.0, 6.0])),
    ]);
    std::fs::write(&first, diagnosis(&of_first)).unwrap();
    std::fs::write(&second, diagnosis(&of_second)).unwrap();
    let compared = run(&["report", text(&first), text(&second), "--json", "-"]).fine().json();
    let present: Vec<(&str, &Value)> = (list(&compared["findings"]).iter())
        .map(|finding| (string(&finding["finding"]), &finding["present"]))
        .collect();
    assert_eq!(
        present,
        [
            ("Viscous friction on b", &json!([true, false])),
            ("External contact on a", &json!([false, true])),
            ("Coulomb friction on a", &json!([true, true])),
            ("External contact on a", &json!([true, true])),
        ]
    );
    // 2.1 in errors of 0.3 each
    let deviation = number(&compared["findings"][2]["parameters"][0]["deviation"]);
    assert!((deviation - 2.1 / (0.3 * 2.0_f64.sqrt())).abs() < 1e-9);
    insta::assert_snapshot!(
        run(&["report", text(&first), text(&second)])
            .fine()
            .stdout
            .replace(text(&folder), "FOLDER")
    );
}

#[test]
fn results_that_cannot_be_compared_are_refused() {
    let folder = scratch("comparison_refused");
    let write = |name: &str, text: &str| -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let diagnosis = write("diagnosis.json", &diagnosis(&json!([])));
    let other = |schema: &str, joint: &str| {
        json!({ "schema": schema, "robot": "arm", "joints": [joint] }).to_string()
    };
    let files = [
        write("identify.json", &other("armident.identify/2", "a")),
        write("check.json", &other("armident.check/2", "a")),
        write("elsewhere.json", &other("armident.diagnosis/2", "c")),
        write("broken.json", "{\n\"schema\":"),
        folder.join("absent.json"),
    ];
    let mut printed = String::new();
    for file in &files {
        let ran = run(&["report", text(&diagnosis), text(file)]);
        assert_eq!((ran.code, ran.stdout.as_str()), (1, ""));
        printed += &ran.stderr;
    }
    let ran = run(&["report", text(&diagnosis)]);
    assert_eq!(ran.code, 1);
    printed += &ran.stderr;
    insta::assert_snapshot!(printed.replace(text(&folder), "FOLDER"));
}

/// SHA-256 of `urdf/ur5.urdf`, by `sha256sum`.
const UR5_SHA256: &str = "67bd9baaac8c45e8f3b209f8cd33cd0052aa1238ab47ca064982b7ba077b1740";

#[test]
fn model_card_has_values_errors_and_digests() {
    let folder = scratch("card");
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let (card, json) = (folder.join("card.html"), folder.join("result.json"));
    let args =
        ["identify", text(&urdf), text(&train), "--json", text(&json), "--card", text(&card)];
    run(&[&args[..], &["--serial", "UR-0815"]].concat()).fine();
    let (found, result) = (read_json(&folder.join("card.json")), read_json(&json));
    assert_eq!(found["schema"], "armident.card/1");
    assert_eq!((string(&found["serial"]), &found["date"]), ("UR-0815", &Value::Null));
    let inputs: Vec<(&str, &str)> = (list(&found["inputs"]).iter())
        .map(|input| (string(&input["used_as"]), string(&input["file"])))
        .collect();
    assert_eq!(inputs, [("robot", text(&urdf)), ("training", text(&train))]);
    assert_eq!(found["inputs"][0]["sha256"], UR5_SHA256);
    let [constants, effects] = ["constants", "effects"].map(|key| list(&result[key]));
    let parameters = list(&found["parameters"]);
    assert_eq!(parameters.len(), constants.len() + effects.len());
    for (parameter, constant) in parameters.iter().zip(constants) {
        assert_eq!(parameter["value"], constant["value"]);
        assert_eq!(parameter["standard_error"], constant["standard_error"]);
    }
    let html = std::fs::read_to_string(&card).unwrap();
    assert!(html.contains("Model card") && html.contains("UR-0815") && html.contains(UR5_SHA256));

    let refused = run(&["identify", text(&urdf), text(&train), "--card", "card.pdf"]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("end the name in .html"), "{}", refused.stderr);
}

/// Stamps that count from 1970 have the date of the recording.
#[test]
fn model_card_has_the_date_of_the_stamps() {
    let folder = scratch("card_date");
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let later = folder.join("later.csv");
    let lines = std::fs::read_to_string(&train).unwrap();
    let moved = lines.lines().enumerate().map(|(k, line)| match line.split_once(',') {
        Some((t, others)) if k > 0 => {
            format!("{:.4},{others}\n", t.parse::<f64>().unwrap() + 1.7e9)
        }
        _ => format!("{line}\n"),
    });
    std::fs::write(&later, moved.collect::<String>()).unwrap();
    let card = folder.join("card.html");
    run(&["identify", text(&urdf), text(&later), "--card", text(&card)]).fine();
    assert_eq!(read_json(&folder.join("card.json"))["date"], "2023-11-14");
}
