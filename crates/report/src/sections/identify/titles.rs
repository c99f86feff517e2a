//! Titles that sections share on the page.

/// Title of the page's section on the parameters.
pub(super) const MINIMAL_SET: &str = "Minimal set";
/// Title of the page's section on the fit.
pub(super) const FIT: &str = "Fit";
