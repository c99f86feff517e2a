//! Where a result comes from.

use std::path::Path;

use sha2::{Digest, Sha256};

use crate::drawing::{PageInput, Provenance};

impl Provenance {
    /// Of a command line and the files it read; a file that cannot be read any more has no digest.
    pub fn of<'a>(command: Vec<String>, files: impl IntoIterator<Item = &'a Path>) -> Self {
        let input = |path: &Path| {
            let bytes = std::fs::read(path).unwrap_or_default();
            let digest = if bytes.is_empty() {
                String::new()
            } else {
                Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect()
            };
            PageInput {
                path: path.display().to_string(),
                bytes: bytes.len() as u64,
                sha256: digest,
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
