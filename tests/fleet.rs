//! A fleet of three robots of one kind: which changed, in what, at which recording.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::shared::{project, skipped};
use crate::tool::UR5_JOINTS as JOINTS;
use crate::tool::{Run, list, number, run_in, scratch, string, text};

/// Viscous friction of the elbow \[N m s/rad\], which one robot doubles.
const ELBOW: f64 = 4.0;
/// Mass that another robot gains on link 3 \[kg\].
const GAINED_KG: f64 = 0.6;

/// Days of the recordings of a robot: their order is that of the numbers, not of the letters.
const DAYS: [usize; 4] = [1, 2, 9, 10];

/// Positions of a recording: two sines a joint, others in each recording.
fn trajectory(number: usize) -> String {
    let mut csv = "t".to_owned();
    JOINTS.iter().for_each(|joint| write!(csv, ",{joint}/position").unwrap());
    for sample in 0..1500 {
        let t = sample as f64 * 0.01;
        write!(csv, "\n{t}").unwrap();
        for joint in 0..JOINTS.len() {
            let place = (1 + joint + 7 * number) as f64;
            let wave = |hz: f64, phase: f64| (std::f64::consts::TAU * hz * t + phase * place).sin();
            let position = 0.9 * wave(0.13 + 0.03 * joint as f64, 1.3) + 0.35 * wave(0.41, 2.1);
            write!(csv, ",{position}").unwrap();
        }
    }
    csv
}

/// The arm with a body fixed to its link 3.
fn loaded(urdf: &str) -> String {
    let body = format!(
        "<link name=\"clamp\"><inertial><origin xyz=\"0 0 0\"/><mass value=\"{GAINED_KG}\"/><inertia ixx=\"0.0006\" \
         iyy=\"0.0006\" izz=\"0.0006\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint name=\"clamp_joint\" \
         type=\"fixed\"><parent link=\"link_3\"/><child link=\"clamp\"/><origin xyz=\"-0.2 0.03 0.05\" rpy=\"0 0 0\"/></joint>\
         </robot>"
    );
    urdf.replace("</robot>", &body)
}

/// Three robots with four recordings each below `logs`: one gains a body after its second recording, one doubles friction
/// after its second, one stays as it is; and two files that cannot be used.
fn fleet(folder: &Path) -> PathBuf {
    let urdf = folder.join("arm.urdf");
    let plain = std::fs::read_to_string(project("urdf/ur5.urdf")).unwrap();
    std::fs::write(folder.join("loaded.urdf"), loaded(&plain)).unwrap();
    std::fs::write(&urdf, plain).unwrap();
    for (index, robot) in ["gains", "rubs", "stays"].into_iter().enumerate() {
        std::fs::create_dir_all(folder.join("logs").join(robot)).unwrap();
        for (recording, day) in DAYS.into_iter().enumerate() {
            let number = 4 * index + recording;
            std::fs::write(folder.join("motion.csv"), trajectory(number)).unwrap();
            let changed = recording >= 2;
            let arm = if changed && robot == "gains" { "loaded.urdf" } else { "arm.urdf" };
            let elbow = if changed && robot == "rubs" { 2.0 * ELBOW } else { ELBOW };
            let (seed, out) = (number.to_string(), format!("logs/{robot}/day{day}.csv"));
            let mut args = vec![
                "simulate",
                arm,
                "motion.csv",
                "-o",
                &out,
                "--torque-noise",
                "1%",
                "--seed",
                &seed,
            ];
            let mut effects = Vec::new();
            for joint in JOINTS {
                let viscous = if joint == "elbow_joint" { elbow } else { 2.0 };
                effects.push(format!("viscous_friction:{joint}={viscous}"));
                effects.push(format!("coulomb_friction:{joint}=1.5"));
            }
            effects.iter().for_each(|effect| args.extend(["--effect", effect]));
            run_in(folder, &args).fine();
        }
    }
    let whole = std::fs::read(folder.join("logs/stays/day1.csv")).unwrap();
    std::fs::write(folder.join("logs/stays/day5.csv"), &whole[..60]).unwrap();
    let other = "t,hinge/position,hinge/effort\n0,0,0\n0.01,0,0\n0.02,0,0\n";
    std::fs::write(folder.join("logs/stays/day6.csv"), other).unwrap();
    urdf
}

fn of_robot<'a>(result: &'a Value, name: &str) -> &'a Value {
    list(&result["robots"]).iter().find(|robot| robot["robot"] == name).unwrap()
}

