//! What is written once about every effect.

use armident_dynamics::RigidArm;
use armident_kinematics::JointKind;
use nalgebra::{Isometry3, Vector3};

/// The sign a parameter may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Admissible {
    /// Any finite number.
    Any,
    /// Zero or more: a fit of the other sign refuses the effect's name.
    NonNegative,
}

impl Admissible {
    /// Whether a value is admissible.
    pub fn allows(self, value: f64) -> bool {
        value.is_finite() && (self == Self::Any || value >= 0.0)
    }
}

/// One number of a law.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name in files and tables.
    pub name: &'static str,
    /// Unit on a rotational joint.
    pub unit_rotational: &'static str,
    /// Unit on a translational joint.
    pub unit_translational: &'static str,
    /// Admissible sign.
    pub admissible: Admissible,
}

impl Parameter {
    /// A parameter of any sign.
    pub(crate) const fn any(
        name: &'static str,
        rotational: &'static str,
        translational: &'static str,
    ) -> Self {
        Self {
            name,
            unit_rotational: rotational,
            unit_translational: translational,
            admissible: Admissible::Any,
        }
    }

    /// A parameter that is zero or more.
    pub(crate) const fn non_negative(
        name: &'static str,
        rotational: &'static str,
        translational: &'static str,
    ) -> Self {
        Self {
            name,
            unit_rotational: rotational,
            unit_translational: translational,
            admissible: Admissible::NonNegative,
        }
    }

    /// Unit on a joint of this kind.
    pub fn unit(&self, kind: JointKind) -> &'static str {
        if kind.is_rotational() { self.unit_rotational } else { self.unit_translational }
    }
}

/// Another effect that can look the same, and the motion that tells them apart.
#[derive(Debug, Clone, Copy)]
pub struct LookAlike {
    /// Slug of the other effect, or a name of a rigid-body constant.
    pub slug: &'static str,
    /// The motion that separates the two.
    pub separated_by: &'static str,
}

/// How an effect is written into simulator formats.
#[derive(Debug, Clone, Copy)]
pub struct Export {
    /// Attribute of URDF's `<dynamics>`, if it can hold the effect.
    pub urdf: Option<&'static str>,
    /// Attribute of MJCF's `<joint>`, if it can hold the effect.
    pub mjcf: Option<&'static str>,
}

impl Export {
    /// Neither format holds the effect.
    pub(crate) const NONE: Self = Self { urdf: None, mjcf: None };
}

/// What a law acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// The effort of one joint, from the motion of that joint.
    Joint,
    /// Two neighbouring joints with a common transmission.
    Neighbours,
    /// One joint, felt by all: transmissions and encoders.
    ThroughJoint,
    /// One link.
    Link,
    /// The whole arm.
    Arm,
}

/// Where a law stands among the others on its joint: two laws of one place exclude each other, because
/// one contains or replaces the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// Friction proportional to the speed.
    Viscous,
    /// Friction that has a direction.
    Dry,
    /// Friction of a higher power of the speed.
    Drag,
    /// Constant or proportional to the position.
    Constant,
    /// Rotor and transmission.
    Inertia,
    /// Gain of the effort channel.
    Gain,
    /// Zero of the encoder.
    Zero,
    /// Periodic in the position.
    Ripple,
    /// A transmission shared with a neighbour.
    Shared,
    /// Inertia of the link.
    Link,
    /// Direction of gravity.
    Gravity,
    /// Clock.
    Time,
    /// Forces of the surroundings.
    Contact,
    /// Structure without a law.
    Unnamed,
}

/// How often an effect comes about between two recordings of one arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Onset {
    /// Bodies are picked up, arms are remounted and homed again, joints wear and warm up.
    Often,
    /// Often of the last link, whose tool is exchanged; seldom of others, which nobody opens.
    OftenOfLastLink,
    /// Built in, or a fault of the channel.
    Seldom,
}

/// Everything about an effect that is not computed.
#[derive(Debug, Clone, Copy)]
pub struct Law {
    /// Name in files.
    pub slug: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// `f`, the effort the motor supplies on top of the rigid body, as a formula.
    pub formula: &'static str,
    /// What it acts on.
    pub scope: Scope,
    /// The places it takes on its joint.
    pub places: &'static [Place],
    /// Parameters in the order of every parameter vector.
    pub parameters: &'static [Parameter],
    /// The simpler laws on its joints that this one contains: what the name must beat.
    pub contains: &'static [&'static str],
    /// What it can be confused with.
    pub look_alikes: &'static [LookAlike],
    /// What simulator formats hold of it.
    pub export: Export,
}

