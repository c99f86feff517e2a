//! `armident diagnose`: what was concealed is named, where it is, and nothing else is.

mod change;
mod inputs;
mod model;
mod naming;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::shared::project;
use crate::tool::UR5_JOINTS as JOINTS;
use crate::tool::{Run, list, number, run, run_in, scratch, string, text};

fn urdf() -> PathBuf {
    project("urdf/ur5.urdf")
}

/// Simulates the UR5 of `urdf/` along a trajectory, with effort noise of 0.1 N m.
fn simulate(trajectory: &Path, to: &Path, seed: &str, effects: &[&str]) {
    let urdf = urdf();
    let mut args = vec!["simulate", text(&urdf), text(trajectory), "-o", text(to), "-q"];
    args.extend(["--torque-noise", "0.1", "--encoder-bits", "19", "--seed", seed]);
    args.extend(effects.iter().flat_map(|effect| ["--effect", effect]));
    run(&args).fine();
}

/// A folder with `train.csv` and `holdout.csv` of an arm with these effects.
fn recordings(test: &str, effects: &[&str]) -> PathBuf {
    let folder = scratch(test);
    for (k, name) in ["train", "holdout"].iter().enumerate() {
        let trajectory = project(&format!("examples/ur5/{name}.csv"));
        simulate(&trajectory, &folder.join(format!("{name}.csv")), &k.to_string(), effects);
    }
    folder
}

/// Runs the diagnosis of `train.csv` in a folder, with more arguments.
fn diagnose(folder: &Path, more: &[&str]) -> Run {
    let urdf = urdf();
    let args = ["diagnose", text(&urdf), "train.csv", "-q", "--json", "-"];
    run_in(folder, &[&args, more].concat())
}

/// The diagnosis with the hold-out.
fn diagnosed(folder: &Path) -> Value {
    diagnose(folder, &["--holdout", "holdout.csv"]).fine().json()
}

/// Effect and joints of each finding.
fn named(diagnosis: &Value) -> BTreeSet<(String, String)> {
    list(&diagnosis["findings"])
        .iter()
        .map(|f| {
            let joints: Vec<&str> = list(&f["joints"]).iter().map(string).collect();
            (string(&f["effect"]).to_owned(), joints.join(" "))
        })
        .collect()
}

fn pairs(expected: &[(&str, &str)]) -> BTreeSet<(String, String)> {
    expected.iter().map(|(effect, joint)| ((*effect).to_owned(), (*joint).to_owned())).collect()
}

fn holdout_error(diagnosis: &Value, of: &str, joint: &str) -> f64 {
    number(&diagnosis["fit"]["holdout"][of][joint])
}

/// A copy of `train.csv` with every row changed, or left out.
fn changed(folder: &Path, to: &str, change: impl Fn(&[&str], &[String]) -> Option<Vec<String>>) {
    let recorded = std::fs::read_to_string(folder.join("train.csv")).unwrap();
    let mut lines = recorded.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut content = header.join(",") + "\n";
    for line in lines {
        let row: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Some(row) = change(&header, &row) {
            content += &(row.join(",") + "\n");
        }
    }
    std::fs::write(folder.join(to), content).unwrap();
}

/// The row with the columns whose names end like this set to one number.
fn set(header: &[&str], row: &[String], ending: &str, to: &str) -> Vec<String> {
    let of = header.iter().zip(row);
    of.map(|(h, x)| if h.ends_with(ending) { to.to_owned() } else { x.clone() }).collect()
}
