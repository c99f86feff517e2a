//! The C source of a controller, compiled with the C compiler that Rust links with, computes what the model predicts.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use armident_dynamics::{inertia_matrix, inverse_dynamics, inverse_dynamics_of_motion};
use armident_effects::{Effect, EffectOnJoint, JointMotion, LoadDependentFriction, ReversalModel};
use armident_export::{
    AlarmThresholds, Exported, ObserverResidual, controller, controller_with_alarm,
};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_recording::{JointChannels, Recording};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const ARMS: [&str; 4] = ["stanford", "scara", "ur5", "panda"];
const STEP_S: f64 = 1e-3;

fn model_of(arm: &str) -> ArmModel {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../urdf/{arm}.urdf"));
    let robot = load_urdf(&path).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    ArmModel::from_chain(DrivingAxisChain::from_chain(&chain))
}

/// Numbers between -1 and 1, the same in every run (Knuth's MMIX generator).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A program that answers the states on its input, one a line, with what `body` prints.
struct Program(PathBuf);

impl Program {
    fn compile(test: &str, model: &ArmModel, body: &str) -> Self {
        Self::of(test, controller(model), body)
    }

    fn of(test: &str, exported: Exported, body: &str) -> Self {
        let companion = exported.companion.unwrap();
        let name = companion.file.strip_suffix(".h").unwrap().to_owned();
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("controller_{test}"));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(&companion.file), companion.text).unwrap();
        std::fs::write(folder.join(format!("{name}.c")), exported.text).unwrap();
        let main = format!(
            "#include <stdio.h>\n#include <string.h>\n#include \"{{header}}\"\n\
             static int read_all(double *x, int n) {{\n  int i;\n  \
             for (i = 0; i < n; i++) if (scanf(\"%lf\", x + i) != 1) return 0;\n  return 1;\n}}\n\
             static void print_all(const double *x, int n) {{\n  int i;\n  \
             for (i = 0; i < n; i++) printf(\"%.17g \", x[i]);\n  printf(\"\\n\");\n}}\n\
             int main(void) {{\n  enum {{ N = ARM_JOINTS }};\n{body}\n  return 0;\n}}\n"
        );
        let main = main.replace("arm_", &format!("{name}_"));
        let main = main.replace("ARM_", &format!("{}_", name.to_uppercase()));
        let main = main.replace("{header}", &companion.file);
        std::fs::write(folder.join("main.c"), main).unwrap();
        let program = folder.join("main");
        let compiled = Command::new("cc")
            .args([
                "-std=c99",
                "-pedantic",
                "-Wall",
                "-Wextra",
                "-Werror",
                "-O2",
                "-ffp-contract=off",
            ])
            .arg("-o")
            .arg(&program)
            .args([folder.join("main.c"), folder.join(format!("{name}.c"))])
            .arg("-lm")
            .output()
            .unwrap();
        assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
        Self(program)
    }

    fn answers(&self, states: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut input = String::new();
        for state in states {
            state.iter().for_each(|x| write!(input, "{x:?} ").unwrap());
            input.push('\n');
        }
        let mut child =
            Command::new(&self.0).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let feed = std::thread::spawn(move || stdin.write_all(input.as_bytes()).unwrap());
        let output = child.wait_with_output().unwrap();
        feed.join().unwrap();
        assert!(output.status.success());
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().map(|l| l.split_whitespace().map(|x| x.parse().unwrap()).collect()).collect()
    }
}

const INVERSE_DYNAMICS: &str = "  double state[3 * N], effort[N];
  static arm_memory memory;
  while (read_all(state, 3 * N)) {
    arm_inverse_dynamics(&memory, state, state + N, state + 2 * N, effort);
    print_all(effort, N);
  }";

/// States one after the other: position, velocity, acceleration.
fn states(dof: usize, count: usize) -> Vec<Vec<f64>> {
    let mut chance = Chance(20_260_127);
    (0..count).map(|_| (0..3 * dof).map(|_| 3.0 * chance.next()).collect()).collect()
}

/// The states as a recording with its derivatives.
fn recording(model: &ArmModel, states: &[Vec<f64>]) -> Recording {
    let dof = model.chain.dof();
    let column = |k: usize| Some(states.iter().map(|state| state[k]).collect());
    let joints = model.chain.joints.iter().enumerate().map(|(j, joint)| JointChannels {
        position: column(j),
        velocity: column(dof + j),
        acceleration: column(2 * dof + j),
        ..JointChannels::new(&joint.name)
    });
    let time_s = (0..states.len()).map(|k| k as f64 * STEP_S).collect();
    Recording::new("states", time_s, joints.collect()).unwrap()
}

