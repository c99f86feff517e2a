//! The list of files of a bag of ROS 2, `metadata.yaml`.
//!
//! Of the metadata only the list of files and the compression are read, line by line, rather than by a parser of YAML: the
//! recorder writes them in one layout. Source: rosbag2, metadata of version 1 to 9.
#![cfg_attr(not(feature = "mcap"), allow(dead_code, reason = "without the feature no bag is read"))]

use std::path::{Path, PathBuf};

/// Name of the list of files.
pub(super) const METADATA: &str = "metadata.yaml";

/// A note on a file that is one of several of a bag.
pub(super) fn part_note(file: &Path) -> Option<String> {
    let folder = file.parent()?;
    let text = std::fs::read_to_string(folder.join(METADATA)).ok()?;
    let files = Metadata::of(&text).files;
    let place = files.iter().position(|other| other.file_name() == file.file_name())?;
    let (number, count) = (place + 1, files.len());
    let whole = match folder.file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        None => "its folder".to_owned(),
    };
    (count > 1).then(|| {
        format!("file {number} of {count} of a bag; `{whole}` as a whole is one recording")
    })
}

/// What is read of `metadata.yaml`.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Metadata {
    pub(super) files: Vec<PathBuf>,
    /// of files or messages, in words
    pub(super) compression: Option<String>,
}

impl Metadata {
    pub(super) fn of(text: &str) -> Self {
        let mut found = Self::default();
        let (mut mode, mut format) = (String::new(), String::new());
        let mut is_in_list = false;
        for line in text.lines().map(str::trim) {
            if let (true, Some(file)) = (is_in_list, line.strip_prefix("- ")) {
                found.files.extend(file_of(file));
                continue;
            }
            is_in_list = is_in_list && line.is_empty();
            let Some((key, value)) = line.split_once(':') else { continue };
            match key {
                "relative_file_paths" => {
                    is_in_list = true;
                    let list = value.trim().trim_start_matches('[').trim_end_matches(']');
                    found.files.extend(list.split(',').filter_map(file_of));
                }
                "compression_mode" => mode = unquoted(value).to_lowercase(),
                "compression_format" => unquoted(value).clone_into(&mut format),
                _ => {}
            }
        }
        if !matches!(mode.as_str(), "" | "none") && !format.is_empty() {
            found.compression = Some(format!("{format}, by {mode}"));
        }
        found
    }
}

fn file_of(text: &str) -> Option<PathBuf> {
    let name = unquoted(text);
    (!name.is_empty()).then(|| PathBuf::from(name))
}

fn unquoted(text: &str) -> &str {
    text.trim().trim_matches(['"', '\''])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        Metadata::of(text).files.iter().map(|file| file.display().to_string()).collect()
    }

    #[test]
    fn lists_of_files_are_read_in_all_layouts() {
        let indented = "rosbag2_bagfile_information:\n  version: 5\n  compression_mode: \"\"\n  relative_file_paths:\n    - run_0.db3\n    - \"run 1.db3\"\n  files:\n    - path: run_0.db3\n";
        assert_eq!(names(indented), ["run_0.db3", "run 1.db3"]);
        let flush = "  relative_file_paths:\n  - a.mcap\n  - b.mcap\n  ros_distro: jazzy\n";
        assert_eq!(names(flush), ["a.mcap", "b.mcap"]);
        assert_eq!(names("relative_file_paths: [a.mcap, 'b.mcap']\n"), ["a.mcap", "b.mcap"]);
        assert_eq!(names("relative_file_paths: []\n"), [""; 0]);
    }

    #[test]
    fn compression_is_known() {
        let of = |text: &str| Metadata::of(text).compression;
        assert_eq!(of("  compression_format: \"\"\n  compression_mode: \"\"\n"), None);
        assert_eq!(of("  compression_format: zstd\n  compression_mode: NONE\n"), None);
        let found = of("  compression_format: zstd\n  compression_mode: FILE\n");
        assert_eq!(found.as_deref(), Some("zstd, by file"));
    }
}
