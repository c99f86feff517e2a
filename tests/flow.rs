//! Who may depend on whom, and what no file may hold.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::shared::project;
use crate::tool::{list, string};

/// The arrows: each crate and the crates of the project it may use (`dev` dependencies aside).
const ARROWS: [(&str, &[&str]); 20] = [
    ("numeric", &[]),
    ("inference", &["numeric"]),
    ("kinematics", &[]),
    ("dynamics", &["kinematics"]),
    ("effects", &["dynamics", "kinematics"]),
    ("recording", &["numeric"]),
    ("motion", &["numeric", "recording"]),
    ("model", &["dynamics", "effects", "kinematics", "motion", "recording"]),
    ("simulation", &["dynamics", "effects", "kinematics", "motion", "recording"]),
    (
        "ident",
        &[
            "dynamics",
            "effects",
            "inference",
            "kinematics",
            "model",
            "motion",
            "numeric",
            "recording",
            "simulation",
        ],
    ),
    ("fleet", &["ident", "inference", "kinematics", "numeric"]),
    (
        "excitation",
        &["dynamics", "effects", "ident", "kinematics", "motion", "numeric", "recording"],
    ),
    (
        "diagnose",
        &[
            "dynamics",
            "effects",
            "ident",
            "inference",
            "kinematics",
            "model",
            "motion",
            "numeric",
            "recording",
        ],
    ),
    (
        "report",
        &[
            "diagnose",
            "dynamics",
            "effects",
            "excitation",
            "fleet",
            "ident",
            "kinematics",
            "model",
            "motion",
        ],
    ),
    ("page", &["effects", "kinematics", "motion", "recording", "report"]),
    (
        "challenge",
        &[
            "diagnose",
            "dynamics",
            "effects",
            "ident",
            "kinematics",
            "model",
            "motion",
            "recording",
            "report",
            "simulation",
        ],
    ),
    ("export", &["dynamics", "effects", "inference", "kinematics", "model", "motion", "recording"]),
    (
        "commands",
        &[
            "diagnose",
            "effects",
            "excitation",
            "export",
            "fleet",
            "ident",
            "kinematics",
            "model",
            "motion",
            "numeric",
            "page",
            "recording",
            "report",
            "simulation",
        ],
    ),
    (
        "python",
        &[
            "commands",
            "effects",
            "excitation",
            "ident",
            "model",
            "page",
            "recording",
            "report",
            "simulation",
        ],
    ),
    (
        "",
        &[
            "challenge",
            "commands",
            "effects",
            "excitation",
            "ident",
            "kinematics",
            "motion",
            "page",
            "recording",
            "report",
            "simulation",
        ],
    ),
];

fn packages() -> Vec<Value> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    list(&metadata["packages"]).to_vec()
}

/// `kinematics` of `armident-kinematics`; the root package is the empty name.
fn short(package: &str) -> Option<&str> {
    Some(package.strip_prefix("armident")?.trim_start_matches('-'))
}

/// Names of the dependencies a package is built with.
fn dependencies(package: &Value) -> impl Iterator<Item = &str> {
    list(&package["dependencies"]).iter().filter(|d| d["kind"] != "dev").map(|d| string(&d["name"]))
}

#[test]
fn crates_depend_in_one_direction() {
    let expected: BTreeMap<&str, BTreeSet<&str>> =
        ARROWS.iter().map(|(name, used)| (*name, used.iter().copied().collect())).collect();
    let packages = packages();
    let found: BTreeMap<&str, BTreeSet<&str>> = packages
        .iter()
        .map(|p| (short(string(&p["name"])).unwrap(), dependencies(p).filter_map(short).collect()))
        .collect();
    assert_eq!(found, expected);
}

/// The table of ARCHITECTURE.md tells the arrows as they are.
#[test]
fn architecture_page_lists_the_arrows() {
    let page = std::fs::read_to_string(project("ARCHITECTURE.md")).unwrap();
    let told: BTreeMap<&str, BTreeSet<&str>> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| `crates/"))
        .map(|row| {
            let (name, rest) = row.split_once('`').unwrap();
            let uses = rest.trim_end_matches('|').rsplit('|').next().unwrap().trim();
            (name, uses.split(", ").filter(|used| *used != "-").collect())
        })
        .collect();
    let expected: BTreeMap<&str, BTreeSet<&str>> = ARROWS
        .iter()
        .filter(|(name, _)| !name.is_empty())
        .map(|(name, used)| (*name, used.iter().copied().collect()))
        .collect();
    assert_eq!(told, expected);
}

/// Dynamic matrices and everything said about ranks are the business of one crate.
#[test]
fn only_numeric_uses_faer() {
    for package in &packages() {
        let name = string(&package["name"]);
        let names_faer = dependencies(package).any(|d| d == "faer");
        assert_eq!(names_faer, name == "armident-numeric", "{name}");
    }
}

#[test]
fn every_crate_has_a_description() {
    for package in &packages() {
        let name = string(&package["name"]);
        let folder = Path::new(string(&package["manifest_path"])).parent().unwrap();
        let lib = folder.join("src/lib.rs");
        let root = if lib.exists() { lib } else { folder.join("src/main.rs") };
        let text = std::fs::read_to_string(&root).unwrap();
        let head: Vec<&str> = text
            .lines()
            .take_while(|line| line.starts_with("//!"))
            .map(|line| line.trim_start_matches("//!").trim())
            .collect();
        let sentence = head.join(" ");
        assert!(
            head.first().is_some_and(|first| first.starts_with(char::is_uppercase))
                && sentence.contains('.'),
            "{name}: {} must start with a sentence that says what it is",
            root.display()
        );
        assert!(string(&package["description"]).ends_with('.') || name == "armident", "{name}");
    }
}

/// Files of the project, without what is built.
fn files(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // `.git` is a file in a second working tree
        if name == "target" || name == ".git" {
            continue;
        }
        if path.is_dir() {
            if !path.is_symlink() {
                files(&path, into);
            }
        } else {
            into.push(path);
        }
    }
}

/// Paths of somebody's machine mean nothing on another.
#[test]
fn files_contain_no_machine_paths() {
    // in pieces, so that this file does not hold them
    let roots = [["/ho", "me/"], ["/ro", "ot/"], ["/wo", "rk/"], ["/Use", "rs/"], [":\\Use", "rs"]]
        .map(|pieces| pieces.concat());
    let mut all = Vec::new();
    files(&project(""), &mut all);
    assert!(all.len() > 50);
    let mut found = Vec::new();
    for path in all {
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        for (k, line) in text.lines().enumerate() {
            for root in &roots {
                // `frame/work/` is no root
                let is_root = line.match_indices(root.as_str()).any(|(at, _)| {
                    !line[..at].ends_with(|c: char| c.is_alphanumeric() || "_-".contains(c))
                });
                if is_root {
                    found.push(format!("{}:{}: {root}", path.display(), k + 1));
                }
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
