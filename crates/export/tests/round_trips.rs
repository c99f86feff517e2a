//! What is exported and read again is the same arm.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;

use armident_dynamics::{RigidArm, inverse_dynamics};
use armident_effects::{Effect, EffectOnJoint, PositionControl, PositionServo, TorqueOffset};
use armident_export::{mjcf, urdf};
use armident_ident::MinimalSet;
use armident_kinematics::{
    ChainSelection, DrivingAxisChain, SerialChain, load_urdf, parse_mjcf, parse_urdf,
};
use armident_model::ArmModel;

fn model_of(robot: &armident_kinematics::RobotDescription, tip: Option<&str>) -> ArmModel {
    let selection = ChainSelection { tip: tip.map(str::to_owned), ..ChainSelection::default() };
    let chain = SerialChain::from_description(robot, &selection).unwrap();
    ArmModel::from_chain(DrivingAxisChain::from_chain(&chain))
}

fn arms() -> Vec<(String, ArmModel)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf");
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "urdf"))
        .collect();
    paths.sort();
    assert_eq!(paths.len(), 15);
    let name = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
    paths.iter().map(|path| (name(path), model_of(&load_urdf(path).unwrap(), None))).collect()
}

/// A smooth function of the index: states without chance.
fn state(dof: usize, sample: usize, kind: usize) -> Vec<f64> {
    (0..dof).map(|j| (1.7 * (sample + 1) as f64 + 2.3 * j as f64 + kind as f64).sin()).collect()
}

fn assert_same_efforts(name: &str, one: &RigidArm, other: &RigidArm) {
    for sample in 0..20 {
        let [q, dq, ddq] = [0, 1, 2].map(|kind| state(one.dof(), sample, kind));
        let (a, b) = (inverse_dynamics(one, &q, &dq, &ddq), inverse_dynamics(other, &q, &dq, &ddq));
        let size = a.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        for (a, b) in a.iter().zip(b) {
            // frames that were snapped (1e-6 m) are written as they are and snapped again
            assert!((a - b).abs() < 1e-7 * size, "{name}: {a} {b}");
        }
    }
}

#[test]
fn exported_mjcf_is_same_arm() {
    for (name, model) in arms() {
        let robot = parse_mjcf(&mjcf(&model).text, &name).unwrap();
        let again = model_of(&robot.description, None);
        assert_eq!(again.chain.joint_names(), model.chain.joint_names(), "{name}");
        assert_eq!(robot.gravity, <[f64; 3]>::from(model.chain.gravity_base), "{name}");
        assert_same_efforts(&name, &again.rigid_arm(), &model.rigid_arm());
    }
}

#[test]
fn exported_urdf_is_same_arm() {
    for (name, model) in arms() {
        let exported = urdf(&model);
        let robot = parse_urdf(&exported.text, &name).unwrap();
        let again = model_of(&robot, Some(&model.chain.tip_link));
        assert_eq!(again.chain.joint_names(), model.chain.joint_names(), "{name}");
        assert_eq!(again.chain.types(), model.chain.types(), "{name}");
        assert_eq!(again.chain.base_link, model.chain.base_link, "{name}");
        assert_eq!(again.chain.tip_link, model.chain.tip_link, "{name}");
        for (a, b) in again.chain.joints.iter().zip(&model.chain.joints) {
            assert_eq!(a.limits.lower, b.limits.lower, "{name}");
            assert_eq!(a.limits.upper, b.limits.upper, "{name}");
        }
        let (before, after) = (model.rigid_arm(), again.rigid_arm());
        assert_same_efforts(&name, &before, &after);
        // the same minimal set with the same values
        let (one, other) = (MinimalSet::of(&before).unwrap(), MinimalSet::of(&after).unwrap());
        assert_eq!(one.labels(), other.labels(), "{name}");
        let (x, y) = (one.values(&before.constants()), other.values(&after.constants()));
        let size = x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        for (a, b) in x.iter().zip(y) {
            assert!((a - b).abs() < 1e-6 * size, "{name}: {a} {b}");
        }
        // a second export says the same to the digits that matter
        assert_same_efforts(&name, &after, &{
            let robot = parse_urdf(&urdf(&again).text, &name).unwrap();
            model_of(&robot, Some(&model.chain.tip_link)).rigid_arm()
        });
    }
}

fn with_effects() -> ArmModel {
    let (_, mut model) = arms().into_iter().find(|(name, _)| name == "ur5").unwrap();
    let joint = model.chain.joints[1].name.clone();
    let on = |effect: &str, value: f64| EffectOnJoint::new(effect, &joint, [value]);
    model.effects = vec![
        on("viscous_friction", 1.5),
        on("coulomb_friction", 2.5),
        on("torque_offset", -0.5),
        on("rotor_inertia", 0.25),
    ];
    model
}

