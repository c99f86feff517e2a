//! A suite of motions: what to record on the arm, in which order, and what it will tell.

use std::collections::BTreeMap;
use std::time::Duration;

use armident_dynamics::RigidArm;
use armident_ident::MinimalSet;
use armident_kinematics::DrivingAxisChain;
use armident_motion::{Motion, MotionSettings};
use armident_recording::{JointChannels, Recording};
use serde::{Deserialize, Serialize};

use crate::error::ExcitationError;
use crate::information::{Columns, Information, JOINT_LAWS, Parameters};
use crate::limits::{GivenLimits, MotionLimits, motion_limits};
use crate::search::{FourierMotion, Search, effort_ratio};
use crate::sweep::Sweep;

/// Frequency of the fastest wave of the training motion and of the fast one \[Hz\]: links turn back in about a second, and
/// at the pace of a fast pick.
const HIGHEST_HZ: [f64; 2] = [0.6, 1.5];
/// Fewest and most waves of a joint.
const HARMONICS: [usize; 2] = [5, 16];
/// Shares of the time for the training motion, the fast one and the validation.
const BUDGET: [f64; 3] = [0.6, 0.2, 0.2];
/// Speed of a rehearsal over that of the motion, and of the warm-up.
const REHEARSAL: f64 = 0.2;
const WARM_UP: f64 = 0.5;
/// Speeds of the friction ladder over the speed limit.
const LADDER: [f64; 5] = [0.02, 0.1, 0.3, 0.55, 0.8];
/// Length of one rung of the ladder at most \[s\], and share of the range it takes at most.
const RUNG_S: f64 = 2.0;
const RUNG_RANGE: f64 = 0.5;
/// Poses of the static holds, and how long each is held \[s\].
const POSES: usize = 12;
const HOLD_S: f64 = 1.5;
/// Slow reversals of a joint: how many, over which share of its range, at which share of its speed limit.
const REVERSALS: usize = 3;
const REVERSAL_RANGE: f64 = 0.04;
const REVERSAL_SPEED: f64 = 0.02;
/// Moves between the parts, over the speed limit.
const APPROACH: f64 = 0.3;
/// Still time before and after each part \[s\].
const STILL_S: f64 = 0.5;
/// Speed of moves between poses over the speed limit.
const BETWEEN_POSES: f64 = 0.5;

/// What a suite is designed for.
#[derive(Debug, Clone)]
pub struct SuiteSettings {
    /// Length of the training motion \[s\].
    pub seconds: f64,
    /// Samples per second of the motions \[Hz\].
    pub rate_hz: f64,
    /// Time for the search.
    pub budget: Duration,
    /// Seed of the random starts.
    pub seed: u64,
    /// Parts to design; all where empty.
    pub parts: Vec<Part>,
}

impl Default for SuiteSettings {
    fn default() -> Self {
        Self {
            seconds: 20.0,
            rate_hz: 100.0,
            budget: Duration::from_secs(30),
            seed: 1992,
            parts: Vec::new(),
        }
    }
}

/// A part of the suite, in the order in which it is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The training motion at half its speed.
    WarmUp,
    /// Each joint at five constant speeds in both directions.
    FrictionLadder,
    /// The motion with the largest information.
    Train,
    /// The same at the speed limits.
    Fast,
    /// Poses that are held.
    StaticHolds,
    /// Small slow movements back and forth.
    SlowReversals,
    /// An independent motion, for the test of what was identified.
    Validation,
}

impl Part {
    /// All parts, in order.
    pub const ALL: [Self; 7] = [
        Self::WarmUp,
        Self::FrictionLadder,
        Self::Train,
        Self::Fast,
        Self::StaticHolds,
        Self::SlowReversals,
        Self::Validation,
    ];

    /// Its name, in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::WarmUp => "warm_up",
            Self::FrictionLadder => "friction_ladder",
            Self::Train => "train",
            Self::Fast => "fast",
            Self::StaticHolds => "static_holds",
            Self::SlowReversals => "slow_reversals",
            Self::Validation => "validation",
        }
    }

    /// What it is for.
    pub fn purpose(self) -> &'static str {
        match self {
            Self::WarmUp => "warms the drives; not for a fit",
            Self::FrictionLadder => "friction over speed",
            Self::Train => "link inertias and friction",
            Self::Fast => "link inertias at high acceleration, friction at high speed",
            Self::StaticHolds => "gravity, offsets, stiction",
            Self::SlowReversals => "friction at reversal, backlash",
            Self::Validation => "test of the model, never for a fit",
        }
    }

    /// Whether a fit uses it, a test, or neither.
    pub fn split(self) -> Split {
        match self {
            Self::WarmUp => Split::Neither,
            Self::Validation => Split::Holdout,
            _ => Split::Train,
        }
    }

    fn has_rehearsal(self) -> bool {
        matches!(self, Self::Train | Self::Fast | Self::Validation)
    }
}

