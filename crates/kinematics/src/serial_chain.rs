//! Serial chain of a URDF tree: path, locked joints, lumped links. Joint axes keep their URDF sign;
//! everything before the first movable joint belongs to the base.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::description::pose;
use crate::{
    ChainError, CollisionShape, IgnoredElement, InertialParameters, JointDynamics, JointLimits,
    RobotDescription, UrdfJointType, Warning,
};

/// Part of the robot that is the arm, and positions of the locked joints.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainSelection {
    /// First link of the chain; the root of the URDF when absent.
    pub base: Option<String>,
    /// Last link of the chain; `None`: the tip that contains the recorded joints, else the path with
    /// the most movable joints (ties by file order).
    pub tip: Option<String>,
    /// Joints with recorded positions. Other joints on the path are locked at 0, with a warning.
    pub recorded_joints: Option<Vec<String>>,
    /// Positions of locked movable joints \[rad or m\], by name.
    pub locked: BTreeMap<String, f64>,
    /// Gravity acceleration in the base link frame \[m/s2\].
    pub gravity_base: [f64; 3],
    /// Tolerance \[rad\] for snapping joint-origin angles to multiples of π/12: 1e-4 for angles
    /// rounded to 1.5708, 2e-3 for 1.57.
    pub snap_rpy_rad: f64,
}

impl Default for ChainSelection {
    fn default() -> Self {
        Self {
            base: None,
            tip: None,
            recorded_joints: None,
            locked: BTreeMap::new(),
            gravity_base: [0.0, 0.0, -9.81],
            snap_rpy_rad: 1e-4,
        }
    }
}

/// Rotation about or translation along the joint axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// `R`: the position is an angle \[rad\], the effort a torque \[N m\].
    Rotational,
    /// `P`: the position is a length \[m\], the effort a force \[N\].
    Translational,
}

impl JointKind {
    /// `R` or `P`.
    pub fn letter(self) -> char {
        match self {
            Self::Rotational => 'R',
            Self::Translational => 'P',
        }
    }

    /// Whether the joint rotates.
    pub fn is_rotational(self) -> bool {
        self == Self::Rotational
    }
}

/// One movable joint of the chain with all links fixed behind it up to the next one.
#[derive(Debug, Clone)]
pub struct ChainJoint {
    /// Joint name of the URDF.
    pub name: String,
    /// Rotation or translation.
    pub kind: JointKind,
    /// Unit axis at q = 0, base coordinates, sign of the URDF.
    pub axis_in_base: Vector3<f64>,
    /// Joint origin at q = 0 in base coordinates \[m\].
    pub origin_in_base_m: Vector3<f64>,
    /// Child link of the joint.
    pub child_link: String,
    /// Pose of the child link frame in the base at q = 0.
    pub base_from_child: Isometry3<f64>,
    /// All links that move rigidly with the joint, in the child link frame.
    pub body_in_child: InertialParameters,
    /// Names of those links, file order.
    pub body_links: Vec<String>,
    /// Shapes of those links, in the child link frame.
    pub shapes: Vec<CollisionShape>,
    /// Limits of the URDF.
    pub limits: JointLimits,
    /// Damping and friction of the URDF.
    pub dynamics: Option<JointDynamics>,
}

/// A serial chain of one-degree-of-freedom joints, in the geometry of the URDF at q = 0.
#[derive(Debug, Clone)]
pub struct SerialChain {
    /// Robot name.
    pub robot: String,
    /// Where the URDF came from.
    pub source: String,
    /// First link.
    pub base_link: String,
    /// Last link.
    pub tip_link: String,
    /// Pose of the tip link frame in the base at q = 0.
    pub base_from_tip: Isometry3<f64>,
    /// Movable joints from base to tip; never empty.
    pub joints: Vec<ChainJoint>,
    /// Shapes of the links that do not move, in the base link frame.
    pub base_shapes: Vec<CollisionShape>,
    /// Locked movable joints and their positions \[rad or m\].
    pub locked: BTreeMap<String, f64>,
    /// Gravity acceleration in the base link frame \[m/s2\].
    pub gravity_base: Vector3<f64>,
    /// Elements of the URDF that are not used.
    pub ignored: Vec<IgnoredElement>,
    /// Warnings for the user.
    pub warnings: Vec<Warning>,
}

