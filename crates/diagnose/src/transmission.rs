//! Springy and loose transmissions: the recorded motor drives a hidden link.
//!
//! ```text
//! m(t) q̈ + b(t) = τ,   τ = K (θ - q) + D (θ̇ - q̇), or that beyond a gap;   effort = rigid(link) + J θ̈
//! ```
//!
//! `m` is the joint's own inertia and `b` all other efforts on it. The motion of the link follows from
//! that of the motor by one scalar differential equation a joint; the efforts of all joints follow from
//! the motion of the link.

use armident_dynamics::gravity_effort;
use armident_effects::{Effect, Role, RotorInertia};
use armident_numeric::dot;
use armident_recording::{RecordingError, differentiate};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::at::At;
use crate::evidence::Evidence;
use crate::problem::{Group, Meaning, Problem, Site};
use crate::rows::Blocks;
use crate::sampled::{kinematics_filter, low_pass};
use crate::signals::Signals;
use crate::stops::{Kind, Series};

/// Cut-off of the motor's position \[Hz\]: the link may ring well above the band.
const MOTOR_HZ: f64 = 80.0;
/// Step of the integration, and the longest one \[s\], of which the motion of a motor (below 80 Hz) is interpolated.
const STEPS_S: (f64, f64) = (2.5e-4, 1e-3);
/// By how much of its phase \[rad\] a spring may ring in a step: its stiffness is then off by a sixth of the square, 0.02 %.
const RING_PER_STEP: f64 = 0.03;
/// Turns in which the motion of a link and the loads on it agree, and how nearly \[rad or m\]: loads are linear in its
/// position within a turn, so that they err by the square of this.
const MOST_TURNS: usize = 6;
const SETTLED: f64 = 3e-3;
/// Resonances of the link behind a resting motor that are tried \[Hz\], and shares of critical damping.
const RESONANCES_HZ: [f64; 14] =
    [1.3, 1.6, 2.0, 2.5, 3.1, 3.9, 5.0, 6.5, 8.5, 11.0, 14.0, 18.0, 24.0, 32.0];
const DAMPINGS: [f64; 2] = [0.02, 0.08];
/// Gaps tried on rotational joints \[rad\] and translational ones \[m\]: from, to, and the factor between: the
/// motion of a link in its gap is its own for every size.
const GAPS: (f64, f64, f64) = (3e-4, 3.2e-2, 1.2);
/// The flanks of a gear are stiffer than what the recordings resolve: the link bounces on them at this
/// circular frequency \[rad/s\], with this share of critical damping: lubricated flanks hardly rebound.
const FLANK_RATE: f64 = 350.0;
const FLANK_DAMPING: f64 = 0.8;

/// What lies between motor and link.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Transmission {
    /// Gap in which no effort passes \[rad or m\]; 0 for a springy transmission.
    pub gap: f64,
    /// \[N m/rad or N/m\]
    pub stiffness: f64,
    /// \[N m s/rad or N s/m\]
    pub damping: f64,
}

/// A transmission in a model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TransmissionTerm {
    /// Joint.
    pub joint: String,
    /// What lies between.
    pub transmission: Transmission,
    /// Inertia of the motor beyond the model's \[kg m2 or kg\].
    pub motor_inertia: f64,
    /// Fitted size of the difference to a rigid transmission; 1 where the law holds.
    pub share: f64,
}

impl Transmission {
    /// The gap that a fitted size of the difference to a rigid transmission stands for. A link goes from flank to flank
    /// sooner than the band tells, so that its efforts grow with the gap: one a tenth too large taken nine tenths is nearly
    /// the same in them, and the misfit has its bottom where the assumed flanks blur impacts as the recordings do.
    pub(crate) fn gap_told(&self, share: f64) -> f64 {
        share * self.gap
    }

    /// Effort that passes for a deflection and its rate.
    fn effort(&self, deflection: f64, rate: f64) -> f64 {
        let half = 0.5 * self.gap;
        if self.gap > 0.0 {
            let side = deflection.signum();
            let pressed = deflection.abs() - half;
            if pressed <= 0.0 {
                return 0.0;
            }
            // flanks push, they do not pull
            return side * (self.stiffness * pressed + self.damping * rate * side).max(0.0);
        }
        self.stiffness * deflection + self.damping * rate
    }

