//! Sections on what the diagnosed model holds beside the findings.

mod bandwidth;
mod detail;
mod effort_clock;
mod effort_low_pass;
mod link_errors;
mod placeholders;
mod presliding;
mod projection;
mod regularised_coulomb;
mod small_terms;
mod sublinear_viscous;
mod transmissions;

pub(super) use bandwidth::ComparisonBandwidth;
pub(super) use effort_clock::ClockOfEfforts;
pub(super) use effort_low_pass::LowPassedEfforts;
pub(super) use link_errors::LinkErrors;
pub(super) use placeholders::PlaceholderLinks;
pub(super) use presliding::Presliding;
pub(super) use projection::Projection;
pub(super) use regularised_coulomb::RegularisedCoulomb;
pub(super) use small_terms::SmallTerms;
pub(super) use sublinear_viscous::SublinearViscous;
pub(super) use transmissions::Transmissions;