/// Motion of one joint over a recording: what columns are formed from. All slices have one length.
#[derive(Debug, Clone, Copy)]
pub struct JointMotion<'a> {
    /// Rotation or translation.
    pub kind: JointKind,
    /// Time since the start of the recording \[s\].
    pub time_s: &'a [f64],
    /// Position \[rad or m\].
    pub position: &'a [f64],
    /// Velocity \[rad/s or m/s\].
    pub velocity: &'a [f64],
    /// Acceleration \[rad/s2 or m/s2\].
    pub acceleration: &'a [f64],
    /// Direction of motion, -1 to 1: the sign of the velocity where it is resolved; what it is
    /// between is the maker's choice ([`directions`](crate::directions)).
    pub direction: &'a [f64],
    /// Effort of the rigid body at this joint \[N m or N\]; empty where no law needs it.
    pub rigid_effort: &'a [f64],
}

/// Size of a joint's motion, from which constants to try are scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionScale {
    /// Rotation or translation.
    pub kind: JointKind,
    /// Root mean square speed \[rad/s or m/s\].
    pub speed_rms: f64,
    /// Standard deviation of the position \[rad or m\].
    pub position_deviation: f64,
    /// Length of the longest recording \[s\].
    pub duration_s: f64,
}

/// Motion of the whole arm over a recording, joint-major.
#[derive(Debug, Clone, Copy)]
pub struct ArmMotion<'a> {
    /// The arm.
    pub arm: &'a RigidArm,
    /// Pose of the frame `E_0` in the base link.
    pub base_from_e0: Isometry3<f64>,
    /// Origin of the tip link in the frame of the last joint \[m\].
    pub tip_in_last_m: Vector3<f64>,
    /// Samples per second.
    pub rate_hz: f64,
    /// Positions \[rad or m\].
    pub position: &'a [Vec<f64>],
    /// Velocities \[rad/s or m/s\].
    pub velocity: &'a [Vec<f64>],
    /// Accelerations \[rad/s2 or m/s2\].
    pub acceleration: &'a [Vec<f64>],
    /// Effort of the rigid body for this motion \[N m or N\].
    pub rigid_effort: &'a [Vec<f64>],
}

/// State of one joint at an instant of a simulation.
#[derive(Debug, Clone, Copy)]
pub struct JointState {
    /// Rotation or translation.
    pub kind: JointKind,
    /// Time since the start of the recording \[s\].
    pub time_s: f64,
    /// Position \[rad or m\].
    pub position: f64,
    /// Velocity \[rad/s or m/s\].
    pub velocity: f64,
    /// Effort that the gear carries, that of the rigid body at this joint \[N m or N\].
    pub load: f64,
}

/// Levels of dry friction; at rest the effort is anything between `-backward` and `forward`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DryFriction {
    /// Effort it takes to move forward \[N m or N\].
    pub forward: f64,
    /// Effort it takes to move backward \[N m or N\], positive.
    pub backward: f64,
}

impl DryFriction {
    /// The same level in both directions.
    pub fn both(level: f64) -> Self {
        Self { forward: level, backward: level }
    }

    /// One beside the other.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { forward: self.forward + other.forward, backward: self.backward + other.backward }
    }

    /// The effort while moving at this velocity; zero at rest.
    pub fn effort(self, velocity: f64) -> f64 {
        if velocity > 0.0 {
            self.forward
        } else if velocity < 0.0 {
            -self.backward
        } else {
            0.0
        }
    }

    /// Whether there is none.
    pub fn is_none(self) -> bool {
        self.forward == 0.0 && self.backward == 0.0
    }
}

/// Columns of the whole arm: `[column][joint][sample]`.
pub type ArmColumns = Vec<Vec<Vec<f64>>>;

/// One physical effect.
///
/// Sign convention: `effort = rigid(q, q̇, q̈) + f`, `f` is what the motor has to supply on top.
///
/// A law is linear in its *coefficients* once its *shape* (the constants it is not linear in) is
/// given: columns are formed for a shape, and shape and coefficients together are the parameters.
pub trait Effect: Sync {
    /// What is written once.
    fn law(&self) -> &'static Law;

