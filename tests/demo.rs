//! The story without any file, and what shells and manuals are told.

use crate::tool::{list, read_json, run, run_in, scratch, text};

#[test]
fn demo_finds_its_hidden_effects() {
    let folder = scratch("demo");
    let said = run_in(&folder, &["demo"]).fine();
    assert!(said.stdout.contains("in a browser"), "{}", said.stdout);
    let made = folder.join("armident-demo");
    let page = std::fs::read_to_string(made.join("report.html")).unwrap();
    // the page names the command that makes it again, without the demo
    assert!(page.contains("armident diagnose armident-demo/ur5.urdf"));
    let json = folder.join("result.json");
    run_in(&made, &["diagnose", "ur5.urdf", "train.csv", "--json", text(&json)]).fine();
    let mut found: Vec<String> = list(&read_json(&json)["findings"])
        .iter()
        .map(|f| {
            // a load and a wrong last link are one thing
            let effect = f["effect"].as_str().unwrap().replace("link_inertia_error", "payload");
            format!("{effect} {}", f["link"].as_str().unwrap_or(f["joints"][0].as_str().unwrap()))
        })
        .collect();
    found.sort();
    let concealed =
        ["coulomb_friction elbow_joint", "payload link_6", "torque_ripple shoulder_pan_joint"];
    assert_eq!(found, concealed);
    // again over its own files, never over others
    run_in(&folder, &["demo", "--seed", "5"]).fine();
    std::fs::create_dir(folder.join("mine")).unwrap();
    std::fs::write(folder.join("mine/thesis.txt"), "years").unwrap();
    let refused = run_in(&folder, &["demo", "-o", "mine"]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("contains other files"), "{}", refused.stderr);
}

#[test]
fn completions_and_manuals_are_written() {
    for shell in ["bash", "zsh", "fish"] {
        let script = run(&["completions", shell]).fine().stdout;
        assert!(script.contains("diagnose") && script.contains("next-motion"), "{shell}");
    }
    let folder = scratch("man");
    run(&["man", "-o", text(&folder)]).fine();
    let page = std::fs::read_to_string(folder.join("armident-diagnose.1")).unwrap();
    assert!(page.contains("holdout"));
}
