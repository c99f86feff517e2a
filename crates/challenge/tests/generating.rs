//! Generated cases: what is promised about them, on one small arm.

#![allow(clippy::unwrap_used, reason = "a failed test may panic")]

use std::path::{Path, PathBuf};

use armident_challenge::{
    Case, CaseKind, CaseRequest, CaseSeries, SampleRate, SeriesKind, case_effects, generate,
    perturbable, score_case,
};
use armident_recording::{JointChannels, Recording, read_csv, write_csv};
use serde_json::json;

fn request(kind: CaseKind, seed: u64, effects: &[&str]) -> CaseRequest {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf/scara.urdf");
    CaseRequest {
        name: "case".to_owned(),
        robot: "scara".to_owned(),
        robot_urdf: std::fs::read_to_string(file).unwrap(),
        seed,
        kind,
        effects: effects.iter().map(ToString::to_string).collect(),
        background: None,
        perturbed: false,
        margin: None,
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

fn law_residual(case: &Case) -> f64 {
    case.truth.checks.as_ref().unwrap()["law_residual_over_noise"].as_f64().unwrap()
}

#[test]
fn cases_follow_from_their_seed() {
    let make = |seed| generate(&request(CaseKind::Clean, seed, &["coulomb_friction"])).unwrap();
    let (one, again, other) = (make(3), make(3), make(4));
    assert_eq!(one.truth, again.truth);
    assert_eq!(one.train_1, again.train_1);
    assert_ne!(one.train_1, other.train_1);
}

#[test]
fn clean_case_keeps_its_contract() {
    let mut wanted = request(CaseKind::Clean, 7, &["viscous_friction"]);
    wanted.background = Some(0.0);
    let case = generate(&wanted).unwrap();
    let truth = &case.truth;
    assert!(case.robot_urdf.contains("tool0") && truth.tip_link == "tool0");
    let effect = &truth.effects[0];
    let margin = effect.naming_margin.unwrap();
    assert!((1.5..16.0).contains(&margin), "{margin}");
    assert!(effect.observability.unwrap() >= margin - 1e-9);
    assert_eq!(truth.affected_joints, effect.joints);
    assert!(law_residual(&case) < 0.02, "{}", law_residual(&case));
    for (joint, sigma) in &truth.noise.effort_sigma {
        let of = |floor: &std::collections::BTreeMap<String, f64>| floor[joint] / sigma;
        // the noise, and little more for a careful user
        assert!((0.93..1.07).contains(&of(&truth.holdout.oracle_rmse)), "{joint}");
        assert!((0.93..1.3).contains(&of(&truth.holdout.attainable_rmse)), "{joint}");
    }
    // from rest, evenly sampled
    let recording = &case.holdout;
    let SampleRate::All(rate_hz) = truth.sample_rate else { panic!("one rate") };
    assert!((recording.time_s[100] - 100.0 / rate_hz).abs() < 1e-9);
    for joint in &recording.joints {
        let position = joint.position.as_ref().unwrap();
        assert!((position[5] - position[0]).abs() < 1e-3);
    }
}

#[test]
fn field_case_has_friction_and_recording_faults() {
    let case = generate(&request(CaseKind::Field, 11, &["quadratic_drag"])).unwrap();
    let truth = &case.truth;
    assert!(truth.kind() == CaseKind::Field && truth.background_inertial_error >= 0.02);
    assert_eq!(truth.baseline.len(), 8);
    assert!(truth.baseline.iter().filter(|term| term.counted).count() >= 3);
    let dirt = truth.dirt.as_ref().unwrap();
    let steps: Vec<f64> = case.train_1.time_s.windows(2).map(|w| w[1] - w[0]).collect();
    let longest = steps.iter().copied().fold(0.0, f64::max);
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    assert!(longest > 1.7 * median, "no sample is lost");
    let lost = steps.iter().filter(|step| **step > 1.6 * median).count() as f64;
    assert!(lost / steps.len() as f64 <= 2.0 * dirt["lost_samples"].as_f64().unwrap() + 0.01);
    let uneven = steps.iter().filter(|step| (*step / median - 1.0).abs() > 0.02).count();
    assert!(uneven > steps.len() / 3);
    assert!(dirt["effort_lag_over_noise"].as_f64().unwrap() < 0.5);
}

/// The earlier arm has its own friction and no hidden effect; changes of friction are in the truth.
#[test]
fn change_case_has_earlier_recordings() {
    let make = |seed| generate(&request(CaseKind::Change, seed, &["torque_offset"])).unwrap();
    let warmed = |case: &&Case| !case.truth.baseline.is_empty();
    let cases: Vec<Case> = (20..28).map(make).collect();
    assert!((1..8).contains(&cases.iter().filter(warmed).count()));
    let case = cases.iter().find(warmed).unwrap();
    let truth = &case.truth;
    assert_eq!((case.before.len(), truth.kind()), (2, CaseKind::Change));
    assert!(truth.background_inertial_error == 0.0 && truth.holdout.urdf_rmse.is_empty());
    assert_eq!(truth.baseline.len(), 8);
    // all warmer or all colder
    let change = |term: &armident_challenge::BaselineFriction| {
        term.parameters.values().next().copied().unwrap()
    };
    let first = change(&truth.baseline[0]);
    assert!(first != 0.0 && truth.baseline.iter().all(|term| change(term) * first > 0.0));
    // an offset is in the mean of the effort after; before and after, gravity pulls a SCARA's first joint nowhere
    let joint = &truth.effects[0].joints[0];
    let offset = truth.effects[0].parameters["offset"];
    let mean = |recording: &Recording| {
        let effort = recording.joint(joint).unwrap().effort.clone().unwrap();
        effort.iter().sum::<f64>() / effort.len() as f64
    };
    let before = 0.5 * (mean(&case.before[0]) + mean(&case.before[1]));
    let after = 0.5 * (mean(&case.train_1) + mean(&case.train_2));
    assert!(((after - before) / offset - 1.0).abs() < 0.5, "{before} {after} {offset}");
    let folder = folder("change");
    case.write(&folder).unwrap();
    assert!(folder.join("before_2.csv").is_file());
    let refused = generate(&request(CaseKind::Change, 1, &["stribeck_friction"])).unwrap_err();
    assert!(refused.hint().unwrap().contains("no other friction law"), "{refused}");
}

#[test]
fn specialised_friction_replaces_baseline_friction() {
    let case = generate(&request(CaseKind::Field, 5, &["presliding_hysteresis"])).unwrap();
    let effect = &case.truth.effects[0];
    let covered: Vec<_> = case
        .truth
        .baseline
        .iter()
        .filter(|term| term.covered_by.is_some())
        .map(|term| (term.effect.as_str(), term.joints.clone()))
        .collect();
    assert_eq!(covered, [("coulomb_friction", effect.joints.clone())]);
    assert!(effect.parameters["level"] > 0.0);
}

#[test]
fn unknown_effects_are_rejected() {
    let unknown = generate(&request(CaseKind::Clean, 1, &["magic"])).unwrap_err();
    assert!(unknown.to_string().contains("no effect `magic`"));
    let baseline = generate(&request(CaseKind::Field, 1, &["coulomb_friction"])).unwrap_err();
    assert!(baseline.hint().unwrap().contains("anyway"));
    let mut broken = request(CaseKind::Clean, 1, &[]);
    broken.robot_urdf = "<robot".to_owned();
    assert_eq!(generate(&broken).unwrap_err().place(), "robot.urdf");
    assert!(case_effects(CaseKind::Field, 3).iter().all(|slug| slug != "coulomb_friction"));
}

/// Written, read, answered with the truth and the exam itself, scored: full marks.
#[test]
fn written_case_scores_full_marks_for_its_truth() {
    let case = generate(&request(CaseKind::Clean, 9, &["joint_spring"])).unwrap();
    let folder = folder("generated");
    case.write(&folder).unwrap();
    for file in ["train_1.csv", "train_2.csv", "holdout.csv", "exam.csv"] {
        assert!(read_csv(folder.join(file)).unwrap().len() > 1000);
    }
    let effort_only = |joint: &JointChannels| JointChannels {
        effort: joint.effort.clone(),
        ..JointChannels::new(&joint.name)
    };
    let efforts = case.exam.joints.iter().map(effort_only).collect();
    let predicted = Recording::new("exam", case.exam.time_s.clone(), efforts).unwrap();
    write_csv(folder.join("predicted.csv"), &predicted).unwrap();
    let effect = &case.truth.effects[0];
    let parameters: serde_json::Map<String, serde_json::Value> =
        effect.parameters.iter().map(|(name, p)| (name.clone(), json!({ "value": p }))).collect();
    let answer = json!({
        "schema": "armident.diagnosis/1", "verdict": "mismatch",
        "findings": [{ "effect": effect.effect, "joints": effect.joints, "link": null,
            "parameters": parameters, "confidence": 0.9 }],
        "fit": { "holdout": { "before": case.truth.holdout.urdf_rmse,
            "after": case.truth.holdout.oracle_rmse } } });
    std::fs::write(folder.join("out.json"), answer.to_string()).unwrap();
    let score = score_case(&folder, &folder).unwrap();
    assert_eq!((score.named.len(), score.missed.len(), score.false_names.len()), (1, 0, 0));
    assert_eq!(score.parameter_errors, [("joint_spring".to_owned(), 0.0)]);
    assert!(score.exam.unwrap().over_oracle.values().all(|ratio| *ratio == 0.0));
    assert!(score.holdout.suspicious.is_empty(), "{:?}", score.holdout.suspicious);
    let _ = std::fs::remove_dir_all(folder);
}

/// An effect of the size asked for, within the tolerance of the generator.
#[test]
fn requested_margin_is_kept() {
    for margin in [1.0, 6.0] {
        let wanted =
            CaseRequest { margin: Some(margin), ..request(CaseKind::Clean, 5, &["torque_ripple"]) };
        let case = generate(&wanted).unwrap();
        let made = case.truth.effects[0].naming_margin.unwrap();
        assert!((margin / 1.3..=margin * 1.3).contains(&made), "{made} for {margin}");
    }
}

#[test]
fn series_follow_from_their_seed() {
    let series = |kind, perturbed| CaseSeries {
        cases: 8,
        seed: 3,
        kind,
        effects: Vec::new(),
        arm: None,
        perturbed,
        margin: None,
    };
    let mixed = series(SeriesKind::Mixed, false).orders();
    let again = series(SeriesKind::Mixed, false).orders();
    for (k, (one, other)) in mixed.iter().zip(&again).enumerate() {
        assert_eq!((one.seed, &one.effects, &one.arms), (other.seed, &other.effects, &other.arms));
        assert_eq!(one.kind == CaseKind::Field, k % 2 == 1);
    }
    let nulls = series(SeriesKind::Null, false).orders();
    assert!(nulls.iter().all(|order| order.effects.is_empty()));
    let kinds: Vec<(bool, bool)> = nulls
        .iter()
        .map(|order| (order.kind == CaseKind::Field, order.background.unwrap() > 0.0))
        .collect();
    assert_eq!(kinds[..4], [(false, false), (false, true), (true, false), (true, true)]);
    let perturbed = series(SeriesKind::Mixed, true).orders();
    assert!(perturbed.iter().all(|order| perturbable().contains(&order.effects[0].as_str())));
    let is_field = |order: &&armident_challenge::Order| order.kind == CaseKind::Field;
    assert!(perturbed.iter().filter(is_field).all(|order| order.effects[0] != "coulomb_friction"));
}
