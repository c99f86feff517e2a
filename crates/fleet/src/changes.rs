//! Changes of a robot: which part, at which recording, by how much.
//!
//! Hypothesis: the parameters of the robot are the same in all recordings but for the [scatter](crate::Scatter) of the fleet.
//! Explanations of the contrary are physical: friction of one joint, or a body on one link, changed between two recordings.
//! Statistic: the likelihood ratio of a step, all else fitted, `θᵀ F θ`, over its degrees of freedom `q`. Under the hypothesis it
//! has the F distribution with `q` and the degrees of freedom of the scatter; the level of one robot (1 %) is divided by the
//! number of explanations times the number of places (Bonferroni), so that a robot that does not change has a change reported
//! with at most this probability.
//!
//! Method: forward selection. The explanation that exceeds its threshold by most is taken into the fit, then each step is
//! placed anew beside the others, and steps that have become superfluous are removed.
//!
//! References: A. J. Scott, M. Knott, A cluster analysis method for grouping means in the analysis of variance, Biometrics 30
//! (1974), for binary segmentation; D. M. Hawkins, Testing a sequence of observations for a shift in location, JASA 72
//! (1977), for the largest likelihood ratio of all places; C. E. Bonferroni (1936).

use armident_inference::{f_quantile, f_tail, student_t_975};
use armident_numeric::{Mat, symmetric_eigen};
use rayon::prelude::*;

use crate::explanation::{ChangedPart, Explanation};
use crate::series::{Series, SeriesFit, Step};

/// Share of the information in a direction, all else fitted, below which recordings do not determine it.
const UNDETERMINED: f64 = 1e-6;
/// Share of a number outside what is determined, above which no value is given.
const PARTLY_DETERMINED: f64 = 1e-3;
/// Difference of twice the log-likelihood within which explanations and places are not distinguished: three standard errors.
const NOT_DISTINGUISHED: f64 = 9.0;
/// Changes of one robot at most.
const MOST_CHANGES: usize = 12;
/// Rounds in which steps are placed anew.
const ROUNDS: usize = 3;

/// A change of a robot.
#[derive(Debug, Clone)]
pub struct FleetChange {
    /// What changed.
    pub part: ChangedPart,
    /// First recording with the change, from 0 in the order of the robot's recordings.
    pub from: usize,
    /// First and last recording from which on it may be, by likelihood.
    pub between: (usize, usize),
    /// By how much.
    pub sizes: Vec<SizeOfChange>,
    /// Likelihood ratio over its degrees of freedom.
    pub statistic: f64,
    /// What it must exceed.
    pub threshold: f64,
    /// Degrees of freedom of the change.
    pub degrees: usize,
    /// Probability of as large a statistic of any explanation at any place of a robot that does not change, at most.
    pub error: f64,
    /// Other parts that explain the recordings as well.
    pub alternatives: Vec<ChangedPart>,
}

/// One number of a change.
#[derive(Debug, Clone, PartialEq)]
pub struct SizeOfChange {
    /// Name of the parameter.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Value after the change less that before.
    pub value: f64,
    /// Its standard error, with the scatter of recordings.
    pub standard_error: f64,
    /// 95 % interval.
    pub interval: (f64, f64),
}

/// A part as directions of scaled parameters.
pub(crate) struct ScaledExplanation {
    pub(crate) part: ChangedPart,
    numbers: Vec<(&'static str, &'static str)>,
    directions: Mat<f64>,
}

impl ScaledExplanation {
    pub(crate) fn new(of: &Explanation, scale: &[f64]) -> Self {
        let directions =
            Mat::from_fn(scale.len(), of.directions.len(), |i, j| of.directions[j][i] / scale[i]);
        Self { part: of.part, numbers: of.numbers.clone(), directions }
    }

    /// Its directions with information of one each.
    fn of_unit_information(&self, series: &Series) -> (Mat<f64>, Vec<f64>) {
        let own = &series.from[0].matrix * &self.directions;
        let norms: Vec<f64> = (0..self.directions.ncols())
            .map(|c| {
                let dot: f64 =
                    (0..own.nrows()).map(|i| own[(i, c)] * self.directions[(i, c)]).sum();
                if dot > 0.0 { dot.sqrt() } else { f64::INFINITY }
            })
            .collect();
        let scaled =
            Mat::from_fn(own.nrows(), norms.len(), |i, j| self.directions[(i, j)] / norms[j]);
        (scaled, norms)
    }
}

