//! Candidates formed again in another problem.

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::compliant_link::Posed;
use crate::design::contact::ContactColumns;
use crate::design::linear_problem::LinearProblem;
use crate::design::smooth::push_smooth;
use crate::design::training::Design;
use crate::design::transmission::push_transmission;
use armident_effects::{Effect, Scope};

/// The same candidate in a new problem.
pub(crate) fn recreate(
    design: &Design<'_>,
    at: &[Posed<'_>],
    contact: &ContactColumns,
    problem: &mut LinearProblem,
    candidate: &Candidate,
) -> Option<usize> {
    match candidate.location.window {
        Some((recording, window)) => known(problem.candidates.iter(), candidate).or_else(|| {
            let id = contact.push(design, problem, recording, window);
            problem.candidates[id].searched = candidate.searched;
            Some(id)
        }),
        None => recreate_lasting(design, at, problem, candidate),
    }
}

/// The same candidate in a new problem, of one that acts at all times.
pub(crate) fn recreate_lasting(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    candidate: &Candidate,
) -> Option<usize> {
    known(problem.candidates.iter(), candidate).or_else(|| match &candidate.kind {
        CandidateKind::Law(law) => {
            let id = formed(design, at, problem, *law, candidate)?;
            problem.candidates[id].searched = candidate.searched;
            Some(id)
        }
        CandidateKind::SmoothDirections(flexible) => {
            let joint = candidate.location.joints[0];
            Some(push_smooth(design, at, problem, joint, flexible))
        }
    })
}

/// The place of the candidate that is the same already.
pub(crate) fn known<'g>(
    mut candidates: impl Iterator<Item = &'g Candidate>,
    candidate: &Candidate,
) -> Option<usize> {
    candidates.position(|other| {
        other.kind == candidate.kind
            && other.location == candidate.location
            && other.shape == candidate.shape
    })
}

/// A law of joints with the shape of a candidate, added to a problem.
pub(crate) fn formed(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    law: &'static dyn Effect,
    candidate: &Candidate,
) -> Option<usize> {
    let joint = *candidate.location.joints.first()?;
    match law.law().scope {
        Scope::Joint => design.push_joint_law(problem, at, law, joint, &candidate.shape),
        Scope::Neighbours => Some(design.push_pair_law(problem, at, law, joint, &candidate.shape)),
        Scope::ThroughJoint if !candidate.shape.is_empty() => {
            push_transmission(design, at, problem, law, joint, &candidate.shape, &mut Vec::new())
        }
        _ => None,
    }
}

/// How many of a candidate's shape constants are continuous, from the first on.
pub(crate) fn continuous(candidate: &Candidate) -> usize {
    let Some(law) = candidate.law() else { return 0 };
    (0..candidate.shape.len()).take_while(|constant| law.shape_step(*constant).is_some()).count()
}
