//! The levels that comparisons must exceed, with the reason of each.
//!
//! | level | `identify` | `diagnose` |
//! | --- | --- | --- |
//! | [`CLEAR_T`] | friction that reverses more slowly than usual, a shared transmission | friction that reverses slowly on a joint with standstills, a change, a rival that explains more |
//! | [`EXPECTED_T`] | friction that reverses sooner, as its law says | friction that reverses slowly elsewhere, another prior scale of the prediction |
//! | [`CHANGE_ERROR`] | | a change that is none, a surrogate term that passes for an effect |
//! | [`SPECIFICATION_ERROR`] | | a right model that the Hausman test of two bands rejects |

/// Standard errors by which a gain on left-out folds must exceed nothing where several candidates are tried: one standard
/// error is exceeded by chance by one of six.
pub const CLEAR_T: f64 = 2.0;

/// Standard errors where physics expects the candidate, so that a smaller gain is believed.
pub const EXPECTED_T: f64 = 1.0;

/// Probability of a change that is none, among all that are tried.
pub const CHANGE_ERROR: f64 = 0.01;

/// Probability that a specification test rejects a right model: rare, because what follows is a narrower band, in which
/// less is seen.
pub const SPECIFICATION_ERROR: f64 = 1e-3;
