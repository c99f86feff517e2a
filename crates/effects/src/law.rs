//! Metadata of a law: everything about an effect that is not computed.

use armident_kinematics::JointKind;

use crate::catalogue::Catalogue;

/// Slug of unmodelled dynamics: structure of the residual that no law explains.
pub const UNMODELLED: &str = "unmodelled";

/// The sign a parameter may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Admissible {
    /// Any finite number.
    Any,
    /// Zero or more: a fit of the other sign is not admitted.
    NonNegative,
}

impl Admissible {
    /// Whether a value is admissible.
    pub fn allows(self, value: f64) -> bool {
        value.is_finite() && (self == Self::Any || value >= 0.0)
    }
}

/// One parameter of a law.
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
    /// Whether it is one of those by which an estimate of the effect is judged.
    pub is_main: bool,
    /// Value at which the effect has no effort, where that is one: 1 of a gain, else 0.
    pub neutral: f64,
}

impl Parameter {
    /// A parameter of any sign.
    pub const fn any(
        name: &'static str,
        rotational: &'static str,
        translational: &'static str,
    ) -> Self {
        Self {
            name,
            unit_rotational: rotational,
            unit_translational: translational,
            admissible: Admissible::Any,
            is_main: false,
            neutral: 0.0,
        }
    }

    /// A parameter that is zero or more.
    pub const fn non_negative(
        name: &'static str,
        rotational: &'static str,
        translational: &'static str,
    ) -> Self {
        Self { admissible: Admissible::NonNegative, ..Self::any(name, rotational, translational) }
    }

    /// The same parameter, by whose error an estimate is judged.
    #[must_use]
    pub const fn main(self) -> Self {
        Self { is_main: true, ..self }
    }

    /// The same parameter with another neutral value.
    #[must_use]
    pub const fn neutral(self, neutral: f64) -> Self {
        Self { neutral, ..self }
    }

    /// Unit on a joint of this kind.
    pub fn unit(&self, kind: JointKind) -> &'static str {
        if kind.is_rotational() { self.unit_rotational } else { self.unit_translational }
    }
}

/// Look-alike effect and the motion that distinguishes the two.
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
    pub const NONE: Self = Self { urdf: None, mjcf: None };
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

/// What a finding of a law gives as its location.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LocationKind {
    /// Its joint, or its two neighbours.
    Joints,
    /// The link, with the joint that moves it.
    Link,
    /// The tip link, without a joint.
    TipLink,
    /// All joints.
    AllJoints,
    /// No joint: the whole arm.
    Arm,
}

/// LawRole of a law; two laws with the same role on one joint are mutually exclusive, because one contains or
/// replaces the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LawRole {
    /// Friction proportional to the speed.
    Viscous,
    /// Dry friction.
    Dry,
    /// Friction of another power of the speed.
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
    /// What gives the effort of the motor.
    Drive,
    /// Unmodelled dynamics.
    Unnamed,
}

/// How often an effect comes about between two recordings of one arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Onset {
    /// Bodies are picked up, arms are remounted and homed again, joints wear and warm up.
    Often,
    /// Often of the last link, whose tool is exchanged; seldom of others.
    OftenOfLastLink,
    /// Built in, or a fault of the channel.
    Seldom,
}

/// Whether a diagnosis may report a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Naming {
    /// Reported as a finding, and hidden in cases.
    Named,
    /// Only fitted beside others, so that predictions are better: it describes a dependence and no cause.
    PredictionOnly,
    /// Fitted by `identify` where commands and no efforts are recorded.
    FromCommands,
    /// Found by the input checks beside any inertias of the links, and corrected before the others are sought; where it cannot be
    /// distinguished from a law that is reported, an alternative of that.
    FromChecks,
}

/// Baseline terms: the laws of a plain identification, which every joint has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Baseline {
    /// Viscous friction.
    Viscous,
    /// Coulomb friction.
    Coulomb,
    /// Constant offset of the effort channel.
    Offset,
    /// Inertia of the rotor.
    RotorInertia,
}

impl Baseline {
    /// Whether it is friction.
    pub fn is_friction(self) -> bool {
        matches!(self, Self::Viscous | Self::Coulomb)
    }
}

/// A quantity about which columns are linearised, and which a law changes: its columns are those of a small change, so a
/// fit moves the quantity and forms all columns again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OperatingTerm {
    /// Direction of gravity: two coefficients are added to the tilt \[rad\].
    Tilt,
    /// Delay of the efforts: the coefficient is added to it \[s\].
    Delay,
    /// Zero of the joint's encoder: the coefficient is added to it \[rad or m\].
    EncoderZero,
    /// Gain of the joint's effort channel: the coefficient is what it has beyond 1.
    Gain,
}

/// How an estimator finds the shape of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scan {
    /// Columns for each of its [`shapes`](crate::Effect::shapes).
    Columns,
    /// A scan of the residual: orders of a ripple, windows of a contact.
    Residual,
    /// A simulation of the motion behind a transmission.
    Simulated(LinkSide),
}

