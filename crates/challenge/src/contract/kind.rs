//! Kinds of cases.

/// Kind of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaseKind {
    /// One or two effects on an otherwise exact arm, clean recordings.
    Clean,
    /// Baseline friction on every joint, inertial errors of every link, recordings with faults.
    Field,
    /// A field arm with up to four effects, slower recordings with more faults, standstills, and joints that barely move.
    Hard,
    /// A field arm recorded before and after: the hidden effect came between, and the friction of an arm that has warmed
    /// up or cooled down.
    Change,
}

impl CaseKind {
    /// Whether joints rub, clocks are uneven and inertials are wrong.
    pub(crate) fn is_field(self) -> bool {
        self != Self::Clean
    }

    /// Name in tables and answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Field => "field",
            Self::Hard => "hard",
            Self::Change => "change",
        }
    }
}
