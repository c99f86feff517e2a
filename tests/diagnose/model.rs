//! Hold-out, model, numbers: what the diagnosis leaves behind.

use serde_json::Value;

use super::{JOINTS, diagnose, diagnosed, holdout_error, named, pairs, recordings, simulate, urdf};
use crate::shared::project;
use crate::tool::{list, number, read_json, run, run_in, scratch, string, text};

/// The hold-out proves and does nothing else; a model stands alone; fields are those of the contract.
#[test]
fn writes_holdout_model_and_fields() {
    let effects = ["torque_offset:wrist_2_joint=0.5", "viscous_friction:elbow_joint=8"];
    let folder = recordings("diagnose_flow", &effects);
    let with = diagnose(&folder, &["--holdout", "holdout.csv", "--save-model", "with.json"]);
    let with = with.fine().json();
    let without = diagnose(&folder, &["--save-model", "without.json"]).fine().json();
    let expected = [("torque_offset", "wrist_2_joint"), ("viscous_friction", "elbow_joint")];
    assert_eq!(named(&with), pairs(&expected));
    // what is found is the same; only the proof is not
    let unproven = |of: &Value| -> Vec<Value> {
        let mut findings = list(&of["findings"]).to_vec();
        for finding in &mut findings {
            finding["confirmed"] = Value::Null;
            finding["evidence"].as_object_mut().unwrap().remove("holdout_gain");
        }
        findings
    };
    assert_eq!(unproven(&with), unproven(&without));
    assert!(list(&with["findings"]).iter().all(|f| f["confirmed"] == true));
    assert!(list(&without["findings"]).iter().all(|f| f["confirmed"].is_null()));
    // both effects are most of the error of their joint
    let gain = |f: &Value| f["evidence"]["holdout_gain"].as_f64();
    assert!(list(&with["findings"]).iter().all(|f| gain(f).is_some_and(|gain| gain > 0.9)));
    assert!(list(&without["findings"]).iter().all(|f| gain(f).is_none()));
    assert!(string(&with["sentence"]).ends_with("are confirmed by the hold-out"));
    assert_eq!(with["verdict"], without["verdict"]);
    assert_eq!(with["fit"]["train"], without["fit"]["train"]);
    assert!(without["fit"]["holdout"].is_null());
    let model = std::fs::read(folder.join("with.json")).unwrap();
    assert!(model == std::fs::read(folder.join("without.json")).unwrap());

    for finding in list(&with["findings"]) {
        assert!(finding["link"].is_null() && finding["window"].is_null());
        assert!(finding["recording"].is_null() && finding["evidence"].is_object());
        assert!((0.5..=1.0).contains(&number(&finding["confidence"])));
        list(&finding["alternatives"]);
        for (name, parameter) in finding["parameters"].as_object().unwrap() {
            assert!(number(&parameter["value"]).is_finite(), "{name}");
            assert!(parameter["stderr"].is_null() || number(&parameter["stderr"]) > 0.0);
            string(&parameter["unit"]);
        }
    }
    for of in ["before", "rigid", "after"] {
        assert_eq!(with["fit"]["holdout"][of].as_object().unwrap().len(), JOINTS.len());
    }

    // nothing but the model and the motion, whose efforts are taken away
    let alone = scratch("diagnose_alone");
    std::fs::write(alone.join("model.json"), model).unwrap();
    let recorded = std::fs::read_to_string(folder.join("holdout.csv")).unwrap();
    let rows: Vec<Vec<&str>> = recorded.lines().map(|line| line.split(',').collect()).collect();
    let kept: Vec<usize> =
        (0..rows[0].len()).filter(|k| !rows[0][*k].ends_with("effort")).collect();
    let motion: Vec<String> = rows
        .iter()
        .enumerate()
        // some samples are lost
        .filter(|(line, _)| line % 50 != 7)
        .map(|(_, row)| kept.iter().map(|k| row[*k]).collect::<Vec<_>>().join(","))
        .collect();
    std::fs::write(alone.join("motion.csv"), motion.join("\n") + "\n").unwrap();
    run_in(&alone, &["predict", "model.json", "motion.csv", "-o", "predicted.csv", "-q"]).fine();
    let predicted = std::fs::read_to_string(alone.join("predicted.csv")).unwrap();
    let lines: Vec<&str> = predicted.lines().collect();
    assert_eq!(lines.len(), motion.len());
    let header: Vec<&str> = lines[0].split(',').collect();
    for joint in JOINTS {
        assert!(header.contains(&format!("{joint}/effort").as_str()), "{joint}");
    }
    let column = header.iter().position(|h| *h == "elbow_joint/effort").unwrap();
    let recorded = rows[0].iter().position(|h| *h == "elbow_joint/effort").unwrap();
    let given = rows.iter().enumerate().filter(|(line, _)| line % 50 != 7).map(|(_, row)| row);
    let mut squares = 0.0;
    for (line, given) in lines.iter().zip(given).skip(1) {
        let values: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        assert!(values.iter().all(|x| x.is_finite()), "{line}");
        assert_eq!(values[0], given[0].parse::<f64>().unwrap());
        squares += (values[column] - given[recorded].parse::<f64>().unwrap()).powi(2);
    }
    let error = (squares / (lines.len() - 1) as f64).sqrt();
    assert!(error < 1.3 * holdout_error(&with, "after", "elbow_joint"), "{error}");
}

