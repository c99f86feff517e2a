//! Every effect of the library in motion: exact solutions, and the way there and back.

#![allow(clippy::unwrap_used, reason = "a failed test may panic")]

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;

use armident_dynamics::inverse_dynamics_of_motion;
use armident_effects::{
    ArmFrames, Backlash, Effect, EffectOnJoint, JointMotion, Library, LinkGeometryError, Scope,
    WholeArmMotion, directions_with, effect,
};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf, parse_urdf};
use armident_recording::{JointChannels, Recording};
use armident_simulation::{
    ArmState, ForwardSettings, ForwardStepper, SimulatedArm, StepEffort, TrackingGains, Trajectory,
    forward, inverse, track,
};
use nalgebra::Point3;

fn chain_of(file: &str) -> DrivingAxisChain {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf").join(file);
    let robot = load_urdf(&path).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    DrivingAxisChain::from_chain(&chain)
}

/// Two carts on one level rail: 2 kg that carry 1 kg.
fn carts() -> DrivingAxisChain {
    let link = |name: &str, mass: f64| {
        format!(
            r#"<link name="{name}"><inertial><mass value="{mass}"/>
            <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>"#
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            r#"<joint name="{name}" type="prismatic"><parent link="{parent}"/>
            <child link="{child}"/><axis xyz="1 0 0"/><limit effort="100" velocity="10"/></joint>"#
        )
    };
    let urdf = [
        r#"<robot name="carts"><link name="base"/>"#,
        &link("lower", 2.0),
        &link("upper", 1.0),
        &joint("rail", "base", "lower"),
        &joint("slide", "lower", "upper"),
        "</robot>",
    ]
    .concat();
    let robot = parse_urdf(&urdf, "carts.urdf").unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    DrivingAxisChain::from_chain(&chain)
}

fn on(slug: &str, joint: &str, parameters: &[f64]) -> EffectOnJoint {
    EffectOnJoint::new(slug, joint, parameters)
}

/// Effects on both carts; the upper one is held by friction unless something acts on it.
fn carts_with(effects: &[EffectOnJoint]) -> SimulatedArm {
    let mut all = effects.to_vec();
    if effects.iter().all(|e| e.other_joint.is_none()) {
        all.push(on("coulomb_friction", "slide", &[1e3]));
    }
    SimulatedArm::on_chain(&carts(), &all).unwrap()
}

/// State of the rail after a constant push from rest.
fn pushed(arm: &SimulatedArm, push_n: f64, seconds: f64) -> (f64, f64) {
    let mut stepper = ForwardStepper::new(arm, ArmState::at_rest(vec![0.0; 2]), 0.0).unwrap();
    let steps = (seconds / 5e-4).round() as usize;
    for _ in 0..steps {
        stepper.step(seconds / steps as f64, &StepEffort::constant(&[push_n, 0.0])).unwrap();
    }
    (stepper.state().position[0], stepper.state().velocity[0])
}

#[test]
fn asymmetric_friction_holds_more_in_one_direction() {
    let arm = carts_with(&[on("asymmetric_coulomb_friction", "rail", &[5.0, 2.0])]);
    assert_eq!(pushed(&arm, 4.9, 0.5), (0.0, 0.0));
    assert_eq!(pushed(&arm, -1.9, 0.5), (0.0, 0.0));
    // (8 - 5) / 3 kg and (8 - 2) / 3 kg
    let ((_, forward), (_, backward)) = (pushed(&arm, 8.0, 0.5), pushed(&arm, -8.0, 0.5));
    assert!((forward - 0.5).abs() < 1e-9 && (backward + 1.0).abs() < 1e-9, "{forward} {backward}");
}

