//! Exit codes, streams, and what is said about wrong command lines and wrong files.

use std::fmt::Write;
use std::path::Path;

use crate::shared::project;
use crate::tool::{read_json, run, run_in, scratch, text};

/// `urdf/stanford.urdf` has one warning (the inertia of link 1 as printed in the paper).
const WARNS: &str = "urdf/stanford.urdf";

#[test]
fn exit_codes_follow_the_outcome() {
    let code = |args: &[&str]| run(args).code;
    assert_eq!(code(&["params", WARNS]), 0, "a warning is no failure");
    assert_eq!(code(&["params", WARNS, "--fail-on", "warning"]), 3);
    assert_eq!(code(&["params", WARNS, "--fail-on", "warning", "--quiet"]), 3);
    assert_eq!(code(&["params", "urdf/scara.urdf", "--fail-on", "warning"]), 0);
    assert_eq!(code(&["params", "urdf/absent.urdf"]), 1);
    assert_eq!(code(&["params", "urdf/absent.urdf", "--fail-on", "warning"]), 1);
    assert_eq!(code(&["params", WARNS, "--colour"]), 2);
    assert_eq!(code(&["params", WARNS, "--gravity", "0,0"]), 2);
    assert_eq!(code(&["params", WARNS, "--lock", "joint_1"]), 2);
    assert_eq!(code(&["params"]), 2);
    assert_eq!(code(&[]), 2);
    assert_eq!(code(&["--help"]), 0);
    assert_eq!(code(&["--version"]), 0);
    for command in ["params", "plan", "simulate", "identify", "validate", "predict"] {
        assert_eq!(code(&[command, "--help"]), 0, "{command}");
    }
}

#[test]
fn results_go_to_stdout_messages_to_stderr() {
    let plain = run(&["params", WARNS]).fine();
    assert!(plain.stdout.starts_with("stanford: 6 joints RRPRRR"));
    assert!(plain.stderr.starts_with("warning: ") && plain.stderr.lines().count() == 1);

    let json = run(&["params", WARNS, "--json", "-"]).fine();
    assert_eq!(json.json()["robot"], "stanford", "stdout is JSON and nothing else");
    assert_eq!(json.stderr, plain.stderr);

    let folder = scratch("cli_streams");
    let file = folder.join("minimal.json");
    let both = run(&["params", WARNS, "--json", text(&file)]).fine();
    assert_eq!(both.stdout, plain.stdout, "JSON in a file leaves the text on stdout");
    assert_eq!(read_json(&file), json.json());
    let left: Vec<_> = std::fs::read_dir(&folder).unwrap().collect();
    assert_eq!(left.len(), 1, "no half-written file is left");

    let quiet = run(&["params", WARNS, "--quiet"]).fine();
    assert_eq!((quiet.stdout, quiet.stderr.as_str()), (plain.stdout, ""));
    let failed = run(&["params", "urdf/absent.urdf", "--quiet"]);
    assert!(failed.stderr.starts_with("error: ") && failed.stdout.is_empty());
}

/// The same command gives the same bytes.
#[test]
fn results_are_reproducible() {
    for args in [&["params", "urdf/panda.urdf", "--json", "-"][..], &["params", "urdf/gantry.urdf"]]
    {
        assert_eq!(run(args).fine().stdout, run(args).fine().stdout);
    }
}

/// A motion of `planar_2r`, 2 s at 100 Hz; `columns` are written behind `t`.
fn motion(columns: &[&str], value: impl Fn(usize, f64) -> f64) -> String {
    let mut csv = format!("t,{}\n", columns.join(","));
    for k in 0..200 {
        let t = f64::from(k) / 100.0;
        let _ = write!(csv, "{t}");
        for column in 0..columns.len() {
            let _ = write!(csv, ",{}", value(column, t));
        }
        csv.push('\n');
    }
    csv
}