impl SerialChain {
    /// Selects the chain of a robot and lumps links that do not move.
    ///
    /// # Errors
    /// [`ChainError`] when a named link or joint does not exist, the tip is not below the base, the
    /// recorded joints do not lie on one path, a floating or planar joint is on the path, or
    /// nothing on the path can move.
    pub fn from_description(
        robot: &RobotDescription,
        selection: &ChainSelection,
    ) -> Result<Self, ChainError> {
        Builder::new(robot, selection)?.build()
    }
}

/// Links that move as one: inertia and shapes in the frame of the first, and their indices.
struct Glued {
    body: InertialParameters,
    links: Vec<usize>,
    shapes: Vec<CollisionShape>,
}

struct Builder<'a> {
    robot: &'a RobotDescription,
    selection: &'a ChainSelection,
    base: usize,
    /// joints below each link, file order
    children: Vec<Vec<usize>>,
    warnings: Vec<Warning>,
}

impl<'a> Builder<'a> {
    fn new(robot: &'a RobotDescription, selection: &'a ChainSelection) -> Result<Self, ChainError> {
        if selection.gravity_base.iter().any(|g| !g.is_finite()) {
            return Err(ChainError::GravityNotFinite { found: selection.gravity_base });
        }
        let mut children = vec![Vec::new(); robot.links.len()];
        for (index, joint) in robot.joints.iter().enumerate() {
            children[joint.parent].push(index);
        }
        let base = match &selection.base {
            Some(name) => link_index(robot, name, "base")?,
            None => robot.root,
        };
        for (name, value) in &selection.locked {
            let joint = joint_index(robot, name, "lock")?;
            if !robot.joints[joint].joint_type.is_movable() {
                return Err(ChainError::LockedJointCannotMove {
                    joint: name.clone(),
                    source_name: robot.source.clone(),
                });
            }
            if !value.is_finite() {
                return Err(ChainError::LockNotFinite { joint: name.clone() });
            }
        }
        Ok(Self { robot, selection, base, children, warnings: robot.warnings.clone() })
    }

    fn build(mut self) -> Result<SerialChain, ChainError> {
        let robot = self.robot;
        let recorded = self.recorded_in_tree()?;
        let (tip, path) = self.path(recorded.as_deref())?;

        let mut locked = self.selection.locked.clone();
        let mut chain_joints = Vec::new();
        for &joint in &path {
            let description = &robot.joints[joint];
            match description.joint_type {
                UrdfJointType::Fixed => {}
                UrdfJointType::Floating | UrdfJointType::Planar => {
                    return Err(ChainError::JointTypeOnPath {
                        joint: description.name.clone(),
                        joint_type: if description.joint_type == UrdfJointType::Planar {
                            "planar"
                        } else {
                            "floating"
                        },
                        line: description.line,
                        source_name: robot.source.clone(),
                    });
                }
                _ if locked.contains_key(&description.name) => {}
                _ if recorded.as_ref().is_some_and(|r| !r.contains(&joint)) => {
                    locked.insert(description.name.clone(), 0.0);
                    self.warnings.push(Warning::new(
                        "joint-not-recorded",
                        format!(
                            "joint `{}` is not recorded; locked at 0 (change with --lock {}=VALUE)",
                            description.name, description.name
                        ),
                    ));
                }
                _ => chain_joints.push(joint),
            }
        }
        if chain_joints.is_empty() {
            return Err(ChainError::NothingMoves {
                base: robot.links[self.base].name.clone(),
                tip: robot.links[tip].name.clone(),
                source_name: robot.source.clone(),
            });
        }

        // every movable joint below the base that is not on the chain is locked
        let mut stack = vec![self.base];
        while let Some(link) = stack.pop() {
            for &joint in &self.children[link] {
                let description = &robot.joints[joint];
                if description.joint_type.is_movable() && !chain_joints.contains(&joint) {
                    locked.entry(description.name.clone()).or_insert(0.0);
                }
                stack.push(description.child);
            }
        }
        let unused: Vec<String> =
            self.selection.locked.keys().filter(|name| !self.below_base(name)).cloned().collect();
        for name in unused {
            self.warnings.push(Warning::new(
                "lock-unused",
                format!("--lock {name} has no effect: the joint is not below the base link"),
            ));
        }

        let joints = self.lumped(&chain_joints, &locked);
        let base_shapes = self.glued(self.base, &chain_joints, &locked).shapes;
        let base_from_tip = self.base_from_link(tip, &locked);
        self.warn_about_missed_snaps();
        for joint in &joints {
            // a link that is inconsistent by itself has its own warning
            let links_are_consistent = joint.body_links.iter().all(|name| {
                !robot
                    .warnings
                    .iter()
                    .any(|w| w.code == "inertia-unphysical" && w.subjects.contains(name))
            });
            if links_are_consistent && !joint.body_in_child.is_physical() {
                self.warnings.push(Warning::new(
                    "body-unphysical",
                    format!(
                        "the lumped body of joint `{}` (links {}) is not physically consistent \
                         (smallest eigenvalue of its pseudo-inertia {:.3e})",
                        joint.name,
                        joint.body_links.join(", "),
                        joint.body_in_child.smallest_pseudo_inertia_eigenvalue()
                    ),
                ));
            }
        }
        Ok(SerialChain {
            robot: robot.name.clone(),
            source: robot.source.clone(),
            base_link: robot.links[self.base].name.clone(),
            tip_link: robot.links[tip].name.clone(),
            base_from_tip,
            joints,
            base_shapes,
            locked,
            gravity_base: Vector3::from(self.selection.gravity_base),
            ignored: robot.ignored.clone(),
            warnings: self.warnings,
        })
    }

