//! Small reproductions of what users reported (the shared data; `expected.md` of each folder says what is right).

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::shared::shared;

/// What `check.sh` of a folder says about the program; none where it passes.
fn failure(folder: &Path) -> Option<String> {
    let checked = Command::new("bash")
        .args(["check.sh", env!("CARGO_BIN_EXE_armident")])
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&checked.stdout);
    let name = folder.file_name().unwrap().to_string_lossy();
    (!checked.status.success()).then(|| format!("{name}: {}", said.trim()))
}

#[test]
fn reported_reproductions_pass() {
    let Some(field) = shared("field", "field") else { return };
    let entries = std::fs::read_dir(field).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<PathBuf> = entries.filter(|path| path.join("check.sh").exists()).collect();
    folders.sort();
    assert!(!folders.is_empty());
    let failed: Vec<String> = folders.iter().filter_map(|folder| failure(folder)).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
