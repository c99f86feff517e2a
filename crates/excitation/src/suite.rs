//! A suite of motions: what to record on the arm, in which order, and what it will tell.

use std::collections::BTreeMap;
use std::time::Duration;

use armident_dynamics::RigidArm;
use armident_ident::MinimalSet;
use armident_kinematics::DrivingAxisChain;
use armident_motion::{Motion, MotionSettings};
use armident_recording::{JointChannels, Recording};

use crate::clearance::{Clearance, MARGIN_M};
use crate::designer::{
    Designer, HARMONICS, Planned, REHEARSAL, SuiteMotion, period_and_waves, times,
};
use crate::error::ExcitationError;
use crate::information::{Columns, Information, Parameters};
use crate::keep_out::KeepOut;
use crate::law_columns::PlannedMotion;
use crate::limits::{GivenLimits, MotionLimits, motion_limits};
use crate::part::{Part, Split};
use crate::predicted::{PredictedError, errors};
use crate::search::{FourierMotion, Search, samples_of};
use crate::separation::{COMPARED_HZ, RivalEffects, Rivals, Separation};
use crate::visibility::{Seen, Visibility};

/// Shares of the time for the training motion, the fast one and the validation.
const BUDGET: [f64; 3] = [0.6, 0.2, 0.2];
/// Speed of the warm-up over that of the training motion.
const WARM_UP: f64 = 0.5;
/// Share of a motion about the free pose below which contacts leave too little of it: errors grow by its inverse and more.
const SMALL_SHARE: f64 = 0.3;
/// Random motions whose condition numbers are compared with that of the training motion.
const RANDOM_MOTIONS: u64 = 21;

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
    /// Parts to design; where empty all, or the separating motion alone where there are rivals.
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
    /// Which effects the fit will show.
    pub visibilities: Vec<Visibility>,
    /// How well the separating motion separates findings from alternatives.
    pub separations: Vec<Separation>,
    /// Condition number over all motions of the fit.
    pub condition: f64,
    /// Condition numbers of random motions inside the limits that are as long as the training motion: their median.
    pub random_condition: f64,
    /// Random starts of the searches.
    pub starts: usize,
    /// What was chosen, and what is not part of the design.
    pub notes: Vec<String>,
}

