//! One recording in the files of NumPy, SciPy and rosbags gives the same numbers; damaged files never make a reader panic.
//!
//! The files beside `judges/others.py` are always read. Where a Python with its packages is found (`ARMIDENT_PEERS_PYTHON`, or
//! the folder `peers` in the target folder, which `.ci/run` makes), all files that it writes are.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

#[allow(dead_code, reason = "the tests of the program use the rest")]
#[path = "../../../tests/shared.rs"]
mod shared;

use std::path::{Path, PathBuf};
#[cfg(feature = "all-formats")]
use std::process::Command;

use armident_recording::{
    Format as _, JointChannels, Mapping, Npz, ReadSettings, Recording, inspect, read_recording,
};
use proptest::prelude::*;

const SAMPLES: usize = 60;

fn judge(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges").join(name)
}

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("others");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

/// Positions, velocities and efforts of shoulder and elbow, as `others.py` makes them.
fn sample(k: usize) -> [[f64; 2]; 3] {
    let t = k as f64 * 0.005;
    [[t.sin(), (2.0 * t).cos()], [t.cos(), -2.0 * (2.0 * t).sin()], [3.0 * t, -0.5 - t]]
}

/// Joints by the names of the file, or by those of the arm.
fn read(path: &Path, topic: Option<&str>) -> Recording {
    let settings = ReadSettings { mapping: None, topic };
    let joints = ["shoulder", "elbow"].map(str::to_owned);
    let found = inspect(path, &settings, &joints).unwrap();
    match found.recording {
        Ok(recording) => recording,
        Err(_) => {
            assert_eq!(found.guess.unsure, [""; 0], "{}", path.display());
            // as a user does: the guess as a file, and the file as the mapping
            let mapping = Mapping::parse(&found.guess.to_toml(), "guess.toml").unwrap();
            let settings = ReadSettings { mapping: Some(&mapping), topic };
            let recording = read_recording(path, &settings).unwrap();
            assert_eq!(recording.joints, found.guessed.unwrap().joints);
            recording
        }
    }
}

fn assert_is_sample(found: &Recording) {
    let source = &found.source;
    assert_eq!(found.joint_names(), ["shoulder", "elbow"], "{source}");
    assert_eq!(found.len(), SAMPLES, "{source}");
    for k in 0..SAMPLES {
        assert!((found.time_s[k] - 0.005 * k as f64).abs() < 1e-9, "{source}");
        let expected = sample(k);
        for (j, joint) in found.joints.iter().enumerate() {
            for (values, expected) in
                [&joint.position, &joint.velocity, &joint.effort].into_iter().zip(expected)
            {
                let value = values.as_ref().unwrap_or_else(|| panic!("{source}"))[k];
                assert!((value - expected[j]).abs() < 1e-14, "{source}: {value} {expected:?}");
            }
        }
    }
}

#[test]
fn arrays_of_other_writers_are_read() {
    for name in ["turned.npz", "compressed.mat"] {
        assert_is_sample(&read(&judge(name), None));
    }
}

#[cfg(feature = "all-formats")]
#[test]
fn hdf5_of_other_writers_is_read() {
    assert_is_sample(&read(&judge("version73.mat"), None));
}

#[cfg(feature = "all-formats")]
#[test]
fn bags_of_other_writers_are_read() {
    for name in ["none.bag", "bz2.bag"] {
        assert_is_sample(&read(&judge(name), None));
    }
    for topic in [None, Some("/dynamic_joint_states"), Some("/controller_state")] {
        let found = read(&judge("bag.db3"), topic);
        assert_is_sample(&found);
        let notes = found.notes.join("\n");
        assert!(notes.contains("/chatter (std_msgs/msg/String)"), "{notes}");
    }
}

#[cfg(feature = "all-formats")]
#[test]
fn fresh_files_of_other_writers_are_read() {
    let own = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../peers/bin/python");
    let given = std::env::var_os("ARMIDENT_PEERS_PYTHON").map(PathBuf::from);
    let Some(python) = given.or_else(|| own.exists().then_some(own)) else {
        shared::skipped(
            "others",
            "no Python with numpy, scipy, hdf5storage and rosbags (ARMIDENT_PEERS_PYTHON, or .ci/run)",
        );
        return;
    };
    let folder = scratch("fresh");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let made = Command::new(python).arg(judge("others.py")).arg(&folder).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    for name in [
        "matrices.npz",
        "turned.npz",
        "columns.npz",
        "plain.mat",
        "compressed.mat",
        "structure.mat",
        "version73.mat",
        "storage.mat",
        "groups.h5",
        "none.bag",
        "bz2.bag",
        "lz4.bag",
    ] {
        assert_is_sample(&read(&folder.join(name), None));
    }
    for name in ["bag_sqlite3/bag_sqlite3.db3", "bag_mcap/bag_mcap.mcap", "bag_sqlite3", "bag_mcap"]
    {
        for topic in [None, Some("/dynamic_joint_states"), Some("/controller_state")] {
            assert_is_sample(&read(&folder.join(name), topic));
        }
    }
}

/// A text file of the sample, a line per row.
fn text(name: &str, header: &str, row: impl Fn(usize, [[f64; 2]; 3]) -> String) -> PathBuf {
    let rows: String = (0..SAMPLES).map(|k| row(k, sample(k)) + "\n").collect();
    let path = scratch(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, format!("{header}{rows}")).unwrap();
    path
}