/// Effects on every joint, each law on some.
fn with_effects(mut model: ArmModel) -> ArmModel {
    let laws: [(&str, &[f64]); 9] = [
        ("viscous_friction", &[0.7]),
        ("rotor_inertia", &[0.3]),
        ("torque_offset", &[-0.4]),
        ("asymmetric_coulomb_friction", &[1.5, 0.5]),
        ("stribeck_friction", &[2.0, 1.0, 0.4]),
        ("quadratic_drag", &[0.2]),
        ("joint_spring", &[8.0, -0.3]),
        ("torque_ripple", &[0.5, 12.0, 0.4, 0.2, -1.1]),
        ("presliding_hysteresis", &[1.2, 40.0, 0.0]),
    ];
    for (j, joint) in model.chain.joints.iter().enumerate() {
        for (slug, parameters) in laws.iter().skip(j % 3).step_by(2) {
            model.effects.push(EffectOnJoint::new(*slug, &joint.name, parameters.to_vec()));
        }
        model.effects.push(EffectOnJoint::new("coulomb_friction", &joint.name, [1.0 + j as f64]));
        let sublinear = EffectOnJoint::new("sublinear_viscous_friction", &joint.name, [0.6]);
        model.effects.push(sublinear);
    }
    let sharp = ReversalModel::regularised(0.0);
    let mut reversals = vec![sharp; model.chain.dof()];
    reversals[1] = ReversalModel::presliding(0.8);
    model.reversals = Some(reversals);
    model
}

/// 1e-12 of the largest effort of a joint.
#[track_caller]
fn assert_equal(arm: &str, answers: &[Vec<f64>], expected: &[Vec<f64>]) {
    for (j, expected) in expected.iter().enumerate() {
        let largest = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(largest > 0.0, "{arm}, joint {j}");
        assert_eq!(answers.len(), expected.len());
        for (t, (answer, expected)) in answers.iter().zip(expected).enumerate() {
            let apart = (answer[j] - expected).abs();
            assert!(
                apart <= 1e-12 * largest,
                "{arm}, joint {j}, state {t}: {apart:e} of {largest}"
            );
        }
    }
}

#[test]
fn efforts_are_those_of_predict() {
    for arm in ARMS {
        let model = with_effects(model_of(arm));
        assert!(controller(&model).lost.is_empty());
        let states = states(model.chain.dof(), 10_000);
        let answers = Program::compile(arm, &model, INVERSE_DYNAMICS).answers(&states);
        let predicted = model.predict(&recording(&model, &states), None).unwrap();
        assert_equal(arm, &answers, &predicted.efforts);
    }
}

/// Terms that only a band holds: a tilted base, encoder zeros and channel gains.
#[test]
fn operating_point_is_part_of_the_arm() {
    let plain = model_of("ur5");
    let dof = plain.chain.dof();
    let mut model = plain.clone();
    model.base_tilt_rad = [0.05, -0.2];
    model.encoder_offset = (0..dof).map(|j| 0.02 * (j as f64 - 2.0)).collect();
    model.channel_gain = (0..dof).map(|j| 1.0 + 0.1 * j as f64).collect();
    let states = states(dof, 200);
    let answers = Program::compile("point", &model, INVERSE_DYNAMICS).answers(&states);
    let mut arm = plain.rigid_arm();
    let tilt = nalgebra::Vector3::new(0.05, -0.2, 0.0);
    arm.gravity_e0 = armident_effects::tilted(&plain.chain.base_from_e0, &arm.gravity_e0, &tilt);
    for (state, answer) in states.iter().zip(&answers) {
        let q: Vec<f64> =
            state[..dof].iter().zip(&model.encoder_offset).map(|(q, o)| q - o).collect();
        let expected = inverse_dynamics(&arm, &q, &state[dof..2 * dof], &state[2 * dof..]);
        for (j, expected) in expected.iter().enumerate() {
            let expected = expected * model.channel_gain[j];
            assert!((answer[j] - expected).abs() < 1e-9, "joint {j}: {} {expected}", answer[j]);
        }
    }
}