/// What a recording of a motion is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// The fit.
    Train,
    /// The test of the fit.
    Holdout,
    /// Neither.
    Neither,
}

/// One motion of the suite.
#[derive(Debug, Clone)]
pub struct SuiteMotion {
    /// Name of its file.
    pub name: String,
    /// What it is for.
    pub purpose: &'static str,
    /// Whether a fit uses it.
    pub split: Split,
    /// The part; rehearsals have that of their motion.
    pub part: Part,
    /// Whether it is the slow rehearsal of the part.
    pub is_rehearsal: bool,
    /// Positions, velocities and accelerations of all joints.
    pub motion: Recording,
    /// Largest effort of the rigid body over what may be used of its limit, between samples too; and its joint.
    pub effort_share: (f64, String),
    /// Condition number of its regressor with columns of unit length.
    pub condition: f64,
}

/// What the suite will tell about one parameter.
#[derive(Debug, Clone, Serialize)]
pub struct PredictedError {
    /// Label of the constant, or slug of the law.
    pub name: String,
    /// Its joint.
    pub joint: String,
    /// Unit.
    pub unit: String,
    /// Value of the given model; none for a law of the joint.
    pub value: Option<f64>,
    /// Standard error from the given recordings alone.
    pub from_given: Option<f64>,
    /// Standard error from the training motion alone.
    pub from_train: Option<f64>,
    /// Standard error from the given recordings and all motions of the fit.
    pub from_suite: f64,
}

/// A designed suite.
#[derive(Debug)]
pub struct Suite {
    /// The motions in the order in which they are recorded, each rehearsal before its motion.
    pub motions: Vec<SuiteMotion>,
    /// Limits that were kept, by joint.
    pub limits: Vec<MotionLimits>,
    /// Standard deviation of a recorded effort that was assumed, by joint \[N m or N\].
    pub noise: Vec<f64>,
    /// What the fit will know.
    pub errors: Vec<PredictedError>,
    /// Condition number over all motions of the fit.
    pub condition: f64,
    /// Condition numbers of random motions inside the limits that are as long as the training motion: their median.
    pub random_condition: f64,
    /// Random starts of the searches.
    pub starts: usize,
    /// What was chosen, and what is not part of the design.
    pub notes: Vec<String>,
}

/// Random motions whose condition numbers are compared with that of the training motion.
const RANDOM_MOTIONS: u64 = 21;

/// An arm and what a suite is designed for.
#[derive(Debug)]
pub struct ExciteRequest<'a> {
    /// The arm.
    pub chain: &'a DrivingAxisChain,
    /// Limits that differ from those of the URDF, by joint.
    pub limits: &'a BTreeMap<String, GivenLimits>,
    /// Recordings that are there already: the training motion adds most to these. None of them need efforts.
    pub given: &'a [Recording],
    /// Lengths, rate, time and parts.
    pub settings: &'a SuiteSettings,
}

