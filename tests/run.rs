//! `armident run`: an analysis of several steps in one file.

use std::path::{Path, PathBuf};

use crate::shared::project;
use crate::tool::{read_json, run_in, scratch, string, text};

const TWO_STEPS: &str = r#"
[defaults]
robot = "ur5.urdf"
quiet = true

[[step]]
name = "fit"
command = "identify"
recordings = ["train.csv"]
holdout = ["holdout.csv"]
cutoff-hz = 3
save_model = "ur5.json"

[[step]]
command = "validate"
robot = "ur5.json"
recordings = ["holdout.csv"]
no-replay = true
json = "result.json"
report = "page.html"
"#;

/// The bundled UR5 in a folder, and a file of steps in it.
fn laid_out(test: &str, steps: &str) -> PathBuf {
    let folder = scratch(test);
    for file in ["urdf/ur5.urdf", "examples/ur5/train.csv", "examples/ur5/holdout.csv"] {
        let from = project(file);
        std::fs::copy(&from, folder.join(from.file_name().unwrap())).unwrap();
    }
    std::fs::write(folder.join("armident.toml"), steps).unwrap();
    folder
}

#[test]
fn steps_run_in_order_in_their_folder() {
    let folder = laid_out("run_steps", TWO_STEPS);
    let said = run_in(folder.parent().unwrap(), &["run", "run_steps/armident.toml"]).fine();
    assert!(
        said.stdout.contains("ur5.json validated on 1 recording, low-pass 3 Hz"),
        "{}",
        said.stdout
    );
    assert_eq!(
        said.stderr,
        "$ armident identify ur5.urdf train.csv --holdout holdout.csv --cutoff-hz 3 --save-model ur5.json --quiet\n\
         \n$ armident validate ur5.json holdout.csv --no-replay --report page.html --json result.json --quiet\n"
    );
    let first = std::fs::read(folder.join("result.json")).unwrap();
    // the page names the step, which makes it again
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("armident validate ur5.json holdout.csv"));
    // the file is found in its folder, and the same bytes come again
    run_in(&folder, &["run", "--quiet"]).fine();
    assert_eq!(std::fs::read(folder.join("result.json")).unwrap(), first);
    // what is printed by a dry run does the same
    let printed = run_in(&folder, &["run", "--dry-run", "--only", "validate"]).fine().stdout;
    std::fs::remove_file(folder.join("result.json")).unwrap();
    let words: Vec<&str> = printed.split_whitespace().skip(1).collect();
    run_in(&folder, &words).fine();
    assert_eq!(std::fs::read(folder.join("result.json")).unwrap(), first);
    assert_eq!(string(&read_json(&folder.join("result.json"))["robot"]), "ur5");
}

/// Every kind of value becomes the words that one would type.
#[test]
fn values_become_command_line_words() {
    let steps = r#"
[[step]]
command = "simulate"
robot = "ur5.urdf"
trajectories = "train.csv"
output-path = "out put.csv"
effect = ["coulomb_friction:elbow_joint=4.5", "viscous_friction:elbow_joint=2"]
gravity = [0, 0, -9.81]
lock = { wrist_3_joint = 0.5 }
encoder-bits = 0x13
quiet = false

[[step]]
command = "identify"
robot = "ur5.urdf"
recordings = ["a.csv", "b.csv"]
payload = [{ file = "b.csv", mass = 2.0, com = [0, 0, 0.05] }]
"#;
    let folder = laid_out("run_values", steps);
    let said = run_in(&folder, &["run", "--dry-run"]).fine().stdout;
    assert_eq!(
        said,
        "armident simulate ur5.urdf train.csv --output-path 'out put.csv' --encoder-bits 19 --effect \
         coulomb_friction:elbow_joint=4.5 --effect viscous_friction:elbow_joint=2 --lock wrist_3_joint=0.5 \
         --gravity 0,0,-9.81\n\
         armident identify ur5.urdf a.csv b.csv --payload com=0:0:0.05,file=b.csv,mass=2.0\n"
    );
}

/// A step that fails ends the run with its code, and no later step is done.
#[test]
fn first_failure_ends_the_run() {
    let steps = TWO_STEPS.replace("train.csv", "absent.csv");
    let folder = laid_out("run_fails", &steps);
    let failed = run_in(&folder, &["run", "--quiet"]);
    assert_eq!(failed.code, 1, "{}", failed.stderr);
    assert!(!folder.join("result.json").exists());
    let steps = "[[step]]\ncommand = \"params\"\nrobot = \"stanford.urdf\"\nfail-on = \"warning\"\n\
                 [[step]]\ncommand = \"params\"\nrobot = \"ur5.urdf\"\njson = \"late.json\"\n";
    let folder = laid_out("run_stops", steps);
    std::fs::copy(project("urdf/stanford.urdf"), folder.join("stanford.urdf")).unwrap();
    assert_eq!(run_in(&folder, &["run", "--quiet"]).code, 3);
    assert!(!folder.join("late.json").exists());
}

/// Every file is refused before anything is done; the page of all is the snapshot.
#[test]
fn errors_show_their_line() {
    let whole = TWO_STEPS;
    let files: Vec<(&str, String)> = vec![
        ("no TOML", whole.replace("[defaults]", "[defaults")),
        ("a misspelt table", whole.replace("[[step]]\nname", "[[stp]]\nname")),
        (
            "no list",
            whole.replace("[[step]]\ncommand", "[other]\ncommand").replace("[[step]]", "[step]"),
        ),
        ("a misspelt default", whole.replace("robot = \"ur5.urdf\"", "robbot = \"ur5.urdf\"")),
        ("a misspelt command", whole.replace("\"identify\"", "\"identfy\"")),
        ("no command", whole.replace("command = \"identify\"\n", "")),
        ("a misspelt key", whole.replace("holdout =", "hold-out =")),
        ("a key of another command", whole.replace("no-replay = true", "placebo = 3")),
        ("a number out of range", whole.replace("cutoff-hz = 3", "cutoff-hz = -3")),
        ("a switch", whole.replace("no-replay = true", "no-replay = \"yes\"")),
        ("no text", whole.replace("save_model = \"ur5.json\"", "save_model = 1979-05-27")),
        ("a missing argument", whole.replace("recordings = [\"train.csv\"]\n", "")),
        ("a run in a run", whole.replace("\"identify\"", "\"run\"")),
        ("nothing", String::new()),
    ];
    let mut page = String::new();
    for (what, steps) in files {
        let folder = laid_out("run_wrong", &steps);
        let failed = run_in(&folder, &["run"]);
        assert_eq!(failed.code, 1, "{what}: {}", failed.stderr);
        assert!(failed.stdout.is_empty() && !folder.join("ur5.json").exists(), "{what}");
        assert!(failed.stderr.contains("\n   in: armident.toml"), "{what}: {}", failed.stderr);
        page.push_str(&format!("{what}\n{}\n", failed.stderr));
    }
    insta::with_settings!({prepend_module_to_snapshot => false, omit_expression => true}, {
        insta::assert_snapshot!("run__wrong", page);
    });
    let absent = run_in(Path::new(text(&scratch("run_absent"))), &["run"]);
    assert_eq!(absent.code, 1);
    assert!(absent.stderr.contains("the file does not exist"), "{}", absent.stderr);
    let folder = laid_out("run_only", whole);
    let only = run_in(&folder, &["run", "--only", "fitt"]);
    assert!(only.stderr.contains("did you mean `fit`?"), "{}", only.stderr);
}