#[test]
fn friction_follows_the_load() {
    let mut model = model_of("panda");
    let dof = model.chain.dof();
    for joint in &model.chain.joints {
        let law = LoadDependentFriction.slug();
        model.effects.push(EffectOnJoint::new(law, &joint.name, vec![0.5, 0.1]));
    }
    let states = states(dof, 300);
    let answers = Program::compile("load", &model, INVERSE_DYNAMICS).answers(&states);
    let channel = |k: usize| -> Vec<Vec<f64>> {
        (0..dof).map(|j| states.iter().map(|state| state[k * dof + j]).collect()).collect()
    };
    let [q, dq, ddq] = [0, 1, 2].map(channel);
    let mut expected = inverse_dynamics_of_motion(&model.rigid_arm(), &q, &dq, &ddq);
    for (j, rigid) in expected.iter_mut().enumerate() {
        let direction: Vec<f64> = dq[j].iter().map(|v| v.signum()).collect();
        let motion = JointMotion {
            kind: model.chain.joints[j].kind,
            time_s: &q[j],
            position: &q[j],
            velocity: &dq[j],
            acceleration: &ddq[j],
            direction: &direction,
            rigid_effort: rigid,
            temperature_c: &[],
        };
        let friction = LoadDependentFriction.effort(&[0.5, 0.1], &motion);
        rigid.iter_mut().zip(friction).for_each(|(e, f)| *e += f);
    }
    assert_equal("panda", &answers, &expected);
}

/// `F = b s + c sign(s)` of the common speed on both joints (vocabulary of the effects, `joint_coupling`).
#[test]
fn coupled_joints_share_friction() {
    let mut model = model_of("ur5");
    let (dof, names) = (model.chain.dof(), model.chain.joint_names());
    let (a, b) = (names[4].to_owned(), names[5].to_owned());
    model.effects.push(EffectOnJoint {
        other_joint: Some(b),
        ..EffectOnJoint::new("joint_coupling", &a, vec![-0.5, 0.3, 2.0])
    });
    let states = states(dof, 300);
    let answers = Program::compile("pair", &model, INVERSE_DYNAMICS).answers(&states);
    for (state, answer) in states.iter().zip(&answers) {
        let dq = &state[dof..2 * dof];
        let mut expected =
            inverse_dynamics(&model.rigid_arm(), &state[..dof], dq, &state[2 * dof..]);
        let speed = dq[5] - 0.5 * dq[4];
        let friction = 0.3 * speed + 2.0 * speed.signum();
        expected[5] += friction;
        expected[4] -= 0.5 * friction;
        let same = expected.iter().zip(answer).all(|(x, y)| (x - y).abs() < 1e-9);
        assert!(same, "{expected:?} {answer:?}");
    }
}

#[test]
fn inertia_matrix_is_that_of_the_arm_and_its_rotors() {
    let body = "  double q[N], inertia[N][N];
  while (read_all(q, N)) {
    arm_inertia_matrix(q, inertia);
    print_all(&inertia[0][0], N * N);
  }";
    for arm in ARMS {
        let mut model = model_of(arm);
        let (dof, first) = (model.chain.dof(), model.chain.joints[0].name.clone());
        model.effects.push(EffectOnJoint::new("rotor_inertia", &first, vec![0.7]));
        let positions: Vec<Vec<f64>> =
            states(dof, 200).into_iter().map(|state| state[..dof].to_vec()).collect();
        let program = Program::compile(&format!("inertia_{arm}"), &model, body);
        for (q, answer) in positions.iter().zip(program.answers(&positions)) {
            let mut expected = inertia_matrix(&model.rigid_arm(), q);
            expected[(0, 0)] += 0.7;
            let largest = expected.amax();
            for i in 0..dof {
                for j in 0..dof {
                    let apart = (answer[dof * i + j] - expected[(i, j)]).abs();
                    assert!(apart < 1e-12 * largest, "{arm} ({i}, {j}): {apart:e} of {largest}");
                }
            }
        }
    }
}