/// The bundled recordings: the heavier forearm among friction and rotors on every joint.
#[test]
fn finds_effects_of_bundled_example() {
    let (urdf, folder) = (urdf(), project("examples/ur5"));
    let args = ["diagnose", text(&urdf), "train.csv", "--holdout", "holdout.csv", "--json", "-"];
    let diagnosis = run_in(&folder, &args).fine().json();
    let findings = list(&diagnosis["findings"]);
    let wrong: Vec<&Value> = findings.iter().filter(|f| !f["link"].is_null()).collect();
    assert_eq!(wrong.len(), 1, "{wrong:?}");
    assert_eq!(wrong[0]["joints"][0], "elbow_joint");
    assert!((number(&wrong[0]["parameters"]["delta_mass"]["value"]) - 0.6).abs() < 0.05);
    // nothing that is not there: friction, its offset and rotors are all the rest
    let there = ["viscous_friction", "coulomb_friction", "torque_offset", "rotor_inertia"];
    let same_as_two = "asymmetric_coulomb_friction";
    for finding in findings.iter().filter(|f| f["link"].is_null()) {
        let slug = string(&finding["effect"]);
        assert!(there.contains(&slug) || slug == same_as_two, "{finding}");
    }
    for joint in JOINTS {
        let [before, after] = ["before", "after"].map(|of| holdout_error(&diagnosis, of, joint));
        assert!(after < 0.1 * before, "{joint}: {before} {after}");
    }
}

/// The minimal set beside the findings holds the truth in its intervals: the UR5 with the heavier forearm.
#[test]
fn constants_cover_the_true_arm() {
    use armident_ident::MinimalSet;
    use armident_kinematics::{
        ChainSelection, DrivingAxisChain, InertialParameters, SerialChain, load_urdf,
    };
    use armident_model::ArmModel;
    let robot = load_urdf(&urdf()).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    let mut model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let set = MinimalSet::of(&model.rigid_arm()).unwrap();
    let believed = set.values(&model.rigid_arm().constants());
    // as in examples/make_ur5_recordings.rs
    let forearm = &mut model.chain.joints[2].link;
    let place = forearm.com_m() + nalgebra::Vector3::new(0.05, 0.0, 0.0);
    let added = InertialParameters::from_com(0.6, place, nalgebra::Matrix3::identity() * 0.002);
    *forearm = forearm.plus(&added);
    let truth = set.values(&model.rigid_arm().constants());

    let train = project("examples/ur5/train.csv");
    let urdf = urdf();
    let args = ["diagnose", text(&urdf), text(&train), "-q", "--json", "-"];
    let diagnosis = run(&args).fine().json();
    let constants = list(&diagnosis["constants"]);
    assert_eq!(constants.len(), set.len());
    let mut within = 0;
    for (k, constant) in constants.iter().enumerate() {
        let label = string(&constant["label"]);
        assert_eq!(label, set.labels()[k]);
        assert!((number(&constant["urdf"]) - believed[k]).abs() < 1e-9, "{label}");
        let error = number(&constant["standard_error"]);
        let off = (number(&constant["value"]) - truth[k]) / error;
        assert!(
            error > 0.0 && off.abs() < 5.0,
            "{label} is {off:.1} standard errors off the truth"
        );
        let interval: Vec<f64> = list(&constant["interval_95"]).iter().map(number).collect();
        within += usize::from(interval[0] <= truth[k] && truth[k] <= interval[1]);
        assert!((0.0..=1.0).contains(&number(&constant["prior_share"])), "{label}");
    }
    assert!(
        within * 10 >= constants.len() * 8,
        "{within} of {} intervals hold the truth",
        constants.len()
    );
    // the forearm's first moment is known from the recording, not from the URDF
    let moment = constants.iter().find(|c| c["label"] == "k3_x").unwrap();
    assert!(number(&moment["prior_share"]) < 0.05 && number(&moment["value"]) > 1.7);
}

