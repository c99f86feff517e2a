//! `info` and `convert`: from a log with other names to a result in two commands.

use std::path::{Path, PathBuf};

use crate::shared::project;
use crate::tool::{list, read_json, run, scratch, string, text};

/// The UR5's recording with the columns of a controller's log, times in milliseconds.
fn controller_log(folder: &Path) -> PathBuf {
    let csv = std::fs::read_to_string(project("examples/ur5/train.csv")).unwrap();
    let (header, rows) = csv.split_once('\n').unwrap();
    let mut joints: Vec<&str> = Vec::new();
    let mut names = vec!["timestamp_ms".to_owned()];
    for column in header.split(',').skip(1) {
        let (joint, quantity) = column.rsplit_once('/').unwrap();
        if !joints.contains(&joint) {
            joints.push(joint);
        }
        let number = joints.iter().position(|known| *known == joint).unwrap();
        let prefix = if quantity == "position" { "actual_q" } else { "joint_torque" };
        names.push(format!("{prefix}_{number}"));
    }
    let rows = rows.lines().map(|row| {
        let (t, others) = row.split_once(',').unwrap();
        format!("{},{others}\n", 1e3 * t.parse::<f64>().unwrap())
    });
    let path = folder.join("log.csv");
    std::fs::write(&path, names.join(",") + "\n" + &rows.collect::<String>()).unwrap();
    path
}

#[test]
fn guessed_mapping_gives_the_same_constants() {
    let folder = scratch("info_mapping");
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let (log, mapping) = (controller_log(&folder), folder.join("mapping.toml"));
    let args = ["info", text(&log), "--robot", text(&urdf), "--write-mapping", text(&mapping)];
    let ran = run(&args).fine();
    assert!(ran.stdout.contains("1200 in 11.99 s, 100 Hz, even"), "{}", ran.stdout);
    assert!(!ran.stdout.contains("unsure"), "{}", ran.stdout);
    let constants = |log: &Path, options: &[&str]| {
        let json = folder.join("result.json");
        let args = ["identify", text(&urdf), text(log), "--cutoff-hz", "3", "--json", text(&json)];
        run(&[&args[..], options].concat()).fine();
        read_json(&json)["constants"].clone()
    };
    let mapped = constants(&log, &["--mapping", text(&mapping)]);
    for (a, b) in list(&mapped).iter().zip(list(&constants(&train, &[]))) {
        assert_eq!(a["label"], b["label"]);
        let (a, b) = (a["value"].as_f64().unwrap(), b["value"].as_f64().unwrap());
        // milliseconds round otherwise than seconds
        assert!((a - b).abs() < 1e-6 * b.abs().max(1.0), "{a} {b}");
    }
}

#[test]
fn unsure_guesses_are_shown_as_such() {
    let folder = scratch("info_unsure");
    let (log, mapping) = (controller_log(&folder), folder.join("mapping.toml"));
    let ran = run(&["info", text(&log), "--write-mapping", text(&mapping)]).fine();
    let why = "unsure: joints are numbered";
    assert!(ran.stdout.contains(why), "{}", ran.stdout);
    assert!(std::fs::read_to_string(&mapping).unwrap().contains(&format!("# {why}")));
    let json = run(&["info", text(&log), "--json", "-"]).fine().json();
    let found = &json["recordings"][0];
    assert_eq!((string(&found["names"]), string(&found["format"])), ("guess", "CSV"));
    assert_eq!(list(&found["guess"]["channels"]).len(), 12);
    assert_eq!(string(&found["guess"]["time"]["unit"]), "ms");
    assert_eq!(found["quality"]["samples"], 1200);
}

#[test]
fn logs_without_joints_are_reported() {
    let folder = scratch("info_none");
    let log = folder.join("log.csv");
    std::fs::write(&log, "t,battery\n0,1\n1,2\n").unwrap();
    let ran = run(&["info", text(&log), "--fail-on", "warning"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("[no_mapping]"), "{}", ran.stderr);
    let mapping = folder.join("mapping.toml");
    let ran = run(&["info", text(&log), "--write-mapping", text(&mapping)]);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("`battery`") && !mapping.exists(), "{}", ran.stderr);
}

#[test]
fn conversions_return_to_the_same_file() {
    let folder = scratch("convert");
    let train = project("examples/ur5/train.csv");
    let (npz, back) = (folder.join("train.npz"), folder.join("back.csv"));
    run(&["convert", text(&train), text(&npz)]).fine();
    run(&["convert", text(&npz), text(&back)]).fine();
    let again = folder.join("again.csv");
    run(&["convert", text(&train), text(&again)]).fine();
    assert_eq!(std::fs::read(&back).unwrap(), std::fs::read(&again).unwrap());
    let ran = run(&["convert", text(&train), text(&folder.join("train.bag"))]);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains(".csv, .mcap, .npz, .parquet"), "{}", ran.stderr);
}

/// Scripts of the users of a program, with the logs beside them; LeRobot's is in Python and runs in `python/tests`.
#[cfg(unix)]
#[test]
fn example_scripts_end_in_a_diagnosis() {
    let programs = std::path::Path::new(env!("CARGO_BIN_EXE_armident")).parent().unwrap();
    for name in ["ros2_bag", "rtde", "matlab"] {
        let folder = scratch(&format!("example_{name}"));
        let ran = std::process::Command::new("sh")
            .arg(project(&format!("examples/{name}.sh")))
            .current_dir(&folder)
            .env("PATH", format!("{}:/usr/bin:/bin", programs.display()))
            .output()
            .unwrap();
        let output = String::from_utf8_lossy(&ran.stdout);
        let errors = String::from_utf8_lossy(&ran.stderr);
        assert!(ran.status.success(), "{name}: {errors}");
        assert!(output.contains("effects are missing from the model"), "{name}: {output}");
        assert!(folder.join(format!("{}_report.html", name.trim_end_matches("_bag"))).exists());
    }
}

/// Logs of the table in `docs/book/src/formats.md` that the default build reads; the others are in `python/tests/test_logs.py`.
#[test]
fn logs_of_other_programs_need_two_commands() {
    let folder = scratch("example_logs");
    let urdf = project("urdf/ur5.urdf");
    for (log, is_mapped) in [
        ("ros2_bag", false),
        ("rtde.csv", true),
        ("matlab.mat", false),
        ("sage/state_motor.csv", false),
        ("numpy.npz", false),
    ] {
        let (path, mapping) =
            (project(&format!("examples/logs/{log}")), folder.join("mapping.toml"));
        let mut args = vec!["info", text(&path), "--robot", text(&urdf), "--json", "-"];
        if is_mapped {
            args.extend(["--write-mapping", text(&mapping)]);
        }
        let found = &run(&args).fine().json()["recordings"][0];
        let names = if is_mapped { "guess" } else { "standard" };
        assert_eq!(string(&found["names"]), names, "{log}: {found}");
        let mut args = vec!["diagnose", text(&urdf), text(&path), "--no-replay", "--json", "-"];
        if is_mapped {
            args.extend(["--mapping", text(&mapping)]);
        }
        let result = run(&args).fine().json();
        let friction = list(&result["findings"])
            .iter()
            .any(|f| f["effect"] == "coulomb_friction" && f["joints"][0] == "wrist_1_joint");
        assert!(friction, "{log}: {}", result["findings"]);
    }
}