#[test]
fn stribeck_friction_holds_more_at_rest() {
    let arm = carts_with(&[on("stribeck_friction", "rail", &[5.0, 3.0, 0.05])]);
    assert_eq!(pushed(&arm, 4.9, 0.5), (0.0, 0.0));
    let start = ArmState { position: vec![0.0; 2], velocity: vec![1.0, 0.0] };
    let mut stepper = ForwardStepper::new(&arm, start, 0.0).unwrap();
    for _ in 0..1000 {
        stepper.step(5e-4, &StepEffort::constant(&[4.5, 0.0])).unwrap();
    }
    // far above the Stribeck velocity: (4.5 - 3) / 3 kg
    assert!((stepper.state().velocity[0] - 1.25).abs() < 1e-9);
}

/// `τ = M a + F + µ M |a|`: the friction is part of what it depends on.
#[test]
fn load_dependent_friction_agrees_with_its_load() {
    let arm = carts_with(&[on("load_dependent_friction", "rail", &[2.0, 0.4])]);
    assert_eq!(pushed(&arm, 1.9, 0.5), (0.0, 0.0));
    let (_, velocity) = pushed(&arm, 8.3, 0.5);
    let exact = 0.5 * (8.3 - 2.0) / (3.0 * 1.4);
    assert!((velocity - exact).abs() < 1e-5, "{velocity} {exact}");
}

/// A push below the level bends the bristles: `f = Fc (1 - exp(-s0 q / Fc))`.
#[test]
fn presliding_joint_settles_where_bristles_hold() {
    let arm = carts_with(&[on("presliding_hysteresis", "rail", &[3.0, 1000.0, 120.0])]);
    let mut stepper = ForwardStepper::new(&arm, ArmState::at_rest(vec![0.0; 2]), 0.0).unwrap();
    // a slow push: what overshoots has another way back
    for k in 0..6000 {
        let push = 1.5 * (f64::from(k) / 3000.0).min(1.0);
        stepper.step(1e-3, &StepEffort::constant(&[push, 0.0])).unwrap();
    }
    let ArmState { position, velocity } = stepper.state();
    assert!((position[0] - 3e-3 * 2.0_f64.ln()).abs() < 1e-5, "{position:?}");
    assert!(velocity[0].abs() < 1e-5, "{velocity:?}");
}

#[test]
fn springs_ripple_and_drift_follow_formulas() {
    let spring = carts_with(&[on("joint_spring", "rail", &[400.0, 0.02])]);
    let (position, _) = pushed(&spring, 0.0, 0.25);
    let exact = 0.02 * (1.0 - ((400.0_f64 / 3.0).sqrt() * 0.25).cos());
    assert!((position - exact).abs() < 1e-6, "{position} {exact}");

    // ripple is the derivative of an energy
    let ripple = carts_with(&[on("torque_ripple", "rail", &[2.0, 7.0, 0.3, 0.5, -1.0])]);
    let turn = TAU * 7.0;
    let energy =
        |q: f64| -2.0 / turn * (turn * q + 0.3).cos() - 0.25 / turn * (2.0 * turn * q - 1.0).cos();
    let (q, v) = pushed(&ripple, 6.0, 0.5);
    let gained = 1.5 * v * v + energy(q) - energy(0.0);
    assert!((gained - 6.0 * q).abs() < 1e-5, "{gained} {}", 6.0 * q);

    let drift = carts_with(&[on("friction_drift", "rail", &[9.0, 3.0, 0.2])]);
    let (_, v) = pushed(&drift, 6.0, 8.0);
    // warm by then: 6 N / 3 N s/m
    assert!((v - 2.0).abs() < 2e-3, "{v}");
}

/// Friction of the common speed alone: the carts move against one another as one.
#[test]
fn coupled_joints_stick_in_common_direction() {
    let mut coupling = on("joint_coupling", "rail", &[2.0, 0.5, 4.0]);
    coupling.other_joint = Some("slide".to_owned());
    let arm = carts_with(&[coupling]);
    let mut stepper = ForwardStepper::new(&arm, ArmState::at_rest(vec![0.0; 2]), 0.0).unwrap();
    for _ in 0..400 {
        stepper.step(1e-3, &StepEffort::constant(&[2.0, 0.0])).unwrap();
        let v = &stepper.state().velocity;
        assert!((v[1] + 2.0 * v[0]).abs() < 1e-12, "{v:?}");
    }
    // one degree of freedom is left: 2 kg at v and 1 kg at v - 2 v
    let v = stepper.state().velocity[0];
    assert!((v - 0.4 * 2.0 / 3.0).abs() < 1e-9, "{v}");
    for _ in 0..2000 {
        stepper.step(1e-3, &StepEffort::constant(&[20.0, 9.0])).unwrap();
    }
    let v = &stepper.state().velocity;
    assert!(v[1] + 2.0 * v[0] > 0.1, "{v:?}");
}

