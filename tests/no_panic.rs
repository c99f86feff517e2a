//! No bytes in any input file make the program panic.

use std::path::Path;
use std::sync::LazyLock;

use armident_ident::experiment::{Plan, algorithm2};
use armident_ident::{BatchProblem, MinimalSet};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf_bytes};
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings};
use armident_recording::{Recording, read_csv_from};
use proptest::prelude::*;

use crate::shared::project;
use crate::tool::{run_in, scratch};

/// Sound files of one small arm, made by the program.
struct Sound {
    urdf: Vec<u8>,
    csv: Vec<u8>,
    model: Vec<u8>,
    plan: Vec<u8>,
    recordings: Vec<Recording>,
}

static SOUND: LazyLock<Sound> = LazyLock::new(|| {
    let folder = scratch("no_panic_sound");
    std::fs::copy(project("urdf/planar_2r.urdf"), folder.join("arm.urdf")).unwrap();
    let plan = ["plan", "arm.urdf", "-o", "plan", "--rate-hz", "40", "-q"];
    run_in(&folder, &plan).fine();
    run_in(&folder, &["simulate", "arm.urdf", "plan", "-o", "runs", "-q"]).fine();
    let fit = ["identify", "arm.urdf", "runs/e001.csv", "--save-model", "model.json", "-q"];
    run_in(&folder, &fit).fine();
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let plan: Plan = serde_json::from_slice(&read("runs/plan.json")).unwrap();
    let recordings = plan
        .experiments
        .iter()
        .map(|e| read_csv_from(&read(&format!("runs/{}.csv", e.id))[..], "sound").unwrap())
        .collect();
    Sound {
        urdf: read("arm.urdf"),
        csv: read("runs/e001.csv"),
        model: read("model.json"),
        plan: read("runs/plan.json"),
        recordings,
    }
});

