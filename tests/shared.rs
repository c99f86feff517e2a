//! Data that lies beside the project and may be absent: `../shared`, or where `ARMIDENT_SHARED` says.

use std::io::Write;
use std::path::{Path, PathBuf};

/// The shared folder's entry, or `None` after saying (past the capture of test output) and
/// recording that `test` is skipped.
pub(crate) fn shared(test: &str, entry: &str) -> Option<PathBuf> {
    let beside = || {
        // the tests of the crates use this file too: the project's neighbour is two folders up
        let mut above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().skip(1).take(3);
        above.find_map(|folder| {
            let shared = folder.join("shared");
            shared.is_dir().then_some(shared)
        })
    };
    let given = std::env::var_os("ARMIDENT_SHARED").map(PathBuf::from);
    let root = given.or_else(beside).unwrap_or_default();
    let path = root.join(entry);
    if !root.as_os_str().is_empty() && path.exists() {
        return Some(path);
    }
    skipped(test, &format!("{entry} not found beside the project (ARMIDENT_SHARED)"));
    None
}

/// Says past the capture of test output that `test` is skipped, and counts it for `.ci/run`.
pub(crate) fn skipped(test: &str, why: &str) {
    let line = format!("skipped: {test}: {why}\n");
    let _ = std::io::stderr().write_all(line.as_bytes());
    let counted = Path::new(env!("CARGO_TARGET_TMPDIR")).join("skipped.txt");
    if let Ok(mut file) = std::fs::OpenOptions::new().create(true).append(true).open(counted) {
        let _ = file.write_all(line.as_bytes());
    }
}

/// A file of the project.
pub(crate) fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The URDFs in a folder, in the order of their names.
pub(crate) fn urdfs(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "urdf"))
        .collect();
    paths.sort();
    assert!(!paths.is_empty(), "{}", folder.display());
    paths
}
