//! A description of structure that no law of the library explains.

/// Variables of a flexible description.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Flexible {
    /// what it depends on
    pub(crate) variables: Vec<Variable>,
}

/// A recorded column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Variable {
    /// Position of a joint.
    Position(usize),
    /// Velocity of a joint.
    Velocity(usize),
}

/// A flexible description with its numbers, as a model file holds it.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub struct FlexibleTerm {
    /// Joint whose effort it describes.
    pub joint: String,
}

impl FlexibleTerm {
    pub(crate) fn effort(
        &self,
        at: &crate::evidence::At<'_>,
        _index: impl Fn(&str) -> Option<usize>,
    ) -> Vec<f64> {
        vec![0.0; at.signals.len()]
    }
}
