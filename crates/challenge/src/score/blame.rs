//! An effect at a place: what is compared between answer and truth.

use std::collections::BTreeSet;

use armident_effects::{Scope, UNMODELLED, effect};

use crate::contract::answer::AnswerFinding;
use crate::contract::truth::{Named, TrueEffect, Truth};
use crate::hidden::UNLISTED;

/// The place of an effect.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// On a joint.
    Joint(String),
    /// Between two joints, in alphabetical order.
    Pair(String, String),
    /// On the body that this joint moves.
    Body(String),
    /// Everywhere.
    Arm,
    /// On a link that no joint moves, or nowhere: never right.
    Unknown(String),
}

/// An effect at a place: one unit of precision and recall.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Blame {
    /// Slug; `unlisted` laws are answered as `unmodelled`.
    pub effect: String,
    /// Where.
    pub place: Place,
}

impl std::fmt::Display for Blame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.place {
            Place::Joint(joint) => write!(f, "{}({joint})", self.effect),
            Place::Pair(a, b) => write!(f, "{}({a}, {b})", self.effect),
            Place::Body(joint) => write!(f, "{}(body of {joint})", self.effect),
            Place::Arm => write!(f, "{}", self.effect),
            Place::Unknown(what) => write!(f, "{}({what}?)", self.effect),
        }
    }
}

impl Blame {
    /// Joints that are blamed.
    pub(crate) fn joints(&self) -> Vec<&str> {
        match &self.place {
            Place::Joint(joint) | Place::Body(joint) => vec![joint],
            Place::Pair(a, b) => vec![a, b],
            Place::Unknown(what) => vec![what],
            Place::Arm => Vec::new(),
        }
    }

    /// Whether this is baseline friction, which every joint of a field case has.
    pub(crate) fn is_baseline(&self) -> bool {
        effect(&self.effect).is_some_and(|effect| effect.law().is_baseline_friction())
    }

    /// Whether a wrong body is blamed.
    pub(crate) fn is_body(&self) -> bool {
        is_body(&self.effect)
    }
}

/// Effects that are located by their link.
pub(crate) fn is_body(slug: &str) -> bool {
    effect(slug).is_some_and(|effect| effect.law().scope == Scope::Link)
}

/// One blame a joint; neighbours, bodies and effects of the whole arm are one.
pub(crate) fn blames(
    slug: &str,
    joints: &[String],
    link: Option<&str>,
    truth: &Truth,
) -> BTreeSet<Blame> {
    let slug = if slug == UNLISTED { UNMODELLED } else { slug };
    let at = |place| Blame { effect: slug.to_owned(), place };
    let unknown = |what: &str| at(Place::Unknown(what.to_owned()));
    // what the library does not have is located by its joints
    match effect(slug).map_or(Scope::Joint, |effect| effect.law().scope) {
        Scope::Arm => [at(Place::Arm)].into(),
        Scope::Neighbours => {
            let mut pair = joints.to_vec();
            pair.sort();
            match <[String; 2]>::try_from(pair) {
                Ok([a, b]) => [at(Place::Pair(a, b))].into(),
                Err(other) => [unknown(&other.join(" "))].into(),
            }
        }
        Scope::Link => match (link, joints) {
            (Some(link), _) if truth.joint_of_link(link).is_some() => {
                let joint = truth.joint_of_link(link).unwrap_or_default();
                [at(Place::Body(joint.to_owned()))].into()
            }
            (Some(link), []) => [unknown(link)].into(),
            (None, []) => [unknown("no link")].into(),
            (_, joints) => joints.iter().map(|joint| at(Place::Body(joint.clone()))).collect(),
        },
        _ if joints.is_empty() => [unknown("no joint")].into(),
        Scope::Joint | Scope::ThroughJoint => {
            joints.iter().map(|joint| at(Place::Joint(joint.clone()))).collect()
        }
    }
}

/// Blames of a hidden effect.
pub(crate) fn of_truth(effect: &TrueEffect, truth: &Truth) -> BTreeSet<Blame> {
    blames(&effect.effect, &effect.joints, effect.link.as_deref(), truth)
}

/// Blames of a finding.
pub(crate) fn of_finding(finding: &AnswerFinding, truth: &Truth) -> BTreeSet<Blame> {
    blames(&finding.effect, &finding.joints, finding.link.as_deref(), truth)
}

/// Blames of an entry of `accept` or `alternatives`.
pub(crate) fn of_named(named: &Named, truth: &Truth) -> BTreeSet<Blame> {
    blames(&named.effect, &named.joints, named.link.as_deref(), truth)
}

/// Whether a blame is what an entry of `tolerate` allows; without joints it is allowed anywhere.
pub(crate) fn tolerated_by(blame: &Blame, named: &Named) -> bool {
    let here = |joint: &str| named.joints.iter().any(|j| j == joint);
    blame.effect == named.effect
        && (named.joints.is_empty() || blame.joints().iter().all(|joint| here(joint)))
}
