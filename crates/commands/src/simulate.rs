//! `simulate`: recordings of an arm in software.

use std::collections::BTreeMap;
use std::str::FromStr;

use armident_effects::EffectOnJoint;
use armident_recording::Recording;
use armident_simulation::{
    ArmState, EffortNoise, ForwardSettings, Sensors, SimulatedArm, Trajectory, forward, inverse,
};

use crate::failure::Failure;
use crate::recordings::joints_with_position;
use crate::robot::{GivenRobot, chain_warnings};

/// Which way an arm is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SimulatedDirection {
    /// Motion to efforts.
    #[default]
    Inverse,
    /// Efforts to motion.
    Forward,
}

/// Level of white effort noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoiseLevel {
    /// Standard deviation \[N m or N\].
    Absolute(f64),
    /// Share of each joint's effort variation.
    Relative(f64),
}

impl FromStr for NoiseLevel {
    type Err = String;

    /// `0.1`, or a share with `%`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (number, relative) = match text.strip_suffix('%') {
            Some(number) => (number, true),
            None => (text, false),
        };
        match number.trim().parse::<f64>() {
            Ok(level) if level < 0.0 => Err(format!("must not be negative, found {level}")),
            Ok(level) if !level.is_finite() => Err(format!("`{number}` is not a finite number")),
            Ok(level) if relative => Ok(Self::Relative(level / 100.0)),
            Ok(level) => Ok(Self::Absolute(level)),
            Err(_) => Err(format!("`{number}` is not a finite number")),
        }
    }
}

/// How recordings are simulated.
#[derive(Debug, Clone, Default)]
pub struct SimulateOptions {
    /// Motion to efforts, or efforts to motion.
    pub direction: SimulatedDirection,
    /// White noise of the efforts.
    pub effort_noise: Option<NoiseLevel>,
    /// Bits per turn or metre that positions are quantised to.
    pub encoder_bits: Option<u32>,
    /// Rate to resample to first \[Hz\].
    pub rate_hz: Option<f64>,
    /// Effects on joints, beside those of the model.
    pub effects: Vec<EffectOnJoint>,
    /// Random seed of the noise.
    pub seed: u64,
}

/// An arm that trajectories are simulated on.
#[derive(Debug)]
pub struct Simulator {
    /// Name of the robot.
    pub robot: String,
    /// Joints of the arm in order.
    pub joints: Vec<String>,
    /// Effects that are simulated.
    pub effects: Vec<EffectOnJoint>,
    /// Notes on what is not simulated.
    pub notes: Vec<String>,
    /// Warnings on the arm.
    pub warnings: Vec<String>,
    arm: SimulatedArm,
    options: SimulateOptions,
}

impl Simulator {
    /// The arm of these trajectories.
    ///
    /// # Errors
    /// A chain that cannot be chosen; effects that the arm cannot have.
    pub fn new(
        robot: &GivenRobot,
        trajectories: &[Recording],
        options: SimulateOptions,
    ) -> Result<Self, Failure> {
        let recorded = match options.direction {
            SimulatedDirection::Inverse => joints_with_position(trajectories),
            SimulatedDirection::Forward => trajectories
                .first()
                .map(|r| r.joint_names().into_iter().map(ToOwned::to_owned).collect())
                .unwrap_or_default(),
        };
        let (model, lost) = robot.arm(Some(&recorded))?.simulated();
        let mut effects = model.effects.clone();
        effects.extend(options.effects.iter().cloned());
        Ok(Self {
            robot: model.chain.robot.clone(),
            joints: model.chain.joints.iter().map(|j| j.name.clone()).collect(),
            arm: SimulatedArm::on_chain(&model.chain, &effects)?,
            effects,
            notes: lost.iter().map(|what| format!("not simulated: {what}")).collect(),
            warnings: chain_warnings(&model),
            options,
        })
    }

    /// The recording of a trajectory, the `k`-th of several from 0, and notes on it.
    ///
    /// # Errors
    /// A trajectory that the arm cannot follow.
    pub fn record(
        &self,
        trajectory: &Recording,
        k: usize,
    ) -> Result<(Recording, Vec<String>), Failure> {
        let Self { joints, options, .. } = self;
        let arm = &self.arm.at_temperatures_of(trajectory);
        let mut notes = Vec::new();
        notes.extend(arm.joints_without_temperature().into_iter().map(|joint| {
            let source = &trajectory.source;
            format!("{source}: no temperature of {joint}: its friction is that at the reference temperature")
        }));
        let exact = match options.direction {
            SimulatedDirection::Inverse => {
                let mut motion = Trajectory::from_recording(trajectory, joints, &BTreeMap::new())?;
                if let Some(rate_hz) = options.rate_hz {
                    motion = motion.resampled(rate_hz)?;
                }
                notes.extend(motion.notes.iter().map(|n| format!("{}: {n}", trajectory.source)));
                inverse(arm, &motion)?
            }
            SimulatedDirection::Forward => {
                let settings =
                    ForwardSettings { rate_hz: options.rate_hz, ..ForwardSettings::default() };
                forward(arm, trajectory, start_state(trajectory, joints), &settings)?
            }
        };
        let sensors = Sensors {
            effort_noise: options.effort_noise.map(|noise| match noise {
                NoiseLevel::Relative(share) => EffortNoise::Relative(share),
                NoiseLevel::Absolute(sigma) => {
                    EffortNoise::Absolute(joints.iter().map(|name| (name.clone(), sigma)).collect())
                }
            }),
            encoder_bits: options.encoder_bits,
            // every trajectory its own noise, the same for the same seed
            seed: options.seed.wrapping_mul(1_000_003).wrapping_add(k as u64),
        };
        Ok((sensors.apply(arm, &exact)?, notes))
    }
}

/// The recorded state at the first sample; at rest at zero where nothing is recorded.
fn start_state(recording: &Recording, joints: &[String]) -> ArmState {
    let first = |pick: fn(&armident_recording::JointChannels) -> &Option<Vec<f64>>| {
        joints
            .iter()
            .map(|name| {
                recording
                    .joint(name)
                    .and_then(|j| pick(j).as_ref())
                    .and_then(|column| column.first().copied())
                    .unwrap_or(0.0)
            })
            .collect()
    };
    ArmState { position: first(|j| &j.position), velocity: first(|j| &j.velocity) }
}
