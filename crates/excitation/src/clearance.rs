//! Distances of the arm from itself and from regions, between samples too.
//!
//! Method: conservative advancement. Over an interval of half-length `h` about its middle, the distance of two shapes is at
//! least that in the middle less the way that any point of the moving shape can go:
//!
//! ```text
//! d(t) >= d(middle) - h Σ_j (|v_j| + h a_j / 2) r_j
//! ```
//!
//! with the speed `v_j` in the middle, a bound `a_j` of the acceleration, and the reach `r_j`: the largest distance of a point
//! of the shape from the axis of joint `j` in any pose (1 for a slide). Intervals on which this is less than the margin are
//! halved.
//!
//! References: B. Mirtich, Impulse-based dynamic simulation of rigid body systems, PhD thesis, Berkeley, 1996 (conservative
//! advancement); the reach is own. Distances of two convex shapes are those of parry (GJK, EPA).

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;

use armident_kinematics::{CollisionGeometry, CollisionShape, DrivingAxisChain};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::contact;
use parry3d_f64::shape::SharedShape;

use crate::error::ExcitationError;
use crate::keep_out::{KeepOut, Region};
use crate::limits::MotionLimits;

/// Distance that is kept \[m\]: shapes of a URDF are rounded to some millimetres, and controllers lag.
pub(crate) const MARGIN_M: f64 = 0.01;
/// Shapes further apart than this are as far as their spheres are \[m\]: nothing needs a better figure.
const FAR_M: f64 = 0.3;
/// Poses that are tried for one without contact, and for pairs that always touch.
const POSES: usize = 400;
/// Shortest interval \[s\]: one that is not clear there is a contact.
const SHORTEST_S: f64 = 1e-4;

/// A shape on a body of the arm, or a region.
struct Solid {
    /// 0 for the base and for regions, else the joint that moves it, from 1
    body: usize,
    pose: Isometry3<f64>,
    shape: SharedShape,
    /// radius about the origin of the shape; infinite for a plane
    radius_m: f64,
    name: String,
    is_region: bool,
}

/// Two solids that may touch.
struct Pair {
    near: usize,
    far: usize,
    /// joints between the two and the reach of each \[m, or 1\]
    reach: Vec<(usize, f64)>,
}

/// The nearest two solids in a pose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Nearest {
    /// distance \[m\], negative where they overlap
    pub(crate) distance_m: f64,
    pub(crate) names: [String; 2],
}

/// What may touch, and how near it comes.
pub(crate) struct Clearance<'a> {
    chain: &'a DrivingAxisChain,
    solids: Vec<Solid>,
    pairs: Vec<Pair>,
    pub(crate) notes: Vec<String>,
}

fn pose_of(pose: &Isometry3<f64>) -> Pose {
    let (t, q) = (pose.translation.vector, pose.rotation.quaternion());
    Pose::from_parts(Vector::new(t.x, t.y, t.z), Rotation::from_xyzw(q.i, q.j, q.k, q.w))
}

/// Shape, its turn and the radius of a sphere about it.
fn solid_of(geometry: &CollisionGeometry) -> Option<(SharedShape, UnitQuaternion<f64>, f64)> {
    let none = UnitQuaternion::identity();
    match *geometry {
        CollisionGeometry::Cuboid { half_edges_m: [x, y, z] } => {
            Some((SharedShape::cuboid(x, y, z), none, Vector3::new(x, y, z).norm()))
        }
        CollisionGeometry::Cylinder { radius_m, length_m } => {
            // along y there, along z in a URDF
            let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
            let half = 0.5 * length_m;
            Some((SharedShape::cylinder(half, radius_m), turn, half.hypot(radius_m)))
        }
        CollisionGeometry::Sphere { radius_m } => {
            Some((SharedShape::ball(radius_m), none, radius_m))
        }
        CollisionGeometry::NotRead(_) => None,
    }
}