/// Designs a suite for an arm.
///
/// ```
/// use std::collections::BTreeMap;
/// use std::time::Duration;
/// use armident_excitation::{ExciteRequest, Part, SuiteSettings, excite};
/// use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
///
/// let urdf = r#"<robot name="pendulum">
///   <link name="base"/>
///   <link name="rod"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
///     <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
///   <joint name="pivot" type="revolute"><parent link="base"/><child link="rod"/>
///     <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="3" effort="40"/></joint>
/// </robot>"#;
/// let robot = parse_urdf(urdf, "pendulum.urdf")?;
/// let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
/// let chain = DrivingAxisChain::from_chain(&chain);
/// let settings = SuiteSettings {
///     seconds: 10.0,
///     budget: Duration::from_millis(200),
///     parts: vec![Part::Train],
///     ..SuiteSettings::default()
/// };
/// let limits = BTreeMap::new();
/// let request =
///     ExciteRequest { chain: &chain, limits: &limits, given: &[], settings: &settings };
/// let suite = excite(&request)?;
/// assert!(suite.errors.iter().all(|error| error.from_suite.is_finite()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ExcitationError`]: impossible limits or settings, or limits that leave no motion.
pub fn excite(request: &ExciteRequest<'_>) -> Result<Suite, ExcitationError> {
    let ExciteRequest { chain, limits, given, settings } = *request;
    for (setting, value, low, high, expected) in [
        ("length of the training motion [s]", settings.seconds, 2.0, 600.0, "2 to 600"),
        ("rate [Hz]", settings.rate_hz, 10.0, 10_000.0, "10 to 10000"),
    ] {
        if !(low..=high).contains(&value) {
            return Err(ExcitationError::Setting { setting, value, expected });
        }
    }
    let arm = RigidArm::from_chain(chain);
    let set = MinimalSet::of(&arm)?;
    let names: Vec<String> = chain.joints.iter().map(|j| j.name.clone()).collect();
    let (limits, mut notes) = motion_limits(chain, limits)?;
    let mut parameters = Parameters::new(&arm, &set, vec![1.0; arm.dof()]);
    parameters.noise = noise(&parameters, &limits, &names, settings, &mut notes);
    let of_given = given_information(&parameters, given, &names)?;
    let search = Search {
        parameters: &parameters,
        limits: &limits,
        names: &names,
        period_s: settings.seconds,
        harmonics: waves(settings.seconds, HIGHEST_HZ[0]),
    };
    // a sample of the search stands for several of the motion
    let share = search.samples() as f64 / (settings.seconds * settings.rate_hz);
    parameters.given = of_given.as_ref().map(|given| given.times(share));
    let design = Designer { parameters: &parameters, limits: &limits, names: &names, settings };
    let wanted = |part: Part| settings.parts.is_empty() || settings.parts.contains(&part);

    let mut motions: Vec<SuiteMotion> = Vec::new();
    let mut starts = 0;
    let train =
        design.search(Part::Train).best(settings.seed, settings.budget.mul_f64(BUDGET[0]))?;
    starts += train.starts;
    for part in Part::ALL.into_iter().filter(|part| wanted(*part)) {
        let found = match part {
            Part::WarmUp => Planned::Waves(train.slower(1.0 / WARM_UP)),
            Part::Train => Planned::Waves(train.clone()),
            Part::Fast | Part::Validation => {
                let which = usize::from(part == Part::Validation);
                let seed = settings.seed.wrapping_add(1_000_003 * (which as u64 + 1));
                let found =
                    design.search(part).best(seed, settings.budget.mul_f64(BUDGET[1 + which]))?;
                starts += found.starts;
                Planned::Waves(found)
            }
            Part::FrictionLadder => Planned::Moves(design.ladder()),
            Part::StaticHolds => Planned::Moves(design.holds()),
            Part::SlowReversals => Planned::Moves(design.reversals()),
        };
        if part.has_rehearsal()
            && let Planned::Waves(waves) = &found
        {
            motions.extend(design.motion(
                part,
                true,
                &Planned::Waves(waves.slower(1.0 / REHEARSAL)),
            )?);
        }
        match design.motion(part, false, &found)? {
            Some(motion) => motions.push(motion),
            None => notes.push(format!(
                "{} is left out: the rigid body alone exceeds an effort limit on it",
                part.name()
            )),
        }
    }
    notes.push(
        "not part of the design: collisions of the arm with itself and with its surroundings; watch the rehearsals, which \
         follow the same paths at a fifth of the speed"
            .to_owned(),
    );
    let of = |wanted: &dyn Fn(&SuiteMotion) -> bool| -> Option<Information> {
        let all = motions.iter().filter(|m| wanted(m));
        all.map(|m| parameters.information(&columns_of(&m.motion))).reduce(|a, b| a.with(&b))
    };
    let fitted = |m: &SuiteMotion| m.split == Split::Train && !m.is_rehearsal;
    let add = |new: Option<Information>| match (&of_given, new) {
        (Some(given), Some(new)) => Some(given.with(&new)),
        (given, new) => new.or_else(|| given.clone()),
    };
    let suite = add(of(&fitted));
    let of_train = of(&|m: &SuiteMotion| m.part == Part::Train && !m.is_rehearsal);
    let condition = suite.as_ref().map_or(Ok(f64::INFINITY), Information::condition)?;
    let errors =
        errors(&parameters, &names, [of_given.as_ref(), of_train.as_ref()], suite.as_ref());
    let random_condition = design.random_condition()?;
    let noise = parameters.noise.clone();
    Ok(Suite { motions, limits, noise, errors, condition, random_condition, starts, notes })
}