/// What a format has no place for is listed, and the rest is where simulators look for it.
#[test]
fn effects_are_exported_or_listed_as_lost() {
    let model = with_effects();
    let joint = &model.chain.joints[1].name;
    let slugs = |lost: &[armident_export::Lost]| -> Vec<String> {
        assert!(lost.iter().all(|l| l.joint == *joint));
        lost.iter().map(|l| l.effect.clone()).collect()
    };
    let exported = urdf(&model);
    assert_eq!(slugs(&exported.lost), ["torque_offset", "rotor_inertia"]);
    assert_eq!(exported.held.len(), 2);
    let robot = parse_urdf(&exported.text, "exported").unwrap();
    let dynamics = robot.joints.iter().find(|j| j.name == *joint).unwrap().dynamics.unwrap();
    assert_eq!((dynamics.damping, dynamics.friction), (1.5, 2.5));

    let exported = mjcf(&model);
    assert_eq!(slugs(&exported.lost), ["torque_offset"]);
    let line = exported.text.lines().find(|l| l.contains(&format!("<joint name=\"{joint}\"")));
    let line = line.unwrap();
    for attribute in ["damping=\"1.5\"", "frictionloss=\"2.5\"", "armature=\"0.25\""] {
        assert!(line.contains(attribute), "{line}");
    }
}

/// Names are whatever the robot description says, and gravity is not always downwards.
#[test]
fn names_are_escaped_and_gravity_is_noted() {
    let mut model = with_effects();
    model.chain.robot = "left & \"right\" <arm>".to_owned();
    model.chain.gravity_base = nalgebra::Vector3::new(0.0, 9.81, 0.0);
    let exported = urdf(&model);
    assert_eq!(parse_urdf(&exported.text, "exported").unwrap().name, model.chain.robot);
    assert!(exported.notes.iter().any(|n| n.contains("gravity") && n.contains("9.81")));
    let exported = mjcf(&model);
    assert!(exported.text.contains("gravity=\"0 9.81 0\""), "{}", exported.text);
    assert!(!exported.notes.iter().any(|n| n.contains("gravity")));
}

/// Links that simulators refuse are said.
#[test]
fn links_without_mass_are_noted() {
    let mut model = with_effects();
    model.chain.joints[2].link = armident_kinematics::InertialParameters::zero();
    let name = format!("`{}`", model.chain.joints[2].child_link);
    let said = |notes: &[String]| notes.iter().filter(|n| n.contains(&name)).count();
    assert_eq!(said(&mjcf(&model).notes), 1);
    // URDF has links without inertia
    let exported = urdf(&model);
    assert_eq!(said(&exported.notes), 0, "{:?}", exported.notes);
    assert!(parse_urdf(&exported.text, "exported").is_ok());
}

/// MuJoCo has a body `world` already: a base of this name is that one.
#[test]
fn base_named_world_becomes_worldbody() {
    let mut model = with_effects();
    let bodies = mjcf(&model).text.matches("<body ").count();
    model.chain.base_link = "world".to_owned();
    let text = mjcf(&model).text;
    assert_eq!(text.matches("<body ").count(), bodies - 1);
    assert!(!text.contains("name=\"world\""), "{text}");
    model.chain.base_link = "base".to_owned();
    model.chain.joints[0].child_link = "world".to_owned();
    let exported = mjcf(&model);
    assert!(exported.text.contains("<body name=\"world_link\""));
    assert!(exported.notes.iter().any(|n| n.contains("`world_link`")), "{:?}", exported.notes);
}

/// Every body of MJCF stands in the one before, so that opening and closing tags are of one number.
/// A position controller is a position actuator, or a general one that holds an offset too; what these have no attribute for is listed
/// with its value.
#[test]
fn position_controllers_are_actuators() {
    let mut model = arms().remove(0).1;
    let names: Vec<String> = model.chain.joint_names().iter().map(|n| (*n).to_owned()).collect();
    let servo =
        PositionServo { stiffness: 80.0, delay_s: 0.02, dead_band: 0.0, effort_limit: Some(5.0) };
    let on = EffectOnJoint::new(PositionControl.slug(), &names[0], servo.parameters());
    model.effects.push(on);
    let exported = mjcf(&model);
    let delay = "delay=\"0.02\" nsample=\"42\" interp=\"linear\" forcerange=\"-5 5\"/>";
    let actuator = format!("<position name=\"{0}\" joint=\"{0}\" kp=\"80\" {delay}", names[0]);
    assert!(exported.text.contains(&actuator), "{}", exported.text);
    assert_eq!(exported.text.matches("<motor ").count(), names.len() - 1);
    assert_eq!(exported.held.len(), 3);
    assert!(exported.lost.is_empty());
    assert_eq!(urdf(&model).lost.len(), 1);
    model.effects.push(EffectOnJoint::new(TorqueOffset.slug(), &names[0], [1.5]));
    let affine = "gainprm=\"80\" biastype=\"affine\" biasprm=\"-1.5 -80 0\"";
    let actuator = format!("<general name=\"{0}\" joint=\"{0}\" {affine} {delay}", names[0]);
    let exported = mjcf(&model);
    assert!(exported.text.contains(&actuator), "{}", exported.text);
    assert!(exported.lost.is_empty());
}

#[test]
fn mjcf_bodies_form_one_tree() {
    for (name, model) in arms() {
        let text = mjcf(&model).text;
        assert_eq!(text.matches("<body ").count(), model.chain.dof() + 1, "{name}");
        assert_eq!(text.matches("</body>").count(), model.chain.dof() + 1, "{name}");
        assert_eq!(text.matches("<motor ").count(), model.chain.dof(), "{name}");
    }
}