    /// Efforts of all joints with the link behind this transmission minus those with a rigid one.
    pub(crate) fn difference(
        &self,
        at: &At<'_>,
        joint: usize,
    ) -> Result<Vec<Vec<f64>>, RecordingError> {
        Ok(self.difference_in(at, joint, MOST_TURNS, None)?.0)
    }

    /// The same in so many turns at most, the first with the load on a link that moves as another one did, or follows its
    /// motor; and the load of the last turn, if that is another.
    fn difference_in(
        &self,
        at: &At<'_>,
        joint: usize,
        most_turns: usize,
        near: Option<&Load>,
    ) -> Result<(Vec<Vec<f64>>, Option<Load>), RecordingError> {
        let (link, load) = self.hidden_link_in(at, joint, most_turns, near)?;
        let (arm, rigid) = at.of_other_links();
        let link = link.each_ref().map(Vec::as_slice);
        let mut effort = at.motion().with_joint(arm, joint, link).efforts(arm);
        for (effort, rigid) in effort.iter_mut().zip(rigid) {
            for (e, r) in effort.iter_mut().zip(rigid) {
                *e -= r;
            }
        }
        Ok((effort, load))
    }

    /// Position, velocity and acceleration of the link at every sample.
    pub(crate) fn hidden_link(
        &self,
        at: &At<'_>,
        joint: usize,
    ) -> Result<[Vec<f64>; 3], RecordingError> {
        Ok(self.hidden_link_in(at, joint, MOST_TURNS, None)?.0)
    }