fn region_solid(name: &str, region: Region) -> Solid {
    let (pose, shape, radius_m) = match region {
        Region::Cuboid { centre_m: [x, y, z], rpy_rad: [roll, pitch, yaw], half_edges_m } => {
            let pose = Isometry3::from_parts(
                Translation3::new(x, y, z),
                UnitQuaternion::from_euler_angles(roll, pitch, yaw),
            );
            let [a, b, c] = half_edges_m;
            (pose, SharedShape::cuboid(a, b, c), Vector3::from(half_edges_m).norm())
        }
        Region::HalfSpace { point_m: [x, y, z], normal: [a, b, c] } => {
            let pose = Isometry3::translation(x, y, z);
            (pose, SharedShape::halfspace(Vector::new(a, b, c)), f64::INFINITY)
        }
    };
    Solid { body: 0, pose, shape, radius_m, name: format!("keep-out `{name}`"), is_region: true }
}

impl<'a> Clearance<'a> {
    /// What may touch on an arm with primitives, and in regions; none where no two solids can.
    ///
    /// # Errors
    /// [`ExcitationError::KeepOut`] for a region that is none.
    pub(crate) fn of(
        chain: &'a DrivingAxisChain,
        limits: &[MotionLimits],
        keep_out: &BTreeMap<String, KeepOut>,
    ) -> Result<Option<Self>, ExcitationError> {
        let mut solids = Vec::new();
        let mut unread: BTreeSet<String> = BTreeSet::new();
        let bodies =
            std::iter::once(&chain.base_shapes).chain(chain.joints.iter().map(|j| &j.shapes));
        for (body, shapes) in bodies.enumerate() {
            for CollisionShape { link, pose, geometry } in shapes {
                let Some((shape, turn, radius_m)) = solid_of(geometry) else {
                    if let CollisionGeometry::NotRead(tag) = geometry {
                        unread.insert(format!("{link} ({tag})"));
                    }
                    continue;
                };
                let name = format!("link `{link}`");
                let pose = pose * turn;
                solids.push(Solid { body, pose, shape, radius_m, name, is_region: false });
            }
        }
        let mut notes = Vec::new();
        if !unread.is_empty() {
            let list: Vec<String> = unread.into_iter().collect();
            notes.push(format!(
                "shapes that are not considered (boxes, cylinders and spheres are): {}",
                list.join(", ")
            ));
        }
        for (name, keep_out) in keep_out {
            solids.push(region_solid(name, keep_out.region(name)?));
        }
        let mut clearance = Self { chain, solids, pairs: Vec::new(), notes };
        for near in 0..clearance.solids.len() {
            for far in 0..clearance.solids.len() {
                let (a, b) = (&clearance.solids[near], &clearance.solids[far]);
                // neighbours touch at their joint; the base does not move
                let apart = if a.is_region { 1 } else { 2 };
                if !b.is_region && b.body >= a.body + apart {
                    let reach = clearance.reach(a.body, b, limits);
                    clearance.pairs.push(Pair { near, far, reach });
                }
            }
        }
        if clearance.pairs.is_empty() {
            return Ok(None);
        }
        clearance.without_lasting_contacts(limits);
        Ok(Some(clearance))
    }

    /// Names of regions that are given, and whether there is any shape of the arm to keep out of them.
    pub(crate) fn has_shapes(chain: &DrivingAxisChain) -> bool {
        let is_solid = |s: &CollisionShape| !matches!(s.geometry, CollisionGeometry::NotRead(_));
        chain.joints.iter().any(|joint| joint.shapes.iter().any(is_solid))
    }

    /// Joints from a body to a shape, with the largest distance of its points from their axes.
    fn reach(&self, from: usize, to: &Solid, limits: &[MotionLimits]) -> Vec<(usize, f64)> {
        let mut all = Vec::new();
        let own = to.pose.translation.vector;
        let mut beyond_m = own.norm() + to.radius_m;
        for joint in (from..to.body).rev() {
            let of = &self.chain.joints[joint];
            let reach = match of.kind.is_rotational() {
                false => 1.0,
                // the own axis is z
                true if joint + 1 == to.body => own.xy().norm() + to.radius_m,
                true => beyond_m,
            };
            all.push((joint, reach));
            let slide = match of.kind.is_rotational() {
                true => 0.0,
                false => limits[joint].lower.abs().max(limits[joint].upper.abs()),
            };
            beyond_m += of.frame.b_m.hypot(of.frame.d_m.abs() + slide);
        }
        all
    }

