//! Normal driving-axis frames of a serial chain (modified Denavit-Hartenberg form).
//!
//! Frame `E_i` is fixed to link `i`, its z axis is the axis of joint `i`, and
//!
//! ```text
//! T(i-1 -> i) = Rot_x(β_i) Trans_x(b_i) Rot_z(θ_i) Trans_z(d_i)
//! ```
//!
//! `b_i, β_i` belong to the normal between the axes `i-1` and `i` (along `x_{i-1}`), `θ_i, d_i` to
//! joint `i`: `θ_i = θ'_i + q_i` for a rotational joint, `d_i = d'_i + q_i` for a translational one
//! (Lin 1992, section 2; the choice of the free origins and x axes is stated at [`place_frames`]).

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::serial_chain::{NEARLY, nearest_twelfth, snapped};
use crate::{
    CollisionShape, IgnoredElement, InertialParameters, JointDynamics, JointKind, JointLimits,
    SerialChain, Warning,
};

/// Two directions are parallel when `|z_i × z_j|` is at most this \[rad\].
pub const PARALLEL_TOLERANCE_RAD: f64 = 1e-4;
/// A length below this is zero \[m\].
pub const LENGTH_TOLERANCE_M: f64 = 1e-6;
/// Distance of a frame origin that gives a warning \[m\].
const FAR_M: f64 = 100.0;

/// The four constants of one joint, at q = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivingAxisFrame {
    /// Length of the normal between the axes `i-1` and `i` \[m\].
    pub b_m: f64,
    /// `d'`, offset along the axis at q = 0 \[m\].
    pub d_m: f64,
    /// Angle between the axes `i-1` and `i` about the normal \[rad\], in (-π, π].
    pub beta_rad: f64,
    /// `θ'`, angle about the axis at q = 0 \[rad\], in (-π, π].
    pub theta_rad: f64,
}

/// Relative position of two consecutive axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisPair {
    /// Neither parallel nor meeting.
    Skew,
    /// Meeting in one point.
    Intersecting,
    /// Parallel and apart.
    Parallel,
    /// The same line.
    Coincident,
}

impl AxisPair {
    /// Lower-case name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Skew => "skew",
            Self::Intersecting => "intersecting",
            Self::Parallel => "parallel",
            Self::Coincident => "coincident",
        }
    }
}

/// One joint of a [`DrivingAxisChain`] with the link it moves.
#[derive(Debug, Clone)]
pub struct DrivingAxisJoint {
    /// Joint name of the URDF.
    pub name: String,
    /// Rotation or translation.
    pub kind: JointKind,
    /// Constants of the frame.
    pub frame: DrivingAxisFrame,
    /// Lumped link in `E_i`.
    pub link: InertialParameters,
    /// Name of the URDF link that the joint moves first.
    pub child_link: String,
    /// Names of all URDF links that move rigidly with the joint.
    pub body_links: Vec<String>,
    /// Pose of that link's URDF frame in `E_i`.
    pub child_link_in_e: Isometry3<f64>,
    /// Shapes of those links, in `E_i`; none in a chain that was not read from a URDF.
    pub shapes: Vec<CollisionShape>,
    /// Limits of the URDF.
    pub limits: JointLimits,
    /// Damping and friction of the URDF.
    pub dynamics: Option<JointDynamics>,
}

