//! What else a finding may be: laws that, in its place and with all else fitted again, explain the
//! recordings about as well.

use std::cell::LazyCell;
use std::collections::BTreeMap;

use armident_effects::effect;

use crate::at::OperatingPoint;
use crate::crossval::{errors_left_out, surely_less};
use crate::material::{LEAST, band_noise, held};
use crate::problem::{Group, Meaning};
use crate::search::{Answer, answer};
use crate::whitened::{PRICE_OF_SELDOM, Whitened};

/// Share of what a name needs that another law may leave over and still pass for the same.
const TOLD_APART: f64 = 1.0 / 3.0;
/// Difference of scores (twice a logarithm of odds) below which two laws are not told apart: twenty to one.
const ODDS: f64 = 6.0;
/// Most alternatives of one finding.
const MOST: usize = 4;
/// Candidates that are fitted for one finding, by the estimate of their fit.
const TRIED: usize = 16;

/// An answer with another law in the place of one.
pub(crate) struct Rival {
    /// group that takes the place
    pub(crate) group: usize,
    pub(crate) answer: Answer,
    /// root mean square effort it leaves more, in standard deviations of one recorded sample, on the
    /// joint where that is most
    pub(crate) left: f64,
}

/// Rivals of a group of an answer, the nearest first; one for every law and place. What the operating
/// point holds of the group is put back into the efforts first.
pub(crate) fn rivals(
    metric: &Whitened<'_>,
    of: &Answer,
    group: usize,
    point: &OperatingPoint,
) -> Vec<Rival> {
    let held = held(&metric.problem.groups[group], point);
    if held.is_empty() {
        return of_group(metric, of, group);
    }
    let moved = metric.problem.with_added(&held);
    let metric = moved.whitened(metric.scale, &metric.wide);
    answer(&metric, of.set.clone()).map_or_else(Vec::new, |of| of_group(&metric, &of, group))
}

/// The answer with everyday friction in the place of laws that the recordings cannot tell from it: nearly
/// every joint has it, and few have another law alone.
pub(crate) fn everyday_first(
    metric: &Whitened<'_>,
    mut of: Answer,
    point: &OperatingPoint,
) -> Answer {
    let everyday = |g: usize| {
        ["viscous_friction", "coulomb_friction"].contains(&metric.problem.groups[g].slug())
    };
    for group in of.set.clone() {
        let joints = &metric.problem.groups[group].site.joints;
        if everyday(group) || joints.len() != 1 {
            continue;
        }
        let usual = rivals(metric, &of, group, point).into_iter().find(|rival| {
            everyday(rival.group)
                && metric.problem.groups[rival.group].site.joints == *joints
                && rival.answer.score - of.score < PRICE_OF_SELDOM
        });
        if let Some(rival) = usual {
            of = rival.answer;
        }
    }
    of
}

/// The answer of a change with a load on the last link in the place of another body that the recordings cannot tell from
/// it: arms pick up loads, and few have a link exchanged.
pub(crate) fn load_first(metric: &Whitened<'_>, mut of: Answer) -> Answer {
    let groups = &metric.problem.groups;
    let Some(load) = groups.iter().position(|group| group.slug() == "payload") else { return of };
    for body in of.set.clone() {
        if body == load || !groups[body].is_of_link() {
            continue;
        }
        let mut set: Vec<usize> = of.set.iter().copied().filter(|g| *g != body).collect();
        if set.iter().any(|g| *g == load || groups[*g].excludes(&groups[load])) {
            continue;
        }
        set.push(load);
        if let Some(loaded) = answer(metric, set)
            && loaded.score - of.score < PRICE_OF_SELDOM
        {
            of = loaded;
        }
    }
    of
}

