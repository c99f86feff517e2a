//! What the catalogue of effects in the book shows of a law beside its metadata.

/// The page of a law in the catalogue of effects.
#[derive(Debug, Clone, Copy)]
pub struct Catalogue {
    /// What it is, in a sentence or two.
    pub about: &'static str,
    /// Published sizes, each with its source; motor-side numbers brought to the joint by the gear ratio of the source.
    pub sizes: &'static [&'static str],
    /// What shows it.
    pub signature: &'static str,
    /// The example of its picture.
    pub example: Example,
}

/// An effect on the bundled UR5.
#[derive(Debug, Clone, Copy)]
pub struct Example {
    /// Joint; empty for effects of the whole arm and of the last link.
    pub joint: &'static str,
    /// The second of two neighbours.
    pub other_joint: Option<&'static str>,
    /// Parameters in the order of the law.
    pub parameters: &'static [f64],
    /// Start and end of a contact \[s\].
    pub window_s: Option<[f64; 2]>,
    /// What its effort is drawn against.
    pub against: Against,
}

impl Example {
    /// An effect on one joint or the whole arm.
    pub const fn new(joint: &'static str, parameters: &'static [f64], against: Against) -> Self {
        Self { joint, other_joint: None, parameters, window_s: None, against }
    }
}

/// Variable of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Against {
    /// Velocity of the joint.
    Speed,
    /// Position of the joint.
    Position,
    /// Acceleration of the joint.
    Acceleration,
    /// Effort of the rigid body at the joint.
    Load,
    /// Time.
    Time,
}
