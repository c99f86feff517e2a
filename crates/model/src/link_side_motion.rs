//! The motion of a link behind its transmission, which the recorded motor drives.
//!
//! ```text
//! m(t) q̈ + b(t) = τ,   τ = K (θ - q) + D (θ̇ - q̇), or that beyond a gap;   effort = rigid(link) + J θ̈
//! ```
//!
//! `m` is the joint's own inertia and `b` all other efforts on it. The motion of the link follows from
//! that of the motor by one scalar differential equation a joint; the efforts of all joints follow from
//! the motion of the link.

use armident_dynamics::gravity_effort;
use armident_motion::{
    BandMotion, ChannelSeries, Kind, differentiate, kinematics_filter, low_pass,
};
use armident_recording::RecordingError;

use crate::FittedTransmission;
use crate::link_load::Load;
use crate::posed_recording::PosedRecording;

/// Cut-off of the motor's position \[Hz\]: the link may ring well above the band.
const MOTOR_HZ: f64 = 80.0;
/// Step of the integration, and the longest one \[s\], of which the motion of a motor (below 80 Hz) is interpolated.
const STEPS_S: (f64, f64) = (2.5e-4, 1e-3);
/// By how much of its phase \[rad\] a spring may ring in a step: its stiffness is then off by a sixth of the square, 0.02 %.
const RING_PER_STEP: f64 = 0.03;
/// Turns in which the motion of a link and the loads on it agree, and how nearly \[rad or m\]: loads are linear in its
/// position within a turn, so that they err by the square of this.
pub const MOST_TURNS: usize = 6;
const SETTLED: f64 = 3e-3;
impl FittedTransmission {
    /// Efforts of all joints with the link behind this transmission minus those with a rigid one.
    pub fn difference(
        &self,
        at: &PosedRecording<'_>,
        joint: usize,
    ) -> Result<Vec<Vec<f64>>, RecordingError> {
        Ok(self.difference_in(at, joint, MOST_TURNS, None)?.0)
    }

    /// The same in so many turns at most, the first with the load on a link that moves as another one did, or follows its
    /// motor; and the load of the last turn, if that is another.
    pub fn difference_in(
        &self,
        at: &PosedRecording<'_>,
        joint: usize,
        most_turns: usize,
        near: Option<&Load>,
    ) -> Result<(Vec<Vec<f64>>, Option<Load>), RecordingError> {
        let (link, load) = self.link_side_motion_in(at, joint, most_turns, near)?;
        let (arm, rigid) = at.of_other_links();
        let link = link.each_ref().map(Vec::as_slice);
        let mut effort = at.motion().with_joint(joint, link).efforts(arm);
        for (effort, rigid) in effort.iter_mut().zip(rigid) {
            for (e, r) in effort.iter_mut().zip(rigid) {
                *e -= r;
            }
        }
        Ok((effort, load))
    }

    /// Position, velocity and acceleration of the link at every sample.
    pub fn link_side_motion(
        &self,
        at: &PosedRecording<'_>,
        joint: usize,
    ) -> Result<[Vec<f64>; 3], RecordingError> {
        Ok(self.link_side_motion_in(at, joint, MOST_TURNS, None)?.0)
    }

    fn link_side_motion_in(
        &self,
        at: &PosedRecording<'_>,
        joint: usize,
        most_turns: usize,
        near: Option<&Load>,
    ) -> Result<([Vec<f64>; 3], Option<Load>), RecordingError> {
        let motor =
            Motor::of(at.signals, joint, at.signals.position[joint][0] - at.position[joint][0])?;
        let rate_hz = at.signals.rate_hz;
        let start = self.twist_at_start(at, joint);
        let first = near.unwrap_or_else(|| at.load(joint));
        let mut link = self.link(&motor, first, start, rate_hz);
        // the loads on the link are those of its own motion: found in turns, two for a stiff spring
        let mut own: Option<Load> = None;
        for _ in 1..most_turns {
            let about = &own.as_ref().unwrap_or(first).position;
            let moved = about.iter().zip(&link[0]).map(|(a, b)| (a - b).abs());
            if moved.fold(0.0, f64::max) < SETTLED {
                break;
            }
            let (motion, arm) = (at.motion(), at.of_other_links().0);
            let load = first.moved(&motion, arm, joint, &link[0], &link[1]);
            link = self.link(&motor, &load, start, rate_hz);
            own = Some(load);
        }
        Ok((link, own))
    }