/// An arm and what a suite is designed for.
#[derive(Debug)]
pub struct ExciteRequest<'a> {
    /// The arm.
    pub chain: &'a DrivingAxisChain,
    /// Limits that differ from those of the URDF, by joint.
    pub limits: &'a BTreeMap<String, GivenLimits>,
    /// Recordings that are there already: the training motion adds most to these. None of them need efforts.
    pub given: &'a [Recording],
    /// Regions in the axes of the base link that the arm keeps out of, by name.
    pub keep_out: &'a BTreeMap<String, KeepOut>,
    /// Findings and their alternatives that a motion is to separate.
    pub rivals: &'a [RivalEffects<'a>],
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
/// let keep_out = BTreeMap::new();
/// let request = ExciteRequest {
///     chain: &chain,
///     limits: &limits,
///     given: &[],
///     keep_out: &keep_out,
///     rivals: &[],
///     settings: &settings,
/// };
/// let suite = excite(&request)?;
/// assert!(suite.errors.iter().all(|error| error.from_suite.is_finite()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ExcitationError`]: impossible limits, settings or regions, limits or regions that leave no motion, or rivals that no
/// motion can be designed for.
pub fn excite(request: &ExciteRequest<'_>) -> Result<Suite, ExcitationError> {
    let ExciteRequest { chain, limits, given, keep_out, rivals, settings } = *request;
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
    if !keep_out.is_empty() && !Clearance::has_shapes(chain) {
        return Err(ExcitationError::NoShapes);
    }
    let clearance = Clearance::of(chain, &limits, keep_out)?;
    let home = match &clearance {
        Some(clearance) => clearance.free_pose(&limits)?,
        None => limits.iter().map(MotionLimits::middle).collect(),
    };
    let of_given = given_information(&parameters, given, &names)?;
    // a sample of the search stands for several of the motion
    let (_, waves) = period_and_waves(Part::Train, settings.seconds);
    let share = samples_of(waves) as f64 / (settings.seconds * settings.rate_hz);
    parameters.given = of_given.as_ref().map(|given| given.times(share));
    let design = Designer {
        parameters: &parameters,
        limits: &limits,
        names: &names,
        clearance: clearance.as_ref(),
        home: &home,
        seconds: settings.seconds,
        rate_hz: settings.rate_hz,
    };
    let rivals = match rivals {
        [] => None,
        pairs => Some(Rivals::of(chain, &parameters, pairs)?),
    };

    let mut planning =
        Planning { design: &design, settings, motions: Vec::new(), starts: 0, notes: Vec::new() };
    let mut separations = Vec::new();
    if let Some(rivals) = &rivals {
        separations = planning.separating(rivals)?;
    }
    planning.parts(rivals.is_some())?;
    let Planning { motions, starts, notes: of_motions, .. } = planning;
    notes.extend(of_motions);
    notes.extend(clearance.iter().flat_map(|clearance| clearance.notes.iter().cloned()));
    notes.push(match clearance {
        Some(_) => format!(
            "contacts: boxes, cylinders and spheres of the URDF{} keep {:.0} mm apart; watch the rehearsals, which follow the \
             same paths at a fifth of the speed",
            if keep_out.is_empty() { "" } else { " and keep-outs" },
            1000.0 * MARGIN_M
        ),
        None => "not part of the design: collisions of the arm with itself and with its surroundings (the links have no boxes, \
             cylinders or spheres that could touch); watch the rehearsals, which follow the same paths at a fifth of the speed"
            .to_owned(),
    });
    let columns: Vec<Columns> = motions.iter().map(|m| columns_of(&m.motion)).collect();
    let fitted: Vec<usize> = (0..motions.len())
        .filter(|&k| motions[k].split == Split::Train && !motions[k].is_rehearsal)
        .collect();
    let is_train = |k: &usize| motions[*k].part == Part::Train;
    let of = |which: &[usize]| -> Option<Information> {
        let all = which.iter().map(|&k| parameters.information(&columns[k]));
        all.reduce(|a, b| a.with(&b))
    };
    let of_train = of(&fitted.iter().copied().filter(is_train).collect::<Vec<_>>());
    let suite = match (&of_given, of(&fitted)) {
        (Some(given), Some(new)) => Some(given.with(&new)),
        (given, new) => new.or_else(|| given.clone()),
    };
    let condition = suite.as_ref().map_or(Ok(f64::INFINITY), Information::condition)?;
    let errors =
        errors(&parameters, &names, [of_given.as_ref(), of_train.as_ref()], suite.as_ref());
    let planned: Vec<PlannedMotion<'_>> = fitted
        .iter()
        .map(|&k| {
            let efforts = parameters.efforts(&columns[k]);
            PlannedMotion::new(&columns[k], efforts, settings.rate_hz)
        })
        .collect();
    let train = fitted.iter().position(is_train);
    let seen = Seen { chain, parameters: &parameters, motions: &planned, train };
    let visibilities = seen.effects();
    let random_condition = design.random_condition(settings.seed, RANDOM_MOTIONS)?;
    let noise = parameters.noise.clone();
    Ok(Suite {
        motions,
        limits,
        noise,
        errors,
        visibilities,
        separations,
        condition,
        random_condition,
        starts,
        notes,
    })
}

/// Motions as they are planned, part by part.
struct Planning<'a> {
    design: &'a Designer<'a>,
    settings: &'a SuiteSettings,
    motions: Vec<SuiteMotion>,
    starts: usize,
    notes: Vec<String>,
}

