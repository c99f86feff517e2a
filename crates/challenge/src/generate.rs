//! Cases with concealed effects, made by the simulator.

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_effects::{EffectOnJoint, LIBRARY};
use armident_kinematics::DrivingAxisChain;
use armident_recording::Recording;
use armident_simulation::{SimulatedArm, Trajectory, inverse, track};

use crate::background::changed_links;
use crate::case::Case;
use crate::draft::{Context, Draft, replaces};
use crate::error::ChallengeError;
use crate::excitation::{Workspace, exciting, gains};
use crate::floors::{Taken, floors};
use crate::random::Draw;
use crate::recorder::{Exact, Sensing, encoder_count, exact_at, instants, record, rms};
use crate::robot::Robot;
use crate::sizes::{Sized, Sizing, size};
use crate::truth::{Floors, VelocityTruth};
use crate::truth_of::{Made, effective_noise, truth_of};

/// What a case looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaseKind {
    /// One or two effects on an otherwise exact arm, clean recordings.
    Clean,
    /// Everyday friction on every joint, errors of every inertial, dirty recordings.
    Field,
    /// A field arm recorded before and after: what is concealed came between, and the friction of an arm that has warmed
    /// up or cooled down.
    Change,
}

impl CaseKind {
    /// Whether joints rub, clocks are uneven and inertials are wrong.
    pub(crate) fn is_field(self) -> bool {
        self != Self::Clean
    }

    /// Name in tables and answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Field => "field",
            Self::Change => "change",
        }
    }
}

/// A case to be made. The same request gives the same case.
#[derive(Debug, Clone)]
pub struct CaseRequest {
    /// Name of the case.
    pub name: String,
    /// Name of the robot.
    pub robot: String,
    /// Text of its URDF.
    pub robot_urdf: String,
    /// Everything that is left to chance follows from it.
    pub seed: u64,
    /// Clean, field or change.
    pub kind: CaseKind,
    /// Slugs of the effects to conceal, or `unlisted`; none for a null.
    pub effects: Vec<String>,
    /// Standard scale of the errors of every inertial; left to chance if it is not given.
    pub background: Option<f64>,
    /// Whether laws that have one are replaced by a variant of their own.
    pub perturbed: bool,
    /// Naming margin of every effect; left to chance if it is not given.
    pub margin: Option<f64>,
}

/// Slugs that a case of this kind can conceal: those of the library and `unlisted`.
pub fn concealable(kind: CaseKind) -> Vec<&'static str> {
    let mut slugs: Vec<&str> = LIBRARY.iter().map(|effect| effect.law().slug).collect();
    slugs.push("unlisted");
    match kind {
        CaseKind::Clean => {}
        CaseKind::Field => slugs.retain(|slug| !is_everyday(slug)),
        // a law in the place of another one is a change of two
        CaseKind::Change => slugs.retain(|slug| replaces(slug).is_none()),
    }
    slugs
}

/// Friction that every joint of a field case has.
fn is_everyday(slug: &str) -> bool {
    matches!(slug, "viscous_friction" | "coulomb_friction")
}

/// Effects of a case that follow from its seed: mostly one, sometimes two, and in field and change cases sometimes
/// none; slugs take turns.
pub fn case_effects(kind: CaseKind, seed: u64) -> Vec<String> {
    let mut random = Draw::new(seed ^ 0x5eed);
    let slugs = concealable(kind);
    if kind.is_field() && random.chance(0.1) {
        return Vec::new();
    }
    let first = slugs[(seed % slugs.len() as u64) as usize];
    let mut chosen = vec![first.to_owned()];
    if random.chance(0.2) {
        let second = random.one_of(&slugs);
        if second != first {
            chosen.push(second.to_owned());
        }
    }
    chosen
}

/// The files of a case.
pub(crate) const FILES: [&str; 6] =
    ["train_1", "train_2", "holdout", "exam", "before_1", "before_2"];
