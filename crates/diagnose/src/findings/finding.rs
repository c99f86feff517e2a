//! Findings of an estimate: effects with locations, parameters and standard errors.

use std::collections::BTreeMap;

use armident_effects::{Effect, LawRole, LinkInertiaError, Payload, UNMODELLED, effect};
use serde::Serialize;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;
use crate::findings::confidence::Evidence;
use crate::findings::numbers::{Numbers, Value, numbers, numbers_of_link};
use crate::findings::residual_map::Character;
use crate::regression::elimination::InflatedLink;
use crate::regression::fit_set::{Estimate, fit_set};
use crate::selection::change_significance::{Inconclusive, ReferenceUncertainty};
use crate::selection::materiality::{
    Materiality, excess, excess_before, link_materiality, materiality, surrogate_threshold_beside,
};
use crate::selection::prior_scale::SCALES;
use crate::selection::rivals::{InPlace, Rival, rivals, rivals_of_body, separated_by};
use crate::selection::solution::{Selection, Solution};
use crate::uncertainty::jackknife::Jackknife;

/// Another effect that the recordings do not distinguish from a finding.
#[derive(Debug, Clone, Serialize)]
pub struct Alternative {
    /// Slug.
    pub effect: String,
    /// Joints.
    pub joints: Vec<String>,
    /// Link.
    pub link: Option<String>,
    /// Root mean square residual that it adds to that of the finding, in noise levels; none where it was not fitted.
    pub left_more: Option<f64>,
    /// The motion that would separate the two, in words, if the library has one.
    pub separated_by: Option<&'static str>,
}

/// Evidence of a finding.
#[derive(Debug, Clone, Serialize)]
pub struct FindingEvidence {
    /// Root mean square effort that the finding alone explains, in noise levels, on the joint where that is largest.
    pub materiality: f64,
    /// Materiality threshold there.
    pub least_materiality: f64,
    /// That joint.
    pub joint: String,
    /// Distance of its main parameters from nothing: 1 at two standard errors; none where these are not known.
    #[serde(skip)]
    pub size: Option<f64>,
    /// Regressors of an unmodelled structure.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub variables: Vec<String>,
    /// Character of an unmodelled structure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub character: Option<Character>,
    /// Share of the squared error of the hold-out on that joint that the finding removes, all else fitted again; negative where
    /// the error is higher with it. None without a hold-out, and where it cannot show that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holdout_gain: Option<f64>,
}

/// One effect at one location that the given model lacks.
#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// Slug of the library, or `unmodelled`.
    pub effect: String,
    /// Joints.
    pub joints: Vec<String>,
    /// Link, for inertial effects.
    pub link: Option<String>,
    /// Window \[s\], for contacts.
    pub window: Option<[f64; 2]>,
    /// Recording of the window.
    pub recording: Option<String>,
    /// Parameters of the law.
    pub parameters: BTreeMap<&'static str, Value>,
    /// How far the name can be relied upon, 0 to 1: 0.5 at the threshold of its weaker evidence, 0.95 at twice that, less
    /// beside rivals and where the hold-out contradicts.
    pub confidence: f64,
    /// Whether the model with it predicts recordings kept out better than the model without it; none
    /// without such recordings, or where they cannot show it (a contact happened once).
    pub confirmed: Option<bool>,
    /// Why.
    pub evidence: FindingEvidence,
    /// Effects that it may be instead.
    pub alternatives: Vec<Alternative>,
}

impl Finding {
    /// Whether its parameters are those of the physics that its law is named for.
    fn is_plausible(&self) -> bool {
        let Some(law) = effect(&self.effect) else { return true };
        let value = |name: &str| self.parameters.get(name).map(|of| of.value);
        let values: Option<Vec<f64>> =
            law.law().parameters.iter().map(|parameter| value(parameter.name)).collect();
        values.is_none_or(|values| law.is_plausible(&values))
    }
}

/// A finding and the estimates beside it.
pub(crate) struct ReportedFinding {
    pub(crate) finding: Finding,
    /// without it, and the inflated links; none where there is no such estimate
    pub(crate) without: Option<(Estimate, Vec<InflatedLink>)>,
    /// with each alternative instead of it, and the inflated links
    pub(crate) rivals: Vec<(Estimate, Vec<InflatedLink>)>,
}

