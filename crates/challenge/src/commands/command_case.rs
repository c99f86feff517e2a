//! An arm behind position controllers of unknown gains, recorded without efforts.

use std::f64::consts::TAU;

use armident_dynamics::{gravity_effort, inertia_matrix};
use armident_effects::{
    CoulombFriction, Draw, Effect, EffectOnJoint, LoadDependentFriction, PositionControl,
    PositionServo, RotorInertia, StribeckFriction, TorqueOffset, ViscousFriction,
};
use armident_model::ArmModel;
use armident_recording::{JointChannels, Recording};
use armident_simulation::{ArmState, SimulatedArm, closed_loop};

use crate::arms::bundled::Arm;
use crate::arms::robot::Robot;
use crate::error::ChallengeError;
use crate::random::RandomStream;

/// Joints of an arm.
const JOINTS: std::ops::RangeInclusive<usize> = 5..=7;
/// Rates of the logs \[Hz\].
const RATES_HZ: [f64; 3] = [50.0, 100.0, 200.0];
/// Steps of the encoders \[rad\].
const STEPS_RAD: [f64; 2] = [TAU / 4096.0, TAU / 65_536.0];
/// Standard deviation of the noise of a position, in steps of its encoder.
const NOISE_STEPS: f64 = 0.3;
/// Length of a recording \[s\].
const LENGTH_S: f64 = 20.0;
/// Training recordings; one more is the hold-out.
const TRAINING: usize = 3;
/// Step of the simulation \[s\].
const STEP_S: f64 = 1e-3;
/// Natural frequency of a joint behind its controller \[rad/s\].
const NATURAL: [f64; 2] = [20.0, 50.0];
/// Damping over stiffness \[s\].
const DAMPING_S: [f64; 2] = [0.02, 0.1];
/// Inertia of a rotor over that of the links of its joint.
const ROTOR: [f64; 2] = [0.2, 1.0];
/// Delay of the commands \[s\], in this share of the arms.
const DELAY_S: [f64; 2] = [0.005, 0.06];
const DELAYED: f64 = 0.7;
/// Position error that dry friction causes \[rad\].
const DRY_RAD: [f64; 2] = [0.002, 0.025];
/// Position error that an offset causes \[rad\].
const OFFSET_RAD: [f64; 2] = [0.003, 0.02];
/// Share of the load that its friction takes.
const BY_LOAD: [f64; 2] = [0.1, 0.4];
/// Static over Coulomb friction, and the Stribeck velocity \[rad/s\].
const STATIC: [f64; 2] = [1.3, 2.0];
const STRIBECK: [f64; 2] = [0.03, 0.15];

/// An effect on a joint, with its size: RMS change of the recorded positions without it, in standard deviations of the noise of a
/// position (rounding and noise).
#[derive(Debug, Clone)]
pub(crate) struct Present {
    pub(crate) effect: &'static str,
    pub(crate) joint: String,
    pub(crate) size: f64,
}

/// A case: the arm, its recordings, and what is in them.
pub(crate) struct CommandCase {
    pub(crate) robot: String,
    pub(crate) model: ArmModel,
    pub(crate) train: Vec<Recording>,
    pub(crate) holdout: Recording,
    /// Stiffness \[N m/rad\] of each joint.
    pub(crate) stiffness: Vec<f64>,
    /// Of all commands \[s\].
    pub(crate) delay_s: f64,
    pub(crate) present: Vec<Present>,
}

