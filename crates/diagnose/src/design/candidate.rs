//! A candidate: one law, body or smooth term at a location, and its columns.

use armident_effects::{Effect, Law, LawRole, LinkSide, Scope, UNMODELLED};
use armident_model::SmoothBasis;

/// Where a candidate acts.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Location {
    /// joints, base to tip; empty for the whole arm
    pub(crate) joints: Vec<usize>,
    /// recording, and window in its time
    pub(crate) window: Option<(usize, [f64; 2])>,
}

/// Law or smooth term of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum CandidateKind {
    /// A law of the library.
    Law(&'static dyn Effect),
    /// A smooth term of these variables.
    SmoothDirections(SmoothDirections),
}

/// A law at a location with a shape: the columns that it adds.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) kind: CandidateKind,
    pub(crate) location: Location,
    pub(crate) shape: Vec<f64>,
    /// ids of columns
    pub(crate) columns: Vec<usize>,
    /// constants that were searched
    pub(crate) searched: usize,
    pub(crate) places: Vec<LawRole>,
    /// parameters from coefficients: `10 x columns`, for links
    pub(crate) transform: Option<Vec<Vec<f64>>>,
    /// directions of these that are not excited, each with its prior deviation
    pub(crate) hidden: Vec<Vec<f64>>,
    /// root mean square of its effort as recorded over that in the band, 1 or more: impacts in a gap are
    /// mostly above it
    pub(crate) above_band: f64,
    /// whether the coefficient of its first column is 1 and not fitted
    pub(crate) is_of_size_one: bool,
}

impl Candidate {
    pub(crate) fn slug(&self) -> &'static str {
        match &self.kind {
            CandidateKind::Law(law) => law.slug(),
            CandidateKind::SmoothDirections(_) => UNMODELLED,
        }
    }

    /// Its law; none of a smooth term.
    pub(crate) fn law(&self) -> Option<&'static dyn Effect> {
        match &self.kind {
            CandidateKind::Law(law) => Some(*law),
            CandidateKind::SmoothDirections(_) => None,
        }
    }

    /// Whether it is of this law.
    pub(crate) fn is(&self, law: &dyn Effect) -> bool {
        self.slug() == law.slug()
    }

    /// Whether its law has a property; a smooth term has none.
    pub(crate) fn has(&self, property: impl FnOnce(&'static Law) -> bool) -> bool {
        self.law().is_some_and(|law| property(law.law()))
    }

    /// Whether it is a transmission with something of this kind between motor and link.
    pub(crate) fn has_link_side(&self, side: LinkSide) -> bool {
        self.has(|law| law.has_link_side(side))
    }

    /// Whether a link moves relative to its motor: a law of a transmission with a shape.
    pub(crate) fn moves_its_link(&self) -> bool {
        !self.shape.is_empty() && self.has(|law| law.scope == Scope::ThroughJoint)
    }

    /// Adds what coefficients of the candidate change of the links' standard parameters, `10` a link.
    pub(crate) fn add_to_links(&self, coefficients: &[f64], change: &mut [f64]) {
        let (Some(transform), Some(link)) = (&self.transform, self.location.joints.first()) else {
            return;
        };
        for (direction, c) in transform.iter().zip(coefficients) {
            for (sum, d) in change[10 * link..].iter_mut().zip(direction) {
                *sum += d * c;
            }
        }
    }

    /// Whether it is a load on a link or an error of one, at all times.
    pub(crate) fn is_of_link(&self) -> bool {
        self.location.window.is_none() && self.places.contains(&LawRole::Link)
    }

    /// Whether the two exclude each other.
    pub(crate) fn excludes(&self, other: &Self) -> bool {
        let same_location = match (&self.location.window, &other.location.window) {
            (Some(a), Some(b)) => a.0 == b.0,
            (None, None) => self.location.joints == other.location.joints,
            _ => false,
        };
        same_location && self.places.iter().any(|p| other.places.contains(p))
    }
}

/// A smooth term in the search: its basis, and the coefficients of the hats from those of the columns, `[column][hat]`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SmoothDirections {
    pub(crate) basis: SmoothBasis,
    pub(crate) transform: Vec<Vec<f64>>,
}