/// A constant effort of the surroundings appears in the residual, and nothing else does.
#[test]
fn observer_finds_efforts_of_the_surroundings() {
    const GAIN: f64 = 40.0;
    const DT_S: f64 = 2e-4;
    const SAMPLES: usize = 5000;
    let body = format!(
        "  double state[3 * N];
  static arm_memory memory;
  static arm_observer observer;
  while (read_all(state, 3 * N)) {{
    arm_observe(&observer, &memory, {GAIN:?}, {DT_S:?}, state, state + N, state + 2 * N);
    print_all(observer.residual, N);
  }}"
    );
    for arm in ARMS {
        let mut model = model_of(arm);
        let dof = model.chain.dof();
        for joint in &model.chain.joints {
            model.effects.push(EffectOnJoint::new("viscous_friction", &joint.name, vec![0.8]));
            model.effects.push(EffectOnJoint::new("rotor_inertia", &joint.name, vec![0.2]));
        }
        model.channel_gain[0] = 1.25;
        let by_surroundings: Vec<f64> = (0..dof).map(|j| 3.0 - j as f64).collect();
        let program = Program::compile(&format!("observer_{arm}"), &model, &body);
        let states: Vec<Vec<f64>> = (0..SAMPLES)
            .map(|k| {
                let t = k as f64 * DT_S;
                let rate = |j: usize| 2.0 + 0.7 * j as f64;
                let of = |f: &dyn Fn(usize, f64) -> f64| -> Vec<f64> {
                    (0..dof).map(|j| f(j, rate(j) * t + j as f64)).collect()
                };
                let q = of(&|_, x| 0.6 * x.sin());
                let dq = of(&|j, x| 0.6 * rate(j) * x.cos());
                let ddq = of(&|j, x| -0.6 * rate(j).powi(2) * x.sin());
                let rigid = inverse_dynamics(&model.rigid_arm(), &q, &dq, &ddq);
                let effort = (0..dof).map(|j| {
                    let motor = rigid[j] + 0.8 * dq[j] + 0.2 * ddq[j] - by_surroundings[j];
                    motor * model.channel_gain[j]
                });
                let effort: Vec<f64> = effort.collect();
                [q, dq, effort].concat()
            })
            .collect();
        let answers = program.answers(&states);
        let last = answers.last().unwrap();
        // the effort at the first sample apart, the residual has come to within exp(-40) of its end; the Euler step of
        // the integral leaves a share of dt times the rates of the efforts
        for j in 0..dof {
            let expected = by_surroundings[j] * model.channel_gain[j];
            assert!((last[j] - expected).abs() < 0.03, "{arm} joint {j}: {} {expected}", last[j]);
        }
    }
}

/// Names that C has no identifiers for, and text that would end a comment.
#[test]
fn names_become_identifiers() {
    let mut model = model_of("scara");
    model.chain.robot = "6-axis */ arm".to_owned();
    model.chain.joints[0].name = "a*/b".to_owned();
    Program::compile("names", &model, INVERSE_DYNAMICS);
    assert_eq!(controller(&model).companion.unwrap().file, "arm_6_axis____arm.h");
}

/// What needs more than the state of a joint is not written, and not lost without a word.
#[test]
fn what_has_no_place_is_listed() {
    let mut model = model_of("scara");
    let joint = model.chain.joints[0].name.clone();
    model.effects.push(EffectOnJoint::new("friction_drift", &joint, vec![2.0, 1.0, 5.0]));
    model.effort_delay_s = 0.01;
    let exported = controller(&model);
    assert_eq!(exported.lost.len(), 1);
    assert_eq!(exported.notes, ["omitted: the lag of the efforts, 0.0100 s"]);
    assert!(exported.companion.unwrap().text.contains("omitted: friction_drift"));
}

/// Rate of recordings in software \[Hz\].
const RATE_HZ: f64 = 20.0;
/// Gain of the observer on them \[1/s\].
const OBSERVER_GAIN: f64 = 2.0;