/// Of these, those of a case without a change.
const AFTER: usize = 4;
/// Draws of joints and sizes before an effect counts as invisible on this arm.
const MOST_DRAWS: usize = 60;
/// The same where each draw is several integrations.
const MOST_TRANSMISSION_DRAWS: usize = 10;
/// Simulations before that.
const MOST_SIMULATIONS: usize = 6;
/// What stick phases add to the noise of a field case, until a simulation shows it.
const UNSEEN_STICK_PHASES: f64 = 1.3;
/// Largest change by the lag of the effort channel over noise.
const MOST_LAG: f64 = 0.45;
/// Share of the effort range that controllers meet unprepared.
const UNKNOWN_SHARE: f64 = 0.08;
/// Share of change cases in which the friction of all joints is another one after, the factors of its viscous part,
/// and how much these differ between joints.
const WARMED: f64 = 0.5;
const WARMTH: [f64; 2] = [0.6, 1.2];
const UNEVEN_WARMTH: f64 = 0.05;

/// Makes a case.
///
/// # Errors
/// A robot that cannot be read or simulated, an effect that the generator does not have or that this
/// arm does not show.
pub fn generate(request: &CaseRequest) -> Result<Case, ChallengeError> {
    let robot = Robot::parse(&request.robot_urdf)?;
    let slugs: Vec<&'static str> = request
        .effects
        .iter()
        .map(|slug| known_slug(slug, request.kind))
        .collect::<Result<_, _>>()?;
    let mut random = Draw::new(request.seed);
    let scene = Scene::draw(&robot, request, &mut random);
    let mut last = None;
    // stick phases are not known before the first simulation
    let margin = if scene.kind.is_field() { UNSEEN_STICK_PHASES } else { 1.0 };
    let mut noise: Vec<f64> = scene.sensing.sigma.iter().map(|sigma| margin * sigma).collect();
    for _ in 0..MOST_SIMULATIONS {
        let mut random = random.branch();
        let drafts = draw_effects(&scene, request, &slugs, &noise, &mut random)?;
        let Some(drafts) = drafts else { continue };
        let simulated = simulate(&scene, &drafts, &mut random);
        let made = match simulated {
            Ok(made) => made,
            // a motion that runs away is another draw
            Err(ChallengeError::Simulation(error)) => {
                last = Some(ChallengeError::Simulation(error));
                continue;
            }
            Err(other) => return Err(other),
        };
        noise = effective_noise(&scene, &drafts, &made);
        if let Some(truth) = truth_of(&scene, &drafts, &made, &noise, request)? {
            let [train_1, train_2, holdout, exam] = made.recorded;
            let robot_urdf = robot.urdf.clone();
            let before = made.before;
            return Ok(Case { robot_urdf, before, train_1, train_2, holdout, exam, truth });
        }
    }
    Err(last.unwrap_or_else(|| ChallengeError::Invisible {
        effects: request.effects.join(", "),
        robot: request.robot.clone(),
    }))
}

fn known_slug(slug: &str, kind: CaseKind) -> Result<&'static str, ChallengeError> {
    let known = match armident_effects::effect(slug) {
        Some(effect) => Some(effect.law().slug),
        None if slug == "unlisted" => Some("unlisted"),
        None => None,
    };
    known
        .filter(|slug| concealable(kind).contains(slug))
        .ok_or_else(|| ChallengeError::UnknownEffect { effect: slug.to_owned() })
}

/// What is drawn before the effects.
pub(crate) struct Scene<'a> {
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
    pub(crate) noise_share: f64,
    pub(crate) level: Vec<f64>,
    pub(crate) viscous: Vec<f64>,
    /// By what viscous friction is another one after than before.
    pub(crate) warmth: Vec<f64>,
    /// Effort range of each joint as believed \[N m or N\].
    pub(crate) range: Vec<f64>,
}