    /// Removes pairs of links that touch in every pose: shapes that are wider than their links, which no motion can part.
    fn without_lasting_contacts(&mut self, limits: &[MotionLimits]) {
        let frames: Vec<Vec<Isometry3<f64>>> =
            poses(limits, POSES).iter().map(|q| self.frames(q)).collect();
        let mut lasting = BTreeSet::new();
        let pairs = std::mem::take(&mut self.pairs);
        self.pairs = pairs
            .into_iter()
            .filter(|pair| {
                let (a, b) = (&self.solids[pair.near], &self.solids[pair.far]);
                let touches =
                    |frames: &Vec<Isometry3<f64>>| self.distance(pair, frames).0 < MARGIN_M;
                if a.is_region || !frames.iter().all(touches) {
                    return true;
                }
                lasting.insert(format!("{} and {}", a.name, b.name));
                false
            })
            .collect();
        if !lasting.is_empty() {
            let list: Vec<String> = lasting.into_iter().collect();
            self.notes.push(format!(
                "shapes that touch in every pose are not considered: {}",
                list.join("; ")
            ));
        }
    }

    /// Frames of the bodies in the base link, the base first.
    fn frames(&self, position: &[f64]) -> Vec<Isometry3<f64>> {
        std::iter::once(Isometry3::identity()).chain(self.chain.frames_in_base(position)).collect()
    }

    /// A lower bound of the distance, equal to it where the solids are near, with their nearest points in the base.
    fn distance(&self, pair: &Pair, frames: &[Isometry3<f64>]) -> (f64, Option<[Point3<f64>; 2]>) {
        let (a, b) = (&self.solids[pair.near], &self.solids[pair.far]);
        let place = |s: &Solid| frames[s.body] * s.pose;
        let (at_a, at_b) = (place(a), place(b));
        let between = (at_a.translation.vector - at_b.translation.vector).norm();
        let spheres = between - a.radius_m - b.radius_m;
        if spheres > FAR_M {
            return (spheres, None);
        }
        let largest = FAR_M + 2.0 * between + b.radius_m;
        match contact(&pose_of(&at_a), &*a.shape, &pose_of(&at_b), &*b.shape, largest) {
            Ok(Some(found)) => {
                let point = |p: Vector| Point3::new(p.x, p.y, p.z);
                (found.dist, Some([point(found.point1), point(found.point2)]))
            }
            // further than the largest distance; no pair of these shapes is unsupported
            Ok(None) => (largest, None),
            Err(_) => (f64::NEG_INFINITY, None),
        }
    }

    /// The nearest solids in a pose.
    pub(crate) fn nearest(&self, position: &[f64]) -> Nearest {
        let frames = self.frames(position);
        let mut nearest: Option<(f64, &Pair)> = None;
        for pair in &self.pairs {
            let (d, _) = self.distance(pair, &frames);
            if nearest.is_none_or(|(least, _)| d < least) {
                nearest = Some((d, pair));
            }
        }
        let (distance_m, names) = nearest
            .map_or((f64::INFINITY, [String::new(), String::new()]), |(d, pair)| {
                (d, [pair.near, pair.far].map(|k| self.solids[k].name.clone()))
            });
        Nearest { distance_m, names }
    }

    /// Sum over all pairs of `w(distance)` and its slope in the positions: `w` gives a penalty and its derivative.
    pub(crate) fn penalty(
        &self,
        position: &[f64],
        w: impl Fn(f64) -> (f64, f64),
    ) -> (f64, Vec<f64>) {
        let frames = self.frames(position);
        let (mut sum, mut slope) = (0.0, vec![0.0; position.len()]);
        for pair in &self.pairs {
            let (distance, points) = self.distance(pair, &frames);
            let (penalty, rate) = w(distance);
            if penalty <= 0.0 {
                continue;
            }
            sum += penalty;
            let Some([on_near, on_far]) = points else { continue };
            // from near to far, also where they overlap
            let Some(normal) = (on_far - on_near).try_normalize(1e-9) else { continue };
            let normal = normal * distance.signum();
            for &(joint, _) in &pair.reach {
                let frame = frames[joint + 1];
                let axis = frame.rotation * Vector3::z();
                let moved = match self.chain.joints[joint].kind.is_rotational() {
                    true => axis.cross(&(on_far.coords - frame.translation.vector)),
                    false => axis,
                };
                slope[joint] += rate * normal.dot(&moved);
            }
        }
        (sum, slope)
    }