/// The same seed gives the same case; a null has controllers only: stiffness, delay, damping and rotors.
pub(crate) fn command_case(seed: u64, is_null: bool) -> Result<CommandCase, ChallengeError> {
    let mut random = RandomStream::new(seed);
    let (name, robot) = draw_arm(&mut random)?;
    let scene = Scene::draw(&robot, &mut random);
    let mut effects = scene.controllers(&robot, &mut random);
    let hidden_from = effects.len();
    if !is_null {
        effects.extend(scene.hidden(&robot, &mut random));
    }
    let motions: Vec<RandomStream> = (0..=TRAINING).map(|_| random.branch()).collect();
    let exact = |effects: &[EffectOnJoint], k: usize| scene.exact(&robot, effects, &motions[k], k);
    let mut present = Vec::new();
    let with = exact(&effects, 0)?;
    let noise = scene.step_rad * (1.0 / 12.0 + NOISE_STEPS * NOISE_STEPS).sqrt();
    let size = |joint: &str, other: &Recording, share: f64| -> f64 {
        let of =
            |r: &Recording| r.joint(joint).and_then(|c| c.position.clone()).unwrap_or_default();
        let (a, b) = (of(&with), of(other));
        let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum();
        (squares / a.len().max(1) as f64).sqrt() / share / noise
    };
    for (k, effect) in effects.iter().enumerate() {
        let Some(law) = armident_effects::effect(&effect.effect) else { continue };
        let slug = law.slug();
        if k < hidden_from && slug != ViscousFriction.slug() {
            continue;
        }
        let mut without = effects.clone();
        // without damping a joint would not come to its command
        let share = if k < hidden_from { 0.5 } else { 1.0 };
        without[k].parameters.iter_mut().for_each(|p| *p *= 1.0 - share);
        if share == 1.0 {
            without.remove(k);
        }
        let joint = effect.joint.clone();
        let size = size(&joint, &exact(&without, 0)?, share);
        present.push(Present { effect: slug, joint, size });
    }
    let commands = exact_commands(&with);
    for joint in &robot.names {
        let size = size(joint, &commands, 1.0);
        present.push(Present { effect: PositionControl.slug(), joint: joint.clone(), size });
    }
    let recorded = |k: usize, random: &mut RandomStream| -> Result<Recording, ChallengeError> {
        Ok(scene.recorded(exact(&effects, k)?, random))
    };
    let mut train = Vec::new();
    for k in 0..TRAINING {
        train.push(recorded(k, &mut random)?);
    }
    let holdout = recorded(TRAINING, &mut random)?;
    Ok(CommandCase {
        robot: name,
        model: ArmModel::from_chain(robot.chain),
        train,
        holdout,
        stiffness: scene.stiffness,
        delay_s: scene.delay_s,
        present,
    })
}

fn draw_arm(random: &mut RandomStream) -> Result<(String, Robot), ChallengeError> {
    let mut fitting = Vec::new();
    for arm in Arm::all() {
        let robot = Robot::parse(&arm.urdf)?;
        if JOINTS.contains(&robot.dof()) && (0..robot.dof()).all(|j| robot.is_rotational(j)) {
            fitting.push((arm.name, robot));
        }
    }
    let k = random.index(fitting.len());
    Ok(fitting.swap_remove(k))
}

/// Positions that equal their commands.
fn exact_commands(motion: &Recording) -> Recording {
    let mut ideal = motion.clone();
    for joint in &mut ideal.joints {
        joint.position = joint.command.clone();
    }
    ideal
}

/// What a case is made of beside its hidden effects.
struct Scene {
    rate_hz: f64,
    step_rad: f64,
    centre: Vec<f64>,
    travel: Vec<f64>,
    stiffness: Vec<f64>,
    delay_s: f64,
    /// diagonal of the inertia matrix at the centre \[kg m²\]
    inertia: Vec<f64>,
    /// weight at the centre \[N m\]
    weight: Vec<f64>,
}