    /// How the link of a spring moves under an effort on it, beside a motion and the load about it: to first order.
    /// `twist`: deflection at the first sample.
    pub fn yields_to(
        &self,
        load: &Load,
        effort: Vec<f64>,
        twist: f64,
        rate_hz: f64,
    ) -> [Vec<f64>; 3] {
        let still = vec![0.0; effort.len()];
        let motor = Motor { position: still.clone(), velocity: still.clone(), start_velocity: 0.0 };
        let load = Load { bias: effort, position: still.clone(), velocity: still, ..load.clone() };
        self.link(&motor, &load, twist, rate_hz)
    }

    /// Deflection at the first sample: of an arm that stands there under what its links weigh where they hang; in motion,
    /// of a link that does not ring, under what accelerates it too.
    fn twist_at_start(&self, at: &PosedRecording<'_>, joint: usize) -> f64 {
        /// In which twist and load agree.
        const ROUNDS: usize = 50;
        let (arm, load) = (at.of_other_links().0, at.load(joint));
        let first: Vec<f64> = at.position.iter().map(|q| q[0]).collect();
        let borne = |twist: f64| {
            if at.signals.starts_at_rest {
                let mut links = first.clone();
                links[joint] -= twist;
                return gravity_effort(arm, &links)[joint];
            }
            load.bias[0] - load.slope[0] * twist
                + load.inertia[0] * at.signals.acceleration[joint][0]
        };
        (0..ROUNDS).fold(0.0, |twist, _| self.twist_under(borne(twist)))
    }

    /// Longest step of the integration of a link \[s\]: flanks are met within it, a spring needs its resonance resolved.
    fn step_s(&self, load: &Load) -> f64 {
        if self.gap > 0.0 {
            return STEPS_S.0;
        }
        let lightest = load.inertia.iter().copied().fold(f64::MAX, f64::min);
        (RING_PER_STEP * (lightest / self.stiffness).sqrt()).clamp(STEPS_S.0, STEPS_S.1)
    }

    /// Position, velocity and acceleration of the link at every sample, from this deflection on.
    fn link(&self, motor: &Motor, load: &Load, start: f64, rate_hz: f64) -> [Vec<f64>; 3] {
        let n = motor.position.len();
        let steps = (1.0 / (rate_hz * self.step_s(load))).ceil().max(1.0) as usize;
        let h = 1.0 / (rate_hz * steps as f64);
        let (mut q, mut v) = (motor.position[0] - start, motor.start_velocity);
        let (mut position, mut velocity, mut acceleration) = (vec![q; n], vec![v; n], vec![0.0; n]);
        for t in 0..n - 1 {
            let before = v;
            let line = |values: &[f64]| Line { from: values[t], by: values[t + 1] - values[t] };
            let (theta, omega) = (motor.between(t, rate_hz), line(&motor.velocity));
            let (m, bias) = (line(&load.inertia), line(&load.bias));
            let (slope, drag) = (line(&load.slope), line(&load.drag));
            let (about, about_rate) = (line(&load.position), line(&load.velocity));
            for k in 0..steps {
                let x = (k as f64 + 0.5) / steps as f64;
                let (theta, omega, m) = (theta.at(x), omega.at(x), m.at(x));
                let passed = self.effort(theta - q, omega - v);
                let (slope, drag) = (slope.at(x), drag.at(x));
                let bias = bias.at(x) + slope * (q - about.at(x)) + drag * (v - about_rate.at(x));
                if self.gap > 0.0 {
                    // flanks act at the end of the step, so that none is too stiff
                    let pressed = f64::from(u8::from(passed != 0.0));
                    let (stiffness, damping) = (pressed * self.stiffness, pressed * self.damping);
                    let implicit = m + h * damping + h * h * stiffness;
                    v += h * (passed - bias + h * stiffness * (omega - v)) / implicit;
                    q += h * v;
                } else {
                    // a spring in the middle of it: of second order, without a damping of its own
                    let stiffness = self.stiffness + slope;
                    let implicit = m + 0.5 * h * (self.damping + drag) + 0.25 * h * h * stiffness;
                    let gained = h * (passed - bias - 0.5 * h * stiffness * v) / implicit;
                    q += h * (v + 0.5 * gained);
                    v += gained;
                }
            }
            position[t + 1] = q;
            velocity[t + 1] = v;
            // the mean over the interval: impacts are shorter than a sample
            let mean = (v - before) * rate_hz;
            acceleration[t] = if t == 0 { mean } else { 0.5 * (acceleration[t] + mean) };
            acceleration[t + 1] = mean;
        }
        if self.gap == 0.0 {
            // a spring has no impacts: what accelerates its link is known at every sample
            for t in 0..n {
                let passed =
                    self.effort(motor.position[t] - position[t], motor.velocity[t] - velocity[t]);
                let bias = load.bias[t]
                    + load.slope[t] * (position[t] - load.position[t])
                    + load.drag[t] * (velocity[t] - load.velocity[t]);
                acceleration[t] = (passed - bias) / load.inertia[t];
            }
        }
        [position, velocity, acceleration]
    }
}

