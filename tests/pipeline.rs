//! What was put into a simulation comes out of the identification; what was learnt predicts.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

use armident_recording::{Quantity, Recording, read_csv};
use serde_json::Value;

use crate::shared::project;
use crate::tool::UR5_JOINTS as UR5;
use crate::tool::{list, number, read_json, run, run_in, scratch, string, text};

/// Truth, estimate and standard error of one constant.
struct Found {
    label: String,
    truth: f64,
    value: f64,
    error: f64,
    interval: [f64; 2],
}

impl Found {
    fn off(&self) -> f64 {
        (self.value - self.truth).abs()
    }
}

/// Constants of an identification beside those that `params` prints for the same arm.
fn constants(identified: &Value, params: &Value) -> Vec<Found> {
    let truth: BTreeMap<&str, f64> = list(&params["minimal"])
        .iter()
        .map(|row| (string(&row["label"]), number(&row["value"])))
        .collect();
    let found: Vec<Found> = list(&identified["constants"])
        .iter()
        .map(|row| Found {
            label: string(&row["label"]).to_owned(),
            truth: truth[string(&row["label"])],
            value: number(&row["value"]),
            error: number(&row["standard_error"]),
            interval: [0, 1].map(|k| number(&row["interval_95"][k])),
        })
        .collect();
    assert_eq!(found.len(), truth.len());
    found
}

#[track_caller]
fn assert_exact(found: &[Found], tolerance: f64) {
    for f in found {
        assert!(f.off() <= tolerance, "{}: {}, true {}", f.label, f.value, f.truth);
    }
}

/// Value of an effect of the list.
#[track_caller]
fn effect<'a>(identified: &'a Value, slug: &str, joint: &str) -> Option<&'a Value> {
    list(&identified["effects"]).iter().find(|e| e["effect"] == slug && e["joint"] == joint)
}

/// Plans, simulates and identifies one arm of `urdf/`.
struct ByPlan<'a> {
    arm: &'a str,
    chain: &'a [&'a str],
    plan: &'a [&'a str],
    simulate: &'a [&'a str],
}

impl ByPlan<'_> {
    fn run(&self, test: &str) -> (Value, Vec<Found>) {
        let folder = scratch(test);
        let urdf = project(&format!("urdf/{}.urdf", self.arm));
        let urdf = text(&urdf);
        run_in(&folder, &[&["plan", urdf, "-o", "plan", "-q"], self.chain, self.plan].concat())
            .fine();
        let simulate = [&["simulate", urdf, "plan", "-o", "runs", "-q"], self.chain, self.simulate];
        run_in(&folder, &simulate.concat()).fine();
        // the plan tells how the arm is mounted: no chain options here
        let ran = run_in(&folder, &["identify", urdf, "runs", "--json", "-"]).fine();
        let identified = ran.json();
        assert_eq!(identified["schema"], "armident.identify/2");
        assert_eq!(identified["method"], "algorithm2");
        assert_eq!(identified["rank"], identified["parameters"]);
        let params = run(&[&["params", urdf, "--json", "-"], self.chain].concat()).fine().json();
        let found = constants(&identified, &params);
        std::fs::remove_dir_all(folder).unwrap();
        (identified, found)
    }
}

const STANFORD: ByPlan<'_> = ByPlan { arm: "stanford", chain: &[], plan: &[], simulate: &[] };

#[test]
fn algorithm_2_is_exact_on_exact_efforts() {
    let (identified, found) = STANFORD.run("pipeline_exact");
    assert_eq!(found.len(), 33);
    assert_exact(&found, 1e-9);
    assert!(identified["cutoff_hz"].is_null(), "recorded accelerations need no filter");
}

#[test]
fn algorithm_2_is_exact_on_other_structures() {
    for arm in ["scara", "gantry", "cylindrical", "planar_3r", "puma560"] {
        let (_, found) = ByPlan { arm, ..STANFORD }.run("pipeline_structures");
        assert_exact(&found, 1e-9);
    }
}

/// White effort noise: errors as large as the standard errors say.
#[test]
fn algorithm_2_covers_truth_with_noise() {
    let noise = ["--torque-noise", "0.1", "--seed", "3"];
    let (_, found) = ByPlan { simulate: &noise, ..STANFORD }.run("pipeline_noise");
    for f in &found {
        assert!(
            f.error > 0.0 && f.off() <= 5.0 * f.error,
            "{}: {} of {}",
            f.label,
            f.off(),
            f.error
        );
    }
    let inside =
        found.iter().filter(|f| (f.interval[0]..=f.interval[1]).contains(&f.truth)).count();
    assert!(inside as f64 > 0.85 * found.len() as f64, "{inside} of {}", found.len());
}