    /// Recorded joints that the URDF has; the others are ignored with a warning.
    fn recorded_in_tree(&mut self) -> Result<Option<Vec<usize>>, ChainError> {
        let Some(names) = &self.selection.recorded_joints else { return Ok(None) };
        let mut found = Vec::new();
        let mut unknown = Vec::new();
        for name in names {
            match self.robot.joints.iter().position(|j| &j.name == name) {
                Some(index) if self.robot.joints[index].joint_type.is_movable() => {
                    found.push(index);
                }
                Some(_) => self.warnings.push(Warning::new(
                    "recorded-joint-fixed",
                    format!("recorded joint `{name}` is fixed in the URDF; columns ignored"),
                )),
                None => unknown.push(name.clone()),
            }
        }
        if found.is_empty() {
            return Err(ChainError::NoRecordedJointInRobot {
                recorded: names.clone(),
                movable: self.movable_names(),
                source_name: self.robot.source.clone(),
            });
        }
        if !unknown.is_empty() {
            // of those that are not recorded under their own name
            let mut open = self.movable_names();
            open.retain(|name| !names.contains(name));
            let meant = unknown.iter().find_map(|name| crate::nearest(name, &open));
            self.warnings.push(Warning::new(
                "recorded-joint-unknown",
                format!(
                    "recorded joints not in the URDF, ignored: {}{} (movable joints of the URDF: {})",
                    unknown.join(", "),
                    meant.map_or_else(String::new, |name| format!("; did you mean {name}?")),
                    self.movable_names().join(", ")
                ),
            ));
        }
        Ok(Some(found))
    }

