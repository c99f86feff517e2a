//! All cases together.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use statrs::distribution::{Beta, ContinuousCDF};

use crate::contract::kind::CaseKind;
use crate::error::ChallengeError;
use crate::score::case_score::{BaselineScore, CaseScore};
use crate::score::rules::score_case;

/// Bins of confidence.
const BINS: usize = 5;

/// The scores of all cases, and their sums for cases of each kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scoreboard {
    /// `armident.scoreboard/1`.
    pub schema: &'static str,
    /// Clean cases, then field cases, where there are any.
    pub groups: Vec<GroupScore>,
    /// Right findings of all cases by confidence, in five bins.
    pub reliability: [ReliabilityBin; BINS],
    /// Case by case.
    pub cases: Vec<CaseScore>,
}

/// A count of a total.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Rate {
    /// Those that are.
    pub count: usize,
    /// Those that could be.
    pub of: usize,
}

impl Rate {
    pub(crate) fn over<'a>(values: impl Iterator<Item = &'a bool>) -> Self {
        values.fold(Self::default(), |rate, &is| rate.and(is))
    }

    pub(crate) fn and(self, is: bool) -> Self {
        Self { count: self.count + usize::from(is), of: self.of + 1 }
    }

    /// The rate that is exceeded with 95 % certainty, exact (Clopper and Pearson, one-sided).
    pub fn at_least(self) -> f64 {
        if self.count == 0 {
            return 0.0;
        }
        beta_quantile(self.count as f64, (self.of - self.count) as f64 + 1.0, 0.05)
    }

    /// The rate that is not exceeded with 95 % certainty, exact (Clopper and Pearson, one-sided).
    pub fn at_most(self) -> f64 {
        if self.count == self.of {
            return 1.0;
        }
        beta_quantile(self.count as f64 + 1.0, (self.of - self.count) as f64, 0.95)
    }

    /// The 95 % interval of the rate, exact (Clopper and Pearson, two-sided).
    pub fn interval_95(self) -> [f64; 2] {
        let (count, missed) = (self.count as f64, (self.of - self.count) as f64);
        [
            if self.count == 0 { 0.0 } else { beta_quantile(count, missed + 1.0, 0.025) },
            if self.count == self.of { 1.0 } else { beta_quantile(count + 1.0, missed, 0.975) },
        ]
    }

    /// From 0 to 1; 0 of nothing is 1.
    pub fn share(self) -> f64 {
        if self.of == 0 { 1.0 } else { self.count as f64 / self.of as f64 }
    }
}

fn beta_quantile(a: f64, b: f64, p: f64) -> f64 {
    Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p))
}

/// 97.5 % quantile of the normal distribution.
const NORMAL_975: f64 = 1.96;

/// How a ratio spreads over joints or cases.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The smallest.
    pub least: f64,
    /// The median.
    pub median: f64,
    /// The 90 % quantile.
    pub p90: f64,
    /// The largest.
    pub largest: f64,
    /// How many numbers.
    pub count: usize,
}

impl Spread {
    /// Nothing of no numbers.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().filter(|value| !value.is_nan()).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        let median = 0.5 * (values[last / 2] + values[values.len() / 2]);
        let p90 = values[(0.9 * last as f64).round() as usize];
        Some(Self { least: values[0], median, p90, largest: values[last], count: values.len() })
    }
}

/// One effect over the cases that hide it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectScore {
    /// Slug.
    pub effect: String,
    /// Pairs named.
    pub named: Rate,
    /// Cases in which the slug is a false name.
    pub false_names: usize,
    /// Worst relative error of the bold parameters.
    pub parameter_error: Option<Spread>,
}

/// Findings of like confidence.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ReliabilityBin {
    /// Mean confidence.
    pub confidence: f64,
    /// Right ones.
    pub right: Rate,
    /// 95 % interval of their share, exact (Clopper and Pearson); all that is possible in an empty bin.
    pub interval_95: [f64; 2],
}

