//! `armident challenge`.

use std::collections::BTreeMap;

use armident_report::{capital, counted, effect_label, percent};
use serde::Deserialize;

use crate::drawing::Drawing;
use crate::figures::{self, Reliability};
use crate::view::{Grid, Section, Step, Tone, View, number};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Scoreboard {
    groups: Vec<Group>,
    reliability: Vec<Bin>,
    cases: Vec<Case>,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(default)]
struct Rate {
    count: usize,
    of: usize,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(default)]
struct Spread {
    least: f64,
    median: f64,
    p90: f64,
    largest: f64,
    count: usize,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Bin {
    confidence: f64,
    right: Rate,
    interval_95: [f64; 2],
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Group {
    kind: String,
    cases: usize,
    unanswered: usize,
    detected: Rate,
    false_alarms: Rate,
    recall: Rate,
    precision: Rate,
    f1: f64,
    top1: Rate,
    located: Rate,
    parameter_error: Option<Spread>,
    within_interval: Rate,
    after_over_reachable: Option<Spread>,
    improvement: Option<Spread>,
    exam_over_oracle: Option<Spread>,
    over_claims: Rate,
    effects: Vec<Effect>,
    confusion: BTreeMap<String, BTreeMap<String, usize>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Effect {
    effect: String,
    named: Rate,
    false_names: usize,
    parameter_error: Option<Spread>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Case {
    case: String,
    robot: String,
    kind: String,
    unanswered: Option<String>,
    effects: Vec<String>,
    pairs: Vec<String>,
    named: Vec<String>,
    missed: Vec<String>,
    false_names: Vec<String>,
    false_alarm: Option<bool>,
    holdout: Holdout,
    exam: Option<Exam>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Holdout {
    after_over_reachable: BTreeMap<String, f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Exam {
    over_oracle: BTreeMap<String, f64>,
}

impl Rate {
    fn and(self, other: Self) -> Self {
        Self { count: self.count + other.count, of: self.of + other.of }
    }

    fn written(self) -> String {
        if self.of == 0 { "-".to_owned() } else { format!("{} of {}", self.count, self.of) }
    }
}

pub(crate) fn view(of: &Scoreboard, drawing: &Drawing) -> View {
    let sum =
        |rate: fn(&Group) -> Rate| of.groups.iter().map(rate).fold(Rate::default(), Rate::and);
    let (named, alarms) = (sum(|g| g.recall), sum(|g| g.false_alarms));
    let precision = sum(|g| g.precision);
    let wrong = precision.of - precision.count;
    let headline = match (named.of, alarms.of) {
        (0, 0) => "No case was scored".to_owned(),
        (0, nulls) => alarms_of(alarms.count, nulls),
        (pairs, 0) => format!("{} of {pairs} hidden effects found", named.count),
        (pairs, nulls) => format!(
            "{} of {pairs} hidden effects found; {}",
            named.count,
            alarms_of(alarms.count, nulls)
        ),
    };
    let good = alarms.count == 0 && named.count * 10 >= named.of * 8;
    View {
        kind: "Challenge",
        tone: if named.of + alarms.of == 0 {
            Tone::Open
        } else if good {
            Tone::Good
        } else {
            Tone::Bad
        },
        headline,
        sentences: sentences(of, named, wrong),
        next: next(of, drawing),
        overview: overview(of),
        sections: of.groups.iter().map(group).chain([cases(of)]).collect(),
        robot: format!("{} cases", of.cases.len()),
        ..View::default()
    }
}

fn alarms_of(count: usize, nulls: usize) -> String {
    let have = if count == 1 { "has" } else { "have" };
    format!("{count} of {nulls} null cases {have} a false alarm")
}

fn sentences(of: &Scoreboard, named: Rate, wrong: usize) -> Vec<String> {
    let mut all = Vec::new();
    if named.of > 0 {
        all.push(format!(
            "Found: effects of the right kind on the right joint or link, {} of {}. False positives: {wrong}.",
            named.count, named.of
        ));
    }
    for group in &of.groups {
        if let Some(spread) = group.after_over_reachable {
            all.push(format!(
                "{} cases: the hold-out error is {} times the error of the true laws (median over {} affected joints; \
                 90 % quantile {}).",
                capital(&group.kind),
                number(spread.median, 3),
                spread.count,
                number(spread.p90, 3)
            ));
        }
    }
    let unanswered: usize = of.groups.iter().map(|g| g.unanswered).sum();
    if unanswered > 0 {
        all.push(format!("{} failed.", counted(unanswered, "case")));
    }
    all
}

/// The same case again, alone.
fn next(of: &Scoreboard, drawing: &Drawing) -> Vec<Step> {
    let failed = |case: &Case| {
        !case.missed.is_empty() || !case.false_names.is_empty() || case.false_alarm == Some(true)
    };
    let Some(number) = of.cases.iter().position(failed) else { return Vec::new() };
    let step = Step::new(format!("Inspect a failed case: {}.", of.cases[number].case));
    // numbers of cases are those of the series only where all of it was made
    let whole = ["--only", "--score", "--study"];
    let made = &drawing.provenance.command;
    if made.is_empty() || made.iter().any(|word| whole.contains(&word.as_str())) {
        return vec![step];
    }
    let mut words = made.iter().peekable();
    let mut again = Vec::new();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--report" | "--json" | "--keep" | "--fail-on" => _ = words.next(),
            _ => again.push(word.as_str()),
        }
    }
    vec![step.by(format!("{} --only {} --keep case/", again.join(" "), number + 1))]
}

fn overview(of: &Scoreboard) -> Vec<figures::Figure> {
    let mut all = Vec::new();
    let bins: Vec<Reliability> = of
        .reliability
        .iter()
        .filter(|bin| bin.right.of > 0)
        .map(|bin| Reliability {
            confidence: bin.confidence,
            right: bin.right.count as f64 / bin.right.of as f64,
            interval: bin.interval_95,
            count: bin.right.of,
        })
        .collect();
    all.extend(figures::reliability(&bins));
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for (truth, named) in of.groups.iter().flat_map(|group| &group.confusion) {
        for (name, count) in named {
            *confusion
                .entry(effect_label(truth))
                .or_default()
                .entry(effect_label(name))
                .or_default() += count;
        }
    }
    all.extend(figures::confusion(&confusion));
    let mut ratios = Vec::new();
    for case in &of.cases {
        let effects = if case.effects.is_empty() {
            vec!["nothing".to_owned()]
        } else {
            case.effects.iter().map(|effect| effect_label(effect)).collect()
        };
        for effect in effects {
            let mut add = |what: &'static str, values: &BTreeMap<String, f64>| {
                for (joint, ratio) in values {
                    let place = format!("{}, {joint}", case.case);
                    ratios.push((what, case.kind.as_str(), effect.clone(), place, *ratio));
                }
            };
            add("hold-out / reachable", &case.holdout.after_over_reachable);
            if let Some(exam) = &case.exam {
                add("prediction / noise", &exam.over_oracle);
            }
        }
    }
    all.extend(figures::over_floors(&ratios));
    all
}

fn group(of: &Group) -> Section {
    let spread = |spread: Option<Spread>| {
        spread.map_or_else(
            || "-".to_owned(),
            |s| {
                format!(
                    "{} to {}, median {}, 90 % {} ({} numbers)",
                    number(s.least, 3),
                    number(s.largest, 3),
                    number(s.median, 3),
                    number(s.p90, 3),
                    s.count
                )
            },
        )
    };
    let rows = [
        ("cases", of.cases.to_string()),
        ("detected: cases with effects and a finding", of.detected.written()),
        ("false alarms: null cases with a finding", of.false_alarms.written()),
        ("recall", of.recall.written()),
        ("precision", of.precision.written()),
        ("F1", number(of.f1, 3)),
        ("first finding correct, cases of one effect", of.top1.written()),
        ("joints located", of.located.written()),
        ("parameter error, relative", spread(of.parameter_error)),
        ("95 % interval coverage", of.within_interval.written()),
        ("hold-out error / reachable error", spread(of.after_over_reachable)),
        ("hold-out error, given / diagnosed", spread(of.improvement)),
        ("prediction error / noise", spread(of.exam_over_oracle)),
        (
            "over-optimistic cases (prediction error over 25 % above the hold-out's)",
            of.over_claims.written(),
        ),
    ];
    let rows = rows.into_iter().map(|(what, value)| vec![what.to_owned(), value]).collect();
    let effects = of
        .effects
        .iter()
        .map(|row| {
            vec![
                effect_label(&row.effect),
                row.named.written(),
                row.false_names.to_string(),
                row.parameter_error.map_or_else(|| "-".to_owned(), |s| percent(s.median)),
                row.parameter_error.map_or_else(|| "-".to_owned(), |s| percent(s.largest)),
            ]
        })
        .collect();
    let header = ["effect", "found", "false positives", "parameter error, median", "worst"];
    let tables = vec![
        Grid::new("Scores", &["score", "value"], 2).with(rows),
        Grid::new("By effect", &header, 1).with(effects),
    ];
    Section::new(of.kind.clone(), format!("{} cases", capital(&of.kind)), Vec::new(), tables)
}

fn cases(of: &Scoreboard) -> Section {
    let rows = of
        .cases
        .iter()
        .map(|case| {
            let verdict = match (&case.unanswered, case.false_alarm) {
                (Some(why), _) => format!("failed: {why}"),
                (None, Some(true)) => "false alarm".to_owned(),
                (None, Some(false)) => "true negative".to_owned(),
                (None, None) => format!("{} of {} found", case.named.len(), case.pairs.len()),
            };
            vec![
                case.case.clone(),
                case.robot.clone(),
                case.kind.clone(),
                case.pairs.join(", "),
                verdict,
                case.missed.join(", "),
                case.false_names.join(", "),
            ]
        })
        .collect();
    let header = ["case", "robot", "kind", "hidden", "verdict", "missed", "false positives"];
    let table = Grid::new("Cases", &header, header.len()).with(rows);
    Section::new("cases", "Cases", Vec::new(), vec![table])
}
