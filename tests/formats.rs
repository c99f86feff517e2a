//! Recordings in other formats than CSV, through the program.

use crate::shared::project;
use crate::tool::{list, number, read_json, run, scratch, text};

/// A simulated recording as MCAP identifies the same constants as it does as CSV.
#[test]
fn mcap_equals_csv() {
    let folder = scratch("formats");
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let mut found = Vec::new();
    for name in ["run.csv", "run.mcap"] {
        let path = folder.join(name);
        // encoders: without them exact accelerations are written, for which ROS has no place
        let args =
            ["simulate", text(&urdf), text(&train), "-o", text(&path), "--encoder-bits", "20"];
        run(&args).fine();
        let model = folder.join(format!("{name}.json"));
        let args =
            ["identify", text(&urdf), text(&path), "--cutoff-hz", "3", "--json", text(&model)];
        run(&args).fine();
        found.push(read_json(&model));
    }
    for (a, b) in list(&found[0]["constants"]).iter().zip(list(&found[1]["constants"])) {
        let error = number(&a["standard_error"]);
        // nanoseconds of the stamps
        assert!((number(&a["value"]) - number(&b["value"])).abs() < 1e-2 * error + 1e-9, "{a} {b}");
    }
    let notes = &found[1]["notes"];
    assert!(list(notes).iter().any(|n| n.as_str().is_some_and(|n| n.contains("/joint_states"))));
}

#[test]
fn unsupported_channels_give_notes() {
    let folder = scratch("formats_lost");
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let path = folder.join("run.mcap");
    let ran = run(&["simulate", text(&urdf), text(&train), "-o", text(&path)]).fine();
    assert!(ran.stderr.contains("cannot hold") && ran.stderr.contains("/acceleration"));
}

/// The columns of the UR5's recording by name.
fn ur5_columns() -> Vec<(String, Vec<String>)> {
    let text = std::fs::read_to_string(project("examples/ur5/train.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let column = |k: usize| rows[1..].iter().map(|row| row[k].to_owned()).collect();
    (0..rows[0].len()).map(|k| (rows[0][k].to_owned(), column(k))).collect()
}

fn write(
    path: &std::path::Path,
    columns: &[(String, Vec<String>)],
    wanted: impl Fn(usize) -> bool,
) {
    let line = |cells: Vec<&str>| cells.join(",") + "\n";
    let mut text = line(columns.iter().map(|(name, _)| name.as_str()).collect());
    for row in (0..columns[0].1.len()).filter(|row| wanted(*row)) {
        text += &line(columns.iter().map(|(_, values)| values[row].as_str()).collect());
    }
    std::fs::write(path, text).unwrap();
}

/// Joints in another order, and a joint and a column that are not the arm's.
#[test]
fn extra_joints_and_order_change_nothing() {
    let folder = scratch("formats_order");
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let mut columns = ur5_columns();
    columns[1..].reverse();
    let saw = |period: usize| (0..columns[0].1.len()).map(move |k| format!("0.{:02}", k % period));
    let gripper = ("gripper/position".to_owned(), saw(50).collect::<Vec<_>>());
    let battery = ("battery".to_owned(), saw(70).collect::<Vec<_>>());
    columns.insert(4, gripper);
    columns.push(battery);
    let other = folder.join("other.csv");
    write(&other, &columns, |_| true);
    let mut constants = Vec::new();
    let mut said = String::new();
    for recording in [&train, &other] {
        let json = folder.join("result.json");
        let ran = run(&["identify", text(&urdf), text(recording), "--json", text(&json)]).fine();
        constants.push(read_json(&json)["constants"].clone());
        said = ran.stderr;
    }
    assert_eq!(constants[0], constants[1]);
    let check = run(&["check", text(&urdf), text(&other)]).fine();
    let quality = check.stdout.lines().filter(|l| l.contains(" quality:") || l.contains(" rate:"));
    let said = format!("{said}--\n{}", quality.collect::<Vec<_>>().join("\n"));
    insta::assert_snapshot!(said.replace(text(&folder), "FOLDER"));
}

#[test]
fn different_rates_are_read_together() {
    let folder = scratch("formats_rates");
    let urdf = project("urdf/ur5.urdf");
    let (fast, slow) = (folder.join("fast.csv"), folder.join("slow.csv"));
    let columns = ur5_columns();
    write(&fast, &columns, |row| row < 700);
    write(&slow, &columns, |row| row >= 700 && row % 2 == 0);
    let json = folder.join("result.json");
    run(&["identify", text(&urdf), text(&fast), text(&slow), "--json", text(&json)]).fine();
    let found = read_json(&json);
    let forearm = list(&found["constants"]).iter().find(|c| c["label"] == "k3_x").unwrap();
    // 0.6 kg heavier than described
    let off = number(&forearm["value"]) - 1.7698;
    assert!(off.abs() < 4.0 * number(&forearm["standard_error"]), "{forearm}");
    let check = run(&["check", text(&urdf), text(&fast), text(&slow)]).fine();
    let said: Vec<&str> =
        check.stdout.lines().filter(|l| l.contains(" quality:") || l.contains(" rate:")).collect();
    insta::assert_snapshot!(said.join("\n").replace(text(&folder), "FOLDER"));
}
