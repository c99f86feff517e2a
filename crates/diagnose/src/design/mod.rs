//! Recordings and laws to the columns of a weighted linear problem.

pub(crate) mod bodies;
pub(crate) mod candidate;
pub(crate) mod comparison;
pub(crate) mod compliant_link;
pub(crate) mod contact;

pub(crate) mod known_effort;
pub(crate) mod linear_problem;
pub(crate) mod link_error_prior;
pub(crate) mod observations;
pub(crate) mod placeholder;
pub(crate) mod rebuild;
pub(crate) mod ripple;
pub(crate) mod smooth;
pub(crate) mod training;
pub(crate) mod transmission;