/// Motion of the motor, finer than the kinematics.
struct Motor {
    position: Vec<f64>,
    velocity: Vec<f64>,
    /// at the first sample
    start_velocity: f64,
}

impl Motor {
    fn of(signals: &BandMotion, joint: usize, offset: f64) -> Result<Self, RecordingError> {
        let low_passed = kinematics_filter(signals.rate_hz)?;
        let recorded = &signals.recorded_position[joint];
        let extensions = signals.extensions[joint];
        let (long, margin) =
            ChannelSeries::of(recorded, Kind::Position, extensions, signals.stands, &low_passed)
                .whole();
        let smooth = low_pass(MOTOR_HZ, signals.rate_hz)?.filter(&long);
        let rate = differentiate(&smooth, signals.rate_hz);
        let inner = margin..margin + signals.len();
        Ok(Self {
            position: smooth[inner.clone()].iter().map(|q| q - offset).collect(),
            start_velocity: if signals.starts_at_rest { 0.0 } else { rate[margin] },
            velocity: rate[inner].to_vec(),
        })
    }

    /// Position between samples `t` and `t + 1`: with both positions and both velocities.
    fn between(&self, t: usize, rate_hz: f64) -> Cubic {
        let (p, r) = (self.position[t], self.position[t + 1]);
        let (v, w) = (self.velocity[t] / rate_hz, self.velocity[t + 1] / rate_hz);
        let moved = r - p;
        Cubic([p, v, 3.0 * moved - 2.0 * v - w, v + w - 2.0 * moved])
    }
}

/// A value between two samples, of `x` from 0 to 1.
#[derive(Clone, Copy)]
struct Line {
    from: f64,
    by: f64,
}

impl Line {
    fn at(self, x: f64) -> f64 {
        self.from + x * self.by
    }
}

/// The same with coefficients of rising powers.
#[derive(Clone, Copy)]
struct Cubic([f64; 4]);

impl Cubic {
    fn at(self, x: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + x * (b + x * (c + x * d))
    }
}

#[cfg(test)]
mod tests {
    use armident_dynamics::RigidArm;
    use armident_kinematics::DrivingAxisChain;
    use armident_motion::BAND_HZ;
    use armident_recording::{JointChannels, Recording};

    use super::*;
    use crate::operating_point::OperatingPoint;
    use crate::posed_recording::changed;
    use crate::test_arms::{swinging, ur5};
    use armident_effects::Backlash;