impl Planning<'_> {
    fn budget(&self, share: f64) -> Duration {
        self.settings.budget.mul_f64(share)
    }

    /// The motion that separates rivals.
    fn separating(&mut self, rivals: &Rivals<'_>) -> Result<Vec<Separation>, ExcitationError> {
        let search = self.design.search(Part::Separation);
        let worth = |columns: &Columns| rivals.worth(columns);
        let budget = self.budget(1.0);
        let found = search.climb(self.settings.seed, budget, 1.0 / COMPARED_HZ, worth)?;
        self.starts += found.starts;
        let columns = found.columns(&times(found.period_s, self.settings.rate_hz));
        self.add(Part::Separation, &Planned::Waves(found))?;
        Ok(rivals.separations(&columns, self.settings.rate_hz))
    }

    /// All wanted parts; those of rivals alone where none is named.
    fn parts(&mut self, has_rivals: bool) -> Result<(), ExcitationError> {
        let settings = self.settings;
        let wanted = |part: &Part| match settings.parts.is_empty() {
            true => !has_rivals,
            false => settings.parts.contains(part),
        };
        let mut train: Option<FourierMotion> = None;
        for part in Part::ALL.into_iter().filter(wanted) {
            if matches!(part, Part::WarmUp | Part::Train) && train.is_none() {
                let search = self.design.search(Part::Train);
                train = Some(self.searched(search.best(settings.seed, self.budget(BUDGET[0])))?);
            }
            let planned = match (part, &train) {
                (Part::WarmUp, Some(train)) => Ok(Planned::Waves(train.slower(1.0 / WARM_UP))),
                (Part::Train, Some(train)) => Ok(Planned::Waves(train.clone())),
                (Part::Fast | Part::Validation, _) => {
                    let which = usize::from(part == Part::Validation);
                    let seed = settings.seed.wrapping_add(1_000_003 * (which as u64 + 1));
                    let search = self.design.search(part);
                    let found = search.best(seed, self.budget(BUDGET[1 + which]));
                    Ok(Planned::Waves(self.searched(found)?))
                }
                _ => self.design.moves(part).map(Planned::Moves),
            };
            match planned {
                Ok(planned) => {
                    if !self.add(part, &planned)? {
                        self.notes.push(format!(
                            "{} is left out: the rigid body alone exceeds an effort limit on it",
                            part.name()
                        ));
                    }
                }
                Err(contact) => self.notes.push(format!(
                    "{} is left out: {} and {} come within {:.0} mm of each other on it, however small its moves",
                    part.name(),
                    contact.names[0],
                    contact.names[1],
                    1000.0 * contact.distance_m.max(0.0)
                )),
            }
        }
        Ok(())
    }

    fn searched(
        &mut self,
        found: Result<FourierMotion, ExcitationError>,
    ) -> Result<FourierMotion, ExcitationError> {
        let found = found?;
        self.starts += found.starts;
        Ok(found)
    }

    /// Adds a motion and its rehearsal before it; false where it exceeds an effort limit.
    fn add(&mut self, part: Part, planned: &Planned) -> Result<bool, ExcitationError> {
        if part.has_rehearsal()
            && let Planned::Waves(waves) = planned
        {
            if waves.clear_share < SMALL_SHARE {
                self.notes.push(format!(
                    "{}: {:.0} % of the motion found is clear, so that errors are large; more of it would be with \
                     keep-outs further away, or with `lower` and `upper` about poses that are free",
                    part.name(),
                    100.0 * waves.clear_share
                ));
            }
            let slow = Planned::Waves(waves.slower(1.0 / REHEARSAL));
            self.motions.extend(self.design.motion(part, true, &slow)?);
        }
        let motion = self.design.motion(part, false, planned)?;
        let is_within = motion.is_some();
        self.motions.extend(motion);
        Ok(is_within)
    }
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
    let search = Search {
        parameters,
        limits,
        names,
        clearance: None,
        home: &[],
        period_s,
        harmonics: HARMONICS[0],
    };
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

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;
    use crate::separation::RivalModels;
    use crate::test_arms::{boxes, chain};

    fn designed(
        limits: &BTreeMap<String, GivenLimits>,
        settings: &SuiteSettings,
        given: &[Recording],
    ) -> Result<Suite, ExcitationError> {
        let chain = chain();
        let keep_out = BTreeMap::new();
        excite(&ExciteRequest {
            chain: &chain,
            limits,
            given,
            keep_out: &keep_out,
            rivals: &[],
            settings,
        })
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

    fn table() -> BTreeMap<String, KeepOut> {
        let table = KeepOut {
            centre: Some([0.45, 0.0, 0.25]),
            size: Some([0.6, 2.0, 0.1]),
            ..KeepOut::default()
        };
        BTreeMap::from([("table".to_owned(), table)])
    }

    fn beside_table(keep_out: &BTreeMap<String, KeepOut>) -> Result<Suite, ExcitationError> {
        let chain = boxes();
        let settings = SuiteSettings {
            seconds: 6.0,
            budget: Duration::from_millis(1500),
            ..SuiteSettings::default()
        };
        let limits = BTreeMap::new();
        excite(&ExciteRequest {
            chain: &chain,
            limits: &limits,
            given: &[],
            keep_out,
            rivals: &[],
            settings: &settings,
        })
    }

    /// No sample of a grid finer than the controller's comes nearer than what is promised, and what is promised is kept.
    #[test]
    fn suite_beside_a_table_is_clear() {
        let keep_out = table();
        let suite = beside_table(&keep_out).unwrap();
        assert_eq!(suite.motions.len(), 10, "{:?}", suite.notes);
        let chain = boxes();
        let clearance = Clearance::of(&chain, &suite.limits, &keep_out).unwrap().unwrap();
        for motion in &suite.motions {
            let promised = motion.clearance_m.unwrap();
            assert!(promised >= MARGIN_M, "{} {promised}", motion.name);
            let columns = columns_of(&motion.motion);
            for k in (0..motion.motion.time_s.len() - 1).step_by(3) {
                // cubic between two samples: exact to the fourth power of 10 ms
                let h = 1.0 / 100.0;
                for x in [0.0, 0.5] {
                    let pose: Vec<f64> = (0..3)
                        .map(|j| {
                            let [q, v] = [0, 1].map(|d| [columns[d][j][k], columns[d][j][k + 1]]);
                            let middle = 0.5 * (q[0] + q[1]) + h / 8.0 * (v[0] - v[1]);
                            if x == 0.0 { q[0] } else { middle }
                        })
                        .collect();
                    let nearest = clearance.nearest(&pose);
                    assert!(nearest.distance_m > promised - 1e-5, "{} {nearest:?}", motion.name);
                }
            }
        }
        // the table costs information, not all of it
        let free = beside_table(&BTreeMap::new()).unwrap();
        let condition = |suite: &Suite| {
            suite.motions.iter().find(|m| m.name == "train").map(|m| m.condition).unwrap()
        };
        assert!(condition(&suite) < 10.0 * condition(&free));
    }

    #[test]
    fn regions_without_room_are_refused() {
        let all = KeepOut { centre: Some([0.0; 3]), size: Some([9.0; 3]), ..KeepOut::default() };
        let error = beside_table(&BTreeMap::from([("cell".to_owned(), all)])).unwrap_err();
        assert!(error.to_string().contains("keep-out `cell` and link"), "{error}");
        let chain = chain();
        let settings = SuiteSettings::default();
        let (limits, keep_out) = (BTreeMap::new(), table());
        let request = ExciteRequest {
            chain: &chain,
            limits: &limits,
            given: &[],
            keep_out: &keep_out,
            rivals: &[],
            settings: &settings,
        };
        assert!(matches!(excite(&request), Err(ExcitationError::NoShapes)));
    }

    /// Link constants imitate a payload; slow rungs show Stribeck friction that the training motion alone does not.
    #[test]
    fn effects_are_visible_on_motions_that_show_them() {
        use crate::visibility::Sight;
        let suite = suite();
        let of = |effect: &str, k: usize| {
            suite.visibilities.iter().filter(|seen| seen.effect == effect).nth(k).unwrap()
        };
        assert_eq!(of("payload", 0).suite, Sight::Imitated);
        assert_eq!(of("asymmetric_coulomb_friction", 0).suite, Sight::Imitated);
        assert_eq!(of("torque_scale", 1).suite, Sight::Visible);
        for joint in 0..6 {
            let seen = of("stribeck_friction", joint);
            let [train, suite] = [seen.least_from_train, seen.least_from_suite].map(Option::unwrap);
            assert!(suite < 0.5 * train, "{seen:?}");
        }
    }

    /// Two models whose efforts differ by a ripple.
    #[derive(Debug)]
    struct Ripple;

    impl RivalModels for Ripple {
        fn difference(&self, motion: &Recording) -> Option<Vec<Vec<f64>>> {
            let of = |joint: &JointChannels| {
                let position = joint.position.clone().unwrap_or_default();
                position.iter().map(|q| (20.0 * q).sin()).collect()
            };
            Some(motion.joints.iter().map(of).collect())
        }
    }

    /// Stribeck and presliding friction are alike on the training motion. A finding that is fitted anyway is separated by no
    /// motion, and what needs a simulation is listed with its reason, or separated by two fitted models.
    #[test]
    fn separating_motion_is_better_than_the_training_motion() {
        let chain = chain();
        let joint = chain.joints[1].name.clone();
        let pair = |effect: &str, parameters: &[f64], alternative: &str| RivalEffects {
            finding: armident_effects::EffectOnJoint::new(effect, joint.clone(), parameters),
            alternative: alternative.to_owned(),
            alternative_joint: joint.clone(),
            models: None,
        };
        let rivals = [
            pair("stribeck_friction", &[6.0, 5.0, 0.1], "presliding_hysteresis"),
            pair("coulomb_friction", &[3.0], "stribeck_friction"),
            pair("backlash", &[0.01, 1e4, 10.0, 1.0], "coulomb_friction"),
            RivalEffects {
                models: Some(&Ripple),
                ..pair("backlash", &[0.01, 1e4, 10.0, 1.0], "joint_elasticity")
            },
        ];
        let (limits, keep_out) = (BTreeMap::new(), BTreeMap::new());
        let settings = SuiteSettings {
            seconds: 10.0,
            budget: Duration::from_millis(2500),
            ..SuiteSettings::default()
        };
        let request = ExciteRequest {
            chain: &chain,
            limits: &limits,
            given: &[],
            keep_out: &keep_out,
            rivals: &rivals,
            settings: &settings,
        };
        let suite = excite(&request).unwrap();
        let names: Vec<&str> = suite.motions.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["separation_rehearsal", "separation"]);
        let found = suite.separations;
        assert_eq!(found[1].standard_errors, Some(0.0));
        assert!(found[2].standard_errors.is_none() && found[2].note.is_some());
        let joints = suite.noise.iter().map(|noise| noise.powi(-2)).sum::<f64>();
        let most = (0.5 * 1000.0 * joints).sqrt();
        let of_models = found[3].standard_errors.unwrap();
        assert!(of_models > 0.3 * most && of_models < 1.5 * most, "{of_models} {most}");
        let train = designed(&limits, &SuiteSettings { parts: vec![Part::Train], ..settings }, &[]);
        let train = train.unwrap().motions.into_iter().find(|m| m.name == "train").unwrap();
        let arm = RigidArm::from_chain(&chain);
        let set = MinimalSet::of(&arm).unwrap();
        let parameters = Parameters::new(&arm, &set, suite.noise);
        let rivals = Rivals::of(&chain, &parameters, &rivals).unwrap();
        let before = rivals.separations(&columns_of(&train.motion), 100.0);
        let [new, old] = [&found[0], &before[0]].map(|pair| pair.standard_errors.unwrap());
        assert!(new > 1.5 * old, "{new} {old}");
    }

    #[test]
    fn rivals_of_another_arm_are_refused() {
        let chain = chain();
        let arm = RigidArm::from_chain(&chain);
        let set = MinimalSet::of(&arm).unwrap();
        let parameters = Parameters::new(&arm, &set, vec![1.0; 6]);
        let good = RivalEffects {
            finding: armident_effects::EffectOnJoint::new(
                "torque_scale",
                chain.joints[0].name.clone(),
                [1.1],
            ),
            alternative: "coulomb_friction".to_owned(),
            alternative_joint: chain.joints[0].name.clone(),
            models: None,
        };
        assert!(Rivals::of(&chain, &parameters, std::slice::from_ref(&good)).is_ok());
        let wrong = [
            RivalEffects { alternative: "gremlins".to_owned(), ..good.clone() },
            RivalEffects { alternative_joint: "axis_9".to_owned(), ..good },
        ];
        for pair in wrong {
            assert!(Rivals::of(&chain, &parameters, &[pair]).is_err());
        }
        assert!(Rivals::of(&chain, &parameters, &[]).is_err());
    }
}