    /// Tip link and the joints from base to tip.
    fn path(&self, recorded: Option<&[usize]>) -> Result<(usize, Vec<usize>), ChainError> {
        if let Some(name) = &self.selection.tip {
            let tip = link_index(self.robot, name, "tip")?;
            let path = self.path_to(tip).ok_or_else(|| ChainError::TipNotBelowBase {
                base: self.robot.links[self.base].name.clone(),
                tip: name.clone(),
                source_name: self.robot.source.clone(),
            })?;
            return Ok((tip, path));
        }
        let leaves = self.leaves_in_file_order();
        let movable = |path: &[usize]| {
            path.iter().filter(|&&j| self.robot.joints[j].joint_type.is_movable()).count()
        };
        let candidates = leaves.into_iter().filter_map(|leaf| Some((leaf, self.path_to(leaf)?)));
        if let Some(recorded) = recorded {
            // the path that holds all recorded joints, and no more movable ones than needed
            let mut best: Option<(usize, Vec<usize>)> = None;
            let mut most_held = (0, Vec::new());
            for (leaf, path) in candidates {
                let held = recorded.iter().filter(|j| path.contains(j)).count();
                if held > most_held.0 {
                    most_held = (held, path.clone());
                }
                if held == recorded.len()
                    && best.as_ref().is_none_or(|(_, b)| movable(&path) < movable(b))
                {
                    best = Some((leaf, path));
                }
            }
            return best.ok_or_else(|| {
                let missing = recorded.iter().filter(|j| !most_held.1.contains(j));
                ChainError::RecordedJointsOnSeveralPaths {
                    together: most_held
                        .1
                        .iter()
                        .filter(|j| recorded.contains(j))
                        .map(|&j| self.robot.joints[j].name.clone())
                        .collect(),
                    apart: missing.map(|&j| self.robot.joints[j].name.clone()).collect(),
                    source_name: self.robot.source.clone(),
                }
            });
        }
        let mut best: Option<(usize, Vec<usize>)> = None;
        for (leaf, path) in candidates {
            if best.as_ref().is_none_or(|(_, b)| movable(&path) > movable(b)) {
                best = Some((leaf, path));
            }
        }
        Ok(best.unwrap_or((self.base, Vec::new())))
    }

    /// Joints from the base to a link; `None` when the link is not below the base.
    fn path_to(&self, link: usize) -> Option<Vec<usize>> {
        let mut path = Vec::new();
        let mut at = link;
        while at != self.base {
            let joint = self.robot.joints.iter().position(|j| j.child == at)?;
            path.push(joint);
            at = self.robot.joints[joint].parent;
        }
        path.reverse();
        Some(path)
    }

    fn leaves_in_file_order(&self) -> Vec<usize> {
        (0..self.robot.links.len()).filter(|&link| self.children[link].is_empty()).collect()
    }

    fn below_base(&self, joint_name: &str) -> bool {
        self.robot
            .joints
            .iter()
            .find(|j| j.name == joint_name)
            .is_some_and(|j| self.path_to(j.child).is_some())
    }

    fn movable_names(&self) -> Vec<String> {
        let movable = self.robot.joints.iter().filter(|j| j.joint_type.is_movable());
        movable.map(|j| j.name.clone()).collect()
    }

    /// Pose of the joint frame in its parent link, angles snapped (theory stage A).
    fn parent_from_joint(&self, joint: usize) -> Isometry3<f64> {
        let description = &self.robot.joints[joint];
        let rpy = description.origin_rpy_rad.map(|a| snapped(a, self.selection.snap_rpy_rad));
        pose(description.origin_xyz_m, rpy)
    }

    /// Pose of the child link in the parent link, the joint at `position`.
    fn parent_from_child(&self, joint: usize, position: f64) -> Isometry3<f64> {
        let description = &self.robot.joints[joint];
        let axis = Vector3::from(description.axis);
        let motion = match description.joint_type {
            UrdfJointType::Revolute | UrdfJointType::Continuous => {
                Isometry3::from_parts(Translation3::identity(), turn(axis, position))
            }
            UrdfJointType::Prismatic => {
                Isometry3::from_parts((axis * position).into(), UnitQuaternion::identity())
            }
            _ => Isometry3::identity(),
        };
        self.parent_from_joint(joint) * motion
    }

    fn base_from_link(&self, link: usize, locked: &BTreeMap<String, f64>) -> Isometry3<f64> {
        let path = self.path_to(link).unwrap_or_default();
        path.iter().fold(Isometry3::identity(), |pose, &joint| {
            let position = locked.get(&self.robot.joints[joint].name).copied().unwrap_or(0.0);
            pose * self.parent_from_child(joint, position)
        })
    }

    fn lumped(&self, chain: &[usize], locked: &BTreeMap<String, f64>) -> Vec<ChainJoint> {
        chain
            .iter()
            .map(|&joint| {
                let description = &self.robot.joints[joint];
                let base_from_joint =
                    self.base_from_link(description.parent, locked) * self.parent_from_joint(joint);
                let Glued { body, mut links, shapes } =
                    self.glued(description.child, chain, locked);
                links.sort_unstable();
                ChainJoint {
                    name: description.name.clone(),
                    kind: if description.joint_type == UrdfJointType::Prismatic {
                        JointKind::Translational
                    } else {
                        JointKind::Rotational
                    },
                    axis_in_base: (base_from_joint * Vector3::from(description.axis)).normalize(),
                    origin_in_base_m: base_from_joint.translation.vector,
                    child_link: self.robot.links[description.child].name.clone(),
                    base_from_child: base_from_joint,
                    body_in_child: body,
                    body_links: links
                        .into_iter()
                        .map(|link| self.robot.links[link].name.clone())
                        .collect(),
                    shapes,
                    limits: description.limits,
                    dynamics: description.dynamics,
                }
            })
            .collect()
    }