/// A motor of 0.5 kg on a spring before 3 kg, against the exact solution.
#[test]
fn elastic_transmission_oscillates_at_its_resonance() {
    let (force, mass, motor, stiffness) = (3.0, 3.0, 0.5, 200.0);
    let arm = carts_with(&[on("joint_elasticity", "rail", &[stiffness, 0.0, motor])]);
    for seconds in [0.05, 0.3, 0.8] {
        let (position, _) = pushed(&arm, force, seconds);
        let omega = (stiffness * (1.0 / mass + 1.0 / motor)).sqrt();
        let twist = force / (motor * omega * omega) * (1.0 - (omega * seconds).cos());
        let both = force * seconds * seconds / (2.0 * (mass + motor));
        let exact = both + mass / (mass + motor) * twist;
        assert!((position - exact).abs() < 2e-5, "{position} {exact}");
    }
}

/// Free through the gap, then impacts that keep the momentum.
#[test]
fn backlash_keeps_momentum_across_gap() {
    let (force, mass, motor, gap) = (2.0, 3.0, 0.5, 0.02);
    let arm = carts_with(&[on("backlash", "rail", &[gap, 2e5, 200.0, motor])]);
    let mut stepper = ForwardStepper::new(&arm, ArmState::at_rest(vec![0.0; 2]), 0.0).unwrap();
    let impact_s = (gap * motor / force).sqrt();
    let (mut travelled, mut moved) = (0.0, false);
    while stepper.time_s() < 1.0 {
        stepper.step(5e-4, &StepEffort::constant(&[force, 0.0])).unwrap();
        let (time_s, link) = (stepper.time_s(), stepper.link_positions()[0]);
        let motor_at = stepper.state().position[0];
        if time_s < impact_s - 1e-3 {
            assert_eq!(link, 0.0);
            assert!((motor_at - force * time_s * time_s / (2.0 * motor)).abs() < 1e-9);
        }
        moved |= link > 0.0;
        travelled = mass * link + motor * motor_at;
    }
    assert!(moved);
    // the centre of mass does not see the impacts
    let exact = 0.5 * force * stepper.time_s().powi(2);
    assert!((travelled - exact).abs() < 1e-6, "{travelled} {exact}");
    let twist = stepper.state().position[0] - stepper.link_positions()[0];
    assert!(twist.abs() < 0.5 * gap + 1e-3, "{twist}");
}

/// A swing of all joints that starts in motion.
fn swing(joints: &[String], rate_hz: f64, seconds: f64) -> Trajectory {
    let time_s: Vec<f64> = (0..=(seconds * rate_hz) as usize).map(|k| k as f64 / rate_hz).collect();
    let columns = |derivative: u32| -> Vec<Vec<f64>> {
        let joint = |j: usize| {
            let (size, omega) = (0.3 + 0.02 * j as f64, 3.0 + 0.7 * j as f64);
            let phase = 0.7 * j as f64 + 0.2 + f64::from(derivative) * FRAC_PI_2;
            let scale = size * omega.powi(derivative as i32);
            time_s.iter().map(|t| scale * (omega * t + phase).sin()).collect()
        };
        (0..joints.len()).map(joint).collect()
    };
    Trajectory {
        joints: joints.to_vec(),
        position: columns(0),
        velocity: columns(1),
        acceleration: columns(2),
        source: "swing".to_owned(),
        notes: Vec::new(),
        time_s,
    }
}