/// An arm in motion without contact: its efforts are those of the model, white noise, and a disturbance that lasts for half a
/// second and grows with the speed.
fn moving(model: &ArmModel, seconds: f64, seed: u64) -> Recording {
    let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let dof = model.chain.dof();
    let samples = (seconds * RATE_HZ) as usize;
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 / RATE_HZ).collect();
    let waves: Vec<[[f64; 2]; 3]> = (0..dof)
        .map(|j| [0.9, 1.7, 0.31].map(|rate| [rate * (1.0 + 0.13 * j as f64), 3.0 * normal()]))
        .collect();
    let of = |f: &dyn Fn(f64, f64, f64) -> f64| -> Vec<Vec<f64>> {
        let at = |wave: &[[f64; 2]; 3], t: f64| wave.iter().map(|[w, p]| f(*w, w * t + p, t)).sum();
        waves.iter().map(|wave| time_s.iter().map(|t| at(wave, *t)).collect()).collect()
    };
    let position = of(&|_, x, _| 0.4 * x.sin());
    let velocity = of(&|w, x, _| 0.4 * w * x.cos());
    let acceleration = of(&|w, x, _| -0.4 * w * w * x.sin());
    let exact = |j: usize| JointChannels {
        position: Some(position[j].clone()),
        velocity: Some(velocity[j].clone()),
        acceleration: Some(acceleration[j].clone()),
        ..JointChannels::new(&model.chain.joints[j].name)
    };
    let motion = Recording::new("motion", time_s.clone(), (0..dof).map(exact).collect()).unwrap();
    let efforts = model.predict(&motion, None).unwrap().efforts;
    let keep = (-1.0 / (0.5 * RATE_HZ)).exp();
    let joints = (0..dof).map(|j| {
        let mut slow = 0.0;
        let effort = efforts[j].iter().zip(&velocity[j]).map(|(effort, v)| {
            slow = keep * slow + (1.0 - keep * keep).sqrt() * normal();
            effort + 0.5 * normal() + (0.1 + 0.4 * v.abs()) * slow
        });
        JointChannels { effort: Some(effort.collect()), acceleration: None, ..exact(j) }
    });
    Recording::new("recording", time_s, joints.collect()).unwrap()
}

fn with_friction(arm: &str) -> ArmModel {
    let mut model = model_of(arm);
    for joint in &model.chain.joints {
        model.effects.push(EffectOnJoint::new("viscous_friction", &joint.name, [0.8]));
        model.effects.push(EffectOnJoint::new("rotor_inertia", &joint.name, [0.2]));
    }
    model
}

/// The residual on recordings is that of the C source, with what dry friction remembers, tilt, encoder zeros and gains.
#[test]
fn residual_of_recordings_is_that_of_the_source() {
    let body = format!(
        "  double state[3 * N];
  static arm_memory memory;
  static arm_observer observer;
  while (read_all(state, 3 * N)) {{
    arm_observe(&observer, &memory, {OBSERVER_GAIN:?}, {:?}, state, state + N, state + 2 * N);
    print_all(observer.residual, N);
  }}",
        1.0 / RATE_HZ
    );
    let mut model = with_effects(model_of("ur5"));
    let dof = model.chain.dof();
    let recording = moving(&model, 30.0, 3);
    model.base_tilt_rad = [0.05, -0.2];
    model.encoder_offset = (0..dof).map(|j| 0.02 * (j as f64 - 2.0)).collect();
    model.channel_gain = (0..dof).map(|j| 1.0 + 0.1 * j as f64).collect();
    let column = |of: fn(&JointChannels) -> &Option<Vec<f64>>, k: usize| {
        recording.joints.iter().map(move |joint| of(joint).as_ref().unwrap()[k])
    };
    let states: Vec<Vec<f64>> = (0..recording.len())
        .map(|k| {
            let of_motion = column(|j| &j.position, k).chain(column(|j| &j.velocity, k));
            of_motion.chain(column(|j| &j.effort, k)).collect()
        })
        .collect();
    let answers = Program::compile("recorded", &model, &body).answers(&states);
    let found = ObserverResidual::of(&model, &recording, OBSERVER_GAIN).unwrap();
    let start = answers.len() - found.residual[0].len();
    assert_eq!(start as f64, 5.0 / OBSERVER_GAIN * RATE_HZ);
    for (j, residual) in found.residual.iter().enumerate() {
        let largest = residual.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(largest > 0.5);
        for (k, x) in residual.iter().enumerate() {
            let answer = answers[start + k][j];
            assert!((answer - x).abs() < 1e-6 * largest, "joint {j}, {k}: {answer} {x}");
        }
    }
}

/// Observed on hours that the thresholds are not of: within a factor of two, down to a rate that the recordings of the
/// thresholds have ten alarms at.
#[test]
fn false_alarms_are_as_rare_as_requested() {
    let model = with_friction("planar_2r");
    let training = moving(&model, 3600.0, 1);
    let holdout = moving(&model, 4.0 * 3600.0, 2);
    for per_hour in [60.0, 10.0] {
        let recordings = std::slice::from_ref(&training);
        let thresholds = AlarmThresholds::of(&model, recordings, per_hour, OBSERVER_GAIN).unwrap();
        let found = thresholds.observed_on(&model, std::slice::from_ref(&holdout)).unwrap();
        assert!((found.hours - 4.0).abs() < 0.01);
        let ratio = found.per_hour / per_hour;
        assert!((0.5..=2.0).contains(&ratio), "{per_hour} requested: {found:?} {thresholds:?}");
    }
}

