//! What each named effect of an answer is: right, tolerated, baseline friction or false.

use std::collections::BTreeSet;

use armident_effects::{Effect, LinkInertiaError, TimeDelay};

use crate::contract::answer::AnswerFinding;
use crate::contract::truth::{Named, TrueEffect, Truth};
use crate::score::blame::{Blame, is_body, of_finding, of_named, of_truth, tolerated_by};

/// Findings of less confidence do not count.
const LEAST_CONFIDENCE: f64 = 0.5;

/// What each blame of an answer turns out to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Judgement {
    Right,
    Tolerated,
    Baseline,
    False,
}

pub(crate) struct Judged<'a> {
    pub(crate) findings: Vec<(&'a AnswerFinding, BTreeSet<Blame>)>,
    pub(crate) found: BTreeSet<Blame>,
    right: BTreeSet<Blame>,
    tolerated: BTreeSet<Blame>,
    pub(crate) baseline: BTreeSet<Blame>,
}

impl Judged<'_> {
    pub(crate) fn of(&self, blame: &Blame) -> Judgement {
        if self.right.contains(blame) {
            Judgement::Right
        } else if self.baseline.contains(blame) {
            Judgement::Baseline
        } else if self.tolerated.contains(blame) {
            Judgement::Tolerated
        } else {
            Judgement::False
        }
    }

    pub(crate) fn all(&self, judgement: Judgement) -> impl Iterator<Item = &Blame> {
        self.found.iter().filter(move |blame| self.of(blame) == judgement)
    }

    /// The judgement of a finding: that of its worst blame.
    pub(crate) fn of_finding(&self, blames: &BTreeSet<Blame>) -> Judgement {
        let judgements: Vec<Judgement> = blames.iter().map(|blame| self.of(blame)).collect();
        [Judgement::False, Judgement::Tolerated, Judgement::Baseline]
            .into_iter()
            .find(|judgement| judgements.contains(judgement))
            .unwrap_or(Judgement::Right)
    }
}

pub(crate) fn judge<'a>(truth: &Truth, findings: &'a [AnswerFinding]) -> Judged<'a> {
    let findings: Vec<_> = findings
        .iter()
        .filter(|finding| finding.confidence >= LEAST_CONFIDENCE)
        .map(|finding| (finding, of_finding(finding, truth)))
        .collect();
    let found: BTreeSet<Blame> = findings.iter().flat_map(|(_, b)| b.clone()).collect();
    let (mut right, mut tolerated) = (BTreeSet::new(), BTreeSet::new());
    let mut beside: Vec<&Named> = Vec::new();
    for effect in &truth.effects {
        let wanted = of_truth(effect, truth);
        let mut hits: BTreeSet<Blame> = wanted.intersection(&found).cloned().collect();
        hits.extend(accepted(effect, truth, &found));
        if !hits.is_empty() {
            beside.extend(&effect.tolerate);
        }
        right.extend(hits);
    }
    let wrong_body = truth.effects.iter().any(|effect| is_body(&effect.effect));
    // one more link beside a wrong body; any under a background of inertial errors
    let mut bodies_left = if wrong_body { 1 } else { usize::MAX };
    for blame in found.difference(&right) {
        let background =
            truth.background_inertial_error > 0.0 && blame.effect == LinkInertiaError.slug();
        // a drive filter and a clock that drifts delay the efforts
        let delayed = truth.delays_efforts() && blame.effect == TimeDelay.slug();
        if background || delayed || beside.iter().any(|named| tolerated_by(blame, named)) {
            if blame.is_body() {
                if bodies_left == 0 {
                    continue;
                }
                bodies_left -= 1;
            }
            tolerated.insert(blame.clone());
        }
    }
    let baseline = |blame: &&Blame| {
        blame.is_baseline()
            && blame.joints().iter().all(|joint| truth.has_baseline(&blame.effect, joint))
    };
    let baseline = found.iter().filter(baseline).cloned().collect();
    Judged { findings, found, right, tolerated, baseline }
}

/// The blames of the first entry of `accept` that is wholly found.
pub(crate) fn accepted(
    effect: &TrueEffect,
    truth: &Truth,
    found: &BTreeSet<Blame>,
) -> BTreeSet<Blame> {
    let sets = effect.accept.iter().map(|set| {
        set.iter().flat_map(|named| of_named(named, truth)).collect::<BTreeSet<Blame>>()
    });
    sets.into_iter().find(|set| !set.is_empty() && set.is_subset(found)).unwrap_or_default()
}