fn efforts(recording: &Recording) -> Vec<Vec<f64>> {
    recording.joints.iter().map(|joint| joint.effort.clone().unwrap()).collect()
}

fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let one = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
    a.iter().zip(b).map(one).collect()
}

/// Root of the sum of squares without the ends, where a delayed channel shows what was before.
fn size(columns: &[Vec<f64>]) -> f64 {
    let squares = |c: &Vec<f64>| c[20..c.len() - 20].iter().map(|x| x * x).sum::<f64>();
    columns.iter().map(squares).sum::<f64>().sqrt()
}

/// Parameters of every effect that the Stanford arm feels; the joint is the shoulder.
fn example(slug: &str) -> EffectOnJoint {
    let parameters: &[f64] = match slug {
        "asymmetric_coulomb_friction" => &[6.0, 3.0],
        "stribeck_friction" => &[6.0, 3.0, 0.2],
        "load_dependent_friction" => &[2.0, 0.12],
        "presliding_hysteresis" => &[4.0, 150.0, 0.3],
        "friction_drift" => &[5.0, 2.0, 0.8],
        "friction_temperature" => &[5.0, -0.1, 40.0],
        "joint_spring" => &[8.0, 0.3],
        "torque_ripple" => &[3.0, 17.0, 0.4, 1.0, 0.2],
        "torque_scale" => &[1.2],
        "joint_coupling" => &[-1.0, 2.0, 1.5],
        "joint_elasticity" => &[6000.0, 12.0, 0.8],
        "backlash" => &[0.004, 1e5, 150.0, 0.5],
        "encoder_offset" => &[0.03],
        "payload" => &[1.5, 0.02, -0.03, 0.1],
        "link_inertia_error" => &[1.0, 0.1, 0.05, -0.02],
        "gravity_direction" => &[0.05, 0.03, 0.04],
        "time_delay" => &[0.006],
        "external_contact" => &[5.3851648, 3.0, 4.0, -2.0],
        "rotor_inertia" => &[0.4],
        "link_geometry_error" => &[0.03, -0.02],
        _ => &[4.0],
    };
    let mut given = on(slug, "joint_2", parameters);
    match slug {
        "joint_coupling" => given.other_joint = Some("joint_3".to_owned()),
        "external_contact" => given.window_s = Some([0.4, 1.1]),
        _ => {}
    }
    given
}

/// The laws that add efforts to those of the given arm.
fn adding() -> impl Iterator<Item = &'static dyn Effect> {
    Library::standard().named().chain([&LinkGeometryError as &dyn Effect])
}

/// What comes out of a controlled simulation satisfies the law: the inverse of the simulated motion
/// reproduces the recorded effort, for every effect of the library.
#[test]
fn inverse_of_simulated_motion_reproduces_effort() {
    let chain = chain_of("stanford.urdf");
    let joints: Vec<String> = chain.joint_names().into_iter().map(str::to_owned).collect();
    let plan = swing(&joints, 2000.0, 1.5);
    let plain = SimulatedArm::on_chain(&chain, &[]).unwrap();
    let start: Vec<f64> = plan.position.iter().map(|c| c[0]).collect();
    let gains = TrackingGains::of_bandwidth(plain.rigid(), &start, 3.0);
    for law in adding() {
        let slug = law.law().slug;
        let arm = SimulatedArm::on_chain(&chain, &[example(slug)]).unwrap();
        let moved = track(&arm, plain.rigid(), &plan, &gains).unwrap();
        let back = Trajectory::from_recording(&moved, &joints, &BTreeMap::new()).unwrap();
        let found = efforts(&moved);
        let effect = size(&difference(&found, &efforts(&inverse(&plain, &back).unwrap())));
        let left = size(&difference(&found, &efforts(&inverse(&arm, &back).unwrap())));
        assert!(effect > 10.0, "{slug} does nothing: {effect}");
        // held efforts kick the springs of transmissions, which a sampled motion shows as cubics;
        // a deflection that turns back within a sample is not seen
        let share = match slug {
            "joint_elasticity" => 0.01,
            "backlash" => 0.05,
            "presliding_hysteresis" => 1e-3,
            _ => 1e-9,
        };
        println!("{slug}: {:.1e}", left / effect);
        assert!(left < share * effect, "{slug}: {left} of {effect} is left");
    }
}