    fn hidden_link_in(
        &self,
        at: &At<'_>,
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
            let load = first.moved(at, joint, &link[0], &link[1]);
            link = self.link(&motor, &load, start, rate_hz);
            own = Some(load);
        }
        Ok((link, own))
    }

    /// How the link of a spring moves under an effort on it, beside a motion and the load about it: to first order.
    /// `twist`: deflection at the first sample.
    pub(crate) fn yields_to(
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

    /// Deflection under an effort.
    fn twist_under(&self, effort: f64) -> f64 {
        effort / self.stiffness + 0.5 * self.gap * effort.signum()
    }

    /// Deflection at the first sample: of an arm that stands there under what its links weigh where they hang; in motion,
    /// of a link that does not ring, under what accelerates it too.
    fn twist_at_start(&self, at: &At<'_>, joint: usize) -> f64 {
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
                    // flanks are taken at the end of the step, so that none is too stiff
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
    fn of(signals: &Signals, joint: usize, offset: f64) -> Result<Self, RecordingError> {
        let low_passed = kinematics_filter(signals.rate_hz)?;
        let recorded = &signals.recorded_position[joint];
        let goes_on = signals.goes_on[joint];
        let (long, margin) =
            Series::of(recorded, Kind::Position, goes_on, signals.stands, &low_passed).whole();
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

/// Inertia of a joint and all other efforts on it, about a motion of its link.
#[derive(Debug, Clone)]
pub(crate) struct Load {
    inertia: Vec<f64>,
    bias: Vec<f64>,
    /// change of `bias` with the position of the link: a soft spring lets it fall far from its motor
    slope: Vec<f64>,
    /// and with its velocity, in which it is linear: other joints in motion take energy from a link that rings, or
    /// give it some
    drag: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
}

impl Load {
    /// About a link that follows its motor.
    pub(crate) fn of(at: &At<'_>, joint: usize) -> Self {
        let (position, velocity) = (&at.position[joint], &at.signals.velocity[joint]);
        let one = vec![1.0; at.signals.len()];
        let arm = at.of_other_links().0;
        let unit = at.motion().with_acceleration(joint, &one).effort_on(arm, joint);
        let mut load = Self::about(at, joint, position, velocity, Vec::new());
        load.inertia = unit.iter().zip(&load.bias).map(|(a, b)| (a - b).max(1e-9)).collect();
        load
    }

    /// Change of the efforts on the joint at the first sample with the position of its link.
    pub(crate) fn slope_at_start(&self) -> f64 {
        self.slope[0]
    }

    /// About another motion of the link; the inertia about a joint does not depend on its own position.
    pub(crate) fn moved(
        &self,
        at: &At<'_>,
        joint: usize,
        position: &[f64],
        velocity: &[f64],
    ) -> Self {
        Self::about(at, joint, position, velocity, self.inertia.clone())
    }

    /// All efforts on a joint but that of its own acceleration, and how they change with its motion.
    fn about(
        at: &At<'_>,
        joint: usize,
        position: &[f64],
        velocity: &[f64],
        inertia: Vec<f64>,
    ) -> Self {
        const STEP: f64 = 1e-4;
        let (motion, arm) = (at.motion(), at.of_other_links().0);
        let none = vec![0.0; position.len()];
        let bias_at = |position: &[f64], velocity: &[f64]| {
            motion.with_joint(arm, joint, [position, velocity, &none]).effort_on(arm, joint)
        };
        let bias = bias_at(position, velocity);
        let beside = |of: &[f64]| -> Vec<f64> { of.iter().map(|x| x + STEP).collect() };
        let change = |moved: Vec<f64>| -> Vec<f64> {
            moved.iter().zip(&bias).map(|(a, b)| (a - b) / STEP).collect()
        };
        Self {
            slope: change(bias_at(&beside(position), velocity)),
            drag: change(bias_at(position, &beside(velocity))),
            inertia,
            bias,
            position: position.to_vec(),
            velocity: velocity.to_vec(),
        }
    }
}

/// Adds the group of a transmission on a joint; gives its id. `near`: of each recording the load on a link that moved nearly
/// so, empty where none is known; afterwards on this one.
pub(crate) fn push(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    problem: &mut Problem,
    slug: &'static str,
    joint: usize,
    shape: &[f64],
    near: &mut Vec<Option<Load>>,
) -> Option<usize> {
    let formed = formed(evidence, at, slug, joint, shape, MOST_TURNS, near)?;
    let Formed { blocks, above_band } = formed;
    let column = problem.push_columns(vec![blocks]);
    Some(push_group(evidence, at, problem, (slug, joint, shape), column, above_band))
}

/// The efforts of a transmission, beside a rigid one, in the band.
struct Formed {
    blocks: Blocks,
    above_band: f64,
}

fn formed(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    slug: &str,
    joint: usize,
    shape: &[f64],
    most_turns: usize,
    near: &mut Vec<Option<Load>>,
) -> Option<Formed> {
    let transmission = of_shape(slug, shape, mean_inertia(at, joint));
    near.resize(at.len(), None);
    let pieces: Vec<Vec<Vec<f64>>> = at
        .par_iter()
        .zip(near)
        .map(|(at, near)| {
            let (mut efforts, load) =
                transmission.difference_in(at, joint, most_turns, near.as_ref())?;
            if load.is_some() {
                *near = load;
            }
            if transmission.gap == 0.0
                && let Some(sprung) = at.sprung().find(|s| s.joint() == joint)
            {
                for (effort, counted) in efforts.iter_mut().zip(sprung.counted()) {
                    effort.iter_mut().zip(counted).for_each(|(e, c)| *e -= c);
                }
            }
            Ok(at.all_recorded(efforts))
        })
        .collect::<Result<_, RecordingError>>()
        .ok()?;
    if pieces.iter().flatten().flatten().any(|x| !x.is_finite()) {
        return None;
    }
    Some(Formed {
        blocks: evidence.arm_blocks(&pieces),
        above_band: above_band(evidence, joint, &pieces),
    })
}

/// The group of a transmission whose column is there.
fn push_group(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    problem: &mut Problem,
    (slug, joint, shape): (&'static str, usize, &[f64]),
    column: usize,
    above_band: f64,
) -> usize {
    let inertia: Vec<Vec<f64>> = at
        .iter()
        .filter_map(|at| RotorInertia.columns(&[], &at.joint(joint)).into_iter().next())
        .collect();
    let inertia = evidence.joint_blocks(joint, &inertia);
    let inertia = match problem.find_column(&inertia, problem.rigid) {
        Some(known) => known,
        None => problem.push_columns(vec![inertia]),
    };
    problem.groups.push(Group {
        meaning: Meaning::Law(slug),
        site: Site { joints: vec![joint], window: None },
        shape: shape.to_vec(),
        columns: vec![column, inertia],
        searched: shape.len(),
        places: vec![Role::Inertia],
        transform: None,
        hidden: Vec::new(),
        above_band,
        is_of_size_one: slug == "joint_elasticity"
            && at.iter().any(|at| at.has_right_spring(joint)),
    });
    problem.groups.len() - 1
}

/// Root mean square of an effort on a joint at all samples over that in the band, 1 or more. Bounded: how
/// sharp an impact is depends on flanks whose stiffness is assumed.
fn above_band(evidence: &Evidence<'_>, joint: usize, by_recording: &[Vec<Vec<f64>>]) -> f64 {
    const MOST: f64 = 4.0;
    let mean_square = |values: &[f64]| dot(values, values) / values.len().max(1) as f64;
    let (mut raw, mut band) = (0.0, 0.0);
    for (signals, efforts) in evidence.signals.iter().zip(by_recording) {
        raw += mean_square(&efforts[joint]);
        band += mean_square(&signals.band.rows(&efforts[joint]));
    }
    (raw / band.max(f64::MIN_POSITIVE)).sqrt().clamp(1.0, MOST)
}

/// The transmission that a shape stands for: stiffness and damping, or a gap.
pub(crate) fn of_shape(slug: &str, shape: &[f64], inertia: f64) -> Transmission {
    if slug == "backlash" {
        return Transmission {
            gap: shape[0],
            stiffness: inertia * FLANK_RATE * FLANK_RATE,
            damping: 2.0 * FLANK_DAMPING * inertia * FLANK_RATE,
        };
    }
    Transmission { gap: 0.0, stiffness: shape[0], damping: shape[1] }
}

/// Mean over the recordings of the joint's own inertia.
pub(crate) fn mean_inertia(at: &[At<'_>], joint: usize) -> f64 {
    let loads = || at.iter().map(|at| &at.load(joint).inertia);
    loads().flatten().sum::<f64>() / loads().map(Vec::len).sum::<usize>() as f64
}

/// Adds springs and gaps of all sizes on a joint; gives their ids.
pub(crate) fn offer(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    problem: &mut Problem,
    joint: usize,
) -> Vec<usize> {
    let inertia = mean_inertia(at, joint);
    let mut sizes: Vec<(&'static str, Vec<f64>)> = Vec::new();
    for hz in RESONANCES_HZ {
        for damping in DAMPINGS {
            let rate = std::f64::consts::TAU * hz;
            let shape = vec![inertia * rate * rate, 2.0 * damping * inertia * rate];
            sizes.push(("joint_elasticity", shape));
        }
    }
    let (mut gap, last, factor) = GAPS;
    while gap < last {
        sizes.push(("backlash", vec![gap]));
        gap *= factor;
    }
    // one turn tells which size is worth a closer look
    let of_size = |(slug, shape): &(&'static str, Vec<f64>)| {
        formed(evidence, at, slug, joint, shape, 1, &mut Vec::new())
    };
    let all: Vec<Option<Formed>> = sizes.par_iter().map(of_size).collect();
    let mut found = Vec::new();
    let mut columns = Vec::new();
    for (size, formed) in sizes.into_iter().zip(all) {
        let Some(Formed { blocks, above_band }) = formed else { continue };
        columns.push(blocks);
        found.push((size, above_band));
    }
    let first = problem.push_columns(columns);
    let places = found.into_iter().zip(first..);
    places
        .map(|(((slug, shape), above_band), column)| {
            push_group(evidence, at, problem, (slug, joint, &shape), column, above_band)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::at::{OperatingPoint, changed};
    use crate::band::BAND_HZ;
    use crate::made::{swung, ur5};
    use armident_dynamics::RigidArm;
    use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
    use armident_recording::{JointChannels, Recording};

    /// A link behind a spring that is heavier than believed moves as in an arm that is believed to have it.
    #[test]
    fn hidden_links_weigh_what_was_found() {
        let robot = parse_urdf(include_str!("../../../urdf/ur5.urdf"), "ur5.urdf").unwrap();
        let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
        let chain = DrivingAxisChain::from_chain(&chain);
        let names: Vec<String> = chain.joints.iter().map(|j| j.name.clone()).collect();
        let time: Vec<f64> = (0..600).map(|k| f64::from(k) / 200.0).collect();
        let joints = names.iter().enumerate().map(|(j, name)| {
            let swing = |t: &f64| 0.4 * ((2.0 + j as f64) * t).sin() - 0.2 * j as f64;
            let position = Some(time.iter().map(swing).collect());
            JointChannels { position, ..JointChannels::new(name) }
        });
        let recording = Recording::new("made", time.clone(), joints.collect()).unwrap();
        let signals = Signals::below(&recording, &names, BAND_HZ).unwrap();
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
            let at = At::new(chain, &RigidArm::from_chain(chain), &signals, point);
            let spring = Transmission { gap: 0.0, stiffness: 800.0, damping: 4.0 };
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

    /// An arm that stands still hangs from its spring, however far that lets it fall: nothing rings.
    #[test]
    fn a_link_that_hangs_at_rest_stays_there() {
        let robot = parse_urdf(include_str!("../../../urdf/ur5.urdf"), "ur5.urdf").unwrap();
        let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
        let chain = DrivingAxisChain::from_chain(&chain);
        let names: Vec<String> = chain.joints.iter().map(|j| j.name.clone()).collect();
        let time: Vec<f64> = (0..600).map(|k| f64::from(k) / 200.0).collect();
        let joints = names.iter().map(|name| {
            let position = Some(vec![0.3; time.len()]);
            JointChannels { position, ..JointChannels::new(name) }
        });
        let recording = Recording::new("made", time.clone(), joints.collect()).unwrap();
        let mut signals = Signals::below(&recording, &names, BAND_HZ).unwrap();
        signals.starts_at_rest = true;
        let none = OperatingPoint::of(names.len());
        let at = At::new(&chain, &RigidArm::from_chain(&chain), &signals, &none);
        let spring = Transmission { gap: 0.0, stiffness: 120.0, damping: 0.4 };
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
    fn a_light_spring_rings_for_its_time() {
        const RATE_HZ: f64 = 200.0;
        const SAMPLES: usize = 1001;
        let (rate, share) = (std::f64::consts::TAU * 2.5, 0.025);
        let zero = vec![0.0; SAMPLES];
        let motor = Motor { position: zero.clone(), velocity: zero.clone(), start_velocity: 0.0 };
        let inertia = vec![1.0; SAMPLES];
        let [bias, slope, drag, position, velocity] =
            [const { Vec::new() }; 5].map(|_: Vec<f64>| zero.clone());
        let load = Load { inertia, bias, slope, drag, position, velocity };
        let spring = Transmission { gap: 0.0, stiffness: rate * rate, damping: 2.0 * share * rate };
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
    fn what_passes_a_spring_is_what_its_link_needs() {
        const JOINT: usize = 0;
        let chain = ur5();
        let signals = swung(&chain, 0.0, |_, _| 0.0);
        let point = OperatingPoint::of(chain.joints.len());
        let at = At::new(&chain, &RigidArm::from_chain(&chain), &signals, &point);
        let inertia = mean_inertia(std::slice::from_ref(&at), JOINT);
        let rate = std::f64::consts::TAU * 4.0;
        let (stiffness, damping) = (inertia * rate * rate, 0.04 * inertia * rate);
        let spring = Transmission { gap: 0.0, stiffness, damping };
        let [q, v, a] = spring.hidden_link(&at, JOINT).unwrap();
        let motor = Motor::of(&signals, JOINT, 0.0).unwrap();
        let arm = at.of_other_links().0;
        let needed = at.motion().with_joint(arm, JOINT, [&q, &v, &a]).effort_on(arm, JOINT);
        let largest = needed.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for (t, needed) in needed.iter().enumerate() {
            let passed = spring.effort(motor.position[t] - q[t], motor.velocity[t] - v[t]);
            assert!((passed - needed).abs() < 1e-4 * largest, "{t}: {passed} {needed} {largest}");
        }
    }

    /// Whatever gap is assumed, and though the flanks are others than assumed, the gap told is that of the arm.
    #[test]
    fn a_gap_of_another_size_tells_the_right_one() {
        const JOINT: usize = 2;
        const GAP: f64 = 5e-4;
        let chain = ur5();
        let signals = swung(&chain, 0.0, |_, _| 0.0);
        let point = OperatingPoint::of(chain.joints.len());
        let at = At::new(&chain, &RigidArm::from_chain(&chain), &signals, &point);
        let inertia = mean_inertia(std::slice::from_ref(&at), JOINT);
        let in_band = |of: Transmission| {
            let efforts = of.difference(&at, JOINT).unwrap();
            signals.band.rows(&efforts[JOINT])
        };
        let (rate, damping) = (0.8 * FLANK_RATE, 0.25 * FLANK_DAMPING);
        let real = in_band(Transmission {
            gap: GAP,
            stiffness: inertia * rate * rate,
            damping: 2.0 * damping * inertia * rate,
        });
        for factor in [0.8, 0.9, 1.0, 1.1, 1.25] {
            let assumed = of_shape("backlash", &[factor * GAP], inertia);
            let column = in_band(assumed);
            let told = assumed.gap_told(dot(&column, &real) / dot(&column, &column));
            assert!((told / GAP - 1.0).abs() < 0.06, "{factor}: {told}");
        }
    }
}
