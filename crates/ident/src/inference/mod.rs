//! Statistics that know no robot: folds, paired gains, block jackknife, quantiles, effective sample size, whiteness.

pub(crate) mod effective_sample_size;
pub(crate) mod folds;
pub(crate) mod jackknife;
pub(crate) mod paired_gain;
pub(crate) mod quantiles;
pub(crate) mod whiteness;
