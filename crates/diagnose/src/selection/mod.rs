//! Which effects the recordings ask for.

pub(crate) mod bandwidth_test;
pub(crate) mod beam_search;
pub(crate) mod change_significance;
pub(crate) mod cross_validation;
pub(crate) mod iterate;
pub(crate) mod materiality;
pub(crate) mod prior_scale;
pub(crate) mod refine_shape;
pub(crate) mod reversal;
pub(crate) mod rivals;
pub(crate) mod simulated_candidates;
pub(crate) mod solution;
pub(crate) mod sublinear;
pub(crate) mod surrogate_threshold;
pub(crate) mod weights;
