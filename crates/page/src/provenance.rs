//! Where a result comes from.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::drawing::{PageInput, Provenance};

impl Provenance {
    /// Of a command line and the files it read; a file that cannot be read any more has no digest.
    pub fn of<'a>(command: Vec<String>, files: impl IntoIterator<Item = &'a Path>) -> Self {
        let input = |path: &Path| {
            let (mut hash, mut length) = (Sha256::new(), 0);
            for bytes in files_of(path).into_iter().filter_map(|file| std::fs::read(file).ok()) {
                length += bytes.len() as u64;
                hash.update(&bytes);
            }
            let digest = hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
            PageInput {
                path: path.display().to_string(),
                bytes: length,
                sha256: if length == 0 { String::new() } else { digest },
            }
        };
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command,
            inputs: files.into_iter().map(input).collect(),
            seed: None,
        }
    }
}

/// The file, or those of a folder (a bag of ROS 2) in the order of their names.
fn files_of(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let entries = std::fs::read_dir(path).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    files
}