    /// A link and all links fixed to it.
    fn glued(&self, link: usize, chain: &[usize], locked: &BTreeMap<String, f64>) -> Glued {
        let mut shapes = Vec::new();
        let mut body = InertialParameters::zero();
        let mut links = Vec::new();
        let mut stack = vec![(link, Isometry3::identity())];
        while let Some((at, pose_in_link)) = stack.pop() {
            links.push(at);
            shapes.extend(self.robot.links[at].collisions.iter().map(|s| s.moved(&pose_in_link)));
            if let Some(inertial) = &self.robot.links[at].inertial {
                let i = inertial.inertia_kgm2;
                let tensor = Matrix3::new(i[0], i[1], i[2], i[1], i[3], i[4], i[2], i[4], i[5]);
                // the inertial frame has its origin in the centre of mass
                let own = InertialParameters::from_com(inertial.mass_kg, Vector3::zeros(), tensor);
                let frame = pose(inertial.com_in_link_m, inertial.rpy_rad);
                body = body.plus(&own.expressed_in(&(pose_in_link * frame)));
            }
            for &joint in self.children[at].iter().filter(|j| !chain.contains(j)) {
                let description = &self.robot.joints[joint];
                let position = locked.get(&description.name).copied().unwrap_or(0.0);
                stack.push((
                    description.child,
                    pose_in_link * self.parent_from_child(joint, position),
                ));
            }
        }
        Glued { body, links, shapes }
    }

    /// Warns about angles near a multiple of π/12 but outside the snapping tolerance.
    fn warn_about_missed_snaps(&mut self) {
        let mut missed = Vec::new();
        for joint in &self.robot.joints {
            for angle in joint.origin_rpy_rad {
                let off = (angle - nearest_twelfth(angle)).abs();
                if off > self.selection.snap_rpy_rad && off < NEARLY {
                    missed.push(format!("joint `{}` (line {}): {angle}", joint.name, joint.line));
                }
            }
        }
        if !missed.is_empty() {
            self.warnings.push(Warning::new(
                "snap-missed",
                format!(
                    "angles near a multiple of pi/12 not snapped: {}; use --snap-rpy 2e-3 if they \
                     are rounded",
                    missed.join("; ")
                ),
            ));
        }
    }
}

/// Distance \[rad\] below which an angle nearly a multiple of π/12, or nearly parallel axes, give a warning.
pub(crate) const NEARLY: f64 = 5e-3;

pub(crate) fn nearest_twelfth(angle: f64) -> f64 {
    (angle / (PI / 12.0)).round() * (PI / 12.0)
}

pub(crate) fn snapped(angle: f64, tolerance: f64) -> f64 {
    let nearest = nearest_twelfth(angle);
    if (angle - nearest).abs() <= tolerance { nearest } else { angle }
}

fn turn(axis: Vector3<f64>, angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&nalgebra::Unit::new_unchecked(axis), angle)
}

fn link_index(
    robot: &RobotDescription,
    name: &str,
    option: &'static str,
) -> Result<usize, ChainError> {
    robot.links.iter().position(|l| l.name == name).ok_or_else(|| ChainError::UnknownLink {
        option,
        name: name.to_owned(),
        links: robot.links.iter().map(|l| l.name.clone()).collect(),
        source_name: robot.source.clone(),
    })
}

fn joint_index(
    robot: &RobotDescription,
    name: &str,
    option: &'static str,
) -> Result<usize, ChainError> {
    robot.joints.iter().position(|j| j.name == name).ok_or_else(|| ChainError::UnknownJoint {
        option,
        name: name.to_owned(),
        joints: robot.joints.iter().map(|j| j.name.clone()).collect(),
        source_name: robot.source.clone(),
    })
}