/// A hold-out of another arm than the one trained on: the finding is not confirmed, and the joint is said on
/// which the model is worse than the robot as given.
#[test]
fn contradicting_holdout_is_not_confirmed() {
    let folder = recordings("diagnose_contradicted", &["coulomb_friction:elbow_joint=4"]);
    simulate(&project("examples/ur5/holdout.csv"), &folder.join("holdout.csv"), "7", &[]);
    let diagnosis = diagnosed(&folder);
    assert_eq!(named(&diagnosis), pairs(&[("coulomb_friction", "elbow_joint")]));
    assert_eq!(diagnosis["findings"][0]["confirmed"], false);
    assert_eq!(diagnosis["worse_on_holdout"], serde_json::json!(["elbow_joint"]));
    let sentence = string(&diagnosis["sentence"]);
    let worse = "hold-out error on elbow_joint is over 10 % larger than with the given model";
    assert!(sentence.ends_with(worse), "{sentence}");
}

/// What is said of a finding is what the saved model has: a friction without the smaller one beside it, too small
/// to be named, would be too large by it.
#[test]
fn findings_equal_model_parameters() {
    let effects = ["coulomb_friction:elbow_joint=4", "viscous_friction:elbow_joint=0.3"];
    let folder = recordings("diagnose_numbers", &effects);
    let diagnosis = diagnose(&folder, &["--save-model", "model.json"]).fine().json();
    assert_eq!(named(&diagnosis), pairs(&[("coulomb_friction", "elbow_joint")]));
    let level = &diagnosis["findings"][0]["parameters"]["level"];
    let model = read_json(&folder.join("model.json"));
    let of_model = |effect: &str| {
        let term = list(&model["effects"])
            .iter()
            .find(|e| e["effect"] == effect && e["joint"] == "elbow_joint");
        term.map(|e| number(&e["parameters"][0]))
    };
    let said = number(&level["value"]);
    assert!((said / of_model("coulomb_friction").unwrap() - 1.0).abs() < 1e-9, "{said}");
    let viscous = of_model("viscous_friction").expect("the small term helps to predict");
    assert!((viscous - 0.3).abs() < 0.1, "{viscous}");
    assert!((said - 4.0).abs() < 3.0 * number(&level["stderr"]), "{said}");
}

/// Positions that shake by themselves from 6 Hz on, as those of a coarse encoder in a loop do: the inertia that the band
/// of 10 Hz gives is too small, and the narrower band is taken and said. Without the shaking it is not.
#[test]
fn encoder_jitter_reduces_bandwidth() {
    let folder = scratch("diagnose_shaking");
    let (mass, inertia, length) = (1.5, 0.02, 0.5);
    let urdf = format!(
        "<robot name=\"pendulum\"><link name=\"base\"/><link name=\"arm\"><inertial>\
         <origin xyz=\"0 0 -{length}\"/><mass value=\"{mass}\"/><inertia ixx=\"{inertia}\" ixy=\"0\" ixz=\"0\" \
         iyy=\"{inertia}\" iyz=\"0\" izz=\"0.01\"/></inertial></link><joint name=\"servo\" type=\"revolute\">\
         <parent link=\"base\"/><child link=\"arm\"/><axis xyz=\"0 1 0\"/>\
         <limit lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"20\"/></joint></robot>"
    );
    std::fs::write(folder.join("arm.urdf"), urdf).unwrap();
    let about_joint = inertia + mass * length * length;
    // amplitude and circular frequency
    let motion = [(0.9, 2.1), (0.5, 5.3), (0.2, 9.7)];
    let shaking = [(2e-3, 43.0), (3e-3, 51.0), (2e-3, 57.0)];
    let found = |shakes: bool| -> Value {
        let mut csv = "t,servo/position,servo/effort\n".to_owned();
        for k in 0..4000 {
            let t = f64::from(k) / 200.0;
            let at = |of: &[(f64, f64)]| of.iter().map(|(a, w)| a * (w * t).sin()).sum::<f64>();
            let q = at(&motion);
            let a: f64 = motion.iter().map(|(a, w)| -a * w * w * (w * t).sin()).sum();
            let noise = f64::from((k * 7919) % 1009) / 1009.0 - 0.5;
            let effort = about_joint * a + mass * 9.81 * length * q.sin() + 0.5 * noise;
            let seen = q + if shakes { at(&shaking) } else { 0.0 };
            csv += &format!("{t},{seen},{effort}\n");
        }
        std::fs::write(folder.join("train.csv"), csv).unwrap();
        let args = ["diagnose", "arm.urdf", "train.csv", "-q", "--json", "-"];
        run_in(&folder, &[&args[..], &["--save-model", "model.json"]].concat()).fine().json()
    };
    let still = found(false);
    assert!(still["comparison_bandwidth_hz"].is_null(), "{still}");
    let shaken = found(true);
    assert_eq!(number(&shaken["comparison_bandwidth_hz"]), 5.0);
    assert_eq!(shaken["verdict"], "match", "{shaken}");
    let link = read_json(&folder.join("model.json"))["joints"][0]["link"].clone();
    let found = number(list(&link).last().unwrap());
    assert!((found / about_joint - 1.0).abs() < 0.03, "{found} {about_joint}");
}