/// A serial arm in driving-axis frames with lumped links: the geometry that all other crates use.
///
/// Invariant: at least one joint, `b = β = d' = θ' = 0` for joint 1 (`E_0 = E_1` at `q_1 = 0`).
#[derive(Debug, Clone)]
pub struct DrivingAxisChain {
    /// Robot name.
    pub robot: String,
    /// Where the robot came from.
    pub source: String,
    /// First link.
    pub base_link: String,
    /// Last link.
    pub tip_link: String,
    /// Pose of the tip link frame in `E_n` (all joints before it at 0).
    pub tip_in_e: Isometry3<f64>,
    /// Shapes of the links that do not move, in the base link frame.
    pub base_shapes: Vec<CollisionShape>,
    /// Locked movable joints and their positions \[rad or m\].
    pub locked: BTreeMap<String, f64>,
    /// Pose of `E_0` in the base link.
    pub base_from_e0: Isometry3<f64>,
    /// Gravity acceleration in the base link frame \[m/s2\].
    pub gravity_base: Vector3<f64>,
    /// Gravity acceleration in `E_0` \[m/s2\], snapped.
    pub gravity_e0: Vector3<f64>,
    /// Joints 1..n.
    pub joints: Vec<DrivingAxisJoint>,
    /// Kind of each consecutive pair of axes, `n - 1` entries.
    pub axis_pairs: Vec<AxisPair>,
    /// Largest entry of the difference between the poses of the snapped chain at q = 0 and those
    /// it came from.
    pub snap_error: f64,
    /// Elements of the URDF that are not used.
    pub ignored: Vec<IgnoredElement>,
    /// Warnings for the user.
    pub warnings: Vec<Warning>,
}

impl DrivingAxisChain {
    /// Places the frames of a chain and snaps their constants.
    pub fn from_chain(chain: &SerialChain) -> Self {
        let mut warnings = chain.warnings.clone();
        let placed = place_frames(chain);
        let n = chain.joints.len();

        let mut frames = Vec::with_capacity(n);
        for i in 0..n {
            frames.push(if i == 0 {
                DrivingAxisFrame { b_m: 0.0, d_m: 0.0, beta_rad: 0.0, theta_rad: 0.0 }
            } else {
                constants_between(&placed.poses[i - 1], &placed.poses[i])
            });
        }
        warn_about_near_misses(chain, &frames, &mut warnings);
        for frame in &mut frames {
            frame.beta_rad = principal(snapped(frame.beta_rad, PARALLEL_TOLERANCE_RAD));
            frame.theta_rad = principal(snapped(frame.theta_rad, PARALLEL_TOLERANCE_RAD));
            for length in [&mut frame.b_m, &mut frame.d_m] {
                if length.abs() <= LENGTH_TOLERANCE_M {
                    *length = 0.0;
                }
            }
        }

        let base_from_e0 = placed.poses[0];
        let gravity = base_from_e0.rotation.inverse() * chain.gravity_base;
        let joints: Vec<_> = chain
            .joints
            .iter()
            .zip(&frames)
            .zip(&placed.poses)
            .map(|((joint, frame), base_from_e)| {
                let child_link_in_e = base_from_e.inverse() * joint.base_from_child;
                DrivingAxisJoint {
                    name: joint.name.clone(),
                    kind: joint.kind,
                    frame: *frame,
                    link: joint.body_in_child.expressed_in(&child_link_in_e),
                    child_link: joint.child_link.clone(),
                    body_links: joint.body_links.clone(),
                    child_link_in_e,
                    shapes: joint.shapes.iter().map(|s| s.moved(&child_link_in_e)).collect(),
                    limits: joint.limits,
                    dynamics: joint.dynamics,
                }
            })
            .collect();
        let mut result = Self {
            robot: chain.robot.clone(),
            source: chain.source.clone(),
            base_link: chain.base_link.clone(),
            tip_link: chain.tip_link.clone(),
            tip_in_e: placed.poses[n - 1].inverse() * chain.base_from_tip,
            base_shapes: chain.base_shapes.clone(),
            locked: chain.locked.clone(),
            base_from_e0,
            gravity_base: chain.gravity_base,
            gravity_e0: without_small_components(gravity),
            joints,
            axis_pairs: placed.pairs,
            snap_error: 0.0,
            ignored: chain.ignored.clone(),
            warnings,
        };
        result.snap_error = result
            .frames_in_base(&vec![0.0; n])
            .iter()
            .zip(&placed.poses)
            .map(|(a, b)| (a.to_homogeneous() - b.to_homogeneous()).amax())
            .fold(0.0, f64::max);
        result
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// A note that lists ignored elements of the URDF, if there are any.
    pub fn ignored_note(&self) -> Option<String> {
        let mut lines: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for element in &self.ignored {
            lines.entry(&element.tag).or_default().push(element.line.to_string());
        }
        let list: Vec<String> = lines
            .iter()
            .map(|(tag, lines)| match lines.len() {
                1..=4 => format!("<{tag}> (line {})", lines.join(", ")),
                n => format!("<{tag}> ({n} times, from line {})", lines[0]),
            })
            .collect();
        (!list.is_empty()).then(|| format!("ignored URDF elements: {}", list.join(", ")))
    }

    /// Joint names in chain order.
    pub fn joint_names(&self) -> Vec<&str> {
        self.joints.iter().map(|j| j.name.as_str()).collect()
    }

    /// `R`/`P` letters in chain order.
    pub fn types(&self) -> String {
        self.joints.iter().map(|j| j.kind.letter()).collect()
    }

    /// Pose of `E_i` in `E_{i-1}` with joint `i` (from 0) at `position` \[rad or m\].
    pub fn parent_from_e(&self, i: usize, position: f64) -> Isometry3<f64> {
        let DrivingAxisFrame { b_m, d_m, beta_rad, theta_rad } = self.joints[i].frame;
        let (theta, d) = match self.joints[i].kind {
            JointKind::Rotational => (theta_rad + position, d_m),
            JointKind::Translational => (theta_rad, d_m + position),
        };
        let about_x = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), beta_rad);
        let about_z = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), theta);
        Isometry3::from_parts(Translation3::new(b_m, 0.0, 0.0), about_x)
            * Isometry3::from_parts(Translation3::new(0.0, 0.0, d), about_z)
    }

    /// Poses of `E_1 .. E_n` in the base link frame at joint positions `q` (length n).
    pub fn frames_in_base(&self, q: &[f64]) -> Vec<Isometry3<f64>> {
        let mut pose = self.base_from_e0;
        (0..self.dof())
            .map(|i| {
                pose *= self.parent_from_e(i, q[i]);
                pose
            })
            .collect()
    }

    /// Pose of the URDF frame of each joint's child link in the base link frame.
    pub fn child_links_in_base(&self, q: &[f64]) -> Vec<Isometry3<f64>> {
        let frames = self.frames_in_base(q);
        frames.iter().zip(&self.joints).map(|(e, j)| e * j.child_link_in_e).collect()
    }
}

