//! What can be wrong with a simulation, where, and what to do about it.

use armident_effects::UnknownEffect;
use armident_recording::RecordingError;

/// Why an effect is refused by an arm that is given without its URDF.
pub(crate) const NEEDS_FRAMES: &str = "it is given in frames of the URDF, and the arm has none";

/// A simulation that cannot be set up or carried out: what is wrong (`Display`), the
/// [`place`](Self::place), and a [`hint`](Self::hint).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// Names and joints of the arm are not one to one.
    #[error("the arm has {joints} joints; different names given: {names}")]
    JointNames {
        /// Joints of the arm.
        joints: usize,
        /// Different names.
        names: usize,
    },
    /// An effect is put on a joint that the arm does not have.
    #[error("effect `{effect}` is put on joint `{joint}`, which the arm does not have")]
    UnknownJoint {
        /// Slug of the effect.
        effect: String,
        /// The joint asked for.
        joint: String,
        /// Joints of the arm.
        known: Vec<String>,
    },
    /// The library has no such effect, or it takes other parameters.
    #[error("{error}")]
    UnknownEffect {
        /// What the library says.
        error: UnknownEffect,
        /// The joint that the effect is put on.
        joint: String,
    },
    /// A parameter of an effect is not a number or has the wrong sign.
    #[error("parameter `{parameter}` of effect `{effect}` on joint `{joint}` is {value} {unit}")]
    Parameter {
        /// Slug of the effect.
        effect: &'static str,
        /// The joint.
        joint: String,
        /// Name of the parameter.
        parameter: &'static str,
        /// The value given.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// An effect that no simulation can take into account as it is given.
    #[error("effect `{effect}` on joint `{joint}` cannot be simulated: {reason}")]
    NotSimulated {
        /// Slug of the effect.
        effect: &'static str,
        /// The joint.
        joint: String,
        /// Why not.
        reason: &'static str,
    },
    /// A channel that the simulation needs is not recorded.
    #[error("the {quantity} of joint `{joint}` is not given")]
    MissingChannel {
        /// The joint.
        joint: String,
        /// `position` or `effort`.
        quantity: &'static str,
        /// Joints whose channel is there.
        given: Vec<String>,
        /// Where it was looked for.
        source_name: String,
    },
    /// A joint is held that cannot be held, or nowhere.
    #[error("joint `{joint}` cannot be held at {position}: {reason}")]
    Held {
        /// The joint.
        joint: String,
        /// The position given \[rad or m\].
        position: f64,
        /// Why not.
        reason: &'static str,
        /// Joints of the arm.
        known: Vec<String>,
    },
    /// A trajectory or recording is of other joints than the arm's.
    #[error("the joints of {what} are not those of the arm")]
    OtherJoints {
        /// `the trajectory`, ...
        what: &'static str,
        /// Joints found.
        found: Vec<String>,
        /// Joints of the arm.
        known: Vec<String>,
    },
    /// A vector does not have one finite number per joint.
    #[error("{what} must be {expected} finite numbers, found {found:?}")]
    State {
        /// `the start position`, ...
        what: &'static str,
        /// Joints of the arm.
        expected: usize,
        /// What was given.
        found: Vec<f64>,
    },
    /// A setting is out of its range.
    #[error("{setting} is {value}; it must be {range}")]
    Setting {
        /// The setting with its unit.
        setting: &'static str,
        /// What was given.
        value: f64,
        /// What is possible.
        range: String,
    },
    /// A motion so fast that its efforts exceed the range of floating-point numbers.
    #[error("the effort of joint `{joint}` is not a finite number at t = {time_s:.4} s")]
    Overflow {
        /// The joint.
        joint: String,
        /// Time \[s\].
        time_s: f64,
    },
    /// The efforts do not determine the accelerations.
    #[error(
        "the inertia matrix is not positive definite at t = {time_s:.4} s, q = {q:?}: the inertial \
         parameters are unphysical or some joint moves no mass"
    )]
    NotPositiveDefinite {
        /// Time \[s\].
        time_s: f64,
        /// Joint positions \[rad or m\].
        q: Vec<f64>,
    },
    /// The motion runs away.
    #[error("the motion diverges: joint `{joint}` has the speed {speed:.3e} at t = {time_s:.4} s")]
    Diverged {
        /// The fastest joint.
        joint: String,
        /// Time \[s\].
        time_s: f64,
        /// Speed there \[rad/s or m/s\].
        speed: f64,
    },
    /// A recording that goes in or comes out is inconsistent.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