fn of_group(metric: &Whitened<'_>, of: &Answer, group: usize) -> Vec<Rival> {
    let problem = metric.problem;
    let groups = &problem.groups;
    if matches!(groups[group].meaning, Meaning::Flexible(_)) {
        return Vec::new();
    }
    let rest: Vec<usize> = of.set.iter().copied().filter(|g| *g != group).collect();
    let Some(fit) = metric.fit(metric.columns_of(&rest)) else { return Vec::new() };
    // the best shape of every law at every place
    let mut best: BTreeMap<(&str, Vec<usize>), (f64, usize)> = BTreeMap::new();
    for (g, candidate) in groups.iter().enumerate() {
        let same = candidate.slug() == groups[group].slug()
            && candidate.site.joints == groups[group].site.joints;
        let unnamed = matches!(candidate.meaning, Meaning::Flexible(_));
        let windowed = candidate.site.window.is_some();
        let taken = rest.iter().any(|r| *r == g || groups[*r].excludes(candidate));
        // a law that contains the other explains no less; that is no reason to doubt the simpler one
        let nested = contains(&groups[group], candidate) || contains(candidate, &groups[group]);
        // where all links are uncertain, any link takes up a little: only the joint's own is a rival
        let other_link = metric.scale > 0.0
            && problem.rows.changed_from == 0
            && candidate.transform.is_some()
            && groups[group].transform.is_none()
            && candidate.site.joints != groups[group].site.joints;
        if same || unnamed || windowed || taken || nested || other_link {
            continue;
        }
        let added: Vec<usize> =
            candidate.columns.iter().copied().filter(|c| !fit.columns.contains(c)).collect();
        let left = (fit.sum_of_squares - metric.gain(&fit, &added)).max(f64::MIN_POSITIVE);
        let set = [rest.as_slice(), &[g]].concat();
        let score = metric.score(left, fit.columns.len() + added.len(), &set);
        let entry =
            best.entry((candidate.slug(), candidate.site.joints.clone())).or_insert((score, g));
        if score < entry.0 {
            *entry = (score, g);
        }
    }
    let mut candidates: Vec<(f64, usize)> = best.into_values().collect();
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let with = metric.residual(&of.fit);
    let left_out = |of: &Answer| errors_left_out(problem, &of.set, metric.scale, &metric.wide);
    let errors = LazyCell::new(|| left_out(of));
    let mut found: Vec<Rival> = candidates
        .iter()
        .take(TRIED)
        .filter_map(|&(_, g)| {
            let answer = answer(metric, [rest.as_slice(), &[g]].concat())?;
            let residual = metric.residual(&answer.fit);
            let left = (0..residual.len())
                .map(|j| {
                    let square = |r: &[f64]| problem.rows.in_sample_noise(j, r).powi(2);
                    (square(&residual[j]) - square(&with[j])).max(0.0).sqrt()
                })
                .fold(0.0, f64::max);
            Some(Rival { group: g, answer, left })
        })
        .filter(|rival| {
            let near = rival.answer.score - of.score < ODDS;
            let of_links = [group, rival.group].map(|g| groups[g].is_of_link());
            let changed = problem.rows.changed_from > 0;
            if changed && of_links == [true; 2] {
                near || !surely_less(&errors, &left_out(&rival.answer))
            } else if !changed && groups[group].transform.is_some() && metric.scale > 0.0 {
                // uncertain inertias take up what a load leaves: there the evidence decides
                near
            } else {
                rival.left < told_apart(metric, of, &with, rival)
            }
        })
        .collect();
    found.sort_by(|a, b| a.left.total_cmp(&b.left));
    found.truncate(MOST);
    found
}

/// What is left more from which on two laws are told apart on these recordings.
fn told_apart(metric: &Whitened<'_>, of: &Answer, with: &[Vec<f64>], rival: &Rival) -> f64 {
    // the more a joint's model leaves over, the less its details say
    let joints = of
        .set
        .iter()
        .chain([&rival.group])
        .flat_map(|g| metric.problem.groups[*g].site.joints.clone());
    let imperfect = joints
        .map(|j| {
            let noise = band_noise(metric.problem, j);
            metric.problem.rows.in_sample_noise(j, &with[j]) / noise.max(f64::MIN_POSITIVE)
        })
        .fold(1.0, f64::max);
    TOLD_APART * LEAST * imperfect.min(2.0)
}

/// Whether a law contains the other on the same joints: its simpler relative was tried already and found
/// wanting.
fn contains(law: &Group, other: &Group) -> bool {
    law.site.joints == other.site.joints
        && effect(law.slug()).is_some_and(|e| e.law().contains.contains(&other.slug()))
}

/// The motion that tells two laws apart, in words, as the library says it.
pub(crate) fn separated_by(slug: &str, other: &str) -> Option<&'static str> {
    let of = |slug: &str, other: &str| {
        let law = effect(slug)?.law();
        law.look_alikes.iter().find(|l| l.slug == other).map(|l| l.separated_by)
    };
    of(slug, other).or_else(|| of(other, slug))
}