    /// Estimator: whether the column of a coefficient jumps between two samples, at a reversal. All do of a law
    /// of dry friction or of a shared transmission, unless it says otherwise.
    fn coefficient_jumps(&self, _coefficient: usize) -> bool {
        let places = self.law().places;
        places.contains(&Place::Dry) || places.contains(&Place::Shared)
    }

    /// Whether it comes about between two recordings of one arm; by default seldom.
    fn onset(&self) -> Onset {
        Onset::Seldom
    }

    /// Estimator: shapes to try on a motion of this size; one empty shape for a linear law.
    fn shapes(&self, _scale: &MotionScale) -> Vec<Vec<f64>> {
        vec![Vec::new()]
    }

    /// Estimator, [`Scope::Joint`]: columns whose combination with the coefficients is `f`.
    fn columns(&self, _shape: &[f64], _motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Estimator, [`Scope::Neighbours`]: columns on joints a and b.
    fn pair_columns(
        &self,
        _shape: &[f64],
        _a: &JointMotion<'_>,
        _b: &JointMotion<'_>,
    ) -> Vec<[Vec<f64>; 2]> {
        Vec::new()
    }

    /// Estimator, the other scopes: columns on all joints; `joint` is the joint or the link it moves.
    fn arm_columns(&self, _joint: usize, _motion: &ArmMotion<'_>) -> ArmColumns {
        Vec::new()
    }

    /// Which of its columns is the one of the law that it contains.
    fn contained_column(&self) -> usize {
        0
    }

    /// Parameters from a shape and the coefficients of its columns.
    fn parameters(&self, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        [coefficients, shape].concat()
    }

    /// Shape and coefficients from the parameters.
    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (Vec::new(), parameters.to_vec())
    }

    /// Whether these parameters may carry the name; by default each by its own sign.
    fn admits(&self, parameters: &[f64]) -> bool {
        let each = self.law().parameters.iter().zip(parameters);
        each.into_iter().all(|(parameter, &value)| parameter.admissible.allows(value))
    }

    /// `f` over a motion, [`Scope::Joint`].
    fn effort(&self, parameters: &[f64], motion: &JointMotion<'_>) -> Vec<f64> {
        let (shape, coefficients) = self.shape_and_coefficients(parameters);
        let mut effort = vec![0.0; motion.velocity.len()];
        for (column, coefficient) in self.columns(&shape, motion).iter().zip(&coefficients) {
            for (effort, x) in effort.iter_mut().zip(column) {
                *effort += coefficient * x;
            }
        }
        effort
    }

    /// Simulator: where the effect acts.
    fn mechanism(&self, _parameters: &[f64]) -> crate::Mechanism {
        crate::Mechanism::Joint
    }

    /// Simulator: the part of `f` that is a smooth function of time, position and velocity.
    fn smooth_effort(&self, _parameters: &[f64], _state: &JointState) -> f64 {
        0.0
    }

    /// Simulator: dry friction at the speed and load of a state.
    fn dry_friction(&self, _parameters: &[f64], _state: &JointState) -> DryFriction {
        DryFriction::default()
    }

    /// Simulator: whether the effect remembers the travel as a deflection.
    fn has_deflection(&self) -> bool {
        false
    }

    /// Simulator: the deflection after a one-way travel of the joint \[rad or m\].
    fn deflection_after(&self, _parameters: &[f64], deflection: f64, _travel: f64) -> f64 {
        deflection
    }

    /// Simulator: the part of `f` that the deflection makes.
    fn deflection_effort(&self, _parameters: &[f64], _deflection: f64, _velocity: f64) -> f64 {
        0.0
    }

    /// Simulator, [`Mechanism::Arm`](crate::Mechanism::Arm): makes the believed arm the true one;
    /// `joint` is the joint or the link it moves.
    fn change_arm(
        &self,
        _parameters: &[f64],
        _joint: usize,
        _frames: &crate::ArmFrames,
        _arm: &mut RigidArm,
    ) {
    }

    /// Simulator: inertia added to the diagonal of `H` \[kg m2 or kg\].
    fn added_inertia(&self, _parameters: &[f64]) -> f64 {
        0.0
    }
}

/// One column formed sample by sample.
pub(crate) fn column(samples: usize, f: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..samples).map(f).collect()
}
