//! Pinocchio, MuJoCo, Drake and OpenUSD load what is exported and compute the same; Isaac Lab's file is run with a stand-in.
//!
//! Needs a Python with `pin`, `mujoco` and `numpy` (and `drake`, `usd-core`): that of `ARMIDENT_PEERS_PYTHON`, or of the folder
//! `peers` in the target folder, which `.ci/run` makes. Without one the test is skipped, and says so.

use std::path::{Path, PathBuf};
use std::process::Command;

use armident_dynamics::{inertia_matrix, inverse_dynamics};
use armident_model::ArmModel;
use rand::{RngExt, SeedableRng};
use serde_json::{Value, json};

use crate::shared::{project, skipped};
use crate::tool::{run, scratch, text};

const STATES: usize = 20;
const ARMS: [&str; 6] = ["scara", "stanford", "puma560", "ur5", "panda", "kinova_gen3"];

/// The Python with other programs; none where there is none.
pub(crate) fn python() -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../peers/bin/python");
    let given = std::env::var_os("ARMIDENT_PEERS_PYTHON").map(PathBuf::from);
    given.or_else(|| own.exists().then_some(own))
}

/// A model of a robot with effects on every joint, as `identify` would leave it.
fn model(name: &str, folder: &Path) -> PathBuf {
    let urdf = project(&format!("urdf/{name}.urdf"));
    let robot = armident_kinematics::load_urdf(&urdf).unwrap();
    let chain = armident_kinematics::SerialChain::from_description(&robot, &Default::default());
    let chain = armident_kinematics::DrivingAxisChain::from_chain(&chain.unwrap());
    let mut model = ArmModel::from_chain(chain);
    // links no body has are refused by simulators: the nearest real ones stand in their place
    let real: Vec<_> =
        model.rigid_arm().links.iter().map(|link| thick(&link.nearest_physical())).collect();
    model = model.with_links(&real);
    for (j, joint) in model.chain.joints.iter().enumerate() {
        for (effect, value) in
            [("viscous_friction", 0.5), ("coulomb_friction", 1.5), ("rotor_inertia", 0.02)]
        {
            let value = value / (1.0 + j as f64);
            model.effects.push(armident_effects::EffectOnJoint::new(effect, &joint.name, [value]));
        }
    }
    let path = folder.join(format!("{name}.json"));
    model.save(&path).unwrap();
    path
}

/// The link with a small ball added: flat links and points are refused too.
fn thick(
    link: &armident_kinematics::InertialParameters,
) -> armident_kinematics::InertialParameters {
    let ball = armident_kinematics::InertialParameters::from_com(
        1e-3,
        link.com_m(),
        nalgebra::Matrix3::identity() * 1e-5,
    );
    link.plus(&ball)
}

/// States with efforts of the rigid body and the inertia matrix, row by row.
fn states(model: &ArmModel) -> Value {
    let arm = model.rigid_arm();
    let mut random = rand_pcg::Pcg64::seed_from_u64(1992);
    let mut draw = |range: f64| -> Vec<f64> {
        (0..arm.dof()).map(|_| random.random_range(-range..range)).collect()
    };
    let states: Vec<Value> = (0..STATES)
        .map(|_| {
            let (q, v, a) = (draw(1.5), draw(2.0), draw(5.0));
            json!({
                "effort": inverse_dynamics(&arm, &q, &v, &a),
                "inertia": inertia_matrix(&arm, &q).as_slice(),
                "q": q, "v": v, "a": a,
            })
        })
        .collect();
    let effects: Vec<Value> = (model.effects.iter())
        .map(|e| json!({ "effect": e.effect, "joint": e.joint, "value": e.parameters[0] }))
        .collect();
    json!({ "joints": model.chain.joint_names(), "states": states, "effects": effects })
}