/// Noise of each joint's effort: given, or a share of its usual effort.
fn noise(
    parameters: &Parameters<'_>,
    limits: &[MotionLimits],
    names: &[String],
    settings: &SuiteSettings,
    notes: &mut Vec<String>,
) -> Vec<f64> {
    /// Share of the root mean square effort of a random motion.
    const OF_USUAL: f64 = 0.01;
    let period_s = settings.seconds;
    let search = Search { parameters, limits, names, period_s, harmonics: HARMONICS[0] };
    let usual = search.usual_efforts(settings.seed);
    let largest = usual.iter().copied().fold(0.0, f64::max);
    let without: Vec<&str> = limits
        .iter()
        .zip(names)
        .filter(|(limit, _)| limit.noise.is_none())
        .map(|(_, name)| name.as_str())
        .collect();
    if !without.is_empty() {
        notes.push(format!(
            "neither noise nor an effort limit is known: 1 % of the effort of a random motion is taken as noise on {}",
            without.join(", ")
        ));
    }
    limits
        .iter()
        .zip(&usual)
        .map(|(limit, usual)| {
            // a joint without effort of its own still has some noise
            let of_motion = OF_USUAL * usual.max(1e-3 * largest).max(f64::MIN_POSITIVE.sqrt());
            limit.noise.unwrap_or(of_motion)
        })
        .collect()
}

/// Waves of a motion of this length up to this frequency.
fn waves(period_s: f64, highest_hz: f64) -> usize {
    ((highest_hz * period_s).round() as usize).clamp(HARMONICS[0], HARMONICS[1])
}

/// Information of the motions of recordings; none without one.
fn given_information(
    parameters: &Parameters<'_>,
    given: &[Recording],
    names: &[String],
) -> Result<Option<Information>, ExcitationError> {
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut sum: Option<Information> = None;
    for recording in given {
        let motion = Motion::from_recording(recording, &joints, &MotionSettings::default())?;
        let columns = [motion.position, motion.velocity, motion.acceleration];
        let new = parameters.information(&columns);
        sum = Some(sum.map_or_else(|| new.clone(), |sum| sum.with(&new)));
    }
    Ok(sum)
}

/// Predicted standard errors of all parameters.
fn errors(
    parameters: &Parameters<'_>,
    names: &[String],
    parts: [Option<&Information>; 2],
    suite: Option<&Information>,
) -> Vec<PredictedError> {
    let Some(suite) = suite.map(Information::standard_errors) else { return Vec::new() };
    let [of_given, of_train] = parts.map(|part| part.map(Information::standard_errors));
    let constants =
        parameters.set.constants.iter().zip(parameters.values()).map(|(constant, value)| {
            let unit = constant.unit().to_owned();
            (constant.label(), constant.joint, unit, Some(*value))
        });
    let laws = (0..names.len()).flat_map(|joint| {
        JOINT_LAWS.iter().map(move |law| {
            let kind = parameters.arm.joints[joint].kind;
            let unit = law.law().parameters.first().map_or("", |p| p.unit(kind)).to_owned();
            (law.law().slug.to_owned(), joint, unit, None)
        })
    });
    constants
        .chain(laws)
        .enumerate()
        .map(|(k, (name, joint, unit, value))| PredictedError {
            name,
            joint: names[joint].clone(),
            unit,
            value,
            from_given: of_given.as_ref().map(|of| of[k]),
            from_train: of_train.as_ref().map(|of| of[k]),
            from_suite: suite[k],
        })
        .collect()
}

/// Positions, velocities and accelerations of a planned motion.
fn columns_of(motion: &Recording) -> Columns {
    let of = |k: usize| -> Vec<Vec<f64>> {
        let column = |joint: &JointChannels| {
            let channel = match k {
                0 => &joint.position,
                1 => &joint.velocity,
                _ => &joint.acceleration,
            };
            channel.clone().unwrap_or_default()
        };
        motion.joints.iter().map(column).collect()
    };
    [of(0), of(1), of(2)]
}