/// What the columns of an estimator give for an effect, joint by joint.
fn by_columns(
    law: &dyn Effect,
    given: &EffectOnJoint,
    chain: &DrivingAxisChain,
    plan: &Trajectory,
    rigid: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let arm = armident_dynamics::RigidArm::from_chain(chain);
    let motion = WholeArmMotion {
        arm: &arm,
        base_from_e0: chain.base_from_e0,
        tip_in_last_m: chain.tip_in_e.translation.vector,
        rate_hz: 2000.0,
        position: &plan.position,
        velocity: &plan.velocity,
        acceleration: &plan.acceleration,
        rigid_effort: rigid,
    };
    let direction: Vec<Vec<f64>> =
        plan.velocity.iter().map(|v| directions_with(v, f64::MIN_POSITIVE)).collect();
    let of_joint = |j: usize| JointMotion {
        kind: arm.joints[j].kind,
        time_s: &plan.time_s,
        position: &plan.position[j],
        velocity: &plan.velocity[j],
        acceleration: &plan.acceleration[j],
        direction: &direction[j],
        rigid_effort: &rigid[j],
        temperature_c: &[],
    };
    let (shape, mut coefficients) = law.shape_and_coefficients(&given.parameters);
    let mut expected = vec![vec![0.0; plan.len()]; chain.dof()];
    let mut add = |joint: usize, column: &[f64], by: f64| {
        expected[joint].iter_mut().zip(column).for_each(|(e, x)| *e += by * x);
    };
    match law.law().scope {
        Scope::Joint => add(1, &law.effort(&given.parameters, &of_joint(1)), 1.0),
        Scope::Neighbours => {
            let columns = law.pair_columns(&shape, &of_joint(1), &of_joint(2));
            for ([a, b], by) in columns.iter().zip(&coefficients) {
                add(1, a, *by);
                add(2, b, *by);
            }
        }
        _ => {
            match law.law().slug {
                "joint_elasticity" => {
                    coefficients = vec![1.0 / given.parameters[0]];
                    add(1, &plan.acceleration[1], given.parameters[2]);
                }
                "payload" => coefficients = body_change(chain, 5, given),
                "link_inertia_error" => coefficients = body_change(chain, 1, given),
                _ => {}
            }
            for (column, by) in law.arm_columns(1, &motion).iter().zip(&coefficients) {
                column.iter().enumerate().for_each(|(j, column)| add(j, column, *by));
            }
        }
    }
    expected
}

/// One effect, three uses: the estimator's columns with the coefficients of the parameters are what
/// the simulator adds to the efforts.
#[test]
fn estimator_columns_match_simulated_efforts() {
    let chain = chain_of("stanford.urdf");
    let joints: Vec<String> = chain.joint_names().into_iter().map(str::to_owned).collect();
    let plan = swing(&joints, 2000.0, 1.5);
    let plain = SimulatedArm::on_chain(&chain, &[]).unwrap();
    let rigid = efforts(&inverse(&plain, &plan).unwrap());
    // the columns of backlash are simulated
    for law in adding().filter(|law| law.slug() != Backlash.slug()) {
        let slug = law.law().slug;
        let mut given = example(slug);
        match slug {
            // columns of the whole arm are first-order in these
            "encoder_offset" | "time_delay" | "gravity_direction" | "link_geometry_error" => {
                given.parameters.iter_mut().for_each(|p| *p *= 1e-3);
            }
            "joint_elasticity" => given.parameters = vec![1e6, 3e3, 0.4],
            "external_contact" => given.window_s = None,
            "presliding_hysteresis" => given.parameters[2] = 0.0,
            _ => {}
        }
        let arm = SimulatedArm::on_chain(&chain, std::slice::from_ref(&given)).unwrap();
        let added = difference(&efforts(&inverse(&arm, &plan).unwrap()), &rigid);
        let expected = by_columns(law, &given, &chain, &plan, &rigid);
        let tolerance = match slug {
            // the spring starts with a vibration
            "joint_elasticity" => 0.05,
            "encoder_offset" | "gravity_direction" | "time_delay" | "link_geometry_error" => 2e-3,
            // the columns fade where the common speed changes its sign
            "joint_coupling" => 0.02,
            _ => 1e-6,
        };
        let off = size(&difference(&added, &expected)) / size(&added);
        println!("{slug}: {off:.1e}");
        assert!(off < tolerance, "{slug}: {off}");
    }
}

