//! One joint of one recording: what its controller is given, what the arm loads it with, and where it went.

use armident_dynamics::{
    ArmMotion, inertia_matrices_of_motion, inverse_dynamics_of_motion, upper_triangle,
};
use armident_kinematics::JointKind;
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings, quantisation_step};
use armident_recording::{Quantity, Recording, RecordingError};
use armident_simulation::JointDrive;

/// Change of a position over which the slope of the weight is taken \[rad or m\].
const SMALL_TURN: f64 = 1e-4;

/// One joint of one recording, at its stamps.
#[derive(Debug, Clone)]
pub(super) struct JointData {
    pub(super) source: String,
    pub(super) kind: JointKind,
    pub(super) gain: f64,
    pub(super) time_s: Vec<f64>,
    /// median time between stamps \[s\]
    pub(super) sample_s: f64,
    pub(super) command: Vec<f64>,
    pub(super) position: Vec<f64>,
    /// low-passed velocity
    pub(super) velocity: Vec<f64>,
    /// effort of the rigid body without the inertia of the joint itself
    pub(super) load: Vec<f64>,
    /// its change by the position of the joint: that of the weight
    pub(super) load_slope: Vec<f64>,
    /// diagonal of the inertia matrix
    pub(super) inertia: Vec<f64>,
    /// step of the position, or the largest number that a rounded one would have
    pub(super) resolution: f64,
    /// largest drive signal over that per position error, where it is at a limit: a position error \[rad or m\] at gain 1
    pub(super) error_limit: Option<f64>,
}

impl JointData {
    /// All joints of all recordings: `[joint][recording]`.
    pub(super) fn of_all(
        model: &ArmModel,
        recordings: &[Recording],
        gains: &[f64],
    ) -> Result<Vec<Vec<Self>>, RecordingError> {
        let mut all: Vec<Vec<Self>> = model.chain.joints.iter().map(|_| Vec::new()).collect();
        for (recording, gain) in recordings.iter().zip(gains) {
            for (joint, data) in Self::of(model, recording, *gain)?.into_iter().enumerate() {
                all[joint].push(data);
            }
        }
        Ok(all)
    }

    /// The joints of one recording.
    fn of(model: &ArmModel, recording: &Recording, gain: f64) -> Result<Vec<Self>, RecordingError> {
        let names = model.chain.joint_names();
        let motion = Motion::from_recording(recording, &names, &MotionSettings::default())?;
        let arm = model.rigid_arm();
        let n = names.len();
        let efforts = inverse_dynamics_of_motion(
            &arm,
            &motion.position,
            &motion.velocity,
            &motion.acceleration,
        );
        let samples = motion.time_s.len();
        let mut inertia = inertia_matrices_of_motion(&arm, &motion.position);
        let diagonal: Vec<Vec<f64>> =
            (0..n).map(|j| std::mem::take(&mut inertia[upper_triangle(n, j, j)])).collect();
        let still = vec![vec![0.0; samples]; n];
        let resting = ArmMotion::new(&motion.position, &still, &still);
        let slope = |j: usize| -> Vec<f64> {
            let weight = |change: f64| {
                let moved: Vec<f64> = motion.position[j].iter().map(|q| q + change).collect();
                resting.with_joint(j, [&moved, &still[j], &still[j]]).effort_on(&arm, j)
            };
            let (above, below) = (weight(SMALL_TURN), weight(-SMALL_TURN));
            above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * SMALL_TURN)).collect()
        };
        let slopes: Vec<Vec<f64>> = (0..n).map(slope).collect();
        let mut steps: Vec<f64> = recording.time_s.windows(2).map(|p| p[1] - p[0]).collect();
        let middle = steps.len() / 2;
        let sample_s = armident_numeric::order_statistic(&mut steps, middle).unwrap_or(1.0);
        let of_joint = |j: usize| {
            let channels = recording.joint(names[j]);
            let channel = |quantity| {
                channels.and_then(|c| c.channel(quantity)).map(<[f64]>::to_vec).unwrap_or_default()
            };
            let (command, position) = (channel(Quantity::Command), channel(Quantity::Position));
            let load: Vec<f64> = (0..samples)
                .map(|t| efforts[j][t] - diagonal[j][t] * motion.acceleration[j][t])
                .collect();
            let largest = position.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            Self {
                source: recording.source.clone(),
                kind: model.chain.joints[j].kind,
                gain,
                time_s: recording.time_s.clone(),
                sample_s,
                velocity: motion.at_stamps(&motion.velocity[j]),
                load: motion.at_stamps(&load),
                load_slope: motion.at_stamps(&slopes[j]),
                inertia: motion.at_stamps(&diagonal[j]),
                resolution: quantisation_step(&position).unwrap_or(1e-6 * largest.max(1e-3)),
                error_limit: error_limit(&channel(Quantity::Voltage), &command, &position, gain),
                command,
                position,
            }
        };
        Ok((0..n).map(of_joint).collect())
    }

    /// What drives the joint in a simulation.
    pub(super) fn drive(&self) -> JointDrive<'_> {
        JointDrive {
            time_s: &self.time_s,
            command: &self.command,
            recorded: &self.position,
            load: &self.load,
            load_slope: &self.load_slope,
            inertia: &self.inertia,
            gain: self.gain,
        }
    }
}

/// Whether a drive signal is at its limit, up to a thousandth: limits are rounded as signals are.
pub(super) fn is_at_limit(signal: f64, limit: f64) -> bool {
    signal.abs() > (1.0 - 1e-3) * limit
}

/// Position error at gain 1 at which the voltage of a drive is at its largest value, where it stays there; none without such
/// a channel.
fn error_limit(voltage: &[f64], command: &[f64], position: &[f64], gain: f64) -> Option<f64> {
    let largest = voltage.iter().fold(0.0_f64, |a, u| a.max(u.abs()));
    // a maximum that a signal passes through is reached once or twice
    const FEWEST: usize = 8;
    let is_at_limit = |u: &f64| is_at_limit(*u, largest);
    // a joint that rests shows a constant voltage too, at a constant error
    const WIDER: f64 = 1.1;
    let inside = voltage.iter().zip(command.iter().zip(position));
    let at_limit = inside.clone().filter(|(u, _)| is_at_limit(u));
    let errors: Vec<f64> = at_limit.map(|(_, (c, q))| (c - q).abs()).collect();
    let [least, most] = armident_numeric::extremes(errors.iter().copied());
    if largest <= 0.0 || errors.len() < FEWEST || most < WIDER * least {
        return None;
    }
    let (mut products, mut squares) = (0.0, 0.0);
    for (u, (c, q)) in inside.filter(|(u, _)| !is_at_limit(u)) {
        products += u * (c - q);
        squares += (c - q).powi(2);
    }
    let slope = products / squares;
    (slope.is_finite() && slope > 0.0).then(|| gain * largest / slope)
}