fn waves(column: usize, t: f64) -> f64 {
    (3.0 * t + column as f64).sin() * 0.5 + (7.0 * t).cos() * 0.1
}

const POSITIONS: [&str; 2] = ["joint_1/position", "joint_2/position"];
const RECORDED: [&str; 4] =
    ["joint_1/position", "joint_1/effort", "joint_2/position", "joint_2/effort"];

/// Good and broken files, all small.
fn lay_out(folder: &Path) {
    let write = |name: &str, content: &[u8]| {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    };
    for arm in ["planar_2r", "scara"] {
        let from = project(&format!("urdf/{arm}.urdf"));
        std::fs::copy(from, folder.join(format!("{arm}.urdf"))).unwrap();
    }
    let urdf = std::fs::read_to_string(folder.join("planar_2r.urdf")).unwrap();
    write("sdf.urdf", b"<?xml version=\"1.0\"?>\n<sdf version=\"1.7\"><model name=\"a\"/></sdf>\n");
    let xacro = "<robot name=\"a\" xmlns:xacro=\"http://ros.org/wiki/xacro\">\n  \
                 <xacro:arm prefix=\"left\"/>\n  <link name=\"base\"/>\n</robot>\n";
    write("arm.urdf.xacro", xacro.as_bytes());
    write("empty.urdf", b"");
    write("photo.urdf", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    write("cut_off.urdf", &urdf.as_bytes()[..urdf.len() / 2]);
    write("no_child.urdf", urdf.replace("<child link=\"link_2\"/>", "").as_bytes());
    write("text.txt", b"not a folder\n");
    write("limits_key.toml", b"[joint_1]\nspeed = 1.0\n");
    write("limits_joint.toml", b"[elbow]\nvelocity = 1.0\n");
    write("limits_sign.toml", b"[joint_1]\nvelocity = -1.0\n");
    write("limits_order.toml", b"[joint_1]\nlower = 1.0\nupper = -1.0\n");
    write("limits_text.toml", b"[joint_1]\n\nvelocity = \"fast\"\n");

    let recording = motion(&RECORDED, waves);
    write("motion.csv", motion(&POSITIONS, waves).as_bytes());
    write("run.csv", recording.as_bytes());
    write("other_arm.csv", motion(&["elbow/position", "elbow/effort"], waves).as_bytes());
    let one = ["joint_1/position", "joint_1/effort", "joint_2/effort"];
    write("one_position.csv", motion(&one, waves).as_bytes());
    write("half.csv", motion(&["joint_1/position", "joint_1/effort"], waves).as_bytes());
    write("photo.csv", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    write("empty.csv", b"");
    let lines = |n: usize| recording.lines().take(n).collect::<Vec<_>>().join("\n") + "\n";
    write("short.csv", lines(6).as_bytes());
    write("no_time.csv", recording.replacen("t,", "stamp,", 1).as_bytes());
    write("words.csv", recording.replacen("\n0.5,", "\n0.5,up,", 1).as_bytes());
    write("nan.csv", recording.replacen("\n0.5,", "\n0.5,nan,", 1).as_bytes());
    write("backwards.csv", recording.replacen("\n0.5,", "\n0.1,", 1).as_bytes());
    let no_numbers: String = recording
        .lines()
        .enumerate()
        .map(|(k, line)| if k == 20 { "0.19,a,b,c,d\n".to_owned() } else { format!("{line}\n") })
        .collect();
    write("letters.csv", no_numbers.as_bytes());
    std::fs::create_dir_all(folder.join("no_csv")).unwrap();

    let identify = ["identify", "planar_2r.urdf", "run.csv", "--save-model", "model.json", "-q"];
    run_in(folder, &identify).fine();
    let model = std::fs::read_to_string(folder.join("model.json")).unwrap();
    write("broken.json", model.split("\"joints\"").next().unwrap().as_bytes());
    write("schema.json", model.replace("armident.model/2", "armident.model/7").as_bytes());
    write("effect.json", model.replace("coulomb_friction", "coulomb_fiction").as_bytes());
    let mut skewed: serde_json::Value = serde_json::from_str(&model).unwrap();
    skewed["base_from_e0"]["quaternion_wxyz"][0] = 9.0.into();
    write("skewed.json", skewed.to_string().as_bytes());
    write("joints.json", b"{\"schema\": \"armident.model/1\", \"joints\": []}\n");

    run_in(folder, &["plan", "planar_2r.urdf", "-o", "plan", "-q"]).fine();
    run_in(folder, &["simulate", "planar_2r.urdf", "plan", "-o", "runs", "-q"]).fine();
    let plan = std::fs::read_to_string(folder.join("runs/plan.json")).unwrap();
    write("runs_broken/plan.json", plan.split("\"experiments\"").next().unwrap().as_bytes());
    write("runs_schema/plan.json", plan.replace("armident.plan/1", "armident.plan/2").as_bytes());
    write("runs_missing/plan.json", plan.as_bytes());
    run_in(folder, &["simulate", "planar_2r.urdf", "plan", "-o", "runs_other", "-q"]).fine();
    write("runs_other/plan.json", plan.replace("U1_33", "U7_33").as_bytes());
}

/// Every line is one wrong command; its page is the snapshot.
const WRONG: &str = "\
params
params absent.urdf
params runs
params sdf.urdf
params arm.urdf.xacro
params empty.urdf
params photo.urdf
params cut_off.urdf
params no_child.urdf
params planar_2r.urdf --tip flnge
params planar_2r.urdf --base gripper
params planar_2r.urdf --base link_2 --tip base
params planar_2r.urdf --tip base
params planar_2r.urdf --lock joint_7=0
params planar_2r.urdf --lock joint_1=0 --lock joint_2=0
params planar_2r.urdf --lock joint_1
params planar_2r.urdf --lock joint_1=up
params planar_2r.urdf --gravity 0,0
params planar_2r.urdf --gravity 0,0,inf
params planar_2r.urdf --snap-rpy -1
params planar_2r.urdf --tipp flange
params planar_2r.urdf --json absent/out.json
params planar_2r.urdf --fail-on everything
params broken.json
params schema.json
params effect.json
params skewed.json
params joints.json
params absent.json
params model.json --tip flange
params run.csv
param planar_2r.urdf
plan planar_2r.urdf
plan planar_2r.urdf -o text.txt/plan
plan planar_2r.urdf -o out --amplitude 0
plan planar_2r.urdf -o out --dither 0.004
plan planar_2r.urdf -o out --coulomb elbow=2
excite planar_2r.urdf
excite planar_2r.urdf -o out --seconds 0
excite planar_2r.urdf -o out --budget soon
excite planar_2r.urdf -o out --only dance
excite planar_2r.urdf -o out --limits absent.toml
excite planar_2r.urdf -o out --limits text.txt
excite planar_2r.urdf -o out --limits limits_key.toml
excite planar_2r.urdf -o out --limits limits_joint.toml
excite planar_2r.urdf -o out --limits limits_sign.toml
excite planar_2r.urdf -o out --limits limits_order.toml
excite planar_2r.urdf -o out --limits limits_text.toml
identify planar_2r.urdf run.csv --payload file=heavy.csv,mass=2
identify planar_2r.urdf run.csv --payload file=run.csv,mass=-2
identify planar_2r.urdf run.csv --payload file=run.csv,mass=2,com=0:0
identify planar_2r.urdf run.csv --payload file=run.csv,mass=2,com_error=0.1
identify planar_2r.urdf run.csv --payload mass=2
identify planar_2r.urdf run.csv --payload file=run.csv,mass=2 --payload file=run.csv,mass=3
simulate planar_2r.urdf motion.csv -o motion.csv
simulate planar_2r.urdf absent.csv -o out.csv
simulate planar_2r.urdf no_csv -o out
simulate planar_2r.urdf other_arm.csv -o out.csv
simulate planar_2r.urdf motion.csv -o out.csv --effect stribeck:joint_1=1
simulate planar_2r.urdf motion.csv -o out.csv --effect coulomb_friction:joint_1=1,2
simulate planar_2r.urdf motion.csv -o out.csv --effect coulomb_friction
simulate planar_2r.urdf motion.csv -o out.csv --effect coulomb_friction:elbow=1
simulate planar_2r.urdf motion.csv -o out.csv --effect coulomb_friction:joint_1=-1
simulate planar_2r.urdf motion.csv -o out.csv --encoder-bits 2
simulate planar_2r.urdf motion.csv -o out.csv --torque-noise -1
simulate planar_2r.urdf motion.csv -o out.csv --direction forward
simulate planar_2r.urdf motion.csv -o out.csv --rate-hz 1e12
identify planar_2r.urdf
identify planar_2r.urdf absent.csv
identify planar_2r.urdf no_csv
identify planar_2r.urdf motion.csv
identify planar_2r.urdf other_arm.csv
identify model.json one_position.csv
identify planar_2r.urdf photo.csv
identify planar_2r.urdf empty.csv
identify planar_2r.urdf short.csv
identify planar_2r.urdf no_time.csv
identify planar_2r.urdf words.csv
identify planar_2r.urdf letters.csv
identify planar_2r.urdf backwards.csv
identify planar_2r.urdf run.csv --holdout absent.csv
identify planar_2r.urdf run.csv --holdout half.csv
identify planar_2r.urdf run.csv --holdout motion.csv
identify planar_2r.urdf run.csv --cutoff-hz 80
identify planar_2r.urdf run.csv --cutoff-hz 0
identify planar_2r.urdf run.csv --save-model absent/model.json
identify planar_2r.urdf runs run.csv
identify scara.urdf runs
identify planar_2r.urdf runs_broken
identify planar_2r.urdf runs_schema
identify planar_2r.urdf runs_missing
identify planar_2r.urdf runs_other
identify planar_2r.urdf run.csv --tip link_1 --lock joint_1=0
accumulate planar_2r.urdf run.csv
accumulate planar_2r.urdf half.csv -o out.jsonl
accumulate planar_2r.urdf run.csv -o text.txt
merge planar_2r.urdf
merge planar_2r.urdf absent.jsonl
merge planar_2r.urdf text.txt
validate model.json
validate absent.json run.csv
validate model.json absent.csv
validate model.json motion.csv
validate model.json half.csv
validate model.json run.csv run.csv --predictions out.csv
validate model.json run.csv --predictions absent/out.csv
predict model.json
predict model.json absent.csv -o out.csv
predict model.json other_arm.csv -o out.csv
predict model.json half.csv -o out.csv
predict model.json motion.csv -o absent/out.csv
predict model.json motion.csv -o out.csv --cutoff-hz 60";

/// Whether a line shows the file at fault: `12 | <link>`.
fn is_excerpt(line: &str) -> bool {
    let mut parts = line.trim_start().splitn(2, '|');
    let number = parts.next().unwrap_or_default().trim_end();
    line.contains('|') && number.chars().all(|c| c.is_ascii_digit())
}

/// The lines after the warnings and notes: `error:`, `   in:` and mostly ` hint:`.
fn is_three_lines(stderr: &str) -> bool {
    let lines: Vec<&str> = stderr
        .lines()
        .filter(|line| !line.starts_with("warning: ") && !line.starts_with("note: "))
        .filter(|line| !is_excerpt(line))
        .collect();
    let starts = ["error: ", "   in: ", " hint: "];
    (2..=3).contains(&lines.len())
        && lines.iter().zip(starts).all(|(line, start)| {
            line.strip_prefix(start).is_some_and(|rest| !rest.trim().is_empty())
        })
}

#[test]
fn errors_match_snapshot() {
    let folder = scratch("cli_errors");
    lay_out(&folder);
    let mut page = String::new();
    for line in WRONG.lines() {
        let args: Vec<&str> = line.split(' ').collect();
        let ran = run_in(&folder, &args);
        assert!(ran.stdout.is_empty(), "{line}: {}", ran.stdout);
        assert!(matches!(ran.code, 1 | 2), "{line}: exit code {}\n{}", ran.code, ran.stderr);
        if ran.code == 1 {
            assert!(is_three_lines(&ran.stderr), "{line}:\n{}", ran.stderr);
        } else {
            assert!(ran.stderr.starts_with("error: "), "{line}:\n{}", ran.stderr);
        }
        let _ = writeln!(page, "$ armident {line}\n(exit code {})\n{}", ran.code, ran.stderr);
    }
    insta::with_settings!({prepend_module_to_snapshot => false, omit_expression => true}, {
        insta::assert_snapshot!("cli__errors", page);
    });
    // nothing half-written, and the trajectory that was to be overwritten is as it was
    let left: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(
        !left.iter().any(|name| name.ends_with(".part") || name.starts_with("out")),
        "{left:?}"
    );
    let kept = std::fs::read_to_string(folder.join("motion.csv")).unwrap();
    assert_eq!(kept, motion(&POSITIONS, waves));
}

/// However its path is written, what goes in is not overwritten by what comes out.
#[test]
fn inputs_are_never_overwritten() {
    let folder = scratch("cli_inputs");
    lay_out(&folder);
    for line in [
        "simulate planar_2r.urdf motion.csv -o motion.csv",
        "simulate planar_2r.urdf motion.csv -o ./motion.csv",
        "simulate planar_2r.urdf plan -o ./plan",
        "predict planar_2r.urdf motion.csv -o ./motion.csv",
    ] {
        let args: Vec<&str> = line.split(' ').collect();
        let ran = run_in(&folder, &args);
        assert_eq!(ran.code, 1, "{line}: {}", ran.stdout);
        let kept = std::fs::read_to_string(folder.join("motion.csv")).unwrap();
        assert_eq!(kept, motion(&POSITIONS, waves), "{line}");
    }
}

/// Doubtful, but there is a result: what was done is said.
#[test]
fn doubtful_inputs_give_messages() {
    let folder = scratch("cli_doubts");
    lay_out(&folder);
    let said = |line: &str| {
        let args: Vec<&str> = line.split(' ').collect();
        run_in(&folder, &args).fine().stderr
    };
    let half = said("identify planar_2r.urdf half.csv");
    assert!(half.contains("locked at 0") && half.contains("[joint-not-recorded]"), "{half}");
    let predicted = said("predict planar_2r.urdf run.csv -o out.csv --cutoff-hz 9");
    assert_eq!(predicted, "");
    let silent = said("predict planar_2r.urdf run.csv -o out.csv --quiet");
    assert_eq!(silent, "");
    let chosen = said("predict planar_2r.urdf run.csv -o out.csv");
    assert!(chosen.is_empty() || chosen.starts_with("note: "), "{chosen}");
}

/// A result sent to a pipe or a device goes into it; a rename would put a file in its place.
#[cfg(unix)]
#[test]
fn outputs_may_be_pipes_and_links() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let folder = scratch("cli_no_files");
    lay_out(&folder);
    let pipe = folder.join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = {
        let pipe = pipe.clone();
        std::thread::spawn(move || std::fs::read_to_string(pipe).unwrap())
    };
    run_in(&folder, &["params", "planar_2r.urdf", "--json", "pipe"]).fine();
    assert!(reader.join().unwrap().contains("armident.params/1"));
    assert!(std::fs::metadata(&pipe).unwrap().file_type().is_fifo());

    std::fs::write(folder.join("real.json"), "").unwrap();
    symlink("real.json", folder.join("link.json")).unwrap();
    run_in(&folder, &["params", "planar_2r.urdf", "--json", "link.json"]).fine();
    assert!(std::fs::symlink_metadata(folder.join("link.json")).unwrap().is_symlink());
    assert_ne!(std::fs::read_to_string(folder.join("real.json")).unwrap(), "");
}

/// Colours are for terminals, and for nobody with `NO_COLOR`.
#[test]
fn colours_follow_the_environment() {
    let run = |env: &[(&str, &str)], args: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_armident"))
            .args(args)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env_remove("NO_COLOR")
            .env_remove("CLICOLOR_FORCE")
            .envs(env.iter().copied())
            .output()
            .unwrap();
        [output.stdout, output.stderr].concat().contains(&0x1b)
    };
    for args in
        [&["params", WARNS][..], &["params", "absent.urdf"], &["params", "--tipp"], &["--help"]]
    {
        assert!(!run(&[], args), "{args:?}: colours in a pipe");
        assert!(!run(&[("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1")], args), "{args:?}");
        assert!(run(&[("CLICOLOR_FORCE", "1")], args), "{args:?}: none although forced");
    }
}