/// Standard errors of an estimate, with all that widens them.
pub(crate) fn honest_errors(design: &Design<'_>, of: &Solution<'_, '_>) -> Jackknife {
    let Solution { metric, estimate, .. } = *of;
    let step_s = design.signals.iter().map(|s| 1.0 / s.recorded_hz).fold(0.0, f64::max);
    let mut jackknife = Jackknife::with_lag(metric, estimate, step_s);
    if design.observations.comparison.seeks_change() {
        let open = ReferenceUncertainty::of(design, of.at(), metric, estimate);
        open.widen(&mut jackknife, metric, estimate);
    }
    jackknife.with_shapes(design, of.at(), metric, estimate)
}

/// The findings, the most material first. `best` has the findings and the small terms of the model: parameters without
/// these would be biased.
pub(crate) fn reported_findings(
    design: &Design<'_>,
    selection: &Selection,
    best: &Solution<'_, '_>,
    jackknife: &Jackknife,
) -> Vec<ReportedFinding> {
    let metric = selection.metric();
    let solution = selection.solution(design, &metric);
    let chance = surrogate_threshold_beside(&metric, &selection.estimate);
    let seeks_change = selection.problem.observations.comparison.seeks_change();
    let with = metric.residual(&selection.estimate.fit);
    let left = excess(&selection.problem, &with);
    let beyond = if seeks_change { design.rows_beyond_reference() } else { Vec::new() };
    // how much less a candidate explains where the reference shows what was there before
    let shown_before = |of: &Materiality, without: Option<&Estimate>| {
        let Some(without) = without.filter(|_| beyond.contains(&true)) else { return *of };
        let (j, rows) = (of.joint, &selection.problem.observations);
        let rest = metric.residual(&without.fit);
        let explained = |is_wanted: &dyn Fn(usize) -> bool| {
            let [rest, with] =
                [&rest, &with].map(|r| rows.in_sample_noise_of(j, &r[j], is_wanted).powi(2));
            (rest - with).max(0.0).sqrt()
        };
        let (all, within) = (explained(&|_| true), explained(&|row| !beyond[row]));
        let share = if all > 0.0 { (within / all).min(1.0) } else { 1.0 };
        Materiality { value: share * of.value, ..*of }
    };
    let confidence = |materiality: &Materiality, size: Option<f64>, behind: Vec<f64>| {
        let j = materiality.joint;
        let left = seeks_change.then(|| [excess_before(&selection.problem, j), left[j]]);
        Evidence { materiality, size, left, behind }.confidence()
    };
    let mut found: Vec<ReportedFinding> = selection
        .estimate
        .set
        .iter()
        .map(|&g| {
            let (size, without) =
                materiality(&metric, &selection.estimate, g, &selection.point, &chance);
            let numbers = numbers(best, g, jackknife);
            let rivals = rivals(&metric, &selection.estimate, g, &selection.point);
            let alternative_of = |r: &Rival| alternative(&solution, InPlace::Candidate(g), r);
            let behind = behind(selection, best, InPlace::Candidate(g), &rivals);
            let shown = shown_before(&size, without.as_ref());
            let confidence = confidence(&shown, numbers.size, behind);
            let mut finding = finding_of_candidate(&solution, g, &size, numbers, confidence);
            finding.alternatives = rivals.iter().map(alternative_of).collect();
            finding.alternatives.extend(load_unweighed(&solution, g));
            ReportedFinding {
                finding,
                without: without.map(|estimate| (estimate, selection.inflated.clone())),
                rivals: rivals.into_iter().map(|r| (r.estimate, r.inflated)).collect(),
            }
        })
        .collect();
    let errors = metric.inertial_errors(&selection.estimate.fit);
    for &InflatedLink { link, .. } in &selection.inflated {
        let size = link_materiality(&metric, &selection.estimate, link, &chance);
        if size.ratio() < 1.0 {
            continue;
        }
        let inflated: Vec<InflatedLink> =
            selection.inflated.iter().copied().filter(|body| body.link != link).collect();
        let others = selection.problem.marginalised(selection.scale, &inflated);
        let change = &errors[10 * link..10 * (link + 1)];
        let numbers = numbers_of_link(
            design,
            link,
            change,
            &jackknife.covariance_of_link(&metric, link),
            jackknife.freedom(),
        );
        if numbers.size.is_some_and(|size| size < 1.0) {
            continue;
        }
        let rivals = rivals_of_body(&metric, &selection.estimate, link);
        let alternative_of = |r: &Rival| alternative(&solution, InPlace::Body(link), r);
        let mut behind = behind(selection, best, InPlace::Body(link), &rivals);
        // small errors of all links explain it too, at a prior scale of their own; beside the small terms of the model, without
        // which links fit what those explain
        let all_links = SCALES.iter().filter_map(|scale| {
            let metric = selection.problem.marginalised(*scale, &inflated);
            Some(fit_set(&metric, best.estimate.set.clone())?.score)
        });
        let best_of_all = all_links.min_by(f64::total_cmp);
        behind.extend(best_of_all.map(|score| score - best.estimate.score));
        let confidence = confidence(&size, numbers.size, behind);
        let mut finding = inflated_link(design, link, &size, numbers, confidence);
        finding.alternatives = rivals.iter().map(alternative_of).collect();
        found.push(ReportedFinding {
            finding,
            without: fit_set(&others, selection.estimate.set.clone())
                .map(|estimate| (estimate, inflated)),
            rivals: rivals.into_iter().map(|r| (r.estimate, r.inflated)).collect(),
        });
    }
    // parts of the operating point stay in the model; without a size they are no names
    found.retain(|reported| reported.finding.evidence.size.is_none_or(|size| size >= 1.0));
    found.retain(|reported| reported.finding.is_plausible());
    found.sort_by(|a, b| b.finding.evidence.materiality.total_cmp(&a.finding.evidence.materiality));
    found
}

