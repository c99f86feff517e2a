//! Warnings: doubtful inputs that do not prevent a result.

use std::fmt;

/// One warning with its stable code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Stable short name, for filters and tests (`inertia-unphysical`, `snap-missed`, ...).
    pub code: &'static str,
    /// One sentence with the place, the consequence and how to change it.
    pub message: String,
    /// Links or joints it concerns, by name; empty if it concerns none in particular.
    pub subjects: Vec<String>,
}

impl Warning {
    /// Creates a warning without subjects.
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), subjects: Vec::new() }
    }

    /// Sets the links or joints that the warning concerns.
    pub fn about(mut self, subjects: impl IntoIterator<Item = String>) -> Self {
        self.subjects = subjects.into_iter().collect();
        self
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} [{}]", self.message, self.code)
    }
}
