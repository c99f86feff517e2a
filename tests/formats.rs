//! Recordings in other formats than CSV, through the program.

use crate::shared::project;
use crate::tool::{list, number, read_json, run, scratch, text};

/// A simulated recording as MCAP identifies the same constants as it does as CSV.
#[test]
fn mcap_is_as_good_as_csv() {
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
fn what_a_format_cannot_hold_is_said() {
    let folder = scratch("formats_lost");
    let (urdf, train) = (project("urdf/ur5.urdf"), project("examples/ur5/train.csv"));
    let path = folder.join("run.mcap");
    let ran = run(&["simulate", text(&urdf), text(&train), "-o", text(&path)]).fine();
    assert!(ran.stderr.contains("cannot hold") && ran.stderr.contains("/acceleration"));
}
