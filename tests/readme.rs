//! The commands of README.md: what it shows is what the program says.

use std::path::Path;

use crate::shared::project;
use crate::tool::scratch;

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        std::fs::copy(from, to).unwrap();
    }
}

/// Runs every ```` ```console ```` block, one after the other in one folder that holds the project's
/// `urdf` and `examples`. `TRYCMD=overwrite cargo test --test acceptance readme` writes the output of
/// today into README.md.
#[test]
fn commands() {
    let readme = project("README.md");
    if !readme.exists() {
        return;
    }
    let folder = scratch("readme");
    copy(&readme, &folder.join("README.md"));
    for given in ["urdf", "examples"] {
        if project(given).exists() {
            copy(&project(given), &folder.join("README.in").join(given));
        }
    }
    // its presence makes the commands share a folder they may write to
    std::fs::create_dir_all(folder.join("README.out")).unwrap();
    trycmd::TestCases::new()
        .register_bin("armident", Path::new(env!("CARGO_BIN_EXE_armident")))
        .case(folder.join("README.md"))
        .run();
    if std::env::var_os("TRYCMD").is_some_and(|wish| wish == "overwrite") {
        copy(&folder.join("README.md"), &readme);
    }
}
