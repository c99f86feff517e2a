//! URDFs of real arms are read, or refused with a reason.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use armident_kinematics::load_urdf;
use shared::shared;

#[path = "../../../tests/shared.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "a test file: each binary uses its part")]
mod shared;

/// The corpus of real arms, where it is at hand.
#[test]
fn reads_urdfs_of_real_arms() {
    let Some(folder) = shared("real_arms_are_read", "urdf-corpus") else { return };
    let entries = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "urdf"));
    paths.sort();
    assert!(!paths.is_empty());
    for path in &paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        match load_urdf(path) {
            Ok(robot) => {
                assert!(!robot.links.is_empty(), "{name}");
                for warning in &robot.warnings {
                    println!("{name}: {warning}");
                }
            }
            Err(error) => {
                assert!(!error.to_string().is_empty() && !error.place().is_empty(), "{name}");
                eprintln!(
                    "refused: {name}\nerror: {error}\nin: {}\nhint: {:?}",
                    error.place(),
                    error.hint()
                );
            }
        }
    }
}