/// Positions of an encoder and noisy efforts: velocity and acceleration come from the low-pass, and
/// standard errors do not cover what it distorts.
#[test]
fn algorithm_2_is_accurate_with_encoders() {
    let sensors = ["--encoder-bits", "19", "--torque-noise", "0.05", "--seed", "1"];
    let (identified, found) = ByPlan { simulate: &sensors, ..STANFORD }.run("pipeline_encoders");
    assert!(number(&identified["cutoff_hz"]) > 1.0);
    let near = found.iter().filter(|f| f.off() <= 4.0 * f.error).count();
    assert!(near as f64 >= 0.8 * found.len() as f64, "{near} of {}", found.len());
    let largest = found.iter().map(|f| f.off() / f.error).fold(0.0, f64::max);
    println!("{near} of {} within 4 standard errors, largest {largest:.1}", found.len());
}

/// Friction of the moving joint is estimated beside the constants, in steps (58) and (60).
#[test]
fn algorithm_2_tolerates_friction_of_moving_joint() {
    let friction =
        ["--effect", "viscous_friction:joint_2=1.5", "--effect", "coulomb_friction:joint_2=2"];
    let (identified, found) = ByPlan { simulate: &friction, ..STANFORD }.run("pipeline_friction");
    assert_exact(&found, 1e-6);
    for (slug, truth) in [("viscous_friction", 1.5), ("coulomb_friction", 2.0)] {
        let row = effect(&identified, slug, "joint_2").unwrap();
        let value = number(&row["value"]);
        assert!((value - truth).abs() < 1e-5, "{slug}: {value}");
        assert_eq!(row["admissible"], true);
    }
}

/// Held joints that are kept moving a little move the equations too.
#[test]
fn algorithm_2_is_exact_with_dither() {
    let (_, found) = ByPlan { plan: &["--dither", "0.004,3"], ..STANFORD }.run("pipeline_dither");
    assert_exact(&found, 1e-9);
}

/// On a slope axis 1 is not along gravity: two more constants, and all are found.
#[test]
fn algorithm_2_is_exact_on_a_slope() {
    let chain = ["--gravity", "0,6.94,-6.94"];
    let (_, found) = ByPlan { chain: &chain, ..STANFORD }.run("pipeline_slope");
    assert_eq!(found.len(), 35);
    assert_exact(&found, 1e-9);
}

/// Effects put on the joints, as on the command line: slug, joint, value.
const EFFECTS: [(&str, &str, f64); 8] = [
    ("viscous_friction", "shoulder_pan_joint", 12.0),
    ("coulomb_friction", "shoulder_pan_joint", 8.0),
    ("viscous_friction", "elbow_joint", 7.5),
    ("coulomb_friction", "elbow_joint", 5.0),
    ("torque_offset", "elbow_joint", -1.25),
    ("rotor_inertia", "elbow_joint", 0.4),
    ("coulomb_friction", "wrist_2_joint", 1.5),
    ("rotor_inertia", "wrist_3_joint", 0.05),
];

/// Sums of three sines a joint with exact derivatives, 10 s at 100 Hz; `phase` makes another motion.
fn exciting_motion(path: &Path, phase: f64, derivatives: bool) {
    let mut csv = "t".to_owned();
    for joint in UR5 {
        let _ = write!(csv, ",{joint}/position");
        if derivatives {
            let _ = write!(csv, ",{joint}/velocity,{joint}/acceleration");
        }
    }
    csv.push('\n');
    for k in 0..1000 {
        let t = f64::from(k) / 100.0;
        let _ = write!(csv, "{t}");
        for j in 0..UR5.len() {
            let (mut q, mut dq, mut ddq) = (0.3 * (j as f64 + phase).sin(), 0.0, 0.0);
            for harmonic in 1..=3 {
                let n = f64::from(harmonic);
                let w = 2.0 * PI * 0.1 * (n + 0.37 * j as f64);
                let (a, p) = (0.5 / n, phase * n + 1.3 * j as f64);
                let (s, c) = (w * t + p).sin_cos();
                q += a * s;
                dq += a * w * c;
                ddq -= a * w * w * s;
            }
            let _ = write!(csv, ",{q}");
            if derivatives {
                let _ = write!(csv, ",{dq},{ddq}");
            }
        }
        csv.push('\n');
    }
    std::fs::write(path, csv).unwrap();
}

fn column(recording: &Recording, joint: &str, quantity: Quantity) -> Vec<f64> {
    recording.joint(joint).unwrap().channel(quantity).unwrap().to_vec()
}

