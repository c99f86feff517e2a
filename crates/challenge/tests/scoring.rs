//! The rules of the score, on small cases written here.
#![allow(
    clippy::unwrap_used,
    clippy::needless_pass_by_value,
    reason = "a failed test may panic; json literals are handed over"
)]

use std::path::{Path, PathBuf};

use armident_challenge::{CaseScore, score_case, score_cases};
use serde_json::{Value, json};

/// A folder that goes with its test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn truth(effects: Value) -> Value {
    json!({
        "schema": "armident.challenge/1", "case": "c", "robot": "r", "tip_link": "tool0",
        "effects": effects, "background_inertial_error": 0.0,
        "affected_joints": ["a", "b"],
        "bodies": { "a": ["link_a"], "b": ["link_b"], "c": ["link_c", "tool0"] },
        "noise": {}, "sample_rate": 200,
        "oracle_rmse": { "a": 1.0, "b": 1.0, "c": 1.0 },
        "attainable_rmse": { "a": 1.1, "b": 2.0, "c": 1.0 },
        "practical_rmse": { "a": 1.2, "b": 1.5, "c": 1.0 },
        "urdf_rmse": { "a": 4.0, "b": 1.0, "c": 1.0 },
        "urdf_rmse_practical": { "a": 4.0, "b": 1.0, "c": 1.0 },
    })
}

fn effect(slug: &str, joints: &[&str], parameters: Value, main: &[&str]) -> Value {
    json!({ "effect": slug, "joints": joints, "link": null, "window": null,
        "parameters": parameters, "main_parameters": main, "accept": [], "tolerate": [] })
}

fn finding(slug: &str, joints: &[&str], confidence: f64) -> Value {
    json!({ "effect": slug, "joints": joints, "link": null, "window": null, "recording": null,
        "parameters": {}, "confidence": confidence, "evidence": {}, "alternatives": [] })
}

fn answer(verdict: &str, findings: Value) -> Value {
    json!({ "schema": "armident.diagnosis/1", "verdict": verdict, "findings": findings,
        "fit": { "holdout": { "before": { "a": 4.0 }, "rigid": {}, "after": { "a": 1.2 } } } })
}

fn score(name: &str, truth: &Value, answer: &Value) -> CaseScore {
    let folder = Folder::new(name);
    std::fs::write(folder.0.join("truth.json"), truth.to_string()).unwrap();
    std::fs::write(folder.0.join("out.json"), answer.to_string()).unwrap();
    score_case(&folder.0, &folder.0).unwrap()
}

#[test]
fn right_answer_has_full_marks() {
    let hidden = effect("rotor_inertia", &["a"], json!({ "inertia": 0.2 }), &["inertia"]);
    let mut found = finding("rotor_inertia", &["a"], 0.9);
    found["parameters"] = json!({ "inertia": { "value": 0.21, "stderr": 0.01, "unit": "kg m2" } });
    let score = score("full", &truth(json!([hidden])), &answer("mismatch", json!([found])));
    assert_eq!(score.named, ["rotor_inertia(a)"]);
    assert!(score.missed.is_empty() && score.false_names.is_empty());
    assert_eq!((score.detected, score.top1, score.located), (Some(true), Some(true), Some(true)));
    assert!((score.parameter_errors[0].1 - 0.05).abs() < 1e-12);
    assert!((score.holdout.after_over_oracle["a"] - 1.2).abs() < 1e-12);
    assert!(score.holdout.suspicious.is_empty());
    assert_eq!(score.reliability, [(0.9, true)]);
}

#[test]
fn null_cases_count_confident_findings() {
    let null = truth(json!([]));
    let found = |confidence| json!([finding("torque_offset", &["a"], confidence)]);
    let alarm = |name: &str, answer: &Value| score(name, &null, answer).false_alarm;
    assert_eq!(alarm("null_silent", &answer("match", json!([]))), Some(false));
    assert_eq!(alarm("null_mismatch", &answer("mismatch", json!([]))), Some(true));
    assert_eq!(alarm("null_unsure", &answer("match", found(0.4))), Some(false));
    assert_eq!(alarm("null_named", &answer("mismatch", found(0.6))), Some(true));
    // with inertial errors of every link either verdict is right, and links may be named
    let mut background = null.clone();
    background["background_inertial_error"] = json!(0.03);
    let links = json!([finding("link_inertia_error", &["a"], 0.9)]);
    let score_of = score("null_background", &background, &answer("mismatch", links));
    assert_eq!(score_of.false_alarm, Some(false));
}