#[test]
fn fleet_reports_what_changed() {
    let folder = scratch("fleet");
    let urdf = fleet(&folder);
    std::fs::write(folder.join("logs/rubs/day2.html"), "<!doctype html>").unwrap();
    let run = |more: &[&str]| -> Run {
        let args = ["fleet", text(&urdf), "logs", "--states", "states.jsonl"];
        run_in(&folder, &[&args, more].concat())
    };
    let result = run(&["--json", "-", "--report", "fleet.html"]).fine().json();

    // the body on link 3, from the third recording on
    let gains = list(&of_robot(&result, "gains")["changes"]);
    assert_eq!(gains.len(), 1, "{gains:?}");
    assert_eq!(
        (string(&gains[0]["link"]), &gains[0]["number"]),
        ("link_3", &3.into()),
        "{gains:?}"
    );
    let mass = list(&gains[0]["sizes"]).iter().find(|size| size["parameter"] == "mass").unwrap();
    let interval = list(&mass["interval"]);
    assert!(number(&interval[0]) < GAINED_KG && GAINED_KG < number(&interval[1]), "{mass}");
    assert!((number(&mass["value"]) - GAINED_KG).abs() < 0.1, "{mass}");

    // friction of the elbow, from the third recording on
    let rubs = list(&of_robot(&result, "rubs")["changes"]);
    assert_eq!(rubs.len(), 1, "{rubs:?}");
    assert_eq!(string(&rubs[0]["what"]), "viscous friction");
    assert_eq!((string(&rubs[0]["joint"]), &rubs[0]["number"]), ("elbow_joint", &3.into()));
    let size = &list(&rubs[0]["sizes"])[0];
    assert!((number(&size["value"]) - ELBOW).abs() < 0.1 * ELBOW, "{size}");
    assert!(
        string(&rubs[0]["sentence"]).contains("viscous friction of joint `elbow_joint` rises by")
    );

    // the third does not change; the files that cannot be used are counted with their reasons
    assert!(list(&of_robot(&result, "stays")["changes"]).is_empty());
    assert_eq!(list(&of_robot(&result, "stays")["recordings"]).len(), 4);
    let aside: Vec<&str> = list(&result["set_aside"]).iter().map(|s| string(&s["file"])).collect();
    assert_eq!(aside, ["logs/stays/day5.csv", "logs/stays/day6.csv"]);
    assert!(list(&result["set_aside"]).iter().all(|s| !string(&s["reason"]).is_empty()));
    let page = std::fs::read_to_string(folder.join("fleet.html")).unwrap();
    // names keep their case, and what stands in backticks is code
    assert!(page.contains("<p>gains: link <code>link_3</code> gains a body of"));
    assert!(page.contains("href=\"./logs/rubs/day2.html\""));
    let (body, friction) = (string(&gains[0]["parameter"]), string(&rubs[0]["parameter"]));
    assert!(["k1_", "k2_", "k3_", "U1_", "U2_", "U3_"].iter().any(|of| body.starts_with(of)));
    assert_eq!(friction, "viscous_friction(elbow_joint)");

    // an interrupted run is continued and gives the same
    let states = std::fs::read_to_string(folder.join("states.jsonl")).unwrap();
    let kept: Vec<&str> = states.lines().take(7).collect();
    std::fs::write(folder.join("states.jsonl"), kept.join("\n") + "\n{\"schema\":\"armident")
        .unwrap();
    let again = run(&["--json", "-"]).fine().json();
    assert_eq!(again["robots"], result["robots"]);
    assert_eq!(std::fs::read_to_string(folder.join("states.jsonl")).unwrap().lines().count(), 13);

    // robots by pattern: all of one robot, where every file is `day*`
    let args =
        ["fleet", text(&urdf), "states.jsonl", "--robot-of", "{robot}/*/*.csv", "--json", "-"];
    let one = run_in(&folder, &args).fine().json();
    assert_eq!(list(&one["robots"]).len(), 1);
    assert_eq!(string(&list(&one["robots"])[0]["robot"]), "logs");
    let ran = run_in(&folder, &["fleet", text(&urdf), "states.jsonl", "--robot-of", "arm*"]);
    assert_eq!(ran.code, 1);
    assert!(
        ran.stderr
            .contains("expected `{robot}` once in the pattern or `column:NAME`, found `arm*`"),
        "{}",
        ran.stderr
    );
    let ran = run_in(&folder, &["fleet", text(&urdf), "logs"]);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("recordings need a file for their states"), "{}", ran.stderr);
}

/// The robot of a recording stands in a column of it, which its state keeps.
#[test]
fn robots_are_named_by_a_column() {
    let folder = scratch("fleet_column");
    let urdf = project("urdf/ur5.urdf");
    for (name, robot) in [("train", "arm 1"), ("holdout", "arm 2")] {
        let log = std::fs::read_to_string(project(&format!("examples/ur5/{name}.csv"))).unwrap();
        let with = |(row, line): (usize, &str)| {
            format!("{line},{}\n", if row == 0 { "cell" } else { robot })
        };
        let log: String = log.lines().enumerate().map(with).collect();
        std::fs::write(folder.join(format!("{name}.csv")), log).unwrap();
    }
    std::fs::copy(project("examples/ur5/train.csv"), folder.join("other.csv")).unwrap();
    let run = |more: &[&str]| {
        let args = ["fleet", text(&urdf), "--robot-of", "column:cell", "--json", "-"];
        run_in(&folder, &[&args, more].concat()).fine().json()
    };
    let logs = ["train.csv", "holdout.csv", "other.csv", "--states", "states.jsonl"];
    let result = run(&logs);
    let names: Vec<&str> = list(&result["robots"]).iter().map(|of| string(&of["robot"])).collect();
    assert_eq!(names, ["arm 1", "arm 2"]);
    let aside = &list(&result["set_aside"])[0];
    assert_eq!(string(&aside["reason"]), "no column `cell` with the robot");
    assert_eq!(run(&["states.jsonl"])["robots"], result["robots"]);
}

