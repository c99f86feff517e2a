//! The arm, motions and sensors of a case: what is drawn before its hidden effects.

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_effects::{BASELINE, Baseline, Draw, EffectOnJoint, Library};
use armident_kinematics::DrivingAxisChain;
use armident_simulation::{SimulatedArm, Trajectory, inverse};

use crate::arms::excitation::{CONTROL_HZ, Workspace, exciting, point_to_point};
use crate::arms::link_errors::changed_links;
use crate::arms::robot::Robot;
use crate::cases::exact_motion::Exact;
use crate::cases::recording_faults::{RATES_HZ, RecordingFaults};
use crate::cases::request::CaseRequest;
use crate::cases::sensors::{Sensing, encoder_count};
use crate::contract::kind::CaseKind;
use crate::contract::truth::VelocityTruth;
use crate::error::ChallengeError;
use crate::hidden::hidden_effect::Sized;
use crate::random::RandomStream;

/// The files of a case.
pub(crate) const FILES: [&str; 6] =
    ["train_1", "train_2", "holdout", "exam", "before_1", "before_2"];
/// Of these, those of training.
pub(crate) const TRAINING: usize = 2;
/// Of these, those of a case without a change.
pub(crate) const AFTER: usize = 4;
/// Share of change cases in which the friction of all joints is another one after, the factors of its viscous part,
/// and how much these differ between joints.
const WARMED: f64 = 0.5;
const WARMTH: [f64; 2] = [0.6, 1.2];
const UNEVEN_WARMTH: f64 = 0.05;
/// Share of hard cases in which a joint barely moves, and of those with a training recording of moves between points.
const STILL: f64 = 0.25;
const POINT_TO_POINT: f64 = 0.4;

/// What is drawn before the effects.
pub(crate) struct Scene<'a> {
    /// Laws that effects are of.
    pub(crate) library: &'a Library,
    pub(crate) robot: &'a Robot,
    pub(crate) kind: CaseKind,
    pub(crate) background: f64,
    /// The true links.
    pub(crate) chain: DrivingAxisChain,
    pub(crate) plans: Vec<Trajectory>,
    /// The plans at a sample rate.
    pub(crate) planned: Vec<Exact>,
    pub(crate) duration_s: f64,
    /// Samples per second of each of [`FILES`].
    pub(crate) rates_hz: [f64; FILES.len()],
    pub(crate) sensing: Sensing,
    /// Of a hard case.
    pub(crate) faults: RecordingFaults,
    pub(crate) noise_share: f64,
    pub(crate) level: Vec<f64>,
    pub(crate) viscous: Vec<f64>,
    /// By what viscous friction is another one after than before.
    pub(crate) warmth: Vec<f64>,
    /// Effort range of each joint of the given arm \[N m or N\].
    pub(crate) range: Vec<f64>,
}