/// The same on a terminal, which `script` of util-linux plays.
#[cfg(target_os = "linux")]
#[test]
fn terminals_show_colours() {
    let command = format!("{} params absent.urdf", env!("CARGO_BIN_EXE_armident"));
    let on_terminal = |no_color: Option<&str>| {
        let mut script = std::process::Command::new("script");
        script
            .args(["-qec", &command, "/dev/null"])
            .env("TERM", "xterm")
            .env_remove("CLICOLOR_FORCE");
        match no_color {
            Some(value) => script.env("NO_COLOR", value),
            None => script.env_remove("NO_COLOR"),
        };
        script.stdin(std::process::Stdio::null()).output()
    };
    let Ok(coloured) = on_terminal(None) else {
        crate::shared::skipped("cli", "no `script` here, which plays a terminal");
        return;
    };
    let text = String::from_utf8_lossy(&coloured.stdout);
    assert!(text.contains("absent.urdf") && text.contains('\u{1b}'), "{text}");
    let plain = on_terminal(Some("1")).unwrap();
    assert!(!plain.stdout.contains(&0x1b), "{}", String::from_utf8_lossy(&plain.stdout));
}

/// Ctrl-C at any time leaves whole files and nothing else.
#[cfg(unix)]
#[test]
fn interrupt_leaves_whole_files() {
    let folder = scratch("cli_interrupted");
    run_in(&folder, &["plan", text(&project("urdf/stanford.urdf")), "-o", "plan", "-q"]).fine();
    let simulate = |to: &str| {
        let urdf = project("urdf/stanford.urdf");
        let args = ["simulate", text(&urdf), "plan", "-o", to, "-q", "--torque-noise", "0.1"];
        std::process::Command::new(env!("CARGO_BIN_EXE_armident"))
            .args(args)
            .current_dir(&folder)
            .spawn()
            .unwrap()
    };
    assert!(simulate("whole").wait().unwrap().success());
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let mut stopped = 0;
    for k in 0..12 {
        let runs = format!("runs_{k}");
        let mut child = simulate(&runs);
        // from the first file on, later each time
        let since = std::time::Instant::now();
        let begun = |folder: &Path| folder.read_dir().is_ok_and(|mut files| files.next().is_some());
        while !begun(&folder.join(&runs)) && since.elapsed().as_secs() < 20 {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        std::thread::sleep(std::time::Duration::from_millis(3 * k));
        let id = child.id().to_string();
        let _ = std::process::Command::new("kill").args(["-INT", &id]).status().unwrap();
        let status = child.wait().unwrap();
        if status.success() {
            continue;
        }
        assert_eq!(status.code(), Some(130));
        stopped += 1;
        for entry in std::fs::read_dir(folder.join(&runs)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            assert_eq!(read(&format!("{runs}/{name}")), read(&format!("whole/{name}")), "{name}");
        }
    }
    assert!(stopped > 0, "every run had ended before it was stopped");
}