/// A model in the place of the URDF is used whole: what it has is no finding, what is new is one, and both are in
/// the model that is written.
#[test]
fn known_effects_are_no_findings() {
    let known = ["torque_offset:wrist_2_joint=0.5", "viscous_friction:elbow_joint=8"];
    let folder = recordings("diagnose_known", &known);
    diagnose(&folder, &["--save-model", "model.json"]).fine();
    let against = |recording: &str, more: &[&str]| {
        let args = ["diagnose", "model.json", recording, "-q", "--json", "-"];
        run_in(&folder, &[&args, more].concat()).fine().json()
    };
    let nothing = against("holdout.csv", &[]);
    assert_eq!(named(&nothing), pairs(&[]));
    assert_eq!(nothing["verdict"], "match");

    let more = [known[0], known[1], "coulomb_friction:shoulder_lift_joint=12"];
    let trajectory = project("examples/ur5/train.csv");
    simulate(&trajectory, &folder.join("later.csv"), "9", &more);
    let new = against("later.csv", &["--save-model", "whole.json"]);
    assert_eq!(named(&new), pairs(&[("coulomb_friction", "shoulder_lift_joint")]));
    let whole = ["diagnose", "whole.json", "later.csv", "-q", "--json", "-"];
    let all = run_in(&folder, &whole).fine().json();
    assert_eq!(named(&all), pairs(&[]));
    // as good as a diagnosis against the URDF
    let joint = "shoulder_lift_joint";
    let of = |diagnosis: &Value, which: &str| number(&diagnosis["fit"]["train"][which][joint]);
    assert!(of(&new, "after") < 0.5 * of(&new, "before"));
    assert!(of(&all, "before") < 1.02 * of(&new, "after"));
}

/// A model that a diagnosis wrote is validated whole: what only it can hold is in the errors, in their bands and in the
/// predictions.
#[test]
fn validates_the_whole_model() {
    let folder = recordings(
        "diagnose_validate",
        &["torque_scale:elbow_joint=1.2", "torque_offset:wrist_2_joint=0.5"],
    );
    let holdout = ["--holdout", "holdout.csv", "--save-model", "model.json"];
    let diagnosis = diagnose(&folder, &holdout).fine().json();
    let gain = ("torque_scale", "elbow_joint");
    assert_eq!(named(&diagnosis), pairs(&[gain, ("torque_offset", "wrist_2_joint")]));
    let args =
        ["validate", "model.json", "holdout.csv", "-q", "--json", "-", "--predictions", "p.csv"];
    let validated = run_in(&folder, &args).fine().json();
    let mut coverage = 0.0;
    for joint in JOINTS {
        let of = |when: &str, what: &str| number(&validated[when][joint][what]);
        let after = holdout_error(&diagnosis, "after", joint);
        assert!((of("after", "rmse_raw") / after - 1.0).abs() < 0.02, "{joint}: {after}");
        coverage += of("after", "band_coverage") / JOINTS.len() as f64;
    }
    assert!((0.93..=0.97).contains(&coverage), "{coverage}");
    let replayed = |when: &str| number(&validated[when]["position_rms"]["elbow_joint"]);
    assert!(replayed("replay_after") < 0.1 * replayed("replay_before"));
    run_in(&folder, &["predict", "model.json", "holdout.csv", "-o", "q.csv", "-q"]).fine();
    let [p, q] = ["p.csv", "q.csv"].map(|name| std::fs::read(folder.join(name)).unwrap());
    assert!(p == q);

    // what starts from the links says what else there is
    for command in ["check", "identify"] {
        let told = run_in(&folder, &[command, "model.json", "train.csv"]).fine();
        let told = told.stderr.replace('\n', " ");
        let note = "using only the links of model.json; ignoring ";
        assert!(told.contains(note) && told.contains("torque_scale"), "{command}: {told}");
    }
}