/// Tables of states are those of lines, whoever writes them.
#[test]
fn tables_of_states_equal_lines() {
    if let Err(error) = armident_recording::tables_are_built(Path::new("states.parquet")) {
        skipped("fleet", &error.to_string());
        return;
    }
    let folder = scratch("fleet_tables");
    let urdf = project("urdf/ur5.urdf");
    let logs = ["train", "holdout"].map(|name| project(&format!("examples/ur5/{name}.csv")));
    let [train, holdout] = [text(&logs[0]), text(&logs[1])];
    let run = |args: &[&str]| run_in(&folder, args).fine();
    let accumulated = |logs: &[&str], output: &str| -> Value {
        let args = [&["accumulate", text(&urdf)], logs, &["-o", output, "--json", "-"]].concat();
        run(&args).json()
    };
    accumulated(&[train, holdout], "states.jsonl");

    // a table is continued, also by what an interrupted run has left beside it
    assert_eq!(list(&accumulated(&[train], "states.parquet")["reduced"]).len(), 1);
    let again = accumulated(&[train, holdout], "states.parquet");
    let count = |key: &str| list(&again[key]).len();
    assert_eq!((count("reduced"), count("already_there"), count("set_aside")), (1, 1, 0));
    assert!(!folder.join("states.parquet.jsonl").exists());
    let lines = std::fs::read_to_string(folder.join("states.jsonl")).unwrap();
    std::fs::write(folder.join("left.parquet.jsonl"), format!("{lines}{{\"schema\":\"arm"))
        .unwrap();
    assert!(list(&accumulated(&[train, holdout], "left.parquet")["reduced"]).is_empty());

    // what is made of them
    let merged = |states: &str| run(&["merge", text(&urdf), states, "--json", "-"]).json();
    let fleet = |states: &str| run(&["fleet", text(&urdf), states, "--json", "-"]).json();
    for table in ["states.parquet", "left.parquet"] {
        assert_eq!(merged(table), merged("states.jsonl"));
        assert_eq!(fleet(table), fleet("states.jsonl"));
    }

    // a table of `armident.fleet.to_parquet`, made of the lines beside it
    let [lines, table] =
        ["jsonl", "parquet"].map(|end| project(&format!("tests/fleet/states.{end}")));
    let urdf = project("urdf/planar_2r.urdf");
    let both = [&lines, &table]
        .map(|states| run(&["fleet", text(&urdf), text(states), "--json", "-"]).json());
    assert_eq!(both[0], both[1]);
    assert_eq!(string(&both[1]["robots"][0]["robot"]), "arm 1");
    let both = [&lines, &table]
        .map(|states| run(&["merge", text(&urdf), text(states), "--json", "-"]).json());
    assert_eq!(both[0], both[1]);
    // any column of a table
    let args = ["fleet", text(&urdf), text(&table), "--robot-of", "column:schema", "--json", "-"];
    let robots = &run(&args).json()["robots"];
    assert_eq!(string(&robots[0]["robot"]), "armident.state-table/1");
    // of another arm: set aside
    let ran = run_in(&folder, &["fleet", text(&urdf), "states.parquet"]);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("the state is of another arm"), "{}", ran.stderr);
    // a recording is no table of states, and is not overwritten
    let copied = folder.join("log.parquet");
    run(&["convert", train, text(&copied)]);
    let ur5 = project("urdf/ur5.urdf");
    let args = ["accumulate", text(&ur5), holdout, "-o", text(&copied)];
    let ran = run_in(&folder, &args);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("the output file holds something else"), "{}", ran.stderr);
}

#[allow(dead_code, reason = "its table is not printed here")]
#[path = "../examples/coverage_fleet.rs"]
mod study;

/// A sample of `docs/studies/fleet.md`: the stated rate is 1 % of robots; of 200 robots more than 8 have a change with a
/// probability below 1e-3 where it is kept.
#[test]
fn fleets_that_do_not_age_have_few_changes() {
    let source = study::Source::new(include_str!("../urdf/planar_2r.urdf")).unwrap();
    for scatter in [0.0, 3.0] {
        let found = study::alarms(&source, (20, 10, 6), scatter, 37).unwrap();
        assert!(found.with_change <= 8, "{} of {}", found.with_change, found.robots);
    }
}
