//! MCAP and Parquet: files of other writers, round trips, damaged files.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::path::{Path, PathBuf};

use armident_recording::{
    Format as _, JointChannels, Parquet, ReadSettings, Recording, read_recording,
};

fn judge(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges").join(name)
}

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("formats");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn read(path: &Path) -> Result<Recording, String> {
    read_with(path, &ReadSettings::default())
}

fn read_with(path: &Path, settings: &ReadSettings<'_>) -> Result<Recording, String> {
    read_recording(path, settings).map_err(|error| {
        let hint = error.hint().unwrap_or_default();
        format!("{error}\n{}\n{hint}", error.place().replace(&path.display().to_string(), "FILE"))
    })
}

/// A recording with every kind of number in it.
fn recording(start_s: f64) -> Recording {
    let n = 500;
    let time: Vec<f64> = (0..n).map(|k| start_s + 0.002 * f64::from(k)).collect();
    let column = |f: &dyn Fn(f64) -> f64| Some(time.iter().map(|t| f(*t)).collect::<Vec<f64>>());
    let joints = vec![
        JointChannels {
            position: column(&f64::sin),
            velocity: column(&f64::cos),
            effort: column(&|t| 1e-17 * t),
            ..JointChannels::new("left/arm/elbow")
        },
        JointChannels {
            position: column(&|t| -t),
            effort: column(&|_| -0.0),
            ..JointChannels::new("wrist 2")
        },
    ];
    Recording::new("test", time, joints).unwrap()
}

/// Position and effort of shoulder and elbow, as `formats.py` makes them.
#[cfg(any(feature = "mcap", feature = "parquet"))]
fn sample(k: usize) -> ([f64; 2], [f64; 2]) {
    let t = k as f64 * 0.005;
    ([t.sin(), (2.0 * t).cos()], [3.0 * t, -0.5])
}

#[cfg(feature = "mcap")]
mod mcap {
    use super::*;
    use armident_recording::{Mapping, Mcap};

    #[test]
    fn file_of_another_writer_is_read() {
        let found = read(&judge("joint_states.mcap")).unwrap();
        assert_eq!(found.joint_names(), ["shoulder", "elbow"]);
        assert_eq!(found.len(), 120);
        for k in 0..120 {
            assert!((found.time_s[k] - 0.25 - 0.005 * k as f64).abs() < 1e-12);
            let (position, effort) = sample(k);
            for (j, name) in ["shoulder", "elbow"].into_iter().enumerate() {
                let joint = found.joint(name).unwrap();
                let near =
                    |a: &Option<Vec<f64>>, b: f64| (a.as_ref().unwrap()[k] - b).abs() < 1e-15;
                assert!(near(&joint.position, position[j]) && near(&joint.effort, effort[j]));
                assert!(joint.velocity.is_some() && joint.acceleration.is_none());
            }
        }
        let notes = found.notes.join("\n");
        for said in [
            "joint states of the topic /joint_states",
            "ignored messages with other joints: 12 with finger",
            "time origin: 1700000000 s",
            "ignored topics: /chatter (std_msgs/msg/String)",
        ] {
            assert!(notes.contains(said), "{said}\n{notes}");
        }
    }

    #[test]
    fn round_trips_keep_every_sample() {
        for start_s in [0.0, 12.5, -3.25] {
            let before = recording(start_s);
            let encoded = Mcap.write(&before).unwrap();
            assert!(encoded.omitted.is_empty());
            let path = scratch("round_trip.mcap");
            std::fs::write(&path, &encoded.bytes).unwrap();
            let after = read(&path).unwrap();
            assert_eq!(after.joint_names(), before.joint_names());
            let shift = if start_s < 0.0 { 4.0 } else { 0.0 };
            for (a, b) in after.time_s.iter().zip(&before.time_s) {
                // ROS counts nanoseconds
                assert!((a - b - shift).abs() <= 0.5e-9 + 1e-15, "{a} {b}");
            }
            for (a, b) in after.joints.iter().zip(&before.joints) {
                assert_eq!(a.position, b.position);
                assert_eq!(a.velocity, b.velocity);
                assert_eq!(a.effort, b.effort);
            }
        }
    }