    fn mean(values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len() as f64
    }

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// A link behind a spring that is heavier than believed moves as in an arm that is believed to have it.
    #[test]
    fn link_side_motion_uses_links_of_operating_point() {
        let chain = ur5();
        let names: Vec<String> = chain.joints.iter().map(|j| j.name.clone()).collect();
        let time: Vec<f64> = (0..600).map(|k| f64::from(k) / 200.0).collect();
        let joints = names.iter().enumerate().map(|(j, name)| {
            let swing = |t: &f64| 0.4 * ((2.0 + j as f64) * t).sin() - 0.2 * j as f64;
            let position = Some(time.iter().map(swing).collect());
            JointChannels { position, ..JointChannels::new(name) }
        });
        let recording = Recording::new("made", time.clone(), joints.collect()).unwrap();
        let signals = BandMotion::below(&recording, &names, BAND_HZ).unwrap();
        let mut change = vec![0.0; 10 * names.len()];
        // 0.6 kg more on the forearm, and where it is
        change[20..24].copy_from_slice(&[0.6, 0.1, 0.02, -0.03]);
        let mut heavier = chain.clone();
        for (joint, change) in heavier.joints.iter_mut().zip(change.chunks(10)) {
            joint.link = changed(&joint.link, change);
        }
        let none = OperatingPoint::of(names.len());
        let found = OperatingPoint { links: Some(change), ..none.clone() };
        let at = |chain: &DrivingAxisChain, point: &OperatingPoint| {
            let at = PosedRecording::new(chain, &RigidArm::from_chain(chain), &signals, point);
            let spring = FittedTransmission { gap: 0.0, stiffness: 800.0, damping: 4.0 };
            (spring.difference(&at, 2).unwrap(), at.rigid)
        };
        let (believed, rigid) = at(&chain, &none);
        let (by_found, rigid_by_found) = at(&chain, &found);
        let (expected, _) = at(&heavier, &none);
        assert_eq!(by_found, expected);
        assert_ne!(by_found, believed);
        // all else is compared with the arm as it was believed
        assert_eq!(rigid_by_found, rigid);
    }

    /// An arm at rest hangs from its spring, at whatever deflection, and does not oscillate.
    #[test]
    fn link_at_rest_keeps_its_deflection() {
        let chain = ur5();
        let names: Vec<String> = chain.joints.iter().map(|j| j.name.clone()).collect();
        let time: Vec<f64> = (0..600).map(|k| f64::from(k) / 200.0).collect();
        let joints = names.iter().map(|name| {
            let position = Some(vec![0.3; time.len()]);
            JointChannels { position, ..JointChannels::new(name) }
        });
        let recording = Recording::new("made", time.clone(), joints.collect()).unwrap();
        let mut signals = BandMotion::below(&recording, &names, BAND_HZ).unwrap();
        signals.starts_at_rest = true;
        let none = OperatingPoint::of(names.len());
        let at = PosedRecording::new(&chain, &RigidArm::from_chain(&chain), &signals, &none);
        let spring = FittedTransmission { gap: 0.0, stiffness: 120.0, damping: 0.4 };
        let twist = spring.twist_at_start(&at, 2);
        assert!(twist.abs() > 0.05, "{twist}");
        for effort in spring.difference(&at, 2).unwrap() {
            let rings = effort.iter().map(|e| (e - effort[0]).abs()).fold(0.0, f64::max);
            // N m; loads are linear in the position within a turn
            assert!(rings < 1e-4, "{rings}");
        }
    }