    /// The smallest distance over a time as a lower bound, or the contact that is met.
    ///
    /// `state` gives positions and velocities of all joints at a time, `acceleration` bounds of their accelerations.
    pub(crate) fn along(
        &self,
        duration_s: f64,
        step_s: f64,
        acceleration: &[f64],
        state: impl Fn(f64) -> [Vec<f64>; 2],
    ) -> Result<f64, Nearest> {
        let steps = (duration_s / step_s).ceil().max(1.0) as usize;
        let half_s = 0.5 * duration_s / steps as f64;
        let mut open: Vec<(f64, f64, Option<Vec<usize>>)> =
            (0..steps).rev().map(|k| ((2 * k + 1) as f64 * half_s, half_s, None)).collect();
        let mut least = f64::INFINITY;
        while let Some((middle_s, half_s, pairs)) = open.pop() {
            let [position, velocity] = state(middle_s);
            let frames = self.frames(&position);
            let travel: Vec<f64> = velocity
                .iter()
                .zip(acceleration)
                .map(|(v, a)| half_s * (v.abs() + 0.5 * half_s * a))
                .collect();
            let all = 0..self.pairs.len();
            let considered = pairs.unwrap_or_else(|| all.collect());
            let mut near = Vec::new();
            for k in considered {
                let pair = &self.pairs[k];
                let (distance, _) = self.distance(pair, &frames);
                let way: f64 = pair.reach.iter().map(|&(joint, r)| r * travel[joint]).sum();
                if distance - way >= MARGIN_M {
                    least = least.min(distance - way);
                } else if distance < MARGIN_M || half_s < SHORTEST_S {
                    let names = [pair.near, pair.far].map(|k| self.solids[k].name.clone());
                    return Err(Nearest { distance_m: distance, names });
                } else {
                    near.push(k);
                }
            }
            if !near.is_empty() {
                let half_s = 0.5 * half_s;
                open.push((middle_s + half_s, half_s, Some(near.clone())));
                open.push((middle_s - half_s, half_s, Some(near)));
            }
        }
        Ok(least)
    }

    /// The pose nearest to the middle of the ranges that is free, among many spread over the ranges.
    ///
    /// # Errors
    /// [`ExcitationError::NoFreePose`] where none is: what is in the way of the one that is most nearly free.
    pub(crate) fn free_pose(&self, limits: &[MotionLimits]) -> Result<Vec<f64>, ExcitationError> {
        /// Distance from the margin that leaves room to move \[m\].
        const ROOM_M: f64 = 0.05;
        let mut best: Option<(f64, Vec<f64>, Nearest)> = None;
        for position in poses(limits, POSES) {
            let nearest = self.nearest(&position);
            let from_middle: f64 = position
                .iter()
                .zip(limits)
                .map(|(q, l)| ((q - l.middle()) / l.range().max(f64::MIN_POSITIVE)).powi(2))
                .sum();
            // room first, then the middle
            let room = (nearest.distance_m - MARGIN_M).min(ROOM_M);
            let worth = if room < ROOM_M { room } else { ROOM_M + 1.0 / (1.0 + from_middle) };
            if best.as_ref().is_none_or(|(most, _, _)| worth > *most) {
                best = Some((worth, position, nearest));
            }
        }
        match best {
            Some((_, position, nearest)) if nearest.distance_m > MARGIN_M => Ok(position),
            Some((_, _, nearest)) => {
                let missing_m = MARGIN_M - nearest.distance_m;
                Err(ExcitationError::NoFreePose { names: nearest.names, missing_m, tried: POSES })
            }
            None => Ok(limits.iter().map(MotionLimits::middle).collect()),
        }
    }
}

