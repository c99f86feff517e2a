//! What a user should know although the result was computed.

use std::fmt;

/// One doubtful thing found on the way, with the place it concerns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Stable short name, for filters and tests (`inertia-unphysical`, `snap-missed`, ...).
    pub code: &'static str,
    /// One sentence that names the place and what to do.
    pub message: String,
}

impl Warning {
    /// A warning with its stable code.
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} [{}]", self.message, self.code)
    }
}
