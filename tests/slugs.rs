//! Laws are named in `effects` alone: elsewhere code asks for their properties, or for a law by its type.

use std::fs;
use std::path::{Path, PathBuf};

use armident_effects::{Effect, Library, UNMODELLED};

use crate::shared::project;

/// Sources where a string that is also a slug stands for something else, with the string.
const OTHER_MEANINGS: [(&str, &str); 2] = [
    // the argument of Isaac Lab's actuators
    ("crates/export/src/isaac_lab.rs", "viscous_friction"),
    // the key of the model file
    ("crates/model/src/file.rs", "encoder_offset"),
];

/// Rust sources below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// The lines of a source before its tests, without comments; a file of tests alone has none.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let code = code.split("#[cfg(test)]\n#[allow").next().unwrap_or_default();
    let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.enumerate().map(|(k, line)| (k + 1, line))
}

#[test]
fn slugs_stand_in_effects_only() {
    let slugs: Vec<&str> =
        Library::standard().all().map(Effect::slug).chain([UNMODELLED]).collect();
    let mut files = Vec::new();
    sources(&project("src"), &mut files);
    for entry in fs::read_dir(project("crates")).unwrap() {
        let path = entry.unwrap().path();
        if !path.ends_with("effects") {
            sources(&path.join("src"), &mut files);
        }
    }
    let root = project("");
    let mut found = Vec::new();
    for path in files {
        let name = path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
        // modules that are compiled for tests only
        if name.ends_with("/test_arms.rs") || name.ends_with("/bad_inputs.rs") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        for (number, line) in code(&text) {
            for slug in &slugs {
                let is_other =
                    OTHER_MEANINGS.iter().any(|(file, key)| *file == name && key == slug);
                if !is_other && line.contains(&format!("\"{slug}\"")) {
                    found.push(format!("{name}:{number} \"{slug}\""));
                }
            }
        }
    }
    found.sort();
    assert!(found.is_empty(), "ask for a property of the law instead:\n{}", found.join("\n"));
}