impl<'a> Scene<'a> {
    pub(crate) fn draw(
        library: &'a Library,
        robot: &'a Robot,
        request: &CaseRequest,
        random: &mut RandomStream,
    ) -> Self {
        let field = request.kind.is_field();
        let hard = request.kind == CaseKind::Hard;
        let mut workspace = Workspace::draw(robot, random);
        if hard && random.chance(STILL) {
            workspace.hold_still(random.index(robot.dof()));
        }
        let (rate_hz, duration_s) = if field {
            (random.choose(&[100.0, 125.0, 200.0, 200.0, 250.0, 500.0]), random.between(12.0, 18.0))
        } else {
            (random.choose(&[200.0, 200.0, 250.0, 400.0, 500.0]), random.between(15.0, 20.0))
        };
        let duration_s = duration_s.round();
        let mut rates_hz = [rate_hz; FILES.len()];
        if field && random.chance(0.5) {
            rates_hz[random.index(AFTER)] = random.choose(&[100.0, 125.0, 200.0, 250.0, 400.0]);
        }
        if hard {
            rates_hz = [random.choose(&RATES_HZ); FILES.len()];
        }
        let files = if request.kind == CaseKind::Change { FILES.len() } else { AFTER };
        let mut plans: Vec<Trajectory> =
            (0..files).map(|_| exciting(robot, &workspace, duration_s, random)).collect();
        if hard && random.chance(POINT_TO_POINT) {
            plans[1] = point_to_point(robot, &workspace, duration_s, random);
        }
        let given = robot.arm();
        let range: Vec<f64> = effort_range(&given, &plans[0]);
        let noise_share = random.log_between(0.003, if field { 0.012 } else { 0.02 });
        let mut sensing = draw_sensing(robot, field, &range, noise_share, random);
        let mut faults = RecordingFaults::default();
        if hard {
            faults = RecordingFaults::draw(TRAINING, &range, duration_s, random);
            sensing.with_faults(&faults);
        }
        let drawn = if field || random.chance(0.25) { random.between(0.02, 0.05) } else { 0.0 };
        let background = request.background.unwrap_or(drawn);
        let mut chain = robot.chain.clone();
        changed_links(&mut chain, background, random);
        let (mut level, mut viscous) = (Vec::new(), Vec::new());
        for (j, joint) in robot.chain.joints.iter().enumerate() {
            let by_limit =
                joint.limits.effort.unwrap_or(f64::INFINITY) * random.between(0.01, 0.05);
            let by_need = range[j] * random.between(0.04, 0.13);
            let dry = by_limit.min(by_need).max(3.0 * sensing.sigma[j]);
            let speed = joint.limits.velocity.unwrap_or(3.0);
            level.push(dry);
            viscous.push(dry * random.log_between(0.5, 2.7) / speed);
        }
        let planned = plans.iter().map(|plan| planned_at(plan, duration_s)).collect();
        let mut warmth = vec![1.0; robot.dof()];
        if request.kind == CaseKind::Change && random.chance(WARMED) {
            let of_arm = random.log_between(WARMTH[0], WARMTH[1]);
            let uneven = [1.0 - UNEVEN_WARMTH, 1.0 + UNEVEN_WARMTH];
            warmth.fill_with(|| of_arm * random.log_between(uneven[0], uneven[1]));
        }
        Self {
            library,
            robot,
            kind: request.kind,
            background,
            chain,
            plans,
            planned,
            duration_s,
            rates_hz,
            sensing,
            faults,
            noise_share,
            level,
            viscous,
            warmth,
            range,
        }
    }

    /// Baseline friction during a recording that no hidden law contains.
    fn baseline(&self, effects: &[Sized], file: usize) -> Vec<EffectOnJoint> {
        if !self.kind.is_field() {
            return Vec::new();
        }
        let mut list = Vec::new();
        for (j, name) in self.robot.names.iter().enumerate() {
            for law in BASELINE.iter().filter(|effect| effect.law().is_baseline_friction()) {
                let Some(term) = law.law().baseline else { continue };
                if replacing(effects, j, term).is_none() {
                    let size = self.friction(effects, term, j, file);
                    list.push(EffectOnJoint::new(law.slug(), name, [size]));
                }
            }
        }
        list
    }

    /// Baseline friction of a joint during a recording: viscous coefficient or dry level. Dry friction changes with
    /// the square root of what viscous friction changes by, and neither where a change of it is hidden.
    pub(crate) fn friction(
        &self,
        effects: &[Sized],
        term: Baseline,
        joint: usize,
        file: usize,
    ) -> f64 {
        let is_it = |sized: &Sized| sized.effect.law().baseline == Some(term);
        let hidden = effects.iter().any(|sized| sized.effect.joint() == joint && is_it(sized));
        let warmth = if file < AFTER && !hidden { self.warmth[joint] } else { 1.0 };
        match term {
            Baseline::Viscous => self.viscous[joint] * warmth,
            _ => self.level[joint] * warmth.sqrt(),
        }
    }

    /// The true arm during a recording, without one of the effects if one is given.
    pub(crate) fn arm(
        &self,
        hidden: &[Sized],
        file: usize,
        without: Option<usize>,
    ) -> Result<SimulatedArm, ChallengeError> {
        let mut effects = self.baseline(hidden, file);
        let there = hidden.iter().enumerate().filter(|(k, sized)| {
            file < AFTER
                && Some(*k) != without
                && sized.effect.recording().is_none_or(|recording| recording == file)
        });
        let there: Vec<&Sized> = there.map(|(_, sized)| sized).collect();
        let names = &self.robot.names;
        effects.extend(there.iter().filter_map(|sized| sized.effect.of_library(sized.size, names)));
        let mut arm = SimulatedArm::on_chain_in(self.library, &self.chain, &effects)?;
        for sized in there {
            if let Some(law) = sized.effect.of_variant(sized.size) {
                arm = arm.with_law(&names[sized.effect.joint()], law)?;
            }
        }
        Ok(arm)
    }
}