/// The sums over cases of one kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupScore {
    /// `clean`, `field` or `change`.
    pub kind: &'static str,
    /// Cases, nulls among them.
    pub cases: usize,
    /// Cases without an answer.
    pub unanswered: usize,
    /// Cases with effects in which something is found.
    pub detected: Rate,
    /// Nulls in which something is found.
    pub false_alarms: Rate,
    /// (effect, place) pairs named of those to name.
    pub recall: Rate,
    /// Pairs named of all that were named or falsely named.
    pub precision: Rate,
    /// Harmonic mean of the two.
    pub f1: f64,
    /// Slugs named of those to name, wherever.
    pub slug_recall: Rate,
    /// Slugs named of those and the false ones.
    pub slug_precision: Rate,
    /// Missed pairs that are among the alternatives.
    pub missed_in_alternatives: Rate,
    /// Cases with more false names than effects.
    pub discredited: usize,
    /// Cases of one effect whose first finding is right.
    pub top1: Rate,
    /// Cases whose joints are found.
    pub located: Rate,
    /// Windows of contacts.
    pub window_iou: Option<Spread>,
    /// Worst bold parameter of each named effect, relative.
    pub parameter_error: Option<Spread>,
    /// Parameters whose 95 % interval (1.96 standard errors to either side) covers the true value.
    pub within_interval: Rate,
    /// Errors of these parameters, in standard errors.
    pub standardized_error: Option<Spread>,
    /// Variables of unlisted laws.
    pub variables: Option<Spread>,
    /// Baseline friction, summed.
    #[serde(rename = "everyday")]
    pub baseline: BaselineScore,
    /// Stated hold-out error over noise, affected joints.
    pub after_over_oracle: Option<Spread>,
    /// The same over the attainable error.
    pub after_over_attainable: Option<Spread>,
    /// The same over the smaller of practical and attainable error.
    pub after_over_reachable: Option<Spread>,
    /// `before` over `after`.
    pub improvement: Option<Spread>,
    /// Predicted error over noise, all joints.
    pub exam_over_oracle: Option<Spread>,
    /// The same over the attainable error.
    pub exam_over_attainable: Option<Spread>,
    /// Predictions that failed, of those that had to be made.
    pub exam_failed: Rate,
    /// Over-optimistic cases, of those with a prediction.
    pub over_claims: Rate,
    /// Cases with something that cannot be.
    pub suspicious: usize,
    /// Effect by effect.
    pub effects: Vec<EffectScore>,
    /// True slug -> named slug -> count; `nothing` on either side.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Right findings by confidence, in five bins.
    pub reliability: [ReliabilityBin; BINS],
}

impl Scoreboard {
    /// Sums up.
    pub fn new(cases: Vec<CaseScore>) -> Self {
        let groups = [CaseKind::Clean, CaseKind::Field, CaseKind::Hard, CaseKind::Change]
            .map(CaseKind::name)
            .into_iter()
            .map(|kind| (kind, cases.iter().filter(|c| c.kind == kind).collect()))
            .filter(|(_, cases): &(_, Vec<&CaseScore>)| !cases.is_empty())
            .map(|(kind, cases)| GroupScore::new(kind, &cases))
            .collect();
        let reliability = reliability(&cases.iter().collect::<Vec<_>>());
        Self { schema: "armident.scoreboard/1", groups, reliability, cases }
    }
}

impl GroupScore {
    fn new(kind: &'static str, cases: &[&CaseScore]) -> Self {
        let sum =
            |of: &dyn Fn(&CaseScore) -> usize| cases.iter().map(|case| of(case)).sum::<usize>();
        let flags = |of: &dyn Fn(&CaseScore) -> Option<bool>| {
            Rate::over(cases.iter().filter_map(|case| of(case)).collect::<Vec<_>>().iter())
        };
        let spread = |of: &dyn Fn(&CaseScore) -> Vec<f64>| {
            Spread::of(cases.iter().flat_map(|case| of(case)))
        };
        let exam = |of: &dyn Fn(&crate::score::exam::ExamScore) -> Vec<f64>| {
            spread(&|case| case.exam.as_ref().map(of).unwrap_or_default())
        };
        let named = sum(&|case| case.named.len());
        let wrong = sum(&|case| case.false_names.len());
        let recall = Rate { count: named, of: sum(&|case| case.pairs.len()) };
        let precision = Rate { count: named, of: named + wrong };
        let slugs = sum(&|case| case.named_slugs.len());
        let both = precision.share() + recall.share();
        Self {
            kind,
            cases: cases.len(),
            unanswered: sum(&|case| case.unanswered.is_some().into()),
            detected: flags(&|case| case.detected),
            false_alarms: flags(&|case| case.false_alarm),
            recall,
            precision,
            f1: if both > 0.0 { 2.0 * precision.share() * recall.share() / both } else { 0.0 },
            slug_recall: Rate { count: slugs, of: sum(&|case| case.effects.len()) },
            slug_precision: Rate { count: slugs, of: slugs + sum(&|case| case.false_slugs.len()) },
            missed_in_alternatives: Rate {
                count: sum(&|case| case.in_alternatives.len()),
                of: sum(&|case| case.missed.len()),
            },
            discredited: sum(&|case| case.discredited.into()),
            top1: flags(&|case| case.top1),
            located: flags(&|case| case.located),
            window_iou: spread(&|case| case.window_iou.clone()),
            parameter_error: spread(&|case| case.parameter_errors.iter().map(|p| p.1).collect()),
            within_interval: Rate::over(
                cases
                    .iter()
                    .flat_map(|case| case.standardized_errors.iter().map(|z| *z < NORMAL_975))
                    .collect::<Vec<_>>()
                    .iter(),
            ),
            standardized_error: spread(&|case| case.standardized_errors.clone()),
            variables: spread(&|case| case.variables.clone()),
            baseline: BaselineScore {
                counted: sum(&|case| case.baseline.counted),
                named: sum(&|case| case.baseline.named),
                with_level: sum(&|case| case.baseline.with_level),
                within_factor_2: sum(&|case| case.baseline.within_factor_2),
            },
            after_over_oracle: spread(&|c| c.holdout.after_over_oracle.values().copied().collect()),
            after_over_attainable: spread(&|c| {
                c.holdout.after_over_attainable.values().copied().collect()
            }),
            after_over_reachable: spread(&|c| {
                c.holdout.after_over_reachable.values().copied().collect()
            }),
            improvement: spread(&|c| c.holdout.improvement.values().copied().collect()),
            exam_over_oracle: exam(&|exam| exam.over_oracle.values().copied().collect()),
            exam_over_attainable: exam(&|exam| exam.over_attainable.values().copied().collect()),
            exam_failed: flags(&|case| case.exam.as_ref().map(|exam| exam.failed.is_some())),
            over_claims: flags(&|case| {
                let exam = case.exam.as_ref().filter(|exam| exam.failed.is_none());
                exam.map(|_| !case.holdout.over_claimed.is_empty())
            }),
            suspicious: sum(&|case| (!case.holdout.suspicious.is_empty()).into()),
            effects: effect_rows(cases),
            confusion: confusion(cases),
            reliability: reliability(cases),
        }
    }
}

