//! The structure of the batch problem, chosen on the training recordings.
//!
//! Method: cross-validation on five contiguous folds of time. Each fold is predicted by a fit to the other four; that
//! decides the reversal of each joint's dry friction ([`reversal`](super::reversal)), which neighbours share a
//! transmission ([`coupling`](super::coupling)), and whose viscous friction is sublinear
//! ([`sublinear`](super::sublinear)). Training errors would decide for whatever has more parameters. The prior scale is
//! estimated on all folds together.
//!
//! References: own.

use armident_motion::Motion;
use armident_numeric::NumericError;

use super::coupling::CouplingFound;
use super::fold_errors::has_folds;
use super::reversal::{ReversalCandidates, least_gain};
use super::sublinear::SublinearFound;
use crate::regression::{BatchProblem, BatchSettings};

/// What is sought beside the reversals of dry friction and the prior scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StructureSearch {
    /// Transmissions that neighbours share.
    pub couplings: bool,
    /// Joints whose viscous friction is sublinear.
    pub sublinear: bool,
}

impl StructureSearch {
    /// Everything.
    pub const ALL: Self = Self { couplings: true, sublinear: true };
    /// Reversals and prior scale only.
    pub const NOTHING: Self = Self { couplings: false, sublinear: false };
}

/// The structure that the recordings show.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// Transmissions that neighbours share, the clearest first.
    pub couplings: Vec<CouplingFound>,
    /// Joints whose viscous friction is sublinear, in their order.
    pub sublinear: Vec<SublinearFound>,
    /// The settings, with the prior scale that the recordings make most likely.
    pub settings: BatchSettings,
}

impl BatchProblem {
    /// Chooses the reversal of each joint's dry friction and, where sought, the transmissions that neighbours share and the
    /// joints with sublinear viscous friction, which become unknowns of this problem; and estimates the prior scale, where
    /// the settings have a link prior at all. Costs one accumulation with some columns more.
    ///
    /// # Errors
    /// [`NumericError`] when a number is not finite.
    ///
    /// # Panics
    /// When a motion has no effort or other joints than the arm.
    pub fn choose_structure(
        &mut self,
        motions: &[&Motion],
        settings: &BatchSettings,
        search: StructureSearch,
    ) -> Result<Structure, NumericError> {
        let mut chosen =
            Structure { couplings: Vec::new(), sublinear: Vec::new(), settings: *settings };
        let couplings = if search.couplings { self.coupling_candidates() } else { Vec::new() };
        let sublinear = if search.sublinear { self.sublinear_candidates() } else { Vec::new() };
        let all = self.with_couplings(&couplings).with_sublinear(&sublinear);
        let candidates = ReversalCandidates::of(self, motions);
        self.reversals = candidates.usual();
        let rows = all.rows_with_directions(motions, &candidates);
        if !has_folds(&rows) {
            return Ok(chosen);
        }
        let mut with = self.clone();
        let mut chosen_reversals =
            all.choose_reversals(&rows, &with, (&candidates, least_gain), settings)?;
        if search.couplings {
            chosen.couplings = self.couplings_shown(&all, &chosen_reversals.rows, settings)?;
        }
        if !chosen.couplings.is_empty() {
            let found: Vec<_> = chosen.couplings.iter().map(|f| f.coupling).collect();
            with = self.with_couplings(&found);
            chosen_reversals =
                all.choose_reversals(&rows, &with, (&candidates, least_gain), settings)?;
        }
        if search.sublinear {
            chosen.sublinear = with.sublinear_shown(&all, &chosen_reversals.rows, settings)?;
        }
        if !chosen.sublinear.is_empty() {
            let found: Vec<usize> = chosen.sublinear.iter().map(|f| f.joint).collect();
            with = with.with_sublinear(&found);
            chosen_reversals =
                all.choose_reversals(&rows, &with, (&candidates, least_gain), settings)?;
        }
        if settings.link_prior.is_some() {
            let rows = chosen_reversals.rows.select(&all, &with);
            let link_prior = with.estimate_prior_scale(&rows, settings)?;
            chosen.settings = BatchSettings { link_prior, ..*settings };
        }
        with.reversals = chosen_reversals.reversals;
        *self = with;
        Ok(chosen)
    }
}