/// Change of the ten parameters of a link by an effect, in the frame of its joint.
fn body_change(chain: &DrivingAxisChain, joint: usize, given: &EffectOnJoint) -> Vec<f64> {
    let mut arm = armident_dynamics::RigidArm::from_chain(chain);
    let before = arm.links[joint].to_array();
    let law = effect(&given.effect).unwrap();
    law.change_arm(&given.parameters, joint, &ArmFrames::of_chain(chain), &mut arm);
    arm.links[joint].to_array().iter().zip(before).map(|(a, b)| a - b).collect()
}

/// A load, held still, weighs what it weighs: the work of its lift is that of the motors.
#[test]
fn motors_carry_payload() {
    let chain = chain_of("stanford.urdf");
    let (mass, centre) = (2.0, Point3::new(0.05, -0.02, 0.2));
    let load = on("payload", "", &[mass, centre.x, centre.y, centre.z]);
    let with = SimulatedArm::on_chain(&chain, &[load]).unwrap();
    let without = SimulatedArm::on_chain(&chain, &[]).unwrap();
    let q = [0.3, -0.8, 0.2, 0.5, 0.9, -0.4];
    let still: Vec<Vec<f64>> = q.iter().map(|q| vec![*q; 8]).collect();
    let zero = vec![vec![0.0; 8]; 6];
    let effort = |arm: &SimulatedArm| inverse_dynamics_of_motion(arm.rigid(), &still, &zero, &zero);
    let (loaded, empty) = (effort(&with), effort(&without));
    let height = |q: &[f64]| (chain.child_links_in_base(q)[5] * centre).z;
    for j in 0..6 {
        let (mut up, mut down) = (q, q);
        up[j] += 1e-5;
        down[j] -= 1e-5;
        let weight = mass * 9.81 * (height(&up) - height(&down)) / 2e-5;
        assert!((loaded[j][0] - empty[j][0] - weight).abs() < 1e-6, "joint {j}");
    }
}

/// The recorded efforts of a delayed, wrongly scaled channel drive the same motion.
#[test]
fn forward_undoes_gain_and_delay() {
    let push = |t: f64| 5.0 * (6.0 * t).sin();
    let time_s: Vec<f64> = (0..1001).map(|k| 1e-3 * f64::from(k)).collect();
    let recording = |by: &dyn Fn(f64) -> f64| {
        let joint = |name: &str, on: bool| JointChannels {
            effort: Some(time_s.iter().map(|t| if on { by(*t) } else { 0.0 }).collect()),
            ..JointChannels::new(name)
        };
        let joints = vec![joint("rail", true), joint("slide", false)];
        Recording::new("efforts", time_s.clone(), joints).unwrap()
    };
    let run = |effects: &[EffectOnJoint], efforts: &Recording| {
        let start = ArmState::at_rest(vec![0.0; 2]);
        forward(&carts_with(effects), efforts, start, &ForwardSettings::default()).unwrap()
    };
    let plain = run(&[], &recording(&push));
    let sensors = [on("torque_scale", "rail", &[1.3]), on("time_delay", "", &[0.004])];
    let found = run(&sensors, &recording(&|t| 1.3 * push((t - 0.004).max(0.0))));
    let position = |r: &Recording| r.joint("rail").unwrap().position.clone().unwrap();
    for (a, b) in position(&plain).iter().zip(position(&found)).take(990) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}
