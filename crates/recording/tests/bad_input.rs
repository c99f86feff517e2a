//! Text instead of numbers, joints that differ in number, and missing values, in each format: the messages. The files are
//! beside `judges/bad.py`, which wrote them.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use armident_recording::{Mapping, ReadSettings, inspect, read_recording};
use proptest::prelude::*;

fn judges() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges")
}

/// Error with place and hint, or what a recording notes; by the guessed mapping where the names are no standard ones.
fn message(path: &Path) -> String {
    let settings = ReadSettings::default();
    let found = inspect(path, &settings, &[]);
    let read = found.and_then(|found| match found.recording {
        Ok(recording) => Ok(recording),
        Err(_) if !found.guess.channels.is_empty() => {
            let mapping = Mapping::parse(&found.guess.to_toml(), "guess.toml")?;
            read_recording(path, &ReadSettings { mapping: Some(&mapping), topic: None })
        }
        Err(error) => Err(error),
    });
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let text = match read {
        Ok(recording) => format!(
            "read, {} samples; {}; ignored: {}",
            recording.len(),
            recording.notes.join("; "),
            recording.ignored_columns.join(", ")
        ),
        Err(error) => {
            format!(
                "{error}\n   in: {}\n hint: {}",
                error.place(),
                error.hint().unwrap_or_default()
            )
        }
    };
    text.replace(&path.display().to_string(), &name)
}

#[test]
fn messages_on_wrong_content() {
    let mut files: Vec<PathBuf> = std::fs::read_dir(judges().join("bad"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert_eq!(files.len(), 21);
    let mut text = String::new();
    for file in &files {
        let name = file.file_name().unwrap().to_string_lossy();
        let _ = writeln!(text, "{name}: {}\n", message(file));
    }
    let suffix = if cfg!(feature = "all-formats") {
        "all"
    } else if cfg!(feature = "mcap") {
        "mcap"
    } else {
        "default"
    };
    insta::with_settings!({ snapshot_suffix => suffix }, { insta::assert_snapshot!(text); });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Refused or read, but without a panic: any bytes instead of some.
    #[test]
    fn corrupted_files_do_not_panic(
        file in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        length in 0.2_f64..1.3,
    ) {
        let names = [
            "joint_states.mcap", "joint_states.parquet", "bad/npz_nan.npz", "bad/mat_nan.mat", "bad/hdf5_nan.h5",
            "bad/parquet_ragged.parquet", "bad/sage_nan.csv", "bad/echo_nan.csv", "bad/mcap_ragged.mcap",
        ];
        let name = names[file.index(names.len())];
        let mut bytes = std::fs::read(judges().join(name)).unwrap();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        bytes.truncate((length * bytes.len() as f64) as usize);
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bad_input");
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join(Path::new(name).file_name().unwrap());
        std::fs::write(&path, &bytes).unwrap();
        if let Err(error) = inspect(&path, &ReadSettings::default(), &[]) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