#[test]
fn excess_false_positives_score_zero() {
    let hidden = effect("joint_spring", &["a"], json!({}), &[]);
    let found = |others: &[&str]| {
        let mut all = vec![finding("joint_spring", &["a"], 0.9)];
        all.extend(others.iter().map(|joint| finding("torque_ripple", &[joint], 0.8)));
        answer("mismatch", json!(all))
    };
    let truth = truth(json!([hidden]));
    let one = score("one_false", &truth, &found(&["b"]));
    assert_eq!((one.named.len(), one.false_names.len(), one.discredited), (1, 1, false));
    assert_eq!(one.located, Some(true));
    let two = score("two_false", &truth, &found(&["b", "c"]));
    assert_eq!((two.named.len(), two.false_names.len(), two.discredited), (0, 2, true));
    assert_eq!(two.located, Some(false));
}

#[test]
fn equivalent_findings_are_accepted() {
    let mut hidden = effect("asymmetric_coulomb_friction", &["a"], json!({}), &[]);
    let named = |slug: &str| json!({ "effect": slug, "joints": ["a"], "link": null });
    hidden["accept"] = json!([[named("coulomb_friction"), named("torque_offset")]]);
    hidden["tolerate"] = json!([named("coulomb_friction"), named("torque_offset")]);
    let truth = truth(json!([hidden]));
    let of = |name: &str, slugs: &[&str]| {
        let all: Vec<Value> = slugs.iter().map(|slug| finding(slug, &["a"], 0.9)).collect();
        let score = score(name, &truth, &answer("mismatch", json!(all)));
        (score.named.len(), score.false_names.len())
    };
    assert_eq!(of("accept_both", &["coulomb_friction", "torque_offset"]), (1, 0));
    assert_eq!(of("tolerated", &["asymmetric_coulomb_friction", "torque_offset"]), (1, 0));
    // alone it is neither the right answer nor beside it
    assert_eq!(of("alone", &["coulomb_friction"]), (0, 1));
}

#[test]
fn bodies_are_located_by_link() {
    let mut hidden = effect("payload", &["c"], json!({}), &[]);
    hidden["link"] = json!("link_c");
    hidden["tolerate"] = json!([{ "effect": "link_inertia_error", "joints": [] }]);
    let truth = truth(json!([hidden]));
    let mut load = finding("payload", &[], 0.9);
    load["link"] = json!("tool0");
    let more = |joints: &[&str]| {
        let mut all = vec![load.clone()];
        all.extend(joints.iter().map(|joint| finding("link_inertia_error", &[joint], 0.7)));
        answer("mismatch", json!(all))
    };
    let one = score("body_one", &truth, &more(&["a"]));
    assert_eq!((one.named.len(), one.false_names.len()), (1, 0));
    let two = score("body_two", &truth, &more(&["a", "b"]));
    assert_eq!((two.named.len(), two.false_names.len()), (1, 1));
}

#[test]
fn contacts_couplings_and_unlisted_laws_are_scored() {
    let mut contact = effect("external_contact", &[], json!({ "force": 3.0 }), &["force"]);
    contact["window"] = json!([2.0, 4.0]);
    contact["recording"] = json!("train_2");
    let coupling = effect("joint_coupling", &["a", "b"], json!({ "ratio": 0.5 }), &["ratio"]);
    let mut unlisted = effect("unlisted", &["c"], json!({}), &[]);
    unlisted["variables"] = json!(["c/position"]);
    let truth = truth(json!([contact, coupling, unlisted]));
    let mut found_contact = finding("external_contact", &[], 0.9);
    found_contact["window"] = json!([3.0, 5.0]);
    let mut found_coupling = finding("joint_coupling", &["b", "a"], 0.9);
    found_coupling["parameters"] = json!({ "ratio": { "value": 2.0 } });
    let mut found_unlisted = finding("unmodelled", &["c"], 0.9);
    found_unlisted["evidence"] = json!({ "variables": ["c/position", "c/velocity"] });
    let found = json!([found_contact, found_coupling, found_unlisted]);
    let all = score("arm_wide", &truth, &answer("mismatch", found.clone()));
    assert_eq!(all.named.len(), 3);
    assert!((all.window_iou[0] - 1.0 / 3.0).abs() < 1e-12);
    assert_eq!(all.variables, [0.5]);
    // a force that is not given counts 100 %; the ratio of the pair the other way round is its inverse
    assert_eq!(all.parameter_errors[0].1, 1.0);
    assert!(all.parameter_errors[1].1 < 1e-12);
    let mut elsewhere = found;
    elsewhere[0]["recording"] = json!("train_1");
    let wrong = score("wrong_recording", &truth, &answer("mismatch", elsewhere));
    assert_eq!(wrong.window_iou, [0.0]);
}