    #[test]
    fn write_omits_channels_without_field() {
        let mut recording = recording(0.0);
        recording.joints[1].acceleration = Some(vec![0.0; recording.len()]);
        let encoded = Mcap.write(&recording).unwrap();
        assert_eq!(encoded.omitted, ["wrist 2/acceleration"]);
    }

    #[test]
    fn mapped_columns_have_the_topic() {
        let text = "[time]\ncolumn = \"__time\"\n[[channel]]\ncolumn = \
                    \"/joint_states/{joint}/position\"\nquantity = \"position\"\nunit = \
                    \"deg\"\n[[channel]]\ncolumn = \"/joint_states/{joint}/effort\"\nquantity = \
                    \"effort\"\n";
        let mapping = Mapping::parse(text, "test.toml").unwrap();
        let settings = ReadSettings { mapping: Some(&mapping), topic: None };
        let found = read_with(&judge("joint_states.mcap"), &settings).unwrap();
        let position = found.joint("elbow").unwrap().position.as_ref().unwrap();
        assert!((position[0] - 1.0_f64.to_radians()).abs() < 1e-15);
    }

    /// A bag as the recorder leaves it, in pieces of 200 samples.
    fn split_bag(name: &str, compression: &str) -> PathBuf {
        let (whole, folder) = (recording(0.0), scratch(name));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let mut list = String::new();
        for (k, rows) in [0..200, 200..400, 400..500].into_iter().enumerate() {
            let joints = (whole.joints.iter())
                .map(|joint| JointChannels {
                    position: joint.position.as_ref().map(|values| values[rows.clone()].to_vec()),
                    velocity: joint.velocity.as_ref().map(|values| values[rows.clone()].to_vec()),
                    effort: joint.effort.as_ref().map(|values| values[rows.clone()].to_vec()),
                    ..JointChannels::new(&joint.name)
                })
                .collect();
            let piece = Recording::new("piece", whole.time_s[rows].to_vec(), joints).unwrap();
            let file = format!("run_{k}.mcap");
            std::fs::write(folder.join(&file), Mcap.write(&piece).unwrap().bytes).unwrap();
            list += &format!("    - {file}\n");
        }
        let metadata = format!(
            "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n  message_count: 500\n  \
             topics_with_message_count:\n    - topic_metadata:\n        name: /joint_states\n        type: \
             sensor_msgs/msg/JointState\n        serialization_format: cdr\n      message_count: 500\n  \
             compression_format: zstd\n  compression_mode: {compression}\n  relative_file_paths:\n{list}  files:\n    - \
             path: run_0.mcap\n  ros_distro: jazzy\n"
        );
        std::fs::write(folder.join("metadata.yaml"), metadata).unwrap();
        folder
    }

    #[test]
    fn split_bags_are_one_recording() {
        let (folder, whole) = (split_bag("split", "NONE"), recording(0.0));
        for path in [folder.clone(), folder.join("metadata.yaml")] {
            let found = read(&path).unwrap();
            assert_eq!(found.len(), 500);
            assert_eq!(found.joints, whole.joints);
            assert!(found.notes.contains(&"3 files of the bag, one after the other".to_owned()));
        }
        let alone = read(&folder.join("run_1.mcap")).unwrap();
        assert_eq!(alone.len(), 200);
        let note = "file 2 of 3 of a bag; `split` as a whole is one recording";
        assert!(alone.notes.contains(&note.to_owned()), "{:?}", alone.notes);
    }

    #[test]
    fn split_bags_are_read_without_lost_pieces() {
        let folder = split_bag("split_lost", "NONE");
        std::fs::remove_file(folder.join("run_1.mcap")).unwrap();
        let last = std::fs::read(folder.join("run_2.mcap")).unwrap();
        std::fs::write(folder.join("run_2.mcap"), &last[..50]).unwrap();
        let found = read(&folder).unwrap();
        assert_eq!(found.len(), 200);
        let notes = found.notes.join("\n");
        for message in
            ["truncated file (run_2.mcap: ", "1 of 3 files of the bag are missing: run_1.mcap"]
        {
            assert!(notes.contains(message), "{message}\n{notes}");
        }
    }