/// Frames at q = 0 in base coordinates, before snapping.
struct PlacedFrames {
    poses: Vec<Isometry3<f64>>,
    pairs: Vec<AxisPair>,
}

/// Origins and x axes of all frames at q = 0.
///
/// | pair (i, i+1) | `x_i` | `O_i` |
/// | --- | --- | --- |
/// | skew | from the foot on axis i to the foot on axis i+1 | foot on axis i |
/// | intersecting | `z_i × z_{i+1}` | intersection |
/// | parallel | part of `P_{i+1} - P_i` normal to `z_i` | projection of `O_{i+1}` on axis i |
/// | coincident | `x_{i+1}` | `O_{i+1}` |
///
/// Last frame: `x_n = x_{n-1}`, `O_n` the foot on axis n of the normal (n-1, n). If the axes t..n
/// are parallel, `O_n` lies in the plane normal to them through the foot on axis t of the normal
/// (t-1, t), or through the origin of joint 1 if t = 1. If all axes coincide, the x axes follow the
/// x axis of the first child link (its y axis where x is nearly along the joint).
fn place_frames(chain: &SerialChain) -> PlacedFrames {
    let n = chain.joints.len();
    let z: Vec<Vector3<f64>> = chain.joints.iter().map(|j| j.axis_in_base).collect();
    let p: Vec<Vector3<f64>> = chain.joints.iter().map(|j| j.origin_in_base_m).collect();
    let pairs: Vec<AxisPair> =
        (0..n - 1).map(|i| classify(z[i], p[i], z[i + 1], p[i + 1])).collect();

    // first joint of the parallel tail, and of the coincident tail
    let tail = |same: fn(AxisPair) -> bool| {
        (0..n - 1).rev().take_while(|&i| same(pairs[i])).last().unwrap_or(n - 1)
    };
    let parallel_tail = tail(|pair| matches!(pair, AxisPair::Parallel | AxisPair::Coincident));
    let coincident_tail = tail(|pair| pair == AxisPair::Coincident);

    let mut origin = vec![Vector3::zeros(); n];
    let plane = if parallel_tail == 0 {
        p[0]
    } else {
        let t = parallel_tail;
        feet(z[t - 1], p[t - 1], z[t], p[t]).1
    };
    origin[n - 1] = p[n - 1] + z[n - 1] * (plane - p[n - 1]).dot(&z[n - 1]);

    // x axes given by the pairs; coincident pairs take over the next frame's
    let mut x: Vec<Option<Vector3<f64>>> = vec![None; n];
    for i in (0..n - 1).rev() {
        (x[i], origin[i]) = match pairs[i] {
            AxisPair::Skew => {
                let (near, far) = feet(z[i], p[i], z[i + 1], p[i + 1]);
                (Some((far - near).normalize()), near)
            }
            AxisPair::Intersecting => {
                (Some(z[i].cross(&z[i + 1]).normalize()), feet(z[i], p[i], z[i + 1], p[i + 1]).0)
            }
            AxisPair::Parallel => (
                Some(normal_part(p[i + 1] - p[i], z[i]).normalize()),
                p[i] + z[i] * (origin[i + 1] - p[i]).dot(&z[i]),
            ),
            AxisPair::Coincident => (x[i + 1], origin[i + 1]),
        };
    }
    let tail_x = match coincident_tail.checked_sub(1).and_then(|before| x[before]) {
        Some(x) => x,
        None => {
            let child = chain.joints[0].base_from_child.rotation.to_rotation_matrix();
            let along_x = normal_part(child.matrix().column(0).into(), z[0]);
            if along_x.norm() >= 1e-3 {
                along_x.normalize()
            } else {
                normal_part(child.matrix().column(1).into(), z[0]).normalize()
            }
        }
    };
    let poses = (0..n)
        .map(|i| {
            let x = if i >= coincident_tail { tail_x } else { x[i].unwrap_or(tail_x) };
            // exactly normal to z also where a parallel pair is parallel only within tolerance
            let x = normal_part(x, z[i]).normalize();
            let axes = Matrix3::from_columns(&[x, z[i].cross(&x), z[i]]);
            let rotation = Rotation3::from_matrix_unchecked(axes);
            Isometry3::from_parts(origin[i].into(), UnitQuaternion::from_rotation_matrix(&rotation))
        })
        .collect();
    PlacedFrames { poses, pairs }
}