/// Poses that are spread evenly over the ranges, the middle first.
pub(crate) fn poses(limits: &[MotionLimits], count: usize) -> Vec<Vec<f64>> {
    // the root of x^(n+1) = x + 1 spreads points evenly in n dimensions (M. Roberts, 2018)
    let n = limits.len();
    let mut root = 2.0_f64;
    for _ in 0..50 {
        root = (1.0 + root).powf(1.0 / (n as f64 + 1.0));
    }
    (0..count)
        .map(|pose| {
            let share = |joint: usize| (0.5 + pose as f64 / root.powi(joint as i32 + 1)).fract();
            limits.iter().enumerate().map(|(j, l)| l.lower + share(j) * l.range()).collect()
        })
        .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;
    use crate::limits::motion_limits;
    use crate::test_arms::boxes;

    fn region(centre: [f64; 3], size: [f64; 3]) -> BTreeMap<String, KeepOut> {
        let region = KeepOut { centre: Some(centre), size: Some(size), ..KeepOut::default() };
        BTreeMap::from([("table".to_owned(), region)])
    }

    fn limits(chain: &DrivingAxisChain) -> Vec<MotionLimits> {
        motion_limits(chain, &BTreeMap::new()).unwrap().0
    }

    /// A plane below an arm that points up, its elbow free: as far as the shapes are.
    #[test]
    fn distances_are_those_of_the_shapes() {
        let chain = boxes();
        let plane = KeepOut {
            point: Some([0.0, 0.0, -0.3]),
            normal: Some([0.0, 0.0, 3.0]),
            ..KeepOut::default()
        };
        let floor = BTreeMap::from([("floor".to_owned(), plane)]);
        let limits = limits(&chain);
        let clearance = Clearance::of(&chain, &limits, &floor).unwrap().unwrap();
        // the column goes down to 0, the arms are above it
        let found = clearance.nearest(&[0.0, 0.0, 0.0]);
        assert!((found.distance_m - 0.3).abs() < 1e-6, "{found:?}");
        // the forearm folded back ends 0.4 m below the elbow at 0.9 m, and the column at 0.4 m
        let folded = clearance.nearest(&[0.0, 0.0, std::f64::consts::PI]);
        assert!((folded.distance_m - 0.1).abs() < 1e-6, "{folded:?}");
        assert!(folded.names[1].contains("forearm"), "{folded:?}");
    }

    /// The slope of the penalty is its derivative.
    #[test]
    fn penalty_slope_is_its_derivative() {
        let chain = boxes();
        let limits = limits(&chain);
        let table = region([0.6, 0.0, 0.1], [0.5, 1.0, 0.1]);
        let clearance = Clearance::of(&chain, &limits, &table).unwrap().unwrap();
        let w = |d: f64| ((0.3 - d).max(0.0).powi(2), -2.0 * (0.3 - d).max(0.0));
        let pose = [0.3, 1.1, 0.7];
        let (_, slope) = clearance.penalty(&pose, w);
        let h = 1e-6;
        for joint in 0..3 {
            let at = |h: f64| {
                let mut moved = pose;
                moved[joint] += h;
                clearance.penalty(&moved, w).0
            };
            let expected = (at(h) - at(-h)) / (2.0 * h);
            assert!((slope[joint] - expected).abs() < 1e-4, "{joint}: {slope:?} {expected}");
        }
    }

    /// The bound is below the distance at every time, and a sweep through the table is met however fast it passes.
    #[test]
    fn contacts_between_samples_are_met() {
        let chain = boxes();
        let limits = limits(&chain);
        let table = region([0.8, 0.0, 0.5], [0.05, 0.05, 2.0]);
        let clearance = Clearance::of(&chain, &limits, &table).unwrap().unwrap();
        // the arm level, swinging past the post at up to 60 rad/s: 3 rad between two steps of the check
        let turn = |t: f64| 1.0 + 2.0 * (30.0 * t).sin();
        let state = |reach: f64| {
            move |t: f64| [vec![turn(t), 1.2 * reach, 0.3], vec![60.0 * (30.0 * t).cos(), 0.0, 0.0]]
        };
        let most = [1800.0, 0.0, 0.0];
        let met = clearance.along(0.5, 0.05, &most, state(1.0)).unwrap_err();
        assert!(met.names[0].contains("table"), "{met:?}");
        let least = clearance.along(0.5, 0.05, &most, state(0.0)).unwrap();
        let sampled = (0..5000)
            .map(|k| clearance.nearest(&state(0.0)(f64::from(k) * 1e-4)[0]).distance_m)
            .fold(f64::INFINITY, f64::min);
        assert!(least <= sampled && least >= MARGIN_M, "{least} {sampled}");
    }

    #[test]
    fn arm_inside_a_region_has_no_free_pose() {
        let chain = boxes();
        let limits = limits(&chain);
        let all = region([0.0, 0.0, 0.0], [9.0, 9.0, 9.0]);
        let clearance = Clearance::of(&chain, &limits, &all).unwrap().unwrap();
        let error = clearance.free_pose(&limits).unwrap_err().to_string();
        assert!(error.contains("keep-out `table`"), "{error}");
    }
}
