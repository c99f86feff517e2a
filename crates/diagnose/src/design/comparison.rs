//! The side that recordings are compared with.

/// The side that recordings are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Comparison {
    /// A model: all recordings are judged.
    AgainstModel,
    /// Reference recordings of the same arm: those before `from` show it as it was, and only a change is sought.
    AgainstReference {
        /// First recording that is judged.
        from: usize,
    },
}

impl Comparison {
    /// Whether only a change is sought.
    pub(crate) fn seeks_change(self) -> bool {
        self != Self::AgainstModel
    }

    /// First recording that is judged.
    pub(crate) fn first_judged(self) -> usize {
        match self {
            Self::AgainstModel => 0,
            Self::AgainstReference { from } => from,
        }
    }
}