/// A motion of waves, or one of moves.
enum Planned {
    Waves(FourierMotion),
    Moves(Vec<Segment>),
}

/// Moves of some joints at one time, and how long all are held afterwards.
struct Segment {
    moves: Vec<(usize, Sweep)>,
    hold_s: f64,
}

impl Segment {
    fn duration_s(&self) -> f64 {
        self.moves.iter().map(|(_, sweep)| sweep.duration_s()).fold(0.0, f64::max) + self.hold_s
    }
}

struct Designer<'a> {
    parameters: &'a Parameters<'a>,
    limits: &'a [MotionLimits],
    names: &'a [String],
    settings: &'a SuiteSettings,
}

impl<'a> Designer<'a> {
    fn search(&self, part: Part) -> Search<'a> {
        // the fast motion repeats the pace of half the length; a validation has other frequencies
        let (period_s, highest_hz) = match part {
            Part::Fast => (0.5 * self.settings.seconds, HIGHEST_HZ[1]),
            Part::Validation => (0.8 * self.settings.seconds, HIGHEST_HZ[0]),
            _ => (self.settings.seconds, HIGHEST_HZ[0]),
        };
        Search {
            parameters: self.parameters,
            limits: self.limits,
            names: self.names,
            period_s,
            harmonics: waves(period_s, highest_hz),
        }
    }

    /// Median condition number of random motions as long as the training motion.
    fn random_condition(&self) -> Result<f64, ExcitationError> {
        let search = self.search(Part::Train);
        let mut all = Vec::new();
        for k in 0..RANDOM_MOTIONS {
            let motion = search.random_motion(self.settings.seed.wrapping_add(7919 * (k + 1)));
            let columns = motion.columns(&times(motion.period_s, self.settings.rate_hz));
            all.push(self.parameters.information(&columns).condition()?);
        }
        all.sort_by(f64::total_cmp);
        Ok(all[all.len() / 2])
    }

    /// The motion as a recording; none where the rigid body exceeds an effort limit.
    fn motion(
        &self,
        part: Part,
        is_rehearsal: bool,
        planned: &Planned,
    ) -> Result<Option<SuiteMotion>, ExcitationError> {
        let rate_hz = self.settings.rate_hz;
        let (time_s, columns) = match planned {
            Planned::Waves(waves) => {
                let time_s = times(waves.period_s, rate_hz);
                let columns = waves.columns(&time_s);
                (time_s, columns)
            }
            Planned::Moves(segments) => self.sampled(segments, rate_hz),
        };
        let effort_share = match planned {
            Planned::Waves(waves) => self.search(part).effort_ratio(waves),
            Planned::Moves(segments) => {
                const CHECKED_HZ: f64 = 500.0;
                let (time_s, columns) = self.sampled(segments, CHECKED_HZ);
                let jerks: Vec<f64> = self.limits.iter().map(|l| l.jerk).collect();
                effort_ratio(self.parameters, self.limits, &time_s, &columns, &jerks)
            }
        };
        if effort_share.0 > 1.0 {
            return Ok(None);
        }
        let condition = self.parameters.information(&columns).condition()?;
        let [q, v, a] = columns;
        let joints = self.names.iter().zip(q.into_iter().zip(v.into_iter().zip(a)));
        let joints = joints
            .map(|(name, (position, (velocity, acceleration)))| JointChannels {
                position: Some(position),
                velocity: Some(velocity),
                acceleration: Some(acceleration),
                ..JointChannels::new(name)
            })
            .collect();
        let name = match is_rehearsal {
            true => format!("{}_rehearsal", part.name()),
            false => part.name().to_owned(),
        };
        let motion = Recording::new(&name, time_s, joints)?;
        let (purpose, split) = match is_rehearsal {
            true => ("the same path at a fifth of the speed: watch for collisions", Split::Neither),
            false => (part.purpose(), part.split()),
        };
        let effort_share = (effort_share.0, self.names[effort_share.1].clone());
        let made = SuiteMotion {
            name,
            purpose,
            split,
            part,
            is_rehearsal,
            motion,
            effort_share,
            condition,
        };
        Ok(Some(made))
    }

    /// Samples of moves from the middle of all ranges.
    fn sampled(&self, segments: &[Segment], rate_hz: f64) -> (Vec<f64>, Columns) {
        let n = self.limits.len();
        let total_s: f64 = segments.iter().map(Segment::duration_s).sum();
        let time_s = times(total_s, rate_hz);
        let mut columns: Columns = [0, 1, 2].map(|_| vec![Vec::with_capacity(time_s.len()); n]);
        let mut held: Vec<f64> = self.limits.iter().map(MotionLimits::middle).collect();
        let (mut which, mut begin_s) = (0, 0.0);
        for &t in &time_s {
            while which + 1 < segments.len() && t >= begin_s + segments[which].duration_s() {
                begin_s += segments[which].duration_s();
                for (joint, sweep) in &segments[which].moves {
                    held[*joint] = sweep.at(f64::INFINITY)[0];
                }
                which += 1;
            }
            let moves = segments.get(which).map_or(&[][..], |s| &s.moves);
            for (joint, held) in held.iter().enumerate() {
                let moved = moves.iter().find(|(j, _)| *j == joint);
                let state = moved.map_or([*held, 0.0, 0.0], |(_, s)| s.at(t - begin_s));
                for (column, x) in columns.iter_mut().zip(state) {
                    column[joint].push(x);
                }
            }
        }
        (time_s, columns)
    }

    fn sweep(&self, joint: usize, from: f64, to: f64, share: f64) -> (usize, Sweep) {
        let limits = &self.limits[joint];
        (joint, Sweep::new(from, to, share * limits.velocity, limits))
    }

    fn ladder(&self) -> Vec<Segment> {
        let mut segments = vec![Segment { moves: Vec::new(), hold_s: STILL_S }];
        for (joint, limits) in self.limits.iter().enumerate() {
            let middle = limits.middle();
            let mut at = middle;
            let mut go = |to: f64, share: f64| {
                let moves = vec![self.sweep(joint, at, to, share)];
                segments.push(Segment { moves, hold_s: STILL_S });
                at = to;
            };
            for share in LADDER {
                let travel = (RUNG_RANGE * limits.range()).min(share * limits.velocity * RUNG_S);
                go(middle - 0.5 * travel, APPROACH);
                go(middle + 0.5 * travel, share);
                go(middle - 0.5 * travel, share);
            }
            go(middle, APPROACH);
        }
        segments
    }

    fn holds(&self) -> Vec<Segment> {
        let n = self.limits.len();
        let mut at: Vec<f64> = self.limits.iter().map(MotionLimits::middle).collect();
        let mut segments = vec![Segment { moves: Vec::new(), hold_s: STILL_S }];
        // the root of x^(n+1) = x + 1 spreads points evenly in n dimensions (M. Roberts, 2018)
        let mut root = 2.0_f64;
        for _ in 0..50 {
            root = (1.0 + root).powf(1.0 / (n as f64 + 1.0));
        }
        for pose in 1..=POSES + 1 {
            let moves = (0..n)
                .map(|joint| {
                    let limits = &self.limits[joint];
                    let share = (0.5 + pose as f64 / root.powi(joint as i32 + 1)).fract();
                    let to = match pose > POSES {
                        true => limits.middle(),
                        false => limits.lower + share * limits.range(),
                    };
                    let sweep = self.sweep(joint, at[joint], to, BETWEEN_POSES);
                    at[joint] = to;
                    sweep
                })
                .collect();
            segments.push(Segment { moves, hold_s: HOLD_S });
        }
        segments
    }

    fn reversals(&self) -> Vec<Segment> {
        let mut segments = vec![Segment { moves: Vec::new(), hold_s: STILL_S }];
        for (joint, limits) in self.limits.iter().enumerate() {
            let (middle, half) = (limits.middle(), 0.5 * REVERSAL_RANGE * limits.range());
            let mut at = middle;
            for k in 0..=2 * REVERSALS {
                let to = match k {
                    _ if k == 2 * REVERSALS => middle,
                    _ if k % 2 == 0 => middle + half,
                    _ => middle - half,
                };
                let moves = vec![self.sweep(joint, at, to, REVERSAL_SPEED)];
                segments.push(Segment { moves, hold_s: 0.0 });
                at = to;
            }
        }
        segments.push(Segment { moves: Vec::new(), hold_s: STILL_S });
        segments
    }
}