impl SimulationError {
    /// Where: the effect, joint, file or setting, as far as known.
    pub fn place(&self) -> String {
        match self {
            Self::JointNames { .. } => "joint names".to_owned(),
            Self::UnknownJoint { effect, .. } => format!("effect `{effect}`"),
            Self::UnknownEffect { joint, .. } => format!("effects on joint `{joint}`"),
            Self::Parameter { effect, joint, .. } | Self::NotSimulated { effect, joint, .. } => {
                format!("effect `{effect}` on joint `{joint}`")
            }
            Self::MissingChannel { source_name, .. } => source_name.clone(),
            Self::Held { joint, .. } => format!("held joint `{joint}`"),
            Self::OtherJoints { what, .. } | Self::State { what, .. } => (*what).to_owned(),
            Self::Setting { .. } => "simulation settings".to_owned(),
            Self::Overflow { time_s, .. }
            | Self::NotPositiveDefinite { time_s, .. }
            | Self::Diverged { time_s, .. } => format!("simulation, t = {time_s:.4} s"),
            Self::Recording(error) => error.place(),
        }
    }

    /// What to do about it, where there is something to say beyond the fault itself.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::JointNames { .. } => {
                Some("give every joint of the chain one name, from base to tip".to_owned())
            }
            Self::UnknownJoint { joint, known, .. } => Some(suggested(joint, known)),
            Self::UnknownEffect { .. } | Self::Setting { .. } | Self::State { .. } => None,
            Self::Parameter { value, .. } if value.is_finite() => {
                Some("give zero or a positive number".to_owned())
            }
            Self::Parameter { .. } => Some("give a finite number".to_owned()),
            Self::NotSimulated { reason, .. } if *reason == NEEDS_FRAMES => Some(
                "simulate a model or a URDF: `SimulatedArm::on_chain` knows the frames".to_owned(),
            ),
            Self::NotSimulated { .. } => None,
            Self::MissingChannel { joint, quantity, given, .. } => {
                let instead = match *quantity {
                    "position" => ", or hold the joint at a constant position",
                    _ => "",
                };
                Some(format!(
                    "add a column `{joint}/{quantity}`{instead}; given are those of {}",
                    listed(given)
                ))
            }
            Self::Held { joint, known, .. } if !known.contains(joint) => {
                Some(suggested(joint, known))
            }
            Self::Held { .. } => Some(
                "hold joints of the chain that are not recorded, at finite positions".to_owned(),
            ),
            Self::OtherJoints { found, known, .. } => {
                Some(format!("found {}; the arm has {}", listed(found), listed(known)))
            }
            Self::Overflow { .. } => {
                Some("check position, velocity and acceleration of all joints there".to_owned())
            }
            Self::NotPositiveDefinite { .. } => Some(
                "give every link a mass and a physical inertia, or the joint a rotor inertia"
                    .to_owned(),
            ),
            Self::Diverged { .. } => Some(
                "choose a smaller step, and check that the efforts belong to this arm and start"
                    .to_owned(),
            ),
            Self::Recording(error) => error.hint(),
        }
    }
}

fn suggested(name: &str, known: &[String]) -> String {
    match armident_kinematics::nearest(name, known) {
        Some(nearest) => format!("did you mean `{nearest}`? the joints are {}", listed(known)),
        None => format!("the joints are {}", listed(known)),
    }
}

/// Names in backquotes.
fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "no joint".to_owned();
    }
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}
