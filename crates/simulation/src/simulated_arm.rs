//! The arm that is moved: rigid body and effects on it.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use armident_dynamics::RigidArm;
use armident_effects::{
    ArmFrames, DryFriction, Effect, EffectOnJoint, JointState, Library, Mechanism, PositionControl,
    PositionServo, Scope, Transmission,
};
use armident_kinematics::DrivingAxisChain;
use armident_recording::Recording;
use nalgebra::Vector3;

use crate::drive_temperature::DriveTemperatures;
use crate::error::{NEEDS_FRAMES, SimulationError};

/// Rise and fall of a contact \[s\].
pub const CONTACT_RAMP_S: f64 = 0.08;

/// An effect of the library with its numbers.
#[derive(Clone)]
pub struct EffectWithParameters {
    /// The law.
    pub effect: &'static dyn Effect,
    /// Numbers in the order of the law, finite and of admissible sign.
    pub parameters: Vec<f64>,
}

impl fmt::Debug for EffectWithParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{:?}", self.effect.law().slug, self.parameters)
    }
}

/// Friction of the common speed `s = v_b + ratio v_a`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairFriction {
    pub(crate) a: usize,
    pub(crate) b: usize,
    pub(crate) ratio: f64,
    pub(crate) viscous: f64,
    pub(crate) coulomb: f64,
}

/// A force on the tip for a while.
#[derive(Debug, Clone, Copy)]
struct TipForce {
    force_base_n: Vector3<f64>,
    window_s: Option<[f64; 2]>,
}

/// A rigid arm with named joints and effects.
#[derive(Debug, Clone)]
pub struct SimulatedArm {
    rigid: RigidArm,
    joints: Vec<String>,
    effects: Vec<Vec<EffectWithParameters>>,
    /// Effects with a deflection: joint, index among its effects.
    deflections: Vec<(usize, usize)>,
    pairs: Vec<PairFriction>,
    transmissions: Vec<Option<Transmission>>,
    servos: Vec<Option<PositionServo>>,
    tip_forces: Vec<TipForce>,
    frames: Option<ArmFrames>,
    effort_gains: Vec<f64>,
    effort_delay_s: f64,
    temperatures: Option<Arc<DriveTemperatures>>,
}

impl SimulatedArm {
    /// The arm with joints named from base to tip and effects on it. Several effects on one joint
    /// add up, also several of one kind. Effects that are given in frames of the URDF (loads, tilts,
    /// contacts) need [`on_chain`](Self::on_chain).
    ///
    /// # Errors
    /// Names that are not one per joint; an effect that the library does not have, on a joint that
    /// the arm does not have, with parameters that are not finite or of the wrong sign, or
    /// [`NotSimulated`](SimulationError::NotSimulated).
    pub fn new(
        arm: RigidArm,
        joint_names: &[impl AsRef<str>],
        effects: &[EffectOnJoint],
    ) -> Result<Self, SimulationError> {
        Self::build(Library::standard(), arm, None, joint_names, effects)
    }