impl<'a> Scene<'a> {
    fn draw(robot: &'a Robot, request: &CaseRequest, random: &mut Draw) -> Self {
        let field = request.kind.is_field();
        let workspace = Workspace::draw(robot, random);
        let (rate_hz, duration_s) = if field {
            (random.one_of(&[100.0, 125.0, 200.0, 200.0, 250.0, 500.0]), random.between(12.0, 18.0))
        } else {
            (random.one_of(&[200.0, 200.0, 250.0, 400.0, 500.0]), random.between(15.0, 20.0))
        };
        let duration_s = duration_s.round();
        let mut rates_hz = [rate_hz; FILES.len()];
        if field && random.chance(0.5) {
            rates_hz[random.index(AFTER)] = random.one_of(&[100.0, 125.0, 200.0, 250.0, 400.0]);
        }
        let files = if request.kind == CaseKind::Change { FILES.len() } else { AFTER };
        let plans: Vec<Trajectory> =
            (0..files).map(|_| exciting(robot, &workspace, duration_s, random)).collect();
        let believed = robot.arm();
        let range: Vec<f64> = effort_range(&believed, &plans[0]);
        let noise_share = random.log_between(0.003, if field { 0.012 } else { 0.02 });
        let sensing = draw_sensing(robot, field, &range, noise_share, random);
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
            robot,
            kind: request.kind,
            background,
            chain,
            plans,
            planned,
            duration_s,
            rates_hz,
            sensing,
            noise_share,
            level,
            viscous,
            warmth,
            range,
        }
    }

    /// Everyday friction during a recording that no special law contains.
    fn everyday(&self, drafts: &[Sized], file: usize) -> Vec<EffectOnJoint> {
        if !self.kind.is_field() {
            return Vec::new();
        }
        let mut list = Vec::new();
        for (j, name) in self.robot.names.iter().enumerate() {
            for slug in ["viscous_friction", "coulomb_friction"] {
                let contained =
                    drafts.iter().any(|d| d.draft.joint == j && d.draft.replaces() == Some(slug));
                if !contained {
                    list.push(EffectOnJoint::new(
                        slug,
                        name,
                        [self.friction(drafts, slug, j, file)],
                    ));
                }
            }
        }
        list
    }

    /// Everyday friction of a joint during a recording: viscous coefficient or dry level. Dry friction changes with
    /// the square root of what viscous friction changes by, and neither where a change of it is concealed.
    pub(crate) fn friction(&self, drafts: &[Sized], slug: &str, joint: usize, file: usize) -> f64 {
        let concealed = drafts.iter().any(|d| d.draft.joint == joint && d.draft.slug == slug);
        let warmth = if file < AFTER && !concealed { self.warmth[joint] } else { 1.0 };
        match slug {
            "viscous_friction" => self.viscous[joint] * warmth,
            _ => self.level[joint] * warmth.sqrt(),
        }
    }

    /// The true arm during a recording; without one of the effects if told so.
    pub(crate) fn arm(
        &self,
        drafts: &[Sized],
        file: usize,
        without: Option<usize>,
    ) -> Result<SimulatedArm, ChallengeError> {
        let mut effects = self.everyday(drafts, file);
        let there = drafts.iter().enumerate().filter(|(k, sized)| {
            file < AFTER
                && Some(*k) != without
                && sized.draft.recording.is_none_or(|recording| recording == file)
        });
        let there: Vec<&Sized> = there.map(|(_, sized)| sized).collect();
        let names = &self.robot.names;
        effects.extend(there.iter().filter_map(|sized| sized.draft.of_library(sized.x, names)));
        let mut arm = SimulatedArm::on_chain(&self.chain, &effects)?;
        for sized in there {
            if let Some(law) = sized.draft.of_its_own(sized.x) {
                arm = arm.with_law(&names[sized.draft.joint], law)?;
            }
        }
        Ok(arm)
    }
}