/// Scores all cases of a folder, in alphabetical order, against the results of the same names.
///
/// # Errors
/// A folder without cases, a truth that cannot be read. Missing or broken results are scores.
pub fn score_cases(cases: &Path, results: &Path) -> Result<Scoreboard, ChallengeError> {
    let entries = std::fs::read_dir(cases).map_err(ChallengeError::io("read", cases))?;
    let mut folders: Vec<_> = entries
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.join("truth.json").is_file())
        .collect();
    folders.sort();
    if folders.is_empty() {
        return Err(ChallengeError::NoCases { path: cases.to_owned() });
    }
    let scores = folders.iter().map(|case| {
        let name = case.file_name().unwrap_or_default();
        score_case(case, &results.join(name))
    });
    Ok(Scoreboard::new(scores.collect::<Result<Vec<_>, _>>()?))
}

fn slug(blame: &str) -> &str {
    blame.split('(').next().unwrap_or(blame)
}

fn effect_rows(cases: &[&CaseScore]) -> Vec<EffectScore> {
    let mut rates: BTreeMap<&str, (Rate, usize, Vec<f64>)> = BTreeMap::new();
    for case in cases {
        for pair in &case.pairs {
            let row = rates.entry(slug(pair)).or_default();
            row.0 = row.0.and(case.named.contains(pair));
        }
        for name in &case.false_names {
            rates.entry(slug(name)).or_default().1 += 1;
        }
        for (effect, error) in &case.parameter_errors {
            rates.entry(effect).or_default().2.push(*error);
        }
    }
    let row =
        |(effect, (named, false_names, errors)): (&str, (Rate, usize, Vec<f64>))| EffectScore {
            effect: effect.to_owned(),
            named,
            false_names,
            parameter_error: Spread::of(errors),
        };
    rates.into_iter().map(row).collect()
}

fn confusion(cases: &[&CaseScore]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut table: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for (truth, named) in cases.iter().flat_map(|case| &case.confusion) {
        *table.entry(truth.clone()).or_default().entry(named.clone()).or_default() += 1;
    }
    table
}

fn reliability(cases: &[&CaseScore]) -> [ReliabilityBin; BINS] {
    let mut bins = [ReliabilityBin::default(); BINS];
    for &(confidence, right) in cases.iter().flat_map(|case| &case.reliability) {
        let bin = &mut bins[((confidence * BINS as f64) as usize).min(BINS - 1)];
        bin.right = bin.right.and(right);
        bin.confidence += (confidence - bin.confidence) / bin.right.of as f64;
    }
    for bin in &mut bins {
        bin.interval_95 = bin.right.interval_95();
    }
    bins
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bounds against the sums of the binomial distribution that define them.
    #[test]
    fn rate_bounds_are_exact() {
        let tail = |rate: Rate, p: f64, from: usize, to: usize| -> f64 {
            let choose = |k: usize| -> f64 {
                (0..k).map(|i| (rate.of - i) as f64 / (k - i) as f64).product()
            };
            let term =
                |k: usize| choose(k) * p.powi(k as i32) * (1.0 - p).powi((rate.of - k) as i32);
            (from..=to).map(term).sum()
        };
        for (count, of) in [(0, 24), (1, 30), (7, 12), (29, 30)] {
            let rate = Rate { count, of };
            assert!((tail(rate, rate.at_most(), 0, count) - 0.05).abs() < 1e-9, "{rate:?}");
        }
        for (count, of) in [(1, 30), (7, 12), (24, 24)] {
            let rate = Rate { count, of };
            assert!((tail(rate, rate.at_least(), count, of) - 0.05).abs() < 1e-9, "{rate:?}");
        }
        for (count, of) in [(0, 24), (7, 12), (24, 24)] {
            let rate = Rate { count, of };
            let [low, high] = rate.interval_95();
            assert!(count == 0 || (tail(rate, low, count, of) - 0.025).abs() < 1e-9, "{rate:?}");
            assert!(count == of || (tail(rate, high, 0, count) - 0.025).abs() < 1e-9, "{rate:?}");
        }
        assert_eq!(Rate { count: 0, of: 9 }.at_least(), 0.0);
        assert_eq!(Rate { count: 9, of: 9 }.at_most(), 1.0);
    }
}
