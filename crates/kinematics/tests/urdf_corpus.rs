//! URDFs of real arms are read, or refused with a reason.

use armident_kinematics::load_urdf;

/// The corpus of real arms, where it is at hand.
#[test]
fn real_arms_are_read() {
    let shared = std::env::var_os("ARMIDENT_SHARED").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        std::path::PathBuf::from,
    );
    let Ok(entries) = std::fs::read_dir(shared.join("urdf-corpus")) else {
        println!("skipped: shared data not found");
        return;
    };
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