    #[test]
    fn bags_that_cannot_be_read_are_refused() {
        let mut message = String::new();
        let folder = split_bag("split_compressed", "MESSAGE");
        message += &read(&folder).unwrap_err();
        let folder = split_bag("split_empty", "NONE");
        for k in 0..3 {
            std::fs::remove_file(folder.join(format!("run_{k}.mcap"))).unwrap();
        }
        message += &format!("\n\n{}", read(&folder).unwrap_err());
        std::fs::write(
            folder.join("metadata.yaml"),
            "rosbag2_bagfile_information:\n  version: 9\n",
        )
        .unwrap();
        message += &format!("\n\n{}", read(&folder).unwrap_err());
        let folder = split_bag("split_other", "NONE");
        std::fs::write(folder.join("run_1.mcap"), "t,a/position\n").unwrap();
        for k in [0, 2] {
            std::fs::remove_file(folder.join(format!("run_{k}.mcap"))).unwrap();
        }
        message += &format!("\n\n{}", read(&folder).unwrap_err());
        insta::assert_snapshot!(message);
    }

    #[test]
    fn unknown_topic_is_refused_with_known_ones() {
        let settings = ReadSettings { mapping: None, topic: Some("/left/joint_states") };
        let said = read_with(&judge("joint_states.mcap"), &settings).unwrap_err();
        assert_eq!(
            said,
            "topic `/left/joint_states` has no sensor_msgs/JointState messages\nFILE\ntopics with \
             joint states: `/joint_states`"
        );
    }

    /// Truncated files are read up to their end; damaged files never make the reader panic.
    #[test]
    fn damaged_files_do_not_panic() {
        let whole = {
            // many chunks, so that some are whole
            let long = recording(0.0);
            Mcap.write(&long).unwrap().bytes
        };
        let path = scratch("broken.mcap");
        std::fs::write(&path, &whole[..whole.len() - 40]).unwrap();
        let found = read(&path).unwrap();
        assert_eq!(found.len(), 500);
        let note = found.notes.iter().find(|n| n.contains("truncated file"));
        assert!(note.is_some(), "{:?}", found.notes);
        std::fs::write(&path, &whole[..60]).unwrap();
        let said = read(&path).unwrap_err();
        assert!(said.starts_with("truncated or corrupt MCAP file: "), "{said}");

        let judge = std::fs::read(judge("joint_states.mcap")).unwrap();
        for at in (8..judge.len()).step_by(7) {
            let mut damaged = judge.clone();
            damaged[at] ^= 0x55;
            std::fs::write(&path, &damaged).unwrap();
            // refused or read, but in words
            if let Err(said) = read(&path) {
                assert!(!said.is_empty());
            }
        }
    }
}

#[cfg(feature = "parquet")]
mod parquet {
    use super::*;

    #[test]
    fn file_of_another_writer_is_read() {
        let found = read(&judge("joint_states.parquet")).unwrap();
        assert_eq!(found.joint_names(), ["shoulder", "elbow"]);
        assert_eq!(found.ignored_columns, ["remark"]);
        for k in 0..120 {
            assert!((found.time_s[k] - 0.25 - 0.005 * k as f64).abs() < 3e-7);
            let (position, effort) = sample(k);
            let [shoulder, elbow] = ["shoulder", "elbow"].map(|name| found.joint(name).unwrap());
            assert!((shoulder.position.as_ref().unwrap()[k] - position[0]).abs() < 1e-15);
            assert!((elbow.position.as_ref().unwrap()[k] - position[1]).abs() < 1e-7);
            // the empty value is interpolated
            let tolerance = if k == 7 { 1e-6 } else { 1e-15 };
            assert!((shoulder.effort.as_ref().unwrap()[k] - effort[0]).abs() < tolerance);
        }
        assert_eq!(found.findings.len(), 1, "{:?}", found.findings);
    }

    #[test]
    fn decimals_are_scaled() {
        let found = read(&judge("decimals.parquet")).unwrap();
        let shoulder = found.joint("shoulder").unwrap();
        for k in 0..120 {
            assert!((found.time_s[k] - 0.005 * k as f64).abs() < 1e-12);
            let (position, effort) = sample(k);
            assert!((shoulder.position.as_ref().unwrap()[k] - position[0]).abs() < 0.51e-7);
            assert!((shoulder.effort.as_ref().unwrap()[k] - effort[0]).abs() < 0.51e-12);
        }
    }

