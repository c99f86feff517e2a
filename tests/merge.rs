//! States of recordings: reduced one by one, merged in any order, continued after an interruption.

use crate::shared::project;
use crate::tool::{list, number, read_json, run_in, scratch, string, text};

#[test]
fn merged_states_identify_the_arm() {
    let folder = scratch("merge");
    let urdf = project("urdf/ur5.urdf");
    std::fs::create_dir_all(folder.join("logs")).unwrap();
    for name in ["train", "holdout"] {
        let from = project(&format!("examples/ur5/{name}.csv"));
        std::fs::copy(from, folder.join(format!("logs/{name}.csv"))).unwrap();
    }
    // one that is cut off in its header, and one of another robot
    std::fs::write(folder.join("logs/broken.csv"), "t,shoulder_pan").unwrap();
    let other = "t,elbow/position,elbow/effort\n0,0,0\n0.01,0,0\n0.02,0,0\n";
    std::fs::write(folder.join("logs/other.csv"), other).unwrap();
    let accumulate = |files: &[&str], out: &str| {
        let args = [&["accumulate", text(&urdf)], files, &["-o", out, "--json", "-"]].concat();
        run_in(&folder, &args).fine().json()
    };
    let whole = accumulate(&["logs"], "whole.jsonl");
    assert_eq!(list(&whole["reduced"]).len(), 2, "{whole}");
    let aside: Vec<&str> = list(&whole["set_aside"]).iter().map(|s| string(&s["file"])).collect();
    assert_eq!(aside, ["logs/broken.csv", "logs/other.csv"]);
    for set_aside in list(&whole["set_aside"]) {
        assert!(!string(&set_aside["reason"]).is_empty());
    }

    let merge = |states: &[&str]| {
        let args =
            [&["merge", text(&urdf)], states, &["--json", "-", "--save-model", "m.json"]].concat();
        run_in(&folder, &args).fine().json()
    };
    let merged = merge(&["whole.jsonl"]);
    assert_eq!(merged["recordings"], 2);
    for joint in list(&merged["joints"]) {
        assert!(number(&joint["rmse"]) < 0.2 * number(&joint["given_rmse"]), "{joint}");
    }
    assert_eq!(read_json(&folder.join("m.json"))["schema"], "armident.model/2");

    // the same recordings in two files, in the other order, one of them twice
    accumulate(&["logs/train.csv"], "one.jsonl");
    accumulate(&["logs/holdout.csv"], "two.jsonl");
    let parts = merge(&["two.jsonl", "one.jsonl", "two.jsonl"]);
    assert_eq!(parts["recordings"], 2);
    for (a, b) in list(&merged["parameters"]).iter().zip(list(&parts["parameters"])) {
        let (a, b) = (number(&a["value"]), number(&b["value"]));
        assert!((a - b).abs() < 1e-9 * (1.0 + a.abs()), "{a} {b}");
    }

    // an interrupted run: its last line is cut off, the next run reads that recording again
    let states = std::fs::read_to_string(folder.join("whole.jsonl")).unwrap();
    std::fs::write(folder.join("cut.jsonl"), &states[..states.len() - 1000]).unwrap();
    let again = accumulate(&["logs"], "cut.jsonl");
    assert_eq!((list(&again["reduced"]).len(), list(&again["already_there"]).len()), (1, 1));
    let cut = merge(&["cut.jsonl"]);
    assert_eq!((cut["recordings"].clone(), list(&cut["set_aside"]).len()), (2.into(), 1));

    // states in the folder of the recordings are no recording of the next run
    assert_eq!(list(&accumulate(&["logs"], "logs/states.csv")["reduced"]).len(), 2);
    assert_eq!(list(&accumulate(&["logs"], "logs/states.csv")["already_there"]).len(), 2);

    // states of another arm
    let ur10 = project("urdf/ur10.urdf");
    let ran = run_in(&folder, &["merge", text(&ur10), "whole.jsonl"]);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("the state is of another arm"), "{}", ran.stderr);
    let args = ["accumulate", text(&urdf), "logs", "-o", "whole.jsonl", "--cutoff-hz", "4"];
    let ran = run_in(&folder, &args);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("cut-off 5 Hz, expected 4 Hz"), "{}", ran.stderr);
}