impl Scene {
    fn draw(robot: &Robot, random: &mut RandomStream) -> Self {
        let n = robot.dof();
        let (mut centre, mut travel) = (Vec::new(), Vec::new());
        for joint in &robot.chain.joints {
            let (low, high) =
                (joint.limits.lower.unwrap_or(-3.0), joint.limits.upper.unwrap_or(3.0));
            let half = (0.4 * (high - low)).min(0.6) * random.between(0.6, 1.0);
            let play = (0.5 * (high - low) - half).clamp(0.0, 0.8);
            centre.push(0.5 * (low + high) + play * random.between(-1.0, 1.0));
            travel.push(half);
        }
        let arm = robot.arm();
        let matrix = inertia_matrix(&arm, &centre);
        let inertia: Vec<f64> = (0..n).map(|j| matrix[(j, j)]).collect();
        let delayed = random.chance(DELAYED);
        let (rate_hz, step_rad) = (random.choose(&RATES_HZ), random.choose(&STEPS_RAD));
        let delay_s = if delayed { random.log_between(DELAY_S[0], DELAY_S[1]) } else { 0.0 };
        let of = |inertia: &f64| inertia * random.log_between(NATURAL[0], NATURAL[1]).powi(2);
        Self {
            rate_hz,
            step_rad,
            stiffness: inertia.iter().map(of).collect(),
            delay_s,
            weight: gravity_effort(&arm, &centre),
            centre,
            travel,
            inertia,
        }
    }

    /// Controllers, what damps them, and the rotors.
    fn controllers(&self, robot: &Robot, random: &mut RandomStream) -> Vec<EffectOnJoint> {
        let mut all = Vec::new();
        for (j, name) in robot.names.iter().enumerate() {
            let stiffness = self.stiffness[j];
            let servo = PositionServo {
                stiffness,
                delay_s: self.delay_s,
                dead_band: 0.0,
                effort_limit: None,
            };
            let damping = stiffness * random.log_between(DAMPING_S[0], DAMPING_S[1]);
            let rotor = self.inertia[j] * random.between(ROTOR[0], ROTOR[1]);
            for (law, parameters) in [
                (PositionControl.slug(), servo.parameters()),
                (ViscousFriction.slug(), vec![damping]),
                (RotorInertia.slug(), vec![rotor]),
            ] {
                all.push(EffectOnJoint::new(law, name, parameters));
            }
        }
        all
    }

    /// One to three effects, in half of the cases beside dry friction of every joint.
    fn hidden(&self, robot: &Robot, random: &mut RandomStream) -> Vec<EffectOnJoint> {
        let n = robot.dof();
        // at most one law of dry friction a joint
        let mut dry: Vec<Option<EffectOnJoint>> = vec![None; n];
        let mut all = Vec::new();
        let level = |j: usize, random: &mut RandomStream| {
            self.stiffness[j] * random.log_between(DRY_RAD[0], DRY_RAD[1])
        };
        if random.chance(0.5) {
            for (j, dry) in dry.iter_mut().enumerate() {
                let parameters = vec![level(j, random)];
                *dry =
                    Some(EffectOnJoint::new(CoulombFriction.slug(), &robot.names[j], parameters));
            }
        }
        for _ in 0..1 + random.index(3) {
            let j = random.index(n);
            let name = &robot.names[j];
            let coulomb = level(j, random);
            let (law, parameters): (&dyn Effect, Vec<f64>) = match random.index(4) {
                0 => (&CoulombFriction, vec![coulomb]),
                1 => {
                    let velocity = random.log_between(STRIBECK[0], STRIBECK[1]);
                    let beyond = random.between(STATIC[0], STATIC[1]);
                    (&StribeckFriction, vec![beyond * coulomb, coulomb, velocity])
                }
                2 if self.weight[j].abs() > 0.01 * self.stiffness[j] => {
                    let share = random.between(BY_LOAD[0], BY_LOAD[1]);
                    (&LoadDependentFriction, vec![coulomb, share])
                }
                _ => {
                    let size = random.log_between(OFFSET_RAD[0], OFFSET_RAD[1]);
                    let sign = if random.chance(0.5) { 1.0 } else { -1.0 };
                    (&TorqueOffset, vec![sign * size * self.stiffness[j]])
                }
            };
            let effect = EffectOnJoint::new(law.slug(), name, parameters);
            if law.slug() != TorqueOffset.slug() {
                dry[j] = Some(effect);
            } else if !all.iter().any(|other: &EffectOnJoint| other.joint == *name) {
                all.push(effect);
            }
        }
        all.extend(dry.into_iter().flatten());
        all
    }