    #[test]
    fn episodes_of_a_dataset_are_read() {
        let path = judge("lerobot/data/chunk-000/file-000.parquet");
        let joints = ["shoulder", "elbow"].map(str::to_owned);
        let found = armident_recording::inspect(&path, &ReadSettings::default(), &joints).unwrap();
        assert!(found.recording.is_err() && found.guess.unsure.is_empty(), "{:?}", found.guess);
        let found = found.guessed.unwrap();
        assert_eq!(found.joint_names(), joints);
        assert_eq!(found.notes[0], "2 episodes, one after the other with pauses of 1 s");
        for k in 0..120 {
            let pause = if k < 60 { 0.0 } else { 0.995 };
            assert!((found.time_s[k] - 0.005 * k as f64 - pause).abs() < 1e-6);
            let (position, effort) = sample(k);
            for (j, joint) in found.joints.iter().enumerate() {
                let near =
                    |a: &Option<Vec<f64>>, b: f64| (a.as_ref().unwrap()[k] - b).abs() < 1e-15;
                assert!(near(&joint.position, position[j]) && near(&joint.effort, effort[j]));
            }
        }
    }

    #[test]
    fn round_trips_keep_every_bit() {
        for start_s in [0.0, -3.25] {
            let before = recording(start_s);
            let path = scratch("round_trip.parquet");
            std::fs::write(&path, Parquet.write(&before).unwrap().bytes).unwrap();
            let after = read(&path).unwrap();
            assert_eq!(after.time_s, before.time_s);
            assert_eq!(after.joints, before.joints);
        }
    }

    #[test]
    fn damaged_files_do_not_panic() {
        let whole = Parquet.write(&recording(0.0)).unwrap().bytes;
        let path = scratch("broken.parquet");
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let said = read(&path).unwrap_err();
        assert!(said.starts_with("truncated or corrupt Parquet file: "), "{said}");
    }
}

/// Recognised formats are refused with a converter.
#[test]
fn unread_formats_name_a_converter() {
    let mut said = String::new();
    // with all formats these two are read, and are cut off here
    for (name, start) in [
        ("log.h5", &b"\x89HDF\r\n\x1a\n"[..]),
        ("log73.mat", b"MATLAB 7.3 MAT-file, Platform: GLNXA64"),
        ("log.npy", b"\x93NUMPY\x01\0"),
        ("log.xlsx", b"PK\x03\x04"),
    ] {
        let path = scratch(name);
        std::fs::write(&path, start).unwrap();
        said += &format!("{}\n\n", read(&path).unwrap_err().replace("FILE", name));
    }
    let suffix = if cfg!(feature = "all-formats") { "all" } else { "default" };
    insta::with_settings!({ snapshot_suffix => suffix }, {
        insta::assert_snapshot!(said);
    });
}

#[cfg(not(feature = "mcap"))]
#[test]
fn mcap_without_feature_names_the_feature() {
    let said = read(&judge("joint_states.mcap")).unwrap_err();
    assert!(said.contains("--features mcap"), "{said}");
}

#[cfg(not(feature = "all-formats"))]
#[test]
fn bags_without_feature_name_the_feature() {
    for (name, format) in [("bag.db3", "ROS 2 bag (SQLite)"), ("bz2.bag", "ROS 1 bag")] {
        let said = read(&judge(name)).unwrap_err();
        assert!(said.starts_with(&format!("{format} is not supported by this build")), "{said}");
        assert!(said.contains("--features all-formats"), "{said}");
    }
}

#[cfg(not(feature = "parquet"))]
#[test]
fn parquet_without_feature_names_the_feature() {
    let said = read(&judge("joint_states.parquet")).unwrap_err();
    assert_eq!(
        said,
        "Parquet is not supported by this build\nFILE\nbuild armident with `--features parquet`, or \
         export CSV"
    );
    assert!(Parquet.write(&recording(0.0)).is_err());
}