/// The hidden effect on a joint whose law contains a term of baseline friction.
pub(crate) fn replacing(effects: &[Sized], joint: usize, term: Baseline) -> Option<&Sized> {
    let here = |sized: &&Sized| sized.effect.joint() == joint;
    effects.iter().filter(here).find(|sized| sized.effect.replaces == Some(term))
}

fn draw_sensing(
    robot: &Robot,
    field: bool,
    range: &[f64],
    noise_share: f64,
    random: &mut RandomStream,
) -> Sensing {
    let sigma = (0..robot.dof())
        .map(|j| {
            // drives are noisy by their size, not by what they are used for
            let limit = robot.chain.joints[j].limits.effort.unwrap_or(0.0);
            let of_drive = 4e-4 * limit * random.between(0.7, 1.3);
            (noise_share * range[j]).max(of_drive.min(0.15 * range[j]))
        })
        .collect();
    let bits = 17 + random.index(4) as u32;
    let white = random.chance(0.4);
    let velocity = VelocityTruth {
        kind: if white { "white" } else { "causal_low_pass_of_encoder_difference" }.to_owned(),
        cutoff_hz: (!white).then(|| random.between(35.0, 90.0)),
        fraction_of_rms: white.then(|| random.log_between(0.001, 0.006)),
    };
    Sensing {
        sigma,
        colour: random.between(0.0, if field { 0.2 } else { 0.1 }),
        count: (0..robot.dof()).map(|j| encoder_count(bits, robot.is_rotational(j))).collect(),
        velocity: (!(field && random.chance(0.25))).then_some(velocity),
        effort_lag_s: if field && random.chance(0.4) { random.between(1e-3, 3e-3) } else { 0.0 },
        jitter: if field { random.between(0.05, 0.1) } else { 0.0 },
        lost: if field { random.between(0.005, 0.02) } else { 0.0 },
    }
}

fn effort_range(arm: &RigidArm, plan: &Trajectory) -> Vec<f64> {
    let efforts =
        inverse_dynamics_of_motion(arm, &plan.position, &plan.velocity, &plan.acceleration);
    let limits = |column: &Vec<f64>| {
        let [low, high] = column
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(*x), h.max(*x)]);
        high - low
    };
    // a joint that nothing loads still has sensors
    let widest = efforts.iter().map(limits).fold(0.0, f64::max);
    efforts.iter().map(|column| limits(column).max(1e-4 * widest)).collect()
}

/// A plan at 200 Hz, as if it were followed exactly.
fn planned_at(plan: &Trajectory, duration_s: f64) -> Exact {
    let stride = (CONTROL_HZ / 200.0) as usize;
    let count = (200.0 * duration_s) as usize;
    let thin = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
        columns.iter().map(|c| c.iter().copied().step_by(stride).take(count).collect()).collect()
    };
    Exact {
        time_s: plan.time_s.iter().copied().step_by(stride).take(count).collect(),
        position: thin(&plan.position),
        velocity: thin(&plan.velocity),
        acceleration: thin(&plan.acceleration),
        effort: Vec::new(),
    }
}

/// Efforts of an exact motion by an arm.
pub(crate) fn efforts_of(
    arm: &SimulatedArm,
    motion: &Exact,
) -> Result<Vec<Vec<f64>>, ChallengeError> {
    let trajectory = Trajectory {
        joints: arm.joints().to_vec(),
        time_s: motion.time_s.clone(),
        position: motion.position.clone(),
        velocity: motion.velocity.clone(),
        acceleration: motion.acceleration.clone(),
        source: String::new(),
        notes: Vec::new(),
    };
    let recording = inverse(arm, &trajectory)?;
    Ok(recording.joints.iter().map(|joint| joint.effort.clone().unwrap_or_default()).collect())
}