fn classify(
    z: Vector3<f64>,
    p: Vector3<f64>,
    z_next: Vector3<f64>,
    p_next: Vector3<f64>,
) -> AxisPair {
    if z.cross(&z_next).norm() <= PARALLEL_TOLERANCE_RAD {
        if normal_part(p_next - p, z).norm() <= LENGTH_TOLERANCE_M {
            AxisPair::Coincident
        } else {
            AxisPair::Parallel
        }
    } else {
        let (near, far) = feet(z, p, z_next, p_next);
        if (far - near).norm() <= LENGTH_TOLERANCE_M {
            AxisPair::Intersecting
        } else {
            AxisPair::Skew
        }
    }
}

/// Feet of the common normal on two lines that are not parallel.
fn feet(
    z: Vector3<f64>,
    p: Vector3<f64>,
    z_next: Vector3<f64>,
    p_next: Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let normal = z.cross(&z_next);
    let apart = p_next - p;
    let scale = normal.norm_squared();
    (
        p + z * (apart.cross(&z_next).dot(&normal) / scale),
        p_next + z_next * (apart.cross(&z).dot(&normal) / scale),
    )
}

fn normal_part(a: Vector3<f64>, z: Vector3<f64>) -> Vector3<f64> {
    a - z * a.dot(&z)
}

