//! The acceptance suite. One binary; each module is one promise of the tool.

/// where the optional shared data lies, and how a skipped test says so
mod shared;

/// chain, constants, minimal set and states against numbers of an independent program
mod golden;