/// What a search compares with.
pub(crate) struct Level {
    /// Probability of a false alarm of one robot.
    pub(crate) of_robot: f64,
    /// Degrees of freedom of the scatter.
    pub(crate) freedom: f64,
}

impl Level {
    /// Threshold of the likelihood ratio of a change with so many degrees of freedom, among so many.
    fn threshold(&self, degrees: usize, tests: f64) -> f64 {
        let q = degrees as f64;
        f_quantile(1.0 - self.of_robot / tests, q, self.freedom).map_or(f64::INFINITY, |f| q * f)
    }
}

/// A step of one explanation, scored.
struct Scored {
    explanation: usize,
    step: Step,
    ratio: f64,
    /// sizes of the explanation's numbers per direction of the step, and the share of each number that is determined
    numbers: Mat<f64>,
    determined: Vec<f64>,
    threshold: f64,
}

impl Scored {
    fn excess(&self) -> f64 {
        self.ratio - self.threshold
    }
}

/// The search for the changes of one robot.
pub(crate) struct Search<'a> {
    series: &'a Series,
    explanations: &'a [ScaledExplanation],
    units: Vec<(Mat<f64>, Vec<f64>)>,
    level: &'a Level,
    /// Thresholds by degrees of freedom.
    thresholds: Vec<f64>,
    tests: f64,
}

impl<'a> Search<'a> {
    pub(crate) fn new(
        series: &'a Series,
        explanations: &'a [ScaledExplanation],
        level: &'a Level,
    ) -> Self {
        let tests = (explanations.len() * series.len().saturating_sub(1)).max(1) as f64;
        let most = explanations.iter().map(|of| of.directions.ncols()).max().unwrap_or(0);
        Self {
            series,
            explanations,
            units: explanations.iter().map(|of| of.of_unit_information(series)).collect(),
            level,
            thresholds: (0..=most)
                .map(|q| if q == 0 { f64::INFINITY } else { level.threshold(q, tests) })
                .collect(),
            tests,
        }
    }

    /// A step of one explanation from one recording on, beside others.
    fn scored(
        &self,
        fit: &SeriesFit,
        steps: &[Step],
        from: usize,
        explanation: usize,
    ) -> Option<Scored> {
        let (unit, norms) = &self.units[explanation];
        let score = self.series.score(fit, steps, from, unit);
        let (values, vectors) = symmetric_eigen(&score.information).ok()?;
        let kept: Vec<usize> = (0..values.len()).filter(|&k| values[k] > UNDETERMINED).collect();
        let along =
            |k: usize| -> f64 { (0..norms.len()).map(|i| vectors[(i, k)] * score.moment[i]).sum() };
        let ratio = kept.iter().map(|&k| along(k).powi(2) / values[k]).sum();
        let picked = Mat::from_fn(norms.len(), kept.len(), |i, k| vectors[(i, kept[k])]);
        let determined = (0..norms.len())
            .map(|i| (0..kept.len()).map(|k| picked[(i, k)].powi(2)).sum())
            .collect();
        Some(Scored {
            explanation,
            step: Step { from, directions: unit * &picked },
            ratio,
            numbers: Mat::from_fn(norms.len(), kept.len(), |i, k| picked[(i, k)] / norms[i]),
            determined,
            threshold: self.thresholds[kept.len()],
        })
    }

    /// All explanations at all places, beside others.
    fn all(&self, steps: &[Step]) -> Vec<Scored> {
        let Some(fit) = self.series.fit(steps) else { return Vec::new() };
        (1..self.series.len())
            .into_par_iter()
            .flat_map_iter(|from| {
                let fit = &fit;
                (0..self.explanations.len())
                    .filter_map(move |explanation| self.scored(fit, steps, from, explanation))
            })
            .collect()
    }

    fn best(&self, steps: &[Step]) -> Option<Scored> {
        let all = self.all(steps).into_iter();
        all.max_by(|a, b| a.excess().total_cmp(&b.excess())).filter(|best| best.excess() > 0.0)
    }