/// By how much worse the rivals of a finding score; none of the same body by another name. Bodies are compared beside the small terms of the model: without these, links fit what the
/// small terms explain.
fn behind(
    selection: &Selection,
    best: &Solution<'_, '_>,
    of: InPlace,
    rivals: &[Rival],
) -> Vec<f64> {
    let candidates = &selection.problem.candidates;
    let link = |place: InPlace| match place {
        InPlace::Body(link) => Some(link),
        InPlace::Candidate(g) if candidates[g].is_of_link() => {
            candidates[g].location.joints.first().copied()
        }
        InPlace::Candidate(_) => None,
    };
    let is_same = |rival: &&Rival| link(of).is_some() && link(of) == link(rival.by);
    let others = rivals.iter().filter(|rival| !is_same(rival));
    let score_beside_small_terms = |rival: &Rival| {
        let mut set = best.estimate.set.clone();
        set.retain(|g| of != InPlace::Candidate(*g));
        if let InPlace::Candidate(g) = rival.by {
            set.retain(|o| !candidates[*o].excludes(&candidates[g]));
            set.push(g);
        }
        let metric = selection.problem.marginalised(best.metric.scale, &rival.inflated);
        Some(fit_set(&metric, set)?.score - best.estimate.score)
    };
    let of_rival = |rival: &Rival| {
        let beside = link(of).and_then(|_| score_beside_small_terms(rival));
        beside.unwrap_or(rival.behind)
    };
    others.map(of_rival).collect()
}

fn alternative(solution: &Solution<'_, '_>, of: InPlace, rival: &Rival) -> Alternative {
    let design = solution.design;
    let candidates = &solution.metric.problem.candidates;
    let place_of = |by: InPlace| match by {
        InPlace::Candidate(g) => {
            let candidate = &candidates[g];
            (candidate.law(), candidate.location.joints.clone(), link_of(design, candidate))
        }
        InPlace::Body(link) => {
            let name = design.chain.joints[link].child_link.clone();
            (Some(&LinkInertiaError as &dyn Effect), vec![link], Some(name))
        }
    };
    let (own, own_joints, own_link) = place_of(of);
    let (other, joints, link) = place_of(rival.by);
    // the library's motion for a load and a link error is one for the same link
    let between_links = own_link.is_some() && link.is_some() && own_joints != joints;
    Alternative {
        effect: other.map_or(UNMODELLED, Effect::slug).to_owned(),
        joints: joints.iter().map(|j| design.names[*j].clone()).collect(),
        link,
        left_more: Some(rival.left),
        separated_by: (!between_links).then(|| separated_by(own, other)).flatten(),
    }
}

/// A change of the last link may also be a load where no effort depends on the mass (one joint, or vertical axes): a load
/// whose mass is not identifiable is not reported.
fn load_unweighed(solution: &Solution<'_, '_>, candidate: usize) -> Option<Alternative> {
    let Solution { design, metric, .. } = *solution;
    let candidates = &metric.problem.candidates;
    let last = design.joints() - 1;
    let of_last = candidates[candidate].is(&LinkInertiaError)
        && candidates[candidate].location.joints == [last];
    (of_last && candidates.iter().all(|g| !g.is(&Payload))).then(|| Alternative {
        effect: Payload.slug().to_owned(),
        joints: vec![design.names[last].clone()],
        link: link_of(design, &candidates[candidate]),
        left_more: Some(0.0),
        separated_by: Some("No motion of this arm distinguishes them, because its efforts do not depend on the mass: weigh the load."),
    })
}

