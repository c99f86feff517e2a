//! The chain in link frames: what both formats are written from.

use armident_kinematics::{InertialParameters, JointKind, JointLimits};
use armident_model::ArmModel;
use nalgebra::{Isometry3, Translation3, Vector3};

/// Lengths \[m\] and entries of directions below this are round-off of the frames.
const ROUND_OFF: f64 = 1e-15;

/// A joint with the link it moves, in the link's frame.
pub(crate) struct Moved<'a> {
    pub(crate) joint: &'a str,
    pub(crate) kind: JointKind,
    pub(crate) link: &'a str,
    /// pose of the link frame in the one before it, at q = 0
    pub(crate) pose: Isometry3<f64>,
    /// axis in the link frame
    pub(crate) axis: Vector3<f64>,
    pub(crate) inertia: InertialParameters,
    pub(crate) limits: JointLimits,
}

/// The joints in order, and the pose of the tip link in the last moved link.
pub(crate) fn moved(model: &ArmModel) -> (Vec<Moved<'_>>, Isometry3<f64>) {
    let chain = &model.chain;
    let mut e_from_link_before = chain.base_from_e0.inverse();
    let mut list = Vec::with_capacity(chain.dof());
    for (i, joint) in chain.joints.iter().enumerate() {
        let mut e_from_link = joint.child_link_in_e;
        if joint.kind.is_rotational() {
            // on the axis to the last bit: snapped lengths have left it by a micrometre
            e_from_link.translation = Translation3::new(0.0, 0.0, e_from_link.translation.z);
        }
        let pose = e_from_link_before.inverse() * chain.parent_from_e(i, 0.0) * e_from_link;
        list.push(Moved {
            joint: &joint.name,
            kind: joint.kind,
            link: &joint.child_link,
            pose: clean_pose(pose),
            axis: clean(e_from_link.rotation.inverse() * Vector3::z()).normalize(),
            inertia: joint.link.expressed_in(&e_from_link.inverse()),
            limits: joint.limits,
        });
        e_from_link_before = e_from_link;
    }
    (list, clean_pose(e_from_link_before.inverse() * chain.tip_in_e))
}

/// Whether the tip is a link of its own behind the last moved one.
pub(crate) fn has_own_tip(model: &ArmModel) -> bool {
    model.chain.joints.last().is_some_and(|last| last.child_link != model.chain.tip_link)
}

fn clean(v: Vector3<f64>) -> Vector3<f64> {
    v.map(|x| if x.abs() < ROUND_OFF { 0.0 } else { x })
}

fn clean_pose(pose: Isometry3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(clean(pose.translation.vector).into(), pose.rotation)
}

/// Inertia about the centre of mass as `ixx ixy ixz iyy iyz izz`; notes if it is not physically consistent.
pub(crate) fn inertia_about_com(link: &Moved<'_>, notes: &mut Vec<String>) -> [f64; 6] {
    if !link.inertia.is_physical() {
        notes.push(format!(
            "link `{}` is not physically consistent and may be rejected by simulators; omit \
             --raw-estimate to project it",
            link.link
        ));
    }
    let i = link.inertia.inertia_com_kgm2();
    [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]
}

/// Gravity of every reader that has one of its own \[m/s2\].
const USUAL_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A note where the gravity of a model is not the usual one and the format has none, which `why` states.
pub(crate) fn gravity_note(model: &ArmModel, why: &str) -> Option<String> {
    let g = model.chain.gravity_base;
    let is_usual = (g - USUAL_GRAVITY).norm() <= 1e-9;
    (!is_usual).then(|| format!("{why}: set ({}, {}, {}) m/s2", g.x, g.y, g.z))
}

/// What a file cannot say beside effects.
pub(crate) fn notes(model: &ArmModel) -> Vec<String> {
    let chain = &model.chain;
    let mut notes = Vec::new();
    for joint in &chain.joints {
        let lumped: Vec<&str> = joint
            .body_links
            .iter()
            .map(String::as_str)
            .filter(|l| *l != joint.child_link)
            .collect();
        if !lumped.is_empty() {
            notes.push(format!("{} merged into link `{}`", lumped.join(", "), joint.child_link));
        }
    }
    if !chain.locked.is_empty() {
        let list: Vec<String> = chain.locked.iter().map(|(j, q)| format!("{j} at {q}")).collect();
        notes.push(format!("locked joints removed: {}", list.join(", ")));
    }
    notes
}