/// What lies between the motor of a joint and its link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinkSide {
    /// A spring with a damper.
    Spring,
    /// Play between stiff flanks.
    Play,
}

/// Where a set of other laws is the same effort as a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Where {
    /// On every joint.
    AnyJoint,
    /// On the first joint.
    FirstJoint,
    /// On the last joint, or on the link it moves.
    LastJoint,
}

/// Other laws on the same joint or link that together are the same effort.
#[derive(Debug, Clone, Copy)]
pub struct Equivalent {
    /// Their slugs.
    pub laws: &'static [&'static str],
    /// Where they are the same effort.
    pub on: Where,
}

/// Everything about an effect that is not computed. A law states what differs from [`Law::BLANK`].
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
    /// What a finding gives as its location.
    pub location: LocationKind,
    /// Its roles on its joint.
    pub roles: &'static [LawRole],
    /// Parameters in the order of every parameter vector.
    pub parameters: &'static [Parameter],
    /// Whether a diagnosis may report it.
    pub naming: Naming,
    /// Which of the baseline terms it is, if it is one.
    pub baseline: Option<Baseline>,
    /// What it changes of the operating point, if its columns are those of a small change.
    pub operating: Option<OperatingTerm>,
    /// How an estimator finds its shape.
    pub scan: Scan,
    /// Whether its columns follow the load that its joint carries, so that they depend on the links behind it.
    pub follows_load: bool,
    /// Whether it is dry friction whose level varies with the speed.
    pub varies_with_speed: bool,
    /// Whether it follows the temperature of the drive, so that it shows only where that is recorded.
    pub follows_temperature: bool,
    /// The simpler laws on its joints that this one contains: it is reported only where it is better than these.
    pub contains: &'static [&'static str],
    /// Laws beyond [`contains`](Self::contains) that a right diagnosis may report beside it.
    pub companions: &'static [&'static str],
    /// Sets of other laws that are the same effort, whatever the motion.
    pub equivalents: &'static [Equivalent],
    /// Whether its [`arm_columns`](crate::Effect::arm_columns) alone are its effort to first order, and no other law's:
    /// then a least-squares fit of them shows whether it passes for another law on given motions.
    pub fits_alone: bool,
    /// Its look-alikes.
    pub look_alikes: &'static [LookAlike],
    /// What simulator formats hold of it.
    pub export: Export,
    /// Its page in the catalogue of effects.
    pub catalogue: Option<&'static Catalogue>,
}

impl Law {
    /// A law of one joint that states nothing.
    pub const BLANK: Self = Self {
        slug: "",
        title: "",
        formula: "",
        scope: Scope::Joint,
        location: LocationKind::Joints,
        roles: &[],
        parameters: &[],
        naming: Naming::Named,
        baseline: None,
        operating: None,
        scan: Scan::Columns,
        follows_load: false,
        varies_with_speed: false,
        follows_temperature: false,
        contains: &[],
        companions: &[],
        equivalents: &[],
        fits_alone: false,
        look_alikes: &[],
        export: Export::NONE,
        catalogue: None,
    };

    /// Whether it has a role.
    pub fn has_role(&self, role: LawRole) -> bool {
        self.roles.contains(&role)
    }

    /// Whether it is dry friction on one joint.
    pub fn is_dry_friction(&self) -> bool {
        self.has_role(LawRole::Dry)
    }

    /// Whether it is viscous or Coulomb friction, which every joint has.
    pub fn is_baseline_friction(&self) -> bool {
        self.baseline.is_some_and(Baseline::is_friction)
    }

    /// Whether it contains another law.
    pub fn contains_law(&self, other: &Law) -> bool {
        self.contains.contains(&other.slug)
    }

    /// Whether a right diagnosis may report another law beside this one.
    pub fn tolerates(&self, slug: &str) -> bool {
        self.tolerated().any(|other| other == slug)
    }

    /// Laws that a right diagnosis may report beside this one: those it contains, then its companions.
    pub fn tolerated(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.contains.iter().chain(self.companions).copied()
    }

    /// Its look-alike of this slug.
    pub fn look_alike(&self, slug: &str) -> Option<&'static LookAlike> {
        self.look_alikes.iter().find(|other| other.slug == slug)
    }

    /// The motion that separates it from another law, by the look-alikes of either.
    pub fn separated_from(&self, other: &Self) -> Option<&'static str> {
        let found = self.look_alike(other.slug).or_else(|| other.look_alike(self.slug));
        found.map(|look_alike| look_alike.separated_by)
    }

    /// Whether it is the transmission of a joint with something of this kind between motor and link.
    pub fn has_link_side(&self, side: LinkSide) -> bool {
        self.link_side() == Some(side)
    }

    /// What lies between motor and link, for laws of a transmission that an estimator must simulate.
    pub fn link_side(&self) -> Option<LinkSide> {
        match self.scan {
            Scan::Simulated(side) => Some(side),
            Scan::Columns | Scan::Residual => None,
        }
    }
}