/// Even times from zero to the end.
fn times(end_s: f64, rate_hz: f64) -> Vec<f64> {
    let steps = (end_s * rate_hz).round().max(1.0) as usize;
    (0..=steps).map(|k| k as f64 / rate_hz).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;
    use crate::test_arms::chain;

    fn designed(
        limits: &BTreeMap<String, GivenLimits>,
        settings: &SuiteSettings,
        given: &[Recording],
    ) -> Result<Suite, ExcitationError> {
        let chain = chain();
        excite(&ExciteRequest { chain: &chain, limits, given, settings })
    }

    /// Recordings of the first joint alone leave the others to the new motion.
    #[test]
    fn given_recordings_are_part_of_the_fit() {
        let settings = SuiteSettings {
            seconds: 10.0,
            budget: Duration::from_millis(1000),
            parts: vec![Part::Train],
            ..SuiteSettings::default()
        };
        let alone = designed(&BTreeMap::new(), &settings, &[]).unwrap();
        let train = alone.motions.iter().find(|m| m.name == "train").unwrap();
        let mut given = train.motion.clone();
        for joint in &mut given.joints[1..] {
            for channel in [&mut joint.velocity, &mut joint.acceleration] {
                channel.as_mut().unwrap().fill(0.0);
            }
            joint.position.as_mut().unwrap().fill(0.3);
        }
        let suite = designed(&BTreeMap::new(), &settings, &[given]).unwrap();
        for error in &suite.errors {
            assert!(error.from_suite <= error.from_train.unwrap() * (1.0 + 1e-9), "{error:?}");
            assert!(error.from_suite <= error.from_given.unwrap() * (1.0 + 1e-9), "{error:?}");
        }
    }

    fn suite() -> Suite {
        let settings = SuiteSettings {
            seconds: 10.0,
            budget: Duration::from_millis(2000),
            ..SuiteSettings::default()
        };
        designed(&BTreeMap::new(), &settings, &[]).unwrap()
    }

    /// Every motion begins and ends at rest, keeps to the limits, and is smooth.
    #[test]
    fn all_motions_keep_to_the_limits() {
        let suite = suite();
        assert_eq!(suite.motions.len(), 10);
        for motion in &suite.motions {
            let dt = 1.0 / 100.0;
            for (joint, limits) in motion.motion.joints.iter().zip(&suite.limits) {
                let [q, v, a] = [&joint.position, &joint.velocity, &joint.acceleration]
                    .map(|c| c.as_deref().unwrap());
                let most = |of: &[f64]| of.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                assert!(q.iter().all(|q| *q >= limits.lower - 1e-9 && *q <= limits.upper + 1e-9));
                assert!(most(v) <= limits.velocity * (1.0 + 1e-9));
                assert!(most(a) <= limits.acceleration * (1.0 + 1e-9));
                for x in [v[0], v[v.len() - 1], a[0]] {
                    assert!(x.abs() < 1e-6, "{} {x}", motion.name);
                }
                for k in 1..q.len() {
                    let jump = (q[k] - q[k - 1] - 0.5 * dt * (v[k] + v[k - 1])).abs();
                    assert!(jump < dt * dt * limits.acceleration, "{} {k}: {jump}", motion.name);
                }
            }
            assert!(motion.effort_share.0 <= 1.0);
        }
    }

    /// The training motion tells more than random ones, and the suite more than the training motion.
    #[test]
    fn suite_tells_more_than_its_parts() {
        let suite = suite();
        let train = suite.motions.iter().find(|m| m.name == "train").unwrap();
        assert!(train.condition < suite.random_condition);
        for error in &suite.errors {
            assert!(error.from_suite.is_finite());
            assert!(error.from_suite <= error.from_train.unwrap() * (1.0 + 1e-9), "{error:?}");
        }
    }

    #[test]
    fn impossible_requests_are_refused() {
        let settings = SuiteSettings { seconds: 0.1, ..SuiteSettings::default() };
        assert!(designed(&BTreeMap::new(), &settings, &[]).is_err());
        // gravity alone exceeds this
        let name = chain().joints[1].name.clone();
        let weak = GivenLimits { effort: Some(0.5), ..GivenLimits::default() };
        let settings =
            SuiteSettings { budget: Duration::from_millis(200), ..SuiteSettings::default() };
        let error = designed(&BTreeMap::from([(name.clone(), weak)]), &settings, &[]);
        let text = error.unwrap_err().to_string();
        assert!(text.contains(&name), "{text}");
    }
}