/// One change of a file; places are shares of its length.
#[derive(Debug, Clone)]
enum Edit {
    Set(f64, u8),
    Delete(f64, usize),
    Insert(f64, &'static str),
    Repeat(f64, usize),
    CutOff(f64),
    /// another number in the place of the one at or behind the place
    Number(f64, &'static str),
}

fn edit() -> impl Strategy<Value = Edit> {
    let number = prop::sample::select(vec![
        "0", "-1", "1e-320", "1e308", "-1e308", "1e999", "nan", "NaN", "inf", "null", "1e16", "",
    ]);
    let piece = prop::sample::select(vec![
        "<", "/>", "\"", ",", "\n", "{", "}", "[", "]", "null", "\0", "\u{feff}", "<link/>", ";",
    ]);
    prop_oneof![
        1 => (0.0..1.0, any::<u8>()).prop_map(|(at, byte)| Edit::Set(at, byte)),
        1 => (0.0..1.0, 1..80_usize).prop_map(|(at, n)| Edit::Delete(at, n)),
        1 => (0.0..1.0, piece).prop_map(|(at, piece)| Edit::Insert(at, piece)),
        1 => (0.0..1.0, 1..300_usize).prop_map(|(at, n)| Edit::Repeat(at, n)),
        1 => (0.0..1.0).prop_map(Edit::CutOff),
        5 => (0.0..1.0, number).prop_map(|(at, number)| Edit::Number(at, number)),
    ]
}

fn edited(sound: &[u8], edits: &[Edit]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for edit in edits {
        let place = |at: &f64| ((at * bytes.len() as f64) as usize).min(bytes.len());
        match edit {
            Edit::Set(at, byte) => {
                let at = place(at);
                if let Some(old) = bytes.get_mut(at) {
                    *old = *byte;
                }
            }
            Edit::Delete(at, n) => {
                let at = place(at);
                bytes.drain(at..(at + n).min(bytes.len()));
            }
            Edit::Insert(at, piece) => {
                let at = place(at);
                bytes.splice(at..at, piece.bytes());
            }
            Edit::Repeat(at, n) => {
                let at = place(at);
                let piece = bytes[at..(at + n).min(bytes.len())].to_vec();
                bytes.splice(at..at, piece);
            }
            Edit::CutOff(at) => {
                let at = place(at);
                bytes.truncate(at);
            }
            Edit::Number(at, number) => {
                let of_number = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
                let from = place(at);
                if let Some(start) = bytes[from..].iter().position(u8::is_ascii_digit) {
                    let start = from + start;
                    let length = bytes[start..].iter().take_while(|b| of_number(b)).count();
                    bytes.splice(start..start + length, number.bytes());
                }
            }
        }
    }
    bytes
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    prop::collection::vec(edit(), 1..4)
}

/// From a URDF to its minimal set.
fn through_urdf(bytes: &[u8]) {
    let Ok(robot) = parse_urdf_bytes(bytes, "arm.urdf") else { return };
    let Ok(chain) = SerialChain::from_description(&robot, &ChainSelection::default()) else {
        return;
    };
    let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    if let Ok(set) = MinimalSet::of(&model.rigid_arm()) {
        let _ = armident_report::ParamsReport::new(&model, &set).text();
    }
}

/// From a CSV to a fit of the sound arm.
fn through_csv(bytes: &[u8]) {
    let Ok(recording) = read_csv_from(bytes, "run.csv") else { return };
    let joints = ["joint_1", "joint_2"];
    let Ok(motion) = Motion::from_recording(&recording, &joints, &MotionSettings::default()) else {
        return;
    };
    if motion.effort.is_none() {
        return;
    }
    let arm = sound_model().rigid_arm();
    let set = MinimalSet::of(&arm).unwrap();
    let problem = BatchProblem::new(&arm, &set);
    let _ = problem.estimate(&problem.accumulate(&[&motion]));
}

fn sound_model() -> ArmModel {
    ArmModel::parse(std::str::from_utf8(&SOUND.model).unwrap(), "model.json").unwrap()
}

/// A model predicts the sound motion.
fn through_model(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(model) = ArmModel::parse(text, "model.json") else { return };
    let names: Vec<&str> = model.chain.joint_names();
    let settings = MotionSettings { cutoff_hz: model.cutoff_hz, ..MotionSettings::default() };
    if let Ok(motion) = Motion::from_recording(&SOUND.recordings[0], &names, &settings) {
        let _ = model.predict_motion(&motion);
    }
    let _ = MinimalSet::of(&model.rigid_arm());
}

/// A plan with the sound recordings.
fn through_plan(bytes: &[u8]) {
    let Ok(plan) = serde_json::from_slice::<Plan>(bytes) else { return };
    let model = sound_model();
    let joints = model.chain.joint_names();
    if plan.joints != joints || plan.experiments.len() > SOUND.recordings.len() {
        return;
    }
    let settings = MotionSettings::default();
    let motions: Vec<Motion> = SOUND
        .recordings
        .iter()
        .map(|r| Motion::from_recording(r, &joints, &settings).unwrap())
        .collect();
    let arm = model.rigid_arm();
    let set = MinimalSet::of(&arm).unwrap();
    let _ = algorithm2(&arm, &set, &plan, &motions[..plan.experiments.len()]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn urdf_bytes_never_panic(edits in edits()) {
        through_urdf(&edited(&SOUND.urdf, &edits));
    }

    #[test]
    fn csv_bytes_never_panic(edits in edits()) {
        through_csv(&edited(&SOUND.csv, &edits));
    }

    #[test]
    fn model_bytes_never_panic(edits in edits()) {
        through_model(&edited(&SOUND.model, &edits));
    }

    #[test]
    fn plan_bytes_never_panic(edits in edits()) {
        through_plan(&edited(&SOUND.plan, &edits));
    }
}

/// The same through the program: a result or a failure in words.
#[test]
fn program_never_panics() {
    let folder = scratch("no_panic");
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    };
    let run = |line: &str| {
        let args: Vec<&str> = line.split(' ').collect();
        let ran = run_in(Path::new(&folder), &args);
        assert!(matches!(ran.code, 0 | 1), "{line}: exit code {}\n{}", ran.code, ran.stderr);
        assert_eq!(ran.code == 1, ran.stderr.contains("error: "), "{line}: {}", ran.stderr);
    };
    write("arm.urdf", &SOUND.urdf);
    write("motion.csv", &SOUND.csv);
    for (k, number) in ["0", "1e308", "-1e308", "1e-320", "1e16", "nan"].into_iter().enumerate() {
        for at in [0.2, 0.55, 0.9] {
            let change = [Edit::Number(at, number)];
            write("edited.urdf", &edited(&SOUND.urdf, &change));
            run("params edited.urdf");
            write("edited.csv", &edited(&SOUND.csv, &change));
            run("identify arm.urdf edited.csv");
            if k % 2 == 0 {
                run("simulate arm.urdf edited.csv -o out.csv");
                write("edited.json", &edited(&SOUND.model, &change));
                run("predict edited.json motion.csv -o out.csv");
                run("plan edited.urdf -o out");
                write("runs/plan.json", &edited(&SOUND.plan, &change));
                run("identify arm.urdf runs");
            }
        }
    }
}

/// A file of steps with something else at any place, and its commands printed or refused in words.
#[test]
fn analysis_bytes_never_panic() {
    let folder = scratch("no_panic_steps");
    let sound = std::fs::read(crate::shared::project("examples/ur5.toml")).unwrap();
    for k in 0..24 {
        for piece in ["\"", "[", "]", "=", "\n", "{", "\0", "\u{e9}", "1e999", "step"] {
            let at = k as f64 / 24.0;
            for edit in [Edit::Insert(at, piece), Edit::Delete(at, piece.len() * (1 + k))] {
                std::fs::write(folder.join("armident.toml"), edited(&sound, &[edit])).unwrap();
                let ran = run_in(&folder, &["run", "--dry-run"]);
                assert!(matches!(ran.code, 0 | 1), "{k} {piece}: {}", ran.stderr);
                assert_eq!(ran.code == 1, ran.stderr.starts_with("error: "), "{}", ran.stderr);
            }
        }
    }
}