#[test]
fn field_cases_count_baseline_friction_separately() {
    let mut field = truth(json!([effect("stribeck_friction", &["a"], json!({}), &[])]));
    field["kind"] = json!("field");
    field["background_inertial_error"] = json!(0.03);
    let baseline = |slug: &str, name: &str, joint: &str, covered: Value, counted: bool| {
        json!({ "effect": slug, "joints": [joint], "parameters": { name: 2.0 },
            "covered_by": covered, "observability": 3.0, "counted": counted })
    };
    field["everyday"] = json!([
        baseline("coulomb_friction", "level", "a", json!("stribeck_friction"), true),
        baseline("coulomb_friction", "level", "b", Value::Null, true),
        baseline("viscous_friction", "coefficient", "b", Value::Null, true),
        baseline("viscous_friction", "coefficient", "c", Value::Null, false),
    ]);
    let mut level = finding("coulomb_friction", &["b"], 0.9);
    level["parameters"] = json!({ "level": { "value": 4.5 } });
    let found = json!([
        finding("stribeck_friction", &["a"], 0.8),
        level,
        finding("viscous_friction", &["c"], 0.95)
    ]);
    let score = score("field", &field, &answer("mismatch", found));
    assert_eq!((score.detected, score.top1), (Some(true), Some(true)));
    assert!(score.false_names.is_empty());
    let baseline = score.baseline;
    assert_eq!((baseline.counted, baseline.named), (3, 2));
    assert_eq!((baseline.with_level, baseline.within_factor_2), (1, 0));
}

#[test]
fn exam_is_judged_sample_by_sample() {
    let folder = Folder::new("exam");
    let (case, result) = (folder.0.join("cases/c"), folder.0.join("results/c"));
    std::fs::create_dir_all(&case).unwrap();
    std::fs::create_dir_all(&result).unwrap();
    let mut hidden = truth(json!([effect("torque_offset", &["a"], json!({}), &[])]));
    hidden["exam"] = json!({ "oracle_rmse": { "a": 0.5 }, "attainable_rmse": { "a": 1.1 } });
    std::fs::write(case.join("truth.json"), hidden.to_string()).unwrap();
    let table = |effort: &dyn Fn(f64) -> f64| {
        let rows = (0..200).map(|k| 0.01 * f64::from(k));
        let rows = rows.map(|t| format!("{t},{}\n", effort(t)));
        format!("t,a/effort\n{}", rows.collect::<String>())
    };
    // wrong by 2 in the middle, by 100 in the first 0.3 s, which do not count
    let off = |t: f64| if t < 0.295 { 100.0 } else { 2.0 };
    std::fs::write(case.join("exam.csv"), table(&|t| t)).unwrap();
    std::fs::write(result.join("predicted.csv"), table(&|t| t + off(t))).unwrap();
    let found = json!([finding("torque_offset", &["a"], 0.9)]);
    std::fs::write(result.join("out.json"), answer("mismatch", found).to_string()).unwrap();
    let board = score_cases(&folder.0.join("cases"), &folder.0.join("results")).unwrap();
    let exam = board.cases[0].exam.as_ref().unwrap();
    assert_eq!((exam.recording, &exam.failed), ("exam", &None));
    assert!((exam.over_oracle["a"] - 4.0).abs() < 1e-9);
    // the diagnosis promised 1.2
    assert_eq!(board.cases[0].holdout.over_claimed, ["a"]);
    assert_eq!(board.groups[0].over_claims.count, 1);

    let short: String = table(&|t| t).lines().take(100).map(|line| format!("{line}\n")).collect();
    std::fs::write(result.join("predicted.csv"), short).unwrap();
    let failed = score_case(&case, &result).unwrap().exam.unwrap().failed.unwrap();
    assert_eq!(failed, "the motion has 200 samples, the prediction 99");
    let text = score_cases(&folder.0.join("cases"), &folder.0.join("results")).unwrap().text();
    assert!(text.contains("predictions failed"), "{text}");
    assert!(text.contains("1 of 1 (100.0 %)"), "{text}");
}

#[test]
fn folder_without_cases_is_rejected() {
    let folder = Folder::new("no_cases");
    let error = score_cases(&folder.0, &folder.0).unwrap_err();
    assert_eq!(error.to_string(), "there is no case in this folder");
    assert!(error.hint().unwrap().contains("truth.json"));
}