fn constants_between(previous: &Isometry3<f64>, this: &Isometry3<f64>) -> DrivingAxisFrame {
    let column = |pose: &Isometry3<f64>, axis: Vector3<f64>| pose.rotation * axis;
    let (x0, z0) = (column(previous, Vector3::x()), column(previous, Vector3::z()));
    let (x1, z1) = (column(this, Vector3::x()), column(this, Vector3::z()));
    let apart = this.translation.vector - previous.translation.vector;
    let b_m = apart.dot(&x0);
    DrivingAxisFrame {
        b_m,
        d_m: (apart - x0 * b_m).dot(&z1),
        beta_rad: z0.cross(&z1).dot(&x0).atan2(z0.dot(&z1)),
        theta_rad: x0.cross(&x1).dot(&z1).atan2(x0.dot(&x1)),
    }
}

/// The same angle in (-π, π].
fn principal(angle: f64) -> f64 {
    let wrapped = angle - TAU * (angle / TAU).round();
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}

/// Components below the parallel tolerance are zeroed and the rest is scaled to the same length.
fn without_small_components(gravity: Vector3<f64>) -> Vector3<f64> {
    let size = gravity.norm();
    if size == 0.0 {
        return gravity;
    }
    let kept = gravity.map(|g| if g.abs() < PARALLEL_TOLERANCE_RAD * size { 0.0 } else { g });
    kept * (size / kept.norm())
}

fn warn_about_near_misses(
    chain: &SerialChain,
    frames: &[DrivingAxisFrame],
    warnings: &mut Vec<Warning>,
) {
    let mut angles = Vec::new();
    let mut far = Vec::new();
    let mut directions = Vec::new();
    for (i, (joint, frame)) in chain.joints.iter().zip(frames).enumerate() {
        for (symbol, angle) in [("beta", frame.beta_rad), ("theta", frame.theta_rad)] {
            let off = (angle - nearest_twelfth(angle)).abs();
            if off > PARALLEL_TOLERANCE_RAD && off < NEARLY {
                angles.push(format!("{symbol} of joint `{}` = {angle:.6} rad", joint.name));
            }
        }
        for (symbol, length) in [("b", frame.b_m), ("d", frame.d_m)] {
            if length.abs() > FAR_M {
                far.push(format!("{symbol} of joint `{}` = {length:.1} m", joint.name));
            }
        }
        let sine = |v: &Vector3<f64>| joint.axis_in_base.cross(v).norm();
        let nearly = |s: f64| s > PARALLEL_TOLERANCE_RAD && s < NEARLY;
        if let Some(next) = chain.joints.get(i + 1)
            && nearly(sine(&next.axis_in_base))
        {
            directions.push(format!("axes of joints `{}` and `{}`", joint.name, next.name));
        }
        let gravity = chain.gravity_base.norm();
        if gravity > 0.0 && nearly(sine(&(chain.gravity_base / gravity))) {
            directions.push(format!("axis of joint `{}` and gravity", joint.name));
        }
    }
    let hint = "use --snap-rpy 2e-3 if the URDF's angles are rounded";
    if !angles.is_empty() {
        warnings.push(Warning::new(
            "frame-angle-near-multiple",
            format!(
                "frame angles near a multiple of pi/12 not snapped: {}; {hint}",
                angles.join(", ")
            ),
        ));
    }
    if !directions.is_empty() {
        warnings.push(Warning::new(
            "nearly-parallel",
            format!(
                "nearly parallel axes treated as non-parallel: {}; {hint}",
                directions.join(", ")
            ),
        ));
    }
    if !far.is_empty() {
        warnings.push(Warning::new(
            "frame-far-away",
            format!(
                "frame origins far from the arm (nearly parallel axes): {}; constants of these joints \
                 are not identifiable from noisy recordings; {hint}",
                far.join(", ")
            ),
        ));
    }
}