    /// The arm of a chain with effects on it, also those that are given in frames of the URDF.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn on_chain(
        chain: &DrivingAxisChain,
        effects: &[EffectOnJoint],
    ) -> Result<Self, SimulationError> {
        Self::on_chain_in(Library::standard(), chain, effects)
    }

    /// The arm of a chain with effects of this library on it, which may have laws of its own.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn on_chain_in(
        library: &Library,
        chain: &DrivingAxisChain,
        effects: &[EffectOnJoint],
    ) -> Result<Self, SimulationError> {
        let arm = RigidArm::from_chain(chain);
        let frames = ArmFrames::of_chain(chain);
        Self::build(library, arm, Some(frames), &chain.joint_names(), effects)
    }

    fn build(
        library: &Library,
        arm: RigidArm,
        frames: Option<ArmFrames>,
        joint_names: &[impl AsRef<str>],
        effects: &[EffectOnJoint],
    ) -> Result<Self, SimulationError> {
        let joints: Vec<String> = joint_names.iter().map(|name| name.as_ref().to_owned()).collect();
        let different = joints.iter().collect::<BTreeSet<_>>().len();
        let n = arm.dof();
        if joints.len() != n || different != n {
            return Err(SimulationError::JointNames { joints: n, names: different });
        }
        let mut built = Self {
            rigid: arm,
            joints,
            effects: vec![Vec::new(); n],
            deflections: Vec::new(),
            pairs: Vec::new(),
            transmissions: vec![None; n],
            servos: vec![None; n],
            tip_forces: Vec::new(),
            frames,
            effort_gains: vec![1.0; n],
            effort_delay_s: 0.0,
            temperatures: None,
        };
        for given in effects {
            built.add(library, given)?;
        }
        Ok(built)
    }

    fn add(&mut self, library: &Library, given: &EffectOnJoint) -> Result<(), SimulationError> {
        let effect = library.resolve(given).map_err(|error| SimulationError::UnknownEffect {
            error,
            joint: given.joint.clone(),
        })?;
        let law = effect.law();
        let everywhere = matches!(law.scope, Scope::Arm | Scope::Link) && given.joint.is_empty();
        let index = if everywhere { self.dof() - 1 } else { self.index(law.slug, &given.joint)? };
        for (parameter, &value) in law.parameters.iter().zip(&given.parameters) {
            if !parameter.admissible.allows(value) {
                return Err(SimulationError::Parameter {
                    effect: law.slug,
                    joint: given.joint.clone(),
                    parameter: parameter.name,
                    value,
                    unit: parameter.unit(self.rigid.joints[index].kind),
                });
            }
        }
        let refused = |reason: &'static str| SimulationError::NotSimulated {
            effect: law.slug,
            joint: given.joint.clone(),
            reason,
        };
        let mechanism = effect.mechanism(&given.parameters);
        if given.other_joint.is_some() && !matches!(mechanism, Mechanism::Pair { .. }) {
            return Err(refused("it acts on one joint, and a second one is given"));
        }
        if given.window_s.is_some() && !matches!(mechanism, Mechanism::TipForce(_)) {
            return Err(refused("only a contact has a time window"));
        }
        match mechanism {
            Mechanism::Joint => {
                let with = EffectWithParameters { effect, parameters: given.parameters.clone() };
                if !self.is_finite(index, &with) {
                    return Err(refused("its effort is no finite number: some parameter is zero"));
                }
                self.push(index, with);
            }
            Mechanism::Pair { ratio, viscous, coulomb } => {
                let Some(other) = &given.other_joint else {
                    return Err(refused("it acts on two joints, and one is given"));
                };
                let b = self.index(law.slug, other)?;
                if b == index {
                    return Err(refused("its two joints are the same"));
                }
                self.pairs.push(PairFriction { a: index, b, ratio, viscous, coulomb });
            }
            Mechanism::Transmission(transmission) => {
                if transmission.motor_inertia <= 0.0 || transmission.stiffness <= 0.0 {
                    return Err(refused("motor inertia and stiffness must be positive"));
                }
                if self.transmissions[index].is_some() {
                    return Err(refused("the joint has a transmission already"));
                }
                self.transmissions[index] = Some(transmission);
            }
            Mechanism::Servo(servo) => {
                if !servo.is_sound() {
                    return Err(refused("its stiffness must be positive"));
                }
                if self.servos[index].is_some() {
                    return Err(refused("the joint has a position controller already"));
                }
                self.servos[index] = Some(servo);
            }
            Mechanism::Arm => {
                let frames = self.frames.clone();
                let frames = frames.ok_or_else(|| refused(NEEDS_FRAMES))?;
                effect.change_arm(&given.parameters, index, &frames, &mut self.rigid);
            }
            Mechanism::TipForce(force_base_n) => {
                if self.frames.is_none() {
                    return Err(refused(NEEDS_FRAMES));
                }
                let sound = |[start, end]: [f64; 2]| start.is_finite() && end > start;
                if !given.window_s.is_none_or(sound) {
                    return Err(refused("its time window does not end after it starts"));
                }
                self.tip_forces.push(TipForce { force_base_n, window_s: given.window_s });
            }
            Mechanism::EffortGain(gain) => {
                if gain <= 0.0 {
                    return Err(refused("a gain must be positive"));
                }
                self.effort_gains[index] *= gain;
            }
            Mechanism::EffortDelay(delay_s) => self.effort_delay_s += delay_s,
        }
        Ok(())
    }

    /// The same arm with a law that is not in the library; it acts by
    /// [`Mechanism::Joint`], whatever it says itself.
    ///
    /// # Errors
    /// A joint that the arm does not have, parameters that do not give a finite effort.
    pub fn with_law(
        mut self,
        joint: &str,
        law: EffectWithParameters,
    ) -> Result<Self, SimulationError> {
        let slug = law.effect.law().slug;
        let index = self.index(slug, joint)?;
        if !self.is_finite(index, &law) {
            let reason = "its effort is no finite number: some parameter is zero";
            let joint = joint.to_owned();
            return Err(SimulationError::NotSimulated { effect: slug, joint, reason });
        }
        self.push(index, law);
        Ok(self)
    }

    fn push(&mut self, joint: usize, law: EffectWithParameters) {
        if law.effect.has_deflection() {
            self.deflections.push((joint, self.effects[joint].len()));
        }
        self.effects[joint].push(law);
    }

    fn index(&self, effect: &str, joint: &str) -> Result<usize, SimulationError> {
        let index = self.joints.iter().position(|name| name == joint);
        index.ok_or_else(|| SimulationError::UnknownJoint {
            effect: effect.to_owned(),
            joint: joint.to_owned(),
            known: self.joints.clone(),
        })
    }

    /// Whether a law gives numbers at rest and in motion: constants that are divided by may be zero.
    fn is_finite(&self, joint: usize, law: &EffectWithParameters) -> bool {
        let (effect, parameters) = (law.effect, &law.parameters);
        [0.0, 1.0].into_iter().all(|velocity| {
            let state = self.joint_state(joint, 0.0, 0.3, velocity, 1.0);
            let dry = effect.dry_friction(parameters, &state);
            let deflection = effect.deflection_after(parameters, 0.0, 0.1);
            effect.smooth_effort(parameters, &state).is_finite()
                && dry.forward.is_finite()
                && dry.backward.is_finite()
                && deflection.is_finite()
                && effect.deflection_effort(parameters, deflection, velocity).is_finite()
        })
    }

    /// The rigid body alone: the given arm with the changes that effects make to it.
    pub fn rigid(&self) -> &RigidArm {
        &self.rigid
    }

    /// Joint names from base to tip.
    pub fn joints(&self) -> &[String] {
        &self.joints
    }

    /// Effects that act on joint `joint` alone, in the order in which they were given.
    pub fn effects(&self, joint: usize) -> &[EffectWithParameters] {
        &self.effects[joint]
    }

    /// The same arm, its drives as warm as in a recording, at the time stamps of that. Laws that follow a temperature which is
    /// not recorded are those at their reference.
    #[must_use]
    pub fn at_temperatures_of(&self, recording: &Recording) -> Self {
        let temperatures = DriveTemperatures::of(recording, &self.joints);
        Self { temperatures: Some(Arc::new(temperatures)), ..self.clone() }
    }

    /// The same if a law follows them.
    pub(crate) fn at_known_temperatures(&self, recording: &Recording) -> Cow<'_, Self> {
        match (0..self.dof()).any(|j| self.follows_temperature(j)) {
            true => Cow::Owned(self.at_temperatures_of(recording)),
            false => Cow::Borrowed(self),
        }
    }

    fn follows_temperature(&self, joint: usize) -> bool {
        self.effects[joint].iter().any(|e| e.effect.law().follows_temperature)
    }

    /// Joints with a law that follows the temperature of the drive, which is not known.
    pub fn joints_without_temperature(&self) -> Vec<&str> {
        let known = |j: usize| self.temperatures().is_some_and(|of| of.at(j, 0.0).is_some());
        let unknown = (0..self.dof()).filter(|j| self.follows_temperature(*j) && !known(*j));
        unknown.map(|j| self.joints[j].as_str()).collect()
    }

    pub(crate) fn temperatures(&self) -> Option<&DriveTemperatures> {
        self.temperatures.as_deref()
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Spring, damper and play before the link of joint `joint`.
    pub fn transmission(&self, joint: usize) -> Option<&Transmission> {
        self.transmissions[joint].as_ref()
    }

    /// Position controller of joint `joint`.
    pub fn servo(&self, joint: usize) -> Option<&PositionServo> {
        self.servos[joint].as_ref()
    }

    /// The same where there must be one.
    pub(crate) fn servo_or_error(&self, joint: usize) -> Result<PositionServo, SimulationError> {
        self.servos[joint].ok_or_else(|| SimulationError::NotSimulated {
            effect: PositionControl.slug(),
            joint: self.joints[joint].clone(),
            reason: "the joint has no position controller to follow commands",
        })
    }

    /// The transmission of each joint that has one.
    pub(crate) fn transmissions(&self) -> &[Option<Transmission>] {
        &self.transmissions
    }

    /// Whether positions are those of motors with a link of its own behind them.
    pub fn has_transmissions(&self) -> bool {
        self.transmissions.iter().any(Option::is_some)
    }

    /// Effort that joint `joint` needs on top of the rigid body at a state, without dry friction,
    /// memory and added inertia \[N m or N\].
    pub fn smooth_effort(&self, joint: usize, time_s: f64, position: f64, velocity: f64) -> f64 {
        let state = self.joint_state(joint, time_s, position, velocity, 0.0);
        self.effects[joint].iter().map(|e| e.effect.smooth_effort(&e.parameters, &state)).sum()
    }

    /// Dry friction of joint `joint` at a speed while the gear carries `load` \[N m or N\].
    pub fn dry_friction(&self, joint: usize, velocity: f64, load: f64) -> DryFriction {
        let state = self.joint_state(joint, 0.0, 0.0, velocity, load);
        let each = self.effects[joint].iter();
        each.map(|e| e.effect.dry_friction(&e.parameters, &state))
            .fold(DryFriction::default(), DryFriction::plus)
    }

    /// Inertia that the effects add to the diagonal of `H` at joint `joint` \[kg m2 or kg\].
    pub fn added_inertia(&self, joint: usize) -> f64 {
        self.effects[joint].iter().map(|e| e.effect.added_inertia(&e.parameters)).sum()
    }

    /// Whether some friction is set-valued at rest.
    pub fn has_dry_friction(&self) -> bool {
        let rubs = |joint| {
            !self.dry_friction(joint, 0.0, 0.0).is_none()
                || !self.dry_friction(joint, 1.0, 1.0).is_none()
        };
        (0..self.dof()).any(rubs) || self.pairs.iter().any(|pair| pair.coulomb > 0.0)
    }

    pub(crate) fn joint_state(
        &self,
        joint: usize,
        time_s: f64,
        position: f64,
        velocity: f64,
        load: f64,
    ) -> JointState {
        let kind = self.rigid.joints[joint].kind;
        let temperature_c = self.temperatures.as_ref().and_then(|of| of.at(joint, time_s));
        JointState { kind, time_s, position, velocity, load, temperature_c }
    }

    pub(crate) fn pairs(&self) -> &[PairFriction] {
        &self.pairs
    }

    /// Effects with a deflection: joint and law.
    pub(crate) fn deflections(&self) -> impl Iterator<Item = (usize, &EffectWithParameters)> {
        self.deflections.iter().map(|&(joint, k)| (joint, &self.effects[joint][k]))
    }

    /// `-Jᵀ F`: what the motors supply against the contacts, if there is one now.
    pub(crate) fn contact_effort(&self, time_s: f64, position: &[f64]) -> Option<Vec<f64>> {
        let frames = self.frames.as_ref()?;
        let mut force = Vector3::zeros();
        for contact in &self.tip_forces {
            force += contact.force_base_n * contact.window_s.map_or(1.0, |w| ramp(w, time_s));
        }
        if force == Vector3::zeros() {
            return None;
        }
        let columns = armident_effects::tip_jacobian(
            &self.rigid,
            &frames.base_from_e0,
            &frames.tip_in_last_m,
            position,
        );
        Some(columns.iter().map(|column| -column.dot(&force)).collect())
    }

    /// What the effort channels show of the true efforts, in place; joint-major.
    pub(crate) fn to_recorded(&self, time_s: &[f64], effort: &mut [Vec<f64>]) {
        for (effort, gain) in effort.iter_mut().zip(&self.effort_gains) {
            effort.iter_mut().for_each(|value| *value *= gain);
        }
        if self.effort_delay_s != 0.0 {
            shift(time_s, effort, -self.effort_delay_s);
        }
    }

    /// The true efforts behind what the effort channels show, in place; joint-major.
    pub(crate) fn to_true(&self, time_s: &[f64], effort: &mut [Vec<f64>]) {
        for (effort, gain) in effort.iter_mut().zip(&self.effort_gains) {
            effort.iter_mut().for_each(|value| *value /= gain);
        }
        if self.effort_delay_s != 0.0 {
            shift(time_s, effort, self.effort_delay_s);
        }
    }
}

/// Share of a contact force: ramps at the start and the end of the window, one between.
fn ramp([start, end]: [f64; 2], time_s: f64) -> f64 {
    let rise = ((time_s - start) / CONTACT_RAMP_S).clamp(0.0, 1.0);
    let fall = ((end - time_s) / CONTACT_RAMP_S).clamp(0.0, 1.0);
    rise.min(fall)
}

/// Columns at `t + by_s` instead of `t`, on lines between the samples; the ends go on.
fn shift(time_s: &[f64], columns: &mut [Vec<f64>], by_s: f64) {
    for column in columns {
        let samples = column.clone();
        for (value, t) in column.iter_mut().zip(time_s) {
            *value = crate::lines::at(time_s, &samples, t + by_s);
        }
    }
}