/// A constant effort of the smallest detectable size is above the threshold in 95 % of the samples, half of it in few.
#[test]
fn smallest_detectable_effort_is_detected() {
    let model = with_friction("planar_2r");
    let free = moving(&model, 1800.0, 1);
    let thresholds =
        AlarmThresholds::of(&model, std::slice::from_ref(&free), 10.0, OBSERVER_GAIN).unwrap();
    let holdout = moving(&model, 1800.0, 5);
    let found = ObserverResidual::of(&model, &holdout, OBSERVER_GAIN).unwrap();
    for (j, joint) in thresholds.joints.iter().enumerate() {
        // the effort of the surroundings takes that of the motor off, in proportion to the speed's threshold
        let share_above = |part: f64| {
            let pairs = found.residual[j].iter().zip(&found.speed[j]);
            let above = pairs.filter(|(residual, speed)| {
                let [threshold, detectable] = [&joint.threshold, &joint.detectable]
                    .map(|of| between(&joint.speed, of, **speed));
                *residual + part * detectable > threshold
            });
            above.count() as f64 / found.residual[j].len() as f64
        };
        let (whole, half) = (share_above(1.0), share_above(0.5));
        assert!((0.93..=0.995).contains(&whole), "joint {j}: {whole}");
        assert!(half < 0.2, "joint {j}: {half}");
    }
}

/// Linear between the speeds, constant outside.
fn between(speeds: &[f64], values: &[f64], speed: f64) -> f64 {
    let k = speeds.iter().filter(|known| **known < speed).count();
    match k {
        0 => values[0],
        k if k == speeds.len() => values[k - 1],
        k => {
            let share = (speed - speeds[k - 1]) / (speeds[k] - speeds[k - 1]);
            values[k - 1] + share * (values[k] - values[k - 1])
        }
    }
}

/// Thresholds in C are those by joint and speed, and the alarm names the joint that is above its own.
#[test]
fn alarms_of_the_source_follow_the_thresholds() {
    let body = "  double state[2 * N], threshold[N];
  while (read_all(state, 2 * N)) {
    int i;
    arm_observer observer;
    memset(&observer, 0, sizeof observer);
    for (i = 0; i < N; i++) observer.residual[i] = state[N + i];
    arm_thresholds(state, threshold);
    printf(\"%d %g \", arm_alarm(&observer, state), ARM_OBSERVER_GAIN);
    print_all(threshold, N);
  }";
    let model = with_friction("planar_2r");
    let free = moving(&model, 600.0, 1);
    let thresholds =
        AlarmThresholds::of(&model, std::slice::from_ref(&free), 30.0, OBSERVER_GAIN).unwrap();
    let program = Program::of("alarm", controller_with_alarm(&model, &thresholds), body);
    let mut states = Vec::new();
    for speed in [-2.5, -0.3, 0.0, 0.04, 0.6, 1.1, 40.0] {
        let own = [0, 1].map(|j| {
            let joint = &thresholds.joints[j];
            between(&joint.speed, &joint.threshold, f64::abs(speed))
        });
        for (shares, joint) in [([0.9, -0.9], -1.0), ([1.1, 0.0], 0.0), ([1.2, -1.4], 1.0)] {
            states.push((speed, own, shares, joint));
        }
    }
    let input: Vec<Vec<f64>> = states
        .iter()
        .map(|(speed, own, shares, _)| {
            vec![*speed, -*speed, shares[0] * own[0], shares[1] * own[1]]
        })
        .collect();
    for (answer, (speed, own, _, joint)) in program.answers(&input).iter().zip(&states) {
        assert_eq!((answer[0], answer[1]), (*joint, OBSERVER_GAIN), "{speed}");
        for j in 0..2 {
            assert!((answer[2 + j] - own[j]).abs() < 1e-12 * own[j], "{speed}: {answer:?} {own:?}");
        }
    }
}

#[test]
fn short_recordings_give_no_thresholds() {
    let model = with_friction("planar_2r");
    let short = moving(&model, 6.0, 1);
    let of = |gain| AlarmThresholds::of(&model, std::slice::from_ref(&short), 1.0, gain);
    assert_eq!(
        of(2.0).unwrap_err().to_string(),
        "4 s without contact are too short for thresholds"
    );
    let error = of(40.0).unwrap_err().to_string();
    assert_eq!(error, "a gain of 40 1/s is too high for 20.0 Hz: at most 6.7 1/s");
}
