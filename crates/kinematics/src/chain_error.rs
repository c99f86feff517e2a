//! Errors of the chain selection.

/// The robot has no usable serial chain for the given selection.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum ChainError {
    /// `--base` or `--tip` names no link.
    #[error("--{option}: unknown link `{name}`")]
    UnknownLink {
        /// `base` or `tip`.
        option: &'static str,
        /// The name given.
        name: String,
        /// Links of the robot.
        links: Vec<String>,
        /// File of the robot.
        source_name: String,
    },
    /// `--lock` names no joint.
    #[error("--{option}: unknown joint `{name}`")]
    UnknownJoint {
        /// `lock`.
        option: &'static str,
        /// The name given.
        name: String,
        /// Joints of the robot.
        joints: Vec<String>,
        /// File of the robot.
        source_name: String,
    },
    /// A fixed joint was to be locked.
    #[error("joint `{joint}` is fixed and cannot be locked")]
    LockedJointCannotMove {
        /// The joint.
        joint: String,
        /// File of the robot.
        source_name: String,
    },
    /// A lock position is NaN or infinite.
    #[error("the lock position of joint `{joint}` is not a finite number")]
    LockNotFinite {
        /// The joint.
        joint: String,
    },
    /// Gravity is NaN or infinite.
    #[error("gravity must be three finite numbers [m/s2], found {found:?}")]
    GravityNotFinite {
        /// What was given.
        found: [f64; 3],
    },
    /// The tip is on another branch than the base.
    #[error("tip link `{tip}` is not a descendant of base link `{base}`")]
    TipNotBelowBase {
        /// Base link.
        base: String,
        /// Tip link.
        tip: String,
        /// File of the robot.
        source_name: String,
    },
    /// A joint with more than one degree of freedom is on the path.
    #[error(
        "joint `{joint}` is {joint_type}; only revolute, continuous and prismatic joints can be on the chain"
    )]
    JointTypeOnPath {
        /// The joint.
        joint: String,
        /// `floating` or `planar`.
        joint_type: &'static str,
        /// Line in the file.
        line: u32,
        /// File of the robot.
        source_name: String,
    },
    /// No movable joint is left on the path.
    #[error("no movable joint between base link `{base}` and tip link `{tip}`")]
    NothingMoves {
        /// Base link.
        base: String,
        /// Tip link.
        tip: String,
        /// File of the robot.
        source_name: String,
    },
    /// A recording names none of the robot's joints.
    #[error("none of the recorded joints ({}) is a movable joint of the robot", recorded.join(", "))]
    NoRecordedJointInRobot {
        /// Names in the recording.
        recorded: Vec<String>,
        /// Movable joints of the robot.
        movable: Vec<String>,
        /// File of the robot.
        source_name: String,
    },
    /// The recorded joints belong to several arms.
    #[error("recorded joints are on different branches: {}; {}", together.join(", "), apart.join(", "))]
    RecordedJointsOnSeveralPaths {
        /// Joints on the best path.
        together: Vec<String>,
        /// Joints on other paths.
        apart: Vec<String>,
        /// File of the robot.
        source_name: String,
    },
}

impl ChainError {
    /// Place of the fault: the file, and the joint's line if it is known.
    pub fn place(&self) -> String {
        match self {
            Self::UnknownLink { source_name, .. }
            | Self::UnknownJoint { source_name, .. }
            | Self::LockedJointCannotMove { source_name, .. }
            | Self::TipNotBelowBase { source_name, .. }
            | Self::NothingMoves { source_name, .. }
            | Self::NoRecordedJointInRobot { source_name, .. }
            | Self::RecordedJointsOnSeveralPaths { source_name, .. } => source_name.clone(),
            Self::JointTypeOnPath { source_name, line, .. } => {
                format!("{source_name}, line {line}")
            }
            Self::LockNotFinite { .. } => "--lock".to_owned(),
            Self::GravityNotFinite { .. } => "--gravity".to_owned(),
        }
    }

    /// Hint for the user.
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::UnknownLink { name, links, .. } => suggestion("links", name, links),
            Self::UnknownJoint { name, joints, .. } => suggestion("joints", name, joints),
            Self::LockedJointCannotMove { .. } => "omit it from --lock".to_owned(),
            Self::LockNotFinite { .. } => {
                "pass a position in rad or m, for example --lock joint=0.5".to_owned()
            }
            Self::GravityNotFinite { .. } => "for example --gravity 0,0,-9.81".to_owned(),
            Self::TipNotBelowBase { .. } => {
                "choose a tip below the base link, or omit --base".to_owned()
            }
            Self::JointTypeOnPath { .. } => {
                "start the chain after it with --base LINK, or end it before with --tip LINK"
                    .to_owned()
            }
            Self::NothingMoves { .. } => {
                "choose another --tip, or release a joint from --lock".to_owned()
            }
            Self::NoRecordedJointInRobot { movable, .. } => format!(
                "rename the columns to <joint>/position etc. with the robot's joints: {}",
                movable.join(", ")
            ),
            Self::RecordedJointsOnSeveralPaths { .. } => {
                "select one arm with --tip LINK; other columns are ignored".to_owned()
            }
        })
    }
}

fn suggestion(what: &str, name: &str, known: &[String]) -> String {
    match crate::names::nearest(name, known) {
        Some(near) => format!("did you mean `{near}`? Valid {what}: {}", known.join(", ")),
        None => format!("valid {what}: {}", known.join(", ")),
    }
}