    /// A link that swings freely behind a resting motor loses of its swing what the spring's damping takes and no more: after
    /// 5 s as much as the solution of the equation of motion has.
    #[test]
    fn underdamped_spring_decays_as_exact_solution() {
        const RATE_HZ: f64 = 200.0;
        const SAMPLES: usize = 1001;
        let (rate, share) = (std::f64::consts::TAU * 2.5, 0.025);
        let zero = vec![0.0; SAMPLES];
        let motor = Motor { position: zero.clone(), velocity: zero.clone(), start_velocity: 0.0 };
        let inertia = vec![1.0; SAMPLES];
        let [bias, slope, drag, position, velocity] =
            [const { Vec::new() }; 5].map(|_: Vec<f64>| zero.clone());
        let load = Load { inertia, bias, slope, drag, position, velocity };
        let spring =
            FittedTransmission { gap: 0.0, stiffness: rate * rate, damping: 2.0 * share * rate };
        let [position, _, acceleration] = spring.link(&motor, &load, -0.1, RATE_HZ);
        let ringing = rate * (1.0 - share * share).sqrt();
        for (t, (q, a)) in position.iter().zip(&acceleration).enumerate() {
            let (angle, left) =
                (ringing * t as f64 / RATE_HZ, (-share * rate * t as f64 / RATE_HZ).exp());
            let expected = 0.1 * left * (angle.cos() + share * rate / ringing * angle.sin());
            let rate_of_it = -0.1 * left * rate * rate / ringing * angle.sin();
            let expected_acceleration = -rate * rate * expected - 2.0 * share * rate * rate_of_it;
            assert!((q - expected).abs() < 1e-4, "{t}: {q} {expected}");
            assert!((a - expected_acceleration).abs() < 1e-4 * rate * rate, "{t}: {a}");
        }
    }

    /// The motion that a link is given is one of its equation of motion: what passes the spring is all that its own motion
    /// asks for, Coriolis efforts of its own speed beside other joints' among it.
    #[test]
    fn transmitted_effort_satisfies_equation_of_motion() {
        const JOINT: usize = 0;
        let chain = ur5();
        let signals = swinging(&chain);
        let point = OperatingPoint::of(chain.joints.len());
        let at = PosedRecording::new(&chain, &RigidArm::from_chain(&chain), &signals, &point);
        let inertia = mean(&at.load(JOINT).inertia);
        let rate = std::f64::consts::TAU * 4.0;
        let (stiffness, damping) = (inertia * rate * rate, 0.04 * inertia * rate);
        let spring = FittedTransmission { gap: 0.0, stiffness, damping };
        let [q, v, a] = spring.link_side_motion(&at, JOINT).unwrap();
        let motor = Motor::of(&signals, JOINT, 0.0).unwrap();
        let arm = at.of_other_links().0;
        let needed = at.motion().with_joint(JOINT, [&q, &v, &a]).effort_on(arm, JOINT);
        let largest = needed.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for (t, needed) in needed.iter().enumerate() {
            let passed = spring.effort(motor.position[t] - q[t], motor.velocity[t] - v[t]);
            assert!((passed - needed).abs() < 1e-4 * largest, "{t}: {passed} {needed} {largest}");
        }
    }

    /// Whatever gap is assumed, and though the flanks are others than assumed, the gap told is that of the arm.
    #[test]
    fn gap_estimate_is_independent_of_assumed_gap() {
        const JOINT: usize = 2;
        const GAP: f64 = 5e-4;
        let chain = ur5();
        let signals = swinging(&chain);
        let point = OperatingPoint::of(chain.joints.len());
        let at = PosedRecording::new(&chain, &RigidArm::from_chain(&chain), &signals, &point);
        let inertia = mean(&at.load(JOINT).inertia);
        let in_band = |of: FittedTransmission| {
            let efforts = of.difference(&at, JOINT).unwrap();
            signals.band.rows(&efforts[JOINT])
        };
        let (rate, damping) = (0.8 * Backlash::FLANK_RATE, 0.25 * Backlash::FLANK_DAMPING);
        let real = in_band(FittedTransmission {
            gap: GAP,
            stiffness: inertia * rate * rate,
            damping: 2.0 * damping * inertia * rate,
        });
        for factor in [0.8, 0.9, 1.0, 1.1, 1.25] {
            let assumed = FittedTransmission::of_law(&Backlash, &[factor * GAP], inertia).unwrap();
            let column = in_band(assumed);
            let told = assumed.fitted_gap(dot(&column, &real) / dot(&column, &column));
            assert!((told / GAP - 1.0).abs() < 0.06, "{factor}: {told}");
        }
    }
}