    /// Exact positions under the commands of a recording; every other recording moves between stops.
    fn exact(
        &self,
        robot: &Robot,
        effects: &[EffectOnJoint],
        motion: &RandomStream,
        k: usize,
    ) -> Result<Recording, ChallengeError> {
        let mut random = motion.clone();
        let arm = SimulatedArm::on_chain(&robot.chain, effects)?;
        let samples = (LENGTH_S * self.rate_hz) as usize;
        let time_s: Vec<f64> = (0..samples).map(|t| t as f64 / self.rate_hz).collect();
        let joints = robot.names.iter().enumerate().map(|(j, name)| {
            let unit: Vec<f64> = if k % 2 == 1 {
                between_stops(&time_s, &mut random)
            } else {
                sines(&time_s, &mut random)
            };
            let command = unit.iter().map(|x| self.centre[j] + self.travel[j] * x).collect();
            JointChannels { command: Some(command), ..JointChannels::new(name) }
        });
        let mut recording =
            Recording::new(format!("run_{}", k + 1), time_s.clone(), joints.collect())?;
        let start = recording.joints.iter().filter_map(|joint| Some(joint.command.as_ref()?[0]));
        let start = ArmState::at_rest(start.collect());
        let moved = closed_loop(&arm, 1.0, &recording, start, STEP_S)?;
        for (joint, moved) in recording.joints.iter_mut().zip(moved.joints) {
            joint.position = moved.position;
        }
        Ok(recording)
    }

    /// As an encoder records it.
    fn recorded(&self, mut motion: Recording, random: &mut RandomStream) -> Recording {
        let step = self.step_rad;
        for position in motion.joints.iter_mut().filter_map(|joint| joint.position.as_mut()) {
            for q in position {
                *q = (*q / step + NOISE_STEPS * random.normal()).round() * step;
            }
        }
        motion
    }
}

/// A motion of three frequencies between -1 and 1.
fn sines(time_s: &[f64], random: &mut RandomStream) -> Vec<f64> {
    let terms: Vec<[f64; 3]> = (0..3)
        .map(|_| {
            let frequency_hz = random.log_between(0.05, 0.5);
            [random.between(0.5, 1.0), TAU * frequency_hz, random.between(0.0, TAU)]
        })
        .collect();
    let sum: f64 = terms.iter().map(|term| term[0]).sum();
    let at = |t: &f64| terms.iter().map(|[a, w, p]| a * (w * t + p).sin()).sum::<f64>() / sum;
    time_s.iter().map(at).collect()
}

/// Moves of a second, at a steady speed, to places between -1 and 1, where the joint stops for a second.
fn between_stops(time_s: &[f64], random: &mut RandomStream) -> Vec<f64> {
    let moves = (LENGTH_S / 2.0) as usize + 1;
    let places: Vec<f64> = (0..=moves).map(|_| random.between(-1.0, 1.0)).collect();
    let at = |t: &f64| {
        let k = (t / 2.0).floor() as usize;
        let share = (t - 2.0 * k as f64).min(1.0);
        places[k] + share * (places[k + 1] - places[k])
    };
    time_s.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::command_case;

    #[test]
    fn null_has_controllers_and_nothing_dry() {
        let case = command_case(11, true).unwrap();
        let laws = ["position_control", "viscous_friction"];
        assert!(case.present.iter().all(|p| laws.contains(&p.effect) && p.size > 0.0));
        assert_eq!(case.train.len(), 3);
        let again = command_case(11, true).unwrap();
        assert_eq!(case.holdout, again.holdout);
    }
}