/// Largest difference of two columns over the largest entry.
fn relative_difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(0.0_f64, |a, e| a.max(e.abs()));
    found.iter().zip(expected).fold(0.0_f64, |a, (f, e)| a.max((f - e).abs())) / largest
}

/// Batch least squares finds constants and joint effects, the model predicts an unseen motion, and
/// efforts drive the motion they came from.
#[test]
fn batch_fit_recovers_simulated_parameters() {
    let folder = scratch("pipeline_batch");
    let urdf = project("urdf/ur5.urdf");
    let urdf = text(&urdf);
    exciting_motion(&folder.join("motion_a.csv"), 0.0, true);
    exciting_motion(&folder.join("motion_b.csv"), 2.1, true);
    let effects: Vec<String> =
        EFFECTS.iter().map(|(slug, joint, value)| format!("{slug}:{joint}={value}")).collect();
    let with_effects: Vec<&str> =
        effects.iter().flat_map(|effect| ["--effect", effect.as_str()]).collect();
    for run_of in ["a", "b"] {
        let (motion, recording) = (format!("motion_{run_of}.csv"), format!("{run_of}.csv"));
        let args = ["simulate", urdf, &motion, "-o", &recording, "-q"];
        run_in(&folder, &[&args, &with_effects[..]].concat()).fine();
    }
    let args = ["identify", urdf, "a.csv", "--holdout", "b.csv", "--save-model", "model.json"];
    let identified = run_in(&folder, &[&args[..], &["--json", "-"]].concat()).fine().json();
    assert_eq!(identified["method"], "batch");
    assert_eq!(identified["rank"], identified["parameters"]);
    assert_eq!(identified["parameters"], 58);

    // what rotor inertia of joints 1 and 2 is part of is as it was: there was none
    let params = run(&["params", urdf, "--json", "-"]).fine().json();
    assert_exact(&constants(&identified, &params), 1e-6);
    for row in list(&identified["effects"]) {
        let put_on = |(slug, joint, value): &(&str, &str, f64)| {
            (row["effect"] == *slug && row["joint"] == *joint).then_some(*value)
        };
        let truth = EFFECTS.iter().find_map(put_on).unwrap_or(0.0);
        let value = number(&row["value"]);
        assert!((value - truth).abs() < 1e-6, "{row}: true {truth}");
    }
    for joint in UR5 {
        let on_holdout = number(&identified["fit"]["holdout"]["relative"][joint]);
        assert!(on_holdout < 1e-6, "{joint}: {on_holdout}");
    }

    // the model on the unseen motion: the simulated effort at every sample
    run_in(&folder, &["predict", "model.json", "motion_b.csv", "-o", "predicted.csv", "-q"]).fine();
    let simulated = read_csv(folder.join("b.csv")).unwrap();
    let predicted = read_csv(folder.join("predicted.csv")).unwrap();
    assert_eq!(predicted.time_s, simulated.time_s);
    for joint in UR5 {
        let [found, expected] =
            [&predicted, &simulated].map(|r| column(r, joint, Quantity::Effort));
        let off = relative_difference(&found, &expected);
        assert!(off < 1e-6, "{joint}: {off}");
    }
    // the same on stdout
    let printed = run_in(&folder, &["predict", "model.json", "motion_b.csv", "-o", "-"]).fine();
    let written = std::fs::read_to_string(folder.join("predicted.csv")).unwrap();
    assert_eq!(printed.stdout, written);

    // judged on it: no effort error, and its efforts drive the arm along the motion
    let judged = run_in(&folder, &["validate", "model.json", "b.csv", "--json", "-"]).fine().json();
    assert_eq!(judged["schema"], "armident.validate/1");
    for joint in UR5 {
        assert!(number(&judged["after"][joint]["relative"]) < 1e-6, "{joint}");
        let [before, after] = ["replay_before", "replay_after"]
            .map(|replay| number(&judged[replay]["position_rms"][joint]));
        assert!(after < 1e-3 && after < 0.01 * before, "{joint}: {after}, before {before}");
    }

    // a second run says the same bytes
    let twice = run_in(&folder, &[&args[..], &["--json", "-"]].concat()).fine().json();
    assert_eq!(twice, identified);
    assert_eq!(read_json(&folder.join("model.json"))["schema"], "armident.model/2");
}