/// An arm in MJCF with what its format allows: degrees, Euler angles, defaults by class, anchors, references, frames.
const HAND_WRITTEN: &str = r#"<mujoco model="hand_written">
  <compiler angle="degree" eulerseq="zyx"/>
  <option gravity="0.3 -0.2 -9.7"/>
  <default>
    <joint damping="0.4" range="-170 170"/>
    <default class="big"><joint armature="0.05" frictionloss="1.5"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <frame pos="0 0 0.2" axisangle="0 0 1 30">
      <body name="turret" euler="10 20 30" childclass="big">
        <inertial pos="0.01 0.02 0.1" mass="4" diaginertia="0.025 0.03 0.01" quat="0.9 0.1 0.2 0.3"/>
        <joint name="turn" axis="0 0 1" ref="15"/>
        <body name="upper" pos="0 0.1 0.3" xyaxes="0 1 0 -1 0 0.2">
          <inertial pos="0.2 0 0" mass="2.5" fullinertia="0.03 0.06 0.07 0.001 -0.002 0.003"/>
          <joint name="shoulder" class="main" axis="0 1 1" pos="0.05 0 -0.02"/>
          <body name="tube" pos="0.4 0 0" zaxis="1 0 0.1">
            <inertial pos="0 0 0.1" mass="1.2" diaginertia="0.004 0.004 0.001"/>
            <joint name="slide" type="slide" axis="0 0 1" range="-2 2" ref="0.1" armature="0.7"/>
            <joint name="roll" axis="0 0 1" pos="0.01 0 0"/>
          </body>
        </body>
      </body>
    </frame>
  </worldbody>
  <actuator>
    <motor joint="turn"/><motor joint="shoulder"/><motor joint="slide"/><motor joint="roll"/>
  </actuator>
</mujoco>
"#;

/// MuJoCo computes for a file of its own what this program computes for it.
#[test]
fn mjcf_is_read_as_mujoco_reads_it() {
    let Some(python) = python() else {
        skipped("peers", "no Python with pin and mujoco (ARMIDENT_PEERS_PYTHON, or .ci/run)");
        return;
    };
    let folder = scratch("peers_mjcf");
    let file = folder.join("hand_written.xml");
    std::fs::write(&file, HAND_WRITTEN).unwrap();
    let robot = armident_commands::GivenRobot::open(&file, Default::default()).unwrap();
    let expected = states(&robot.arm(None).unwrap());
    assert_eq!(
        expected["effects"].as_array().unwrap().len(),
        3 + 1 + 3 + 3,
        "{}",
        expected["effects"]
    );
    std::fs::write(folder.join("hand_written.states.json"), expected.to_string()).unwrap();
    let output = Command::new(python)
        .arg(project("tests/peers.py"))
        .args([text(&folder), "--mujoco", "hand_written"])
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
}

#[test]
fn exports_agree_with_other_programs() {
    let Some(python) = python() else {
        skipped("peers", "no Python with pin and mujoco (ARMIDENT_PEERS_PYTHON, or .ci/run)");
        return;
    };
    let folder = scratch("peers");
    for name in ARMS {
        let path = model(name, &folder);
        for end in ["urdf", "xml", "sdf", "usda", "py"] {
            let file = folder.join(format!("{name}.{end}"));
            run(&["export", text(&path), "-o", text(&file)]).fine();
        }
        let expected = states(&ArmModel::load(&path).unwrap());
        std::fs::write(folder.join(format!("{name}.states.json")), expected.to_string()).unwrap();
    }
    let output = Command::new(python)
        .arg(project("tests/peers.py"))
        .arg(&folder)
        .args(ARMS)
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{printed}\n{errors}");
    let absent: Vec<&str> = printed.lines().filter_map(|l| l.strip_prefix("skipped: ")).collect();
    for program in &absent {
        skipped("peers", &format!("no {program} from PyPI"));
    }
    // programs that are there, each a line per arm
    assert_eq!(
        printed.lines().count(),
        absent.len() + (5 - absent.len()) * ARMS.len(),
        "{printed}"
    );
}