fn draw_sensing(
    robot: &Robot,
    field: bool,
    range: &[f64],
    noise_share: f64,
    random: &mut Draw,
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
    let stride = (crate::excitation::CONTROL_HZ / 200.0) as usize;
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

/// Effects of a case with sizes that show on the planned motions; nothing if some do not.
fn draw_effects(
    scene: &Scene<'_>,
    request: &CaseRequest,
    slugs: &[&'static str],
    noise: &[f64],
    random: &mut Draw,
) -> Result<Option<Vec<Sized>>, ChallengeError> {
    let true_arm = RigidArm::from_chain(&scene.chain);
    let context = Context {
        robot: scene.robot,
        arm: &true_arm,
        plans: &scene.planned[..2],
        sigma: &scene.sensing.sigma,
        range: &scene.range,
        level: &scene.level,
        viscous: &scene.viscous,
        duration_s: scene.duration_s,
    };
    let sizing = Sizing::new(scene, noise);
    let mut chosen: Vec<Sized> = Vec::new();
    for &slug in slugs {
        let mut found = None;
        let transmission = matches!(slug, "joint_elasticity" | "backlash");
        for _ in 0..if transmission { MOST_TRANSMISSION_DRAWS } else { MOST_DRAWS } {
            let perturbed = request.perturbed && Draft::can_be_perturbed(slug);
            let Some(draft) = Draft::draw(slug, perturbed, &context, random) else { continue };
            // two effects on one joint may add up to a third
            let near = |other: &Sized| {
                let joints = |d: &Draft| [Some(d.joint), d.other];
                joints(&draft)
                    .into_iter()
                    .flatten()
                    .any(|joint| joints(&other.draft).into_iter().flatten().any(|j| j == joint))
            };
            if chosen.iter().any(near) {
                continue;
            }
            found = size(draft, scene, &sizing, request.margin, random)?;
            if found.is_some() {
                break;
            }
        }
        match found {
            Some(sized) => chosen.push(sized),
            None => return Ok(None),
        }
    }
    Ok(Some(chosen))
}

/// Moves the true arm along all plans, records, and finds the floors.
fn simulate(
    scene: &Scene<'_>,
    drafts: &[Sized],
    random: &mut Draw,
) -> Result<Made, ChallengeError> {
    let robot = scene.robot;
    let believed = robot.arm();
    let unknown: Vec<f64> = (0..robot.dof())
        .map(|j| {
            let dry = if scene.kind.is_field() { 2.0 * scene.level[j] } else { 0.0 };
            let special: f64 = drafts.iter().map(|sized| sized.torque[j]).sum();
            UNKNOWN_SHARE * scene.range[j] + dry + special
        })
        .collect();
    let gains = gains(robot, &scene.plans[0], &unknown);
    let mut exact = Vec::new();
    let mut moved = Vec::new();
    for (file, plan) in scene.plans.iter().enumerate() {
        let arm = scene.arm(drafts, file, None)?;
        let motion = track(&arm, &believed, plan, &gains)?;
        let (rate_hz, duration_s) = (scene.rates_hz[file], scene.duration_s);
        let at = instants(rate_hz, duration_s, &scene.sensing, random);
        exact.push(exact_at(&motion, &at));
        moved.push(motion);
    }
    let lag_over_noise = |lag_s: f64| {
        let each = exact.iter().map(|motion| lag_error(motion, &scene.sensing.sigma, lag_s));
        each.fold(0.0, f64::max)
    };
    // the lag stays below half the noise
    let over = lag_over_noise(scene.sensing.effort_lag_s);
    let lag_s = scene.sensing.effort_lag_s * (MOST_LAG / over).min(1.0);
    let (lag_s, lag_over_noise) = (lag_s, lag_over_noise(lag_s));
    let mut recorded = Vec::new();
    for (file, motion) in exact.iter().enumerate() {
        recorded.push(record(&moved[file], motion, &scene.sensing, lag_s, FILES[file], random)?);
    }
    let names = &robot.names;
    let floor = |file: usize, whole: bool| -> Result<Floors, ChallengeError> {
        let taken = Taken::new(&exact[file], &recorded[file], whole);
        floors(&taken, &scene.arm(drafts, file, None)?, &believed, names)
    };
    let (mut holdout, exam) = (floor(2, true)?, floor(3, false)?);
    if scene.kind == CaseKind::Change {
        // what the arm was before is no URDF
        holdout.urdf_rmse.clear();
        holdout.urdf_rmse_practical.clear();
    }
    let before = recorded.split_off(AFTER);
    let recorded: [Recording; AFTER] = <[Recording; AFTER]>::try_from(recorded)
        .map_err(|_| ChallengeError::Robot { reason: "a recording is missing".to_owned() })?;
    Ok(Made { exact, recorded, before, holdout, exam, effort_lag_s: lag_s, lag_over_noise })
}

/// RMS change by the lag of the effort channel over noise, on the most affected joint.
fn lag_error(motion: &Exact, sigma: &[f64], lag_s: f64) -> f64 {
    (0..sigma.len())
        .map(|j| {
            let effort = &motion.effort[j];
            let lagged = crate::recorder::lag(&motion.time_s, effort, lag_s);
            let change: Vec<f64> = lagged.iter().zip(effort).map(|(a, b)| a - b).collect();
            rms(&change) / sigma[j]
        })
        .fold(0.0, f64::max)
}
