//! The parameters of a batch fit as plain data: which there are, and how they are numbered.
//!
//! Every other file of the fit names parameters by these types; they depend on the effect library alone.

use armident_effects::{BASELINE, Effect, JointCoupling, Parameter, SublinearViscousFriction};

/// Laws of one joint whose parameters may be unknowns: those that every joint has, then those that recordings may call
/// for ([`choose_structure`](crate::BatchProblem::choose_structure)).
pub const LAWS: [&dyn Effect; 5] = {
    let [viscous, coulomb, offset, inertia] = BASELINE else { panic!("four baseline laws") };
    [*viscous, *coulomb, *offset, *inertia, &SublinearViscousFriction]
};

/// The law of a shared transmission.
pub(crate) const SHARED: &dyn Effect = &JointCoupling;

/// A transmission shared by a joint and the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// The first of both joints, from 0.
    pub first: usize,
    /// Speed of the common shaft: that of the second joint and `ratio` times that of the first.
    pub ratio: f64,
}

impl Coupling {
    /// The law's name in files.
    pub fn slug() -> &'static str {
        SHARED.law().slug
    }

    /// Both joints.
    pub fn joints(self) -> [usize; 2] {
        [self.first, self.first + 1]
    }

    /// Its coefficients.
    pub(crate) fn terms(self) -> impl Iterator<Item = Term> {
        (0..SHARED.law().parameters.len() - 1)
            .map(move |coefficient| Term::Shared { coupling: self, coefficient })
    }
}

/// One unknown of the batch problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Term {
    /// A constant of the minimal set, by index.
    Constant(usize),
    /// A parameter of an effect on a joint.
    Effect {
        /// Joint, from 0.
        joint: usize,
        /// Effect, index into [`LAWS`].
        effect: usize,
        /// Parameter, index into the law's list.
        parameter: usize,
    },
    /// A coefficient of the transmission that a joint shares with the next ([`Coupling`]).
    Shared {
        /// Which.
        coupling: Coupling,
        /// Coefficient, index into the law's columns.
        coefficient: usize,
    },
    /// A parameter of a load on the last link that is not known ([`KnownLoad`](crate::KnownLoad)).
    Load {
        /// Which, index into the loads with unknowns.
        load: usize,
        /// Number of the ten parameters of a body, 1 to 9.
        number: usize,
    },
}

impl Term {
    /// The parameter of the law; none where there is no law.
    pub fn parameter(&self) -> Option<&'static Parameter> {
        match *self {
            Self::Constant(_) | Self::Load { .. } => None,
            Self::Effect { effect, parameter, .. } => LAWS[effect].law().parameters.get(parameter),
            // the ratio comes first
            Self::Shared { coefficient, .. } => SHARED.law().parameters.get(1 + coefficient),
        }
    }
}

/// An unknown that is the same as a combination of others on every motion of this arm.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedTerm {
    /// The unknown that is not estimated on its own.
    pub term: Term,
    /// What it adds to: (index into [`BatchProblem::terms`](crate::BatchProblem::terms), coefficient).
    pub into: Vec<(usize, f64)>,
}
