//! Candidates formed again in another problem.

use crate::design::candidate::{Group, Meaning};
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::design::smooth::push_smooth;
use crate::design::transmission::push_transmission;
use armident_effects::{Scope, effect};
/// The group of a new problem that stands for the same.
pub(crate) fn recreate(
    evidence: &Evidence<'_>,
    at: &[Posed<'_>],
    contact: &ContactColumns,
    problem: &mut Problem,
    group: &Group,
) -> Option<usize> {
    match group.site.window {
        Some((recording, window)) => known(problem.groups.iter(), group).or_else(|| {
            let id = contact.push(evidence, problem, recording, window);
            problem.groups[id].searched = group.searched;
            Some(id)
        }),
        None => recreate_lasting(evidence, at, problem, group),
    }
}

/// The same of what acts at all times.
pub(crate) fn recreate_lasting(
    evidence: &Evidence<'_>,
    at: &[Posed<'_>],
    problem: &mut Problem,
    group: &Group,
) -> Option<usize> {
    known(problem.groups.iter(), group).or_else(|| match &group.meaning {
        Meaning::Law(slug) => {
            let id = formed(evidence, at, problem, slug, group)?;
            problem.groups[id].searched = group.searched;
            Some(id)
        }
        Meaning::SmoothDirections(flexible) => {
            let joint = group.site.joints[0];
            Some(push_smooth(evidence, at, problem, joint, flexible))
        }
    })
}

/// The place of the group that is the same already.
pub(crate) fn known<'g>(
    mut groups: impl Iterator<Item = &'g Group>,
    group: &Group,
) -> Option<usize> {
    groups.position(|other| {
        other.meaning == group.meaning && other.site == group.site && other.shape == group.shape
    })
}

/// A law of joints with the shape of a group, added to a problem.
pub(crate) fn formed(
    evidence: &Evidence<'_>,
    at: &[Posed<'_>],
    problem: &mut Problem,
    slug: &'static str,
    group: &Group,
) -> Option<usize> {
    let law = effect(slug)?;
    let joint = *group.site.joints.first()?;
    match law.law().scope {
        Scope::Joint => evidence.push_joint_law(problem, at, law, joint, &group.shape),
        Scope::Neighbours => Some(evidence.push_pair_law(problem, at, law, joint, &group.shape)),
        Scope::ThroughJoint if !group.shape.is_empty() => {
            push_transmission(evidence, at, problem, slug, joint, &group.shape, &mut Vec::new())
        }
        _ => None,
    }
}

/// How many of a group's shape constants are numbers that can be polished: those of a ripple after its order say which
/// harmonics it has.
pub(crate) fn continuous(group: &Group) -> usize {
    if group.slug() == "torque_ripple" { 1 } else { group.shape.len() }
}
