//! The checked content of a URDF file: a tree of links and joints, before any chain is chosen.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};

use crate::{CollisionShape, Warning};

/// A URDF that has been read and checked: one root, unique names, every number finite.
///
/// Links and joints keep the order of the file; indices below refer to these lists.
#[derive(Debug, Clone)]
pub struct RobotDescription {
    /// Name attribute of `<robot>`.
    pub name: String,
    /// Where the text came from: a path as given by the caller, or a label such as `<memory>`.
    pub source: String,
    /// Links in file order.
    pub links: Vec<LinkDescription>,
    /// Joints in file order.
    pub joints: Vec<JointDescription>,
    /// Index of the root link, the one link that is no joint's child.
    pub root: usize,
    /// Warnings on doubtful but usable values of the file.
    pub warnings: Vec<Warning>,
    /// Ignored elements (`transmission`, `gazebo`, ...), each with its line.
    pub ignored: Vec<IgnoredElement>,
}

/// One `<link>`.
#[derive(Debug, Clone)]
pub struct LinkDescription {
    /// Link name.
    pub name: String,
    /// The `<inertial>` element; `None` when the file has none (the link then has no mass).
    pub inertial: Option<InertialDescription>,
    /// Shapes for collisions, in the frame of the link.
    pub collisions: Vec<CollisionShape>,
    /// Line in the file, from 1.
    pub line: u32,
}

/// The numbers of one `<inertial>` element, as written.
#[derive(Debug, Clone, Copy)]
pub struct InertialDescription {
    /// Mass \[kg\], finite and not negative.
    pub mass_kg: f64,
    /// Centre of mass in the link frame \[m\].
    pub com_in_link_m: [f64; 3],
    /// Roll, pitch, yaw of the inertial frame in the link frame \[rad\].
    pub rpy_rad: [f64; 3],
    /// `ixx, ixy, ixz, iyy, iyz, izz` about the centre of mass in the inertial frame \[kg m2\],
    /// products with the sign of the tensor.
    pub inertia_kgm2: [f64; 6],
}

/// The joint types of the URDF format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UrdfJointType {
    /// Rotation within limits.
    Revolute,
    /// Rotation without limits.
    Continuous,
    /// Translation along the axis.
    Prismatic,
    /// No motion.
    Fixed,
    /// Six degrees of freedom; refused on a chain.
    Floating,
    /// Three degrees of freedom in a plane; refused on a chain.
    Planar,
}

impl UrdfJointType {
    /// Whether the joint has exactly one degree of freedom.
    pub fn is_movable(self) -> bool {
        matches!(self, Self::Revolute | Self::Continuous | Self::Prismatic)
    }
}

/// One `<joint>`.
#[derive(Debug, Clone)]
pub struct JointDescription {
    /// Joint name.
    pub name: String,
    /// Joint type.
    pub joint_type: UrdfJointType,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// Origin of the joint frame in the parent link frame \[m\].
    pub origin_xyz_m: [f64; 3],
    /// Roll, pitch, yaw of the joint frame in the parent link frame \[rad\], as written.
    pub origin_rpy_rad: [f64; 3],
    /// Unit vector of the axis in the joint frame, with the sign of the file.
    /// `[1, 0, 0]` where the file has no `<axis>`; meaningless for fixed and floating joints.
    pub axis: [f64; 3],
    /// Limits; `None` where the file has no usable value.
    pub limits: JointLimits,
    /// `<dynamics>` of the file.
    pub dynamics: Option<JointDynamics>,
    /// `<mimic>` of the file.
    pub mimic: Option<Mimic>,
    /// Line in the file, from 1.
    pub line: u32,
}

/// Limits of a joint; `None` means unlimited or unspecified.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JointLimits {
    /// Lowest position \[rad or m\].
    pub lower: Option<f64>,
    /// Highest position \[rad or m\].
    pub upper: Option<f64>,
    /// Largest effort \[N m or N\].
    pub effort: Option<f64>,
    /// Largest speed \[rad/s or m/s\].
    pub velocity: Option<f64>,
}

/// `<dynamics>` of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDynamics {
    /// Viscous coefficient \[N m s/rad or N s/m\].
    pub damping: f64,
    /// Coulomb level \[N m or N\].
    pub friction: f64,
}

/// `<mimic>` of a joint: `position = multiplier * master + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Mimic {
    /// Name of the joint that leads; it exists in the file.
    pub master: String,
    /// Factor on the leading joint's position.
    pub multiplier: f64,
    /// Offset \[rad or m\].
    pub offset: f64,
}

/// A child element of `<robot>` that has no influence on the result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IgnoredElement {
    /// Tag name.
    pub tag: String,
    /// Line in the file, from 1.
    pub line: u32,
}

/// Fixed-axis roll, pitch, yaw as in URDF: `Rz(yaw) Ry(pitch) Rx(roll)`.
pub(crate) fn pose(xyz: [f64; 3], rpy: [f64; 3]) -> Isometry3<f64> {
    let rotation = Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]);
    Isometry3::from_parts(
        Translation3::new(xyz[0], xyz[1], xyz[2]),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}