/// A change that is not significant.
#[derive(Debug, Clone, Serialize)]
pub struct DoubtfulChange {
    /// Slug of the effect.
    pub effect: String,
    /// Its joints, base to tip; empty for the whole arm.
    pub joints: Vec<String>,
    /// Its link, of a load or a link inertia error.
    pub link: Option<String>,
    /// p-value of the hypothesis that nothing changed.
    pub chance: f64,
    /// Whether it is inconclusive because the reference does not exclude it.
    pub maybe_before: bool,
}

impl DoubtfulChange {
    pub(crate) fn of(design: &Design<'_>, inconclusive: &Inconclusive) -> Self {
        let candidate = &inconclusive.candidate;
        Self {
            effect: candidate.slug().to_owned(),
            joints: candidate.location.joints.iter().map(|j| design.names[*j].clone()).collect(),
            link: link_of(design, candidate),
            chance: inconclusive.p_value,
            maybe_before: inconclusive.maybe_before,
        }
    }
}

/// The link of an inertial effect.
fn link_of(design: &Design<'_>, candidate: &Candidate) -> Option<String> {
    candidate
        .transform
        .is_some()
        .then(|| design.chain.joints[candidate.location.joints[0]].child_link.clone())
}

fn finding_of_candidate(
    solution: &Solution<'_, '_>,
    id: usize,
    size: &Materiality,
    numbers: Numbers,
    confidence: f64,
) -> Finding {
    let Solution { design, metric, estimate, .. } = *solution;
    let candidate = &metric.problem.candidates[id];
    let described = has_smooth_friction(metric.problem, estimate, candidate);
    let names = |joints: &[usize]| joints.iter().map(|j| design.names[*j].clone()).collect();
    Finding {
        effect: candidate.slug().to_owned(),
        joints: names(&candidate.location.joints),
        link: link_of(design, candidate),
        window: candidate.location.window.map(|w| w.1),
        recording: candidate.location.window.map(|w| stem(&design.signals[w.0].source)),
        parameters: numbers.parameters,
        confidence: if described { confidence.min(BESIDE_SMOOTH_TERM) } else { confidence },
        confirmed: None,
        evidence: FindingEvidence {
            materiality: size.value,
            least_materiality: size.least,
            joint: design.names[size.joint].clone(),
            size: numbers.size,
            variables: match &candidate.kind {
                CandidateKind::SmoothDirections(flexible) => flexible.basis.variables(),
                CandidateKind::Law(_) => Vec::new(),
            },
            character: None,
            holdout_gain: None,
        },
        alternatives: Vec::new(),
    }
}

/// Confidence of a friction law beside a smooth term of the same joint's speed, between which friction is not
/// distinguishable.
const BESIDE_SMOOTH_TERM: f64 = 0.45;

fn has_smooth_friction(
    problem: &LinearProblem,
    estimate: &Estimate,
    candidate: &Candidate,
) -> bool {
    let friction = [LawRole::Viscous, LawRole::Drag];
    if matches!(candidate.kind, CandidateKind::SmoothDirections(_))
        || !candidate.places.iter().any(|p| friction.contains(p))
    {
        return false;
    }
    estimate.set.iter().map(|g| &problem.candidates[*g]).any(|other| {
        other.location == candidate.location
            && matches!(&other.kind, CandidateKind::SmoothDirections(f) if !f.basis.factors.is_empty())
    })
}

/// The finding of an inflated link.
fn inflated_link(
    design: &Design<'_>,
    link: usize,
    size: &Materiality,
    numbers: Numbers,
    confidence: f64,
) -> Finding {
    let joint = &design.chain.joints[link];
    Finding {
        effect: LinkInertiaError.slug().to_owned(),
        joints: vec![joint.name.clone()],
        link: Some(joint.child_link.clone()),
        window: None,
        recording: None,
        parameters: numbers.parameters,
        confidence,
        confirmed: None,
        evidence: FindingEvidence {
            materiality: size.value,
            least_materiality: size.least,
            joint: design.names[size.joint].clone(),
            size: numbers.size,
            variables: Vec::new(),
            character: None,
            holdout_gain: None,
        },
        alternatives: Vec::new(),
    }
}

/// Name of a file without folder and ending.
fn stem(source: &str) -> String {
    std::path::Path::new(source)
        .file_stem()
        .map_or_else(|| source.to_owned(), |s| s.to_string_lossy().into_owned())
}