/// A fitted model has friction of either sign within its noise; it simulates all the same.
#[test]
fn identified_model_simulates() {
    let folder = scratch("pipeline_model");
    let urdf = project("urdf/ur5.urdf");
    exciting_motion(&folder.join("motion.csv"), 0.0, true);
    let noisy = ["motion.csv", "-o", "run.csv", "--torque-noise", "0.1", "--seed", "2", "-q"];
    run_in(&folder, &[&["simulate", text(&urdf)], &noisy[..]].concat()).fine();
    let fit = ["identify", text(&urdf), "run.csv", "--save-model", "model.json", "-q"];
    run_in(&folder, &fit).fine();
    let again = ["simulate", "model.json", "motion.csv", "-o", "again.csv", "-q"];
    run_in(&folder, &again).fine();
    run_in(&folder, &["predict", "model.json", "motion.csv", "-o", "predicted.csv", "-q"]).fine();
    let [again, predicted] =
        ["again.csv", "predicted.csv"].map(|file| read_csv(folder.join(file)).unwrap());
    for joint in UR5 {
        let [found, expected] = [&again, &predicted].map(|r| column(r, joint, Quantity::Effort));
        assert!(relative_difference(&found, &expected) < 1e-9, "{joint}");
    }
}

/// A URDF predicts without anything learnt; positions alone are enough, but for what the low-pass
/// takes away.
#[test]
fn predict_accepts_a_urdf() {
    let folder = scratch("pipeline_predict");
    let urdf = project("urdf/ur5.urdf");
    let urdf = text(&urdf);
    exciting_motion(&folder.join("exact.csv"), 0.7, true);
    exciting_motion(&folder.join("positions.csv"), 0.7, false);
    run_in(&folder, &["simulate", urdf, "exact.csv", "-o", "simulated.csv", "-q"]).fine();
    let simulated = read_csv(folder.join("simulated.csv")).unwrap();
    for (motion, tolerance) in [("exact.csv", 1e-12), ("positions.csv", 0.05)] {
        let out = format!("predicted_{motion}");
        let report =
            run_in(&folder, &["predict", urdf, motion, "-o", &out, "--json", "-", "-q"]).fine();
        assert_eq!(report.json()["samples"], 1000);
        assert_eq!(report.json()["joints"], serde_json::json!(UR5));
        let predicted = read_csv(folder.join(&out)).unwrap();
        assert_eq!(predicted.time_s, simulated.time_s);
        for joint in UR5 {
            let [found, expected] =
                [&predicted, &simulated].map(|r| column(r, joint, Quantity::Effort));
            // away from the ends, where a filter knows only one side
            let inner = 100..900;
            let off = relative_difference(&found[inner.clone()], &expected[inner]);
            assert!(off < tolerance, "{motion} {joint}: {off}");
        }
    }
}

/// Efforts of a smooth motion give the motion back.
#[test]
fn forward_simulation_recovers_the_motion() {
    let folder = scratch("pipeline_forward");
    let urdf = project("urdf/planar_2r.urdf");
    let urdf = text(&urdf);
    let mut csv = "t".to_owned();
    for joint in ["joint_1", "joint_2"] {
        let _ = write!(csv, ",{joint}/position,{joint}/velocity,{joint}/acceleration");
    }
    csv.push('\n');
    for k in 0..1000 {
        let t = f64::from(k) / 1000.0;
        let _ = write!(csv, "{t}");
        for (a, w) in [(0.6, 4.0), (0.4, 7.0)] {
            let (s, c) = f64::sin_cos(w * t);
            let _ = write!(csv, ",{},{},{}", a * c, -a * w * s, -a * w * w * c);
        }
        csv.push('\n');
    }
    std::fs::write(folder.join("motion.csv"), csv).unwrap();
    let friction = ["--effect", "viscous_friction:joint_1=0.8"];
    let inverse = ["simulate", urdf, "motion.csv", "-o", "efforts.csv", "-q"];
    run_in(&folder, &[&inverse[..], &friction].concat()).fine();
    let forward =
        ["simulate", urdf, "efforts.csv", "-o", "back.csv", "--direction", "forward", "-q"];
    run_in(&folder, &[&forward[..], &friction].concat()).fine();
    let motion = read_csv(folder.join("motion.csv")).unwrap();
    let back = read_csv(folder.join("back.csv")).unwrap();
    assert_eq!(back.time_s, motion.time_s);
    for joint in ["joint_1", "joint_2"] {
        // efforts between the samples lie on a line: an error of the order of the step squared
        for (quantity, tolerance) in [(Quantity::Position, 1e-4), (Quantity::Velocity, 1e-3)] {
            let [found, expected] = [&back, &motion].map(|r| column(r, joint, quantity));
            let off = relative_difference(&found, &expected);
            assert!(off < tolerance, "{joint} {quantity}: {off}");
        }
    }
}