    /// The changes in the order of recordings, and the steps of the fit.
    pub(crate) fn changes(&self) -> (Vec<FleetChange>, Vec<Step>) {
        let mut found: Vec<Scored> = Vec::new();
        let steps = |of: &[Scored]| of.iter().map(|s| s.step.clone()).collect::<Vec<_>>();
        let most = MOST_CHANGES.min(self.series.len().saturating_sub(1));
        while found.len() < most {
            let Some(best) = self.best(&steps(&found)) else { break };
            found.push(best);
            self.place_anew(&mut found);
        }
        found.sort_by_key(|scored| scored.step.from);
        let all = steps(&found);
        let changes = (0..found.len()).map(|index| self.change(&found, index)).collect();
        (changes, all)
    }

    /// Each step where it explains most beside the others; without those that explain nothing there.
    fn place_anew(&self, found: &mut Vec<Scored>) {
        for _ in 0..ROUNDS {
            if found.len() < 2 {
                return;
            }
            let mut is_settled = true;
            let mut index = 0;
            while index < found.len() {
                let before = found.remove(index);
                let others: Vec<Step> = found.iter().map(|s| s.step.clone()).collect();
                let Some(best) = self.best(&others) else {
                    is_settled = false;
                    continue;
                };
                is_settled &=
                    best.step.from == before.step.from && best.explanation == before.explanation;
                found.insert(index, best);
                index += 1;
            }
            if is_settled {
                return;
            }
        }
    }

    fn change(&self, found: &[Scored], index: usize) -> FleetChange {
        let scored = &found[index];
        let others: Vec<Step> = (found.iter().enumerate())
            .filter(|(other, _)| *other != index)
            .map(|(_, s)| s.step.clone())
            .collect();
        let all = self.all(&others);
        // at other places the same part, at other parts the same place
        let as_good = |other: &&Scored| other.ratio > scored.ratio - NOT_DISTINGUISHED;
        let places = all.iter().filter(|s| s.explanation == scored.explanation).filter(as_good);
        let places: Vec<usize> = places.map(|s| s.step.from).collect();
        let first = places.iter().copied().min().unwrap_or(scored.step.from);
        let last = places.iter().copied().max().unwrap_or(scored.step.from);
        let alternatives = all
            .iter()
            .filter(|s| s.step.from == scored.step.from && s.explanation != scored.explanation)
            .filter(|s| s.excess() > 0.0)
            .filter(as_good)
            .map(|s| self.explanations[s.explanation].part)
            .collect();
        let degrees = scored.step.directions.ncols();
        let statistic = scored.ratio / degrees.max(1) as f64;
        let tail = f_tail(statistic, degrees as f64, self.level.freedom).unwrap_or(1.0);
        FleetChange {
            part: self.explanations[scored.explanation].part,
            from: scored.step.from,
            between: (first, last),
            sizes: self.sizes(found, index),
            statistic,
            threshold: scored.threshold / degrees.max(1) as f64,
            degrees,
            error: (tail * self.tests).min(1.0),
            alternatives,
        }
    }

    /// Numbers of a change that the recordings determine.
    fn sizes(&self, found: &[Scored], index: usize) -> Vec<SizeOfChange> {
        let steps: Vec<Step> = found.iter().map(|s| s.step.clone()).collect();
        let Some(fit) = self.series.fit(&steps) else { return Vec::new() };
        let before: usize = steps[..index].iter().map(|s| s.directions.ncols()).sum();
        let all: usize = steps.iter().map(|s| s.directions.ncols()).sum();
        let at = fit.values.len() - all + before;
        let scored = &found[index];
        let sizes = scored.step.directions.ncols();
        let quantile = student_t_975(self.level.freedom);
        let of = &self.explanations[scored.explanation];
        (of.numbers.iter().enumerate())
            .filter(|(i, _)| scored.determined[*i] > 1.0 - PARTLY_DETERMINED)
            .map(|(i, &(name, unit))| {
                let share = |k: usize| scored.numbers[(i, k)];
                let value = (0..sizes).map(|k| share(k) * fit.values[at + k]).sum();
                let variance: f64 = (0..sizes)
                    .flat_map(|a| (0..sizes).map(move |b| (a, b)))
                    .map(|(a, b)| share(a) * share(b) * fit.covariance[(at + a, at + b)])
                    .sum();
                let standard_error = variance.max(0.0).sqrt();
                let half = quantile * standard_error;
                let interval = (value - half, value + half);
                SizeOfChange { name, unit, value, standard_error, interval }
            })
            .collect()
    }
}