#[test]
fn layouts_of_text_are_read() {
    let echo = text("echo.csv", "", |k, [q, v, e]| {
        let ns = 5_000_000 * k;
        // joints in another order in some rows
        let pair = |x: [f64; 2]| {
            if k % 3 == 1 { format!("{},{}", x[1], x[0]) } else { format!("{},{}", x[0], x[1]) }
        };
        let names = if k % 3 == 1 { "elbow,shoulder" } else { "shoulder,elbow" };
        format!("1700000000,{ns},base_link,{names},{},{},{}", pair(q), pair(v), pair(e))
    });
    assert_is_sample(&read(&echo, None));
    std::fs::create_dir_all(scratch("sage")).unwrap();
    std::fs::write(scratch("sage/joint_list.txt"), "shoulder\nelbow\n").unwrap();
    let header = "type,timestamp,positions,velocities,torques\n";
    let sage = text("sage/state_motor.csv", header, |k, [q, v, e]| {
        format!("STATE_MOTOR,{},\"{q:?}\",\"{v:?}\",\"{e:?}\"", 5000 * k)
    });
    assert_is_sample(&read(&sage, None));
    let header = "timestamp actual_q_0 actual_q_1 target_q_0 target_q_1 actual_qd_0 actual_qd_1 joint_torque_0 joint_torque_1 actual_TCP_force_0\n";
    let rtde = text("rtde.csv", header, |k, [q, v, e]| {
        let t = 0.005 * k as f64;
        format!("{t} {} {} 7 7 {} {} {} {} 1", q[0], q[1], v[0], v[1], e[0], e[1])
    });
    assert_is_sample(&read(&rtde, None));
    // as spreadsheets of some countries write: mark, index, semicolons, decimal commas, units, CRLF
    let header = "\u{feff};Time [ms];shoulder angle [deg];elbow angle [deg];shoulder_vel;elbow_vel;shoulder torque (Nm);elbow torque (Nm)\r\n";
    let excel = text("excel.csv", header, |k, [q, v, e]| {
        let numbers =
            [5.0 * k as f64, q[0].to_degrees(), q[1].to_degrees(), v[0], v[1], e[0], e[1]];
        let cells: Vec<String> = numbers.iter().map(|x| x.to_string().replace('.', ",")).collect();
        format!("{k};{}\r", cells.join(";"))
    });
    assert_is_sample(&read(&excel, None));
}

fn recording() -> Recording {
    let time: Vec<f64> = (0..300).map(|k| 12.5 + 0.002 * f64::from(k)).collect();
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
            current: column(&|t| 0.1 * t),
            ..JointChannels::new("wrist 2")
        },
    ];
    Recording::new("test", time, joints).unwrap()
}

#[test]
fn npz_round_trips_keep_every_bit() {
    let before = recording();
    let encoded = Npz.write(&before).unwrap();
    assert!(encoded.omitted.is_empty());
    let path = scratch("round_trip.npz");
    std::fs::write(&path, encoded.bytes).unwrap();
    let after = read_recording(&path, &ReadSettings::default()).unwrap();
    assert_eq!((after.time_s, after.joints), (before.time_s, before.joints));
}

/// What becomes of a file cut in the middle: notes on the loss, or a refusal.
fn cut(name: &str, share: f64) -> String {
    let whole = std::fs::read(judge(name)).unwrap();
    let path = scratch(&format!("cut_{name}"));
    std::fs::write(&path, &whole[..(share * whole.len() as f64) as usize]).unwrap();
    match read_recording(&path, &ReadSettings::default()) {
        Ok(found) => {
            assert!(found.len() < SAMPLES, "{name}");
            let loss = found.notes.iter().find(|note| note.contains("truncated file"));
            format!("{} samples; {}", found.len(), loss.unwrap_or_else(|| panic!("{name}")))
        }
        Err(error) => format!("{error}; {}", error.hint().unwrap_or_default()),
    }
}

#[test]
fn truncated_files_are_read_to_the_break() {
    let mut found_by_file = Vec::new();
    let names: &[&str] = if cfg!(feature = "all-formats") {
        &["turned.npz", "compressed.mat", "bag.db3", "bz2.bag", "none.bag", "version73.mat"]
    } else {
        &["turned.npz", "compressed.mat"]
    };
    for name in names {
        for share in [0.05, 0.6] {
            found_by_file.push(format!("{name} {share}: {}", cut(name, share)));
        }
    }
    let suffix = if cfg!(feature = "all-formats") { "all" } else { "default" };
    insta::with_settings!({ snapshot_suffix => suffix }, {
        insta::assert_snapshot!(found_by_file.join("\n"));
    });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Refused or read, but without a panic.
    #[test]
    fn corrupted_files_do_not_panic(
        file in 0_usize..6,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        length in 0.2_f64..1.3,
    ) {
        let name = ["turned.npz", "compressed.mat", "bag.db3", "bz2.bag", "none.bag", "version73.mat"][file];
        let mut bytes = std::fs::read(judge(name)).unwrap();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        bytes.truncate((length * bytes.len() as f64) as usize);
        let path = scratch(&format!("corrupt_{name}"));
        std::fs::write(&path, &bytes).unwrap();
        if let Err(error) = inspect(&path, &ReadSettings::default(), &[]) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
