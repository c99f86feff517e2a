//! Studies: series of cases, and a table of what came out.

use std::collections::BTreeMap;

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

use crate::cases::request::hideable;
use crate::contract::kind::CaseKind;
use crate::score::case_score::CaseScore;
use crate::score::scoreboard::{Rate, Scoreboard};
use crate::studies::series::{CaseSeries, Order, Outcome, SeriesKind};

/// Magnitudes of the power study, in naming margins.
const MARGINS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// Keeps the seeds of the effects of the power study apart.
const POWER_SEEDS: u64 = 7_919;

/// A question that a table answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Study {
    /// False alarm rate.
    Nulls,
    /// Detection power against effect size.
    Power,
    /// Laws that deviate from the library.
    Perturbed,
    /// All in all, clean and field cases in turn.
    Mixed,
    /// Hard cases: several effects, poor recordings.
    Hard,
    /// Changes between two sets of recordings of one arm.
    Change,
}

impl Study {
    /// Cases where their number is not given; of the power study for each effect and magnitude.
    pub fn default_cases(self) -> u64 {
        match self {
            Self::Nulls => 200,
            Self::Power => 2,
            Self::Perturbed => 24,
            Self::Mixed => 96,
            Self::Hard | Self::Change => 40,
        }
    }

    /// The cases to be made. `kind` is that of the power study; the others have theirs.
    pub fn orders(self, cases: u64, seed: u64, kind: CaseKind) -> Vec<Order> {
        let series = |kind, perturbed| CaseSeries {
            cases,
            seed,
            kind,
            effects: Vec::new(),
            arm: None,
            perturbed,
            margin: None,
        };
        match self {
            Self::Nulls => series(SeriesKind::Null, false).orders(),
            Self::Mixed => series(SeriesKind::Mixed, false).orders(),
            Self::Hard => series(SeriesKind::Hard, false).orders(),
            Self::Change => series(SeriesKind::Change, false).orders(),
            Self::Perturbed => series(SeriesKind::Mixed, true).orders(),
            Self::Power => power_orders(cases, seed, kind),
        }
    }

    /// The table, in Markdown, below a sentence that says what it shows.
    pub fn text(self, orders: &[Order], outcomes: &[Outcome]) -> String {
        let made: Vec<(&Order, &CaseScore)> = orders
            .iter()
            .zip(outcomes)
            .filter_map(|(order, outcome)| Some((order, outcome.score.as_ref()?)))
            .collect();
        let cases = || Scoreboard::new(made.iter().map(|(_, score)| (*score).clone()).collect());
        match self {
            Self::Nulls => nulls(&made),
            Self::Power => power(orders, &made),
            Self::Perturbed => perturbed(&made) + &in_full(&cases()),
            Self::Mixed => in_full(&cases()),
            Self::Hard => HARD.to_owned() + &in_full(&cases()),
            Self::Change => CHANGE.to_owned() + &in_full(&cases()),
        }
    }
}

/// What the table of changes shows.
const CHANGE: &str = "\
Field arms with inertial errors of every link, recorded before and after. Between, an effect was hidden, sometimes two
or none; in half of the cases the friction of every joint changes as well (warm or cold: 0.6 to 1.2 times its
viscous part, the square root of that its dry part), which may be reported where it does. Inertial errors are no change:
a link that is reported without having changed is a false positive.
";

/// What the table of hard cases shows.
const HARD: &str = "\
Field arms with up to four effects, at 40 to 125 Hz, some with a joint that barely moves or with point-to-point motion
and standstills. Each has recording faults: stamps of reception, an effort clock that drifts, a low-pass in the drive,
coarse efforts, clipped efforts, spikes, a missing second.
";

fn in_full(board: &Scoreboard) -> String {
    format!("\n```text\n{}```\n", board.text())
}

/// The same arms, motions and noise at every magnitude of an effect.
fn power_orders(cases: u64, seed: u64, kind: CaseKind) -> Vec<Order> {
    let mut orders = Vec::new();
    for (e, effect) in hideable(kind).into_iter().enumerate() {
        for margin in MARGINS {
            let series = CaseSeries {
                cases,
                seed: seed.wrapping_mul(POWER_SEEDS).wrapping_add(e as u64),
                kind: match kind {
                    CaseKind::Clean => SeriesKind::Clean,
                    CaseKind::Field => SeriesKind::Field,
                    CaseKind::Hard => SeriesKind::Hard,
                    CaseKind::Change => SeriesKind::Change,
                },
                effects: vec![effect.to_owned()],
                arm: None,
                perturbed: false,
                margin: Some(margin),
            };
            orders.extend(
                series.orders().into_iter().map(|order| Order {
                    name: format!("{effect}_{margin}_{}", order.name),
                    ..order
                }),
            );
        }
    }
    orders
}

pub(crate) fn markdown(header: &[&str], rows: &[Vec<String>], left: usize) -> String {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.iter().map(ToString::to_string).collect::<Vec<_>>());
    for row in rows {
        table.add_row(row.clone());
    }
    for column in table.column_iter_mut().skip(left) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{table}\n")
}

pub(crate) fn fraction(rate: Rate) -> String {
    if rate.of == 0 { "-".to_owned() } else { format!("{}/{}", rate.count, rate.of) }
}

pub(crate) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

pub(crate) fn counted(names: impl IntoIterator<Item = String>) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    counts.iter().map(|(name, n)| format!("{name} {n}")).collect::<Vec<_>>().join(", ")
}

fn slug(blame: &str) -> String {
    blame.split('(').next().unwrap_or(blame).to_owned()
}

fn nulls(made: &[(&Order, &CaseScore)]) -> String {
    let kind = |order: &Order| match (order.kind, order.background) {
        (CaseKind::Clean, Some(0.0)) => "exact",
        (CaseKind::Clean, _) => "inertial errors of 2 to 5 %",
        (_, Some(0.0)) => "baseline friction, recording faults",
        (_, _) => "baseline friction, recording faults, inertial errors of 2 to 5 %",
    };
    let mut kinds: Vec<&str> = Vec::new();
    for (order, _) in made {
        if !kinds.contains(&kind(order)) {
            kinds.push(kind(order));
        }
    }
    let row = |name: &str, of: &dyn Fn(&Order) -> bool| {
        let cases: Vec<&CaseScore> =
            made.iter().filter(|(order, _)| of(order)).map(|(_, score)| *score).collect();
        let alarms: Vec<bool> = cases.iter().filter_map(|case| case.false_alarm).collect();
        let rate = Rate::over(alarms.iter());
        let names = cases.iter().flat_map(|case| &case.false_names).map(|name| slug(name));
        vec![
            name.to_owned(),
            rate.of.to_string(),
            rate.count.to_string(),
            percent(rate.at_most()),
            counted(names),
        ]
    };
    let mut rows: Vec<Vec<String>> =
        kinds.iter().map(|name| row(name, &|order| kind(order) == *name)).collect();
    rows.push(row("all", &|_| true));
    let baseline = made.iter().fold([0; 2], |[named, of], (_, case)| {
        [named + case.baseline.named, of + case.baseline.counted]
    });
    let wrong: Vec<String> = made
        .iter()
        .filter(|(_, case)| case.false_alarm == Some(true))
        .map(|(_, case)| {
            let names = if case.false_names.is_empty() {
                "mismatch without a finding".to_owned()
            } else {
                case.false_names.join(", ")
            };
            format!("* {} ({}): {names}\n", case.case, case.robot)
        })
        .collect();
    format!(
        "Cases without a hidden effect. A finding is false unless it is baseline friction that is there, or\n\
         `link_inertia_error` where links have errors; so is `mismatch` on an exact null case. The bound is exact\n\
         (Clopper and Pearson, one-sided).\n\n{}\nBaseline friction above the noise: {} of {} found.\n{}{}",
        markdown(
            &["null cases", "cases", "false alarms", "at most (95 %)", "false positives"],
            &rows,
            1
        ),
        baseline[0],
        baseline[1],
        if wrong.is_empty() { "" } else { "\nFalse alarms:\n\n" },
        wrong.concat()
    )
}

fn power(orders: &[Order], made: &[(&Order, &CaseScore)]) -> String {
    let mut effects: Vec<&str> = Vec::new();
    for effect in orders.iter().filter_map(|order| order.effects.first()) {
        if !effects.contains(&effect.as_str()) {
            effects.push(effect);
        }
    }
    let at = |order: &Order, margin: f64| order.margin == Some(margin);
    let named_of = |cases: &mut dyn Iterator<Item = &CaseScore>| {
        let named: Vec<bool> = cases.map(|case| case.missed.is_empty()).collect();
        Rate::over(named.iter())
    };
    let row = |name: &str, of: &dyn Fn(&Order) -> bool| {
        let mut cells = vec![name.to_owned()];
        for margin in MARGINS {
            let mut cases = made
                .iter()
                .filter(|(order, _)| of(order) && at(order, margin))
                .map(|(_, case)| *case);
            cells.push(fraction(named_of(&mut cases)));
        }
        let cases = || made.iter().filter(|(order, _)| of(order)).map(|(_, case)| *case);
        let instead = cases().filter(|case| !case.missed.is_empty()).flat_map(|case| {
            let names: Vec<String> = case.false_names.iter().map(|name| slug(name)).collect();
            if names.is_empty() { vec!["nothing".to_owned()] } else { names }
        });
        let beside = cases()
            .filter(|case| case.missed.is_empty())
            .flat_map(|case| case.false_names.iter().map(|name| slug(name)));
        cells.push(counted(instead));
        cells.push(counted(beside));
        cells
    };
    let mut rows: Vec<Vec<String>> = effects
        .iter()
        .map(|effect| row(effect, &|order| order.effects.first().is_some_and(|e| e == effect)))
        .collect();
    let mut all = row("all", &|_| true);
    // listed by effect above
    all.truncate(1 + MARGINS.len());
    all.extend([String::new(), String::new()]);
    rows.push(all);
    let headers: Vec<String> = MARGINS.iter().map(|margin| format!("{margin} x")).collect();
    let mut header = vec!["effect"];
    header.extend(headers.iter().map(String::as_str));
    header.extend(["missed: reported instead", "found: false positives beside it"]);
    format!(
        "Found at the right location, of all cases, by magnitude: the RMS of the effect's torque over the noise of\n\
         a sample on the most affected joint, after least squares have removed what the rigid body and baseline\n\
         friction explain (the naming margin). {} of {} cases could be made: some effects are never so large or\n\
         so small on the arms that were tried.\n\n{}",
        made.len(),
        orders.len(),
        markdown(&header, &rows, 1)
    )
}

fn perturbed(made: &[(&Order, &CaseScore)]) -> String {
    let mut groups: BTreeMap<(String, &str), Vec<&CaseScore>> = BTreeMap::new();
    for (order, case) in made {
        groups.entry((order.effects.join(", "), order.kind.name())).or_default().push(case);
    }
    let rows: Vec<Vec<String>> = groups
        .iter()
        .map(|((effect, kind), cases)| {
            let named: Vec<bool> = cases.iter().map(|case| case.missed.is_empty()).collect();
            let names = cases.iter().flat_map(|case| &case.false_names).map(|name| slug(name));
            vec![
                effect.clone(),
                (*kind).to_owned(),
                fraction(Rate::over(named.iter())),
                counted(names),
            ]
        })
        .collect();
    format!(
        "The hidden law is near one of the library: Fc tanh(v / width) for Coulomb friction, Dahl friction of\n\
         second order for LuGre friction, a triangular wave for a ripple. The name of the library's law is right;\n\
         its parameters are compared although no law of the library has the hidden torque (the first harmonic\n\
         of a triangle is 0.81 of its height).\n\n{}",
        markdown(&["effect", "cases", "found", "false positives"], &rows, 2)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(score: CaseScore) -> Outcome {
        Outcome { score: Some(score), seconds: 1.0 }
    }

    #[test]
    fn nulls_are_counted_by_kind() {
        let orders = Study::Nulls.orders(8, 5, CaseKind::Clean);
        let outcomes: Vec<Outcome> = (0..orders.len())
            .map(|k| {
                let false_names =
                    if k == 2 { vec!["torque_ripple(a)".to_owned()] } else { Vec::new() };
                outcome(CaseScore {
                    case: orders[k].name.clone(),
                    robot: "r".to_owned(),
                    kind: orders[k].kind.name(),
                    false_alarm: Some(!false_names.is_empty()),
                    false_names,
                    ..CaseScore::default()
                })
            })
            .collect();
        let text = Study::Nulls.text(&orders, &outcomes);
        let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let lines: Vec<String> = text.lines().map(words).collect();
        assert!(lines.contains(&"| exact | 2 | 0 | 77.6 % | |".to_owned()), "{text}");
        let dirty = "| baseline friction, recording faults | 2 | 1 | 97.5 % | torque_ripple 1 |";
        assert!(lines.contains(&dirty.to_owned()), "{text}");
        assert!(lines.contains(&"| all | 8 | 1 | 47.1 % | torque_ripple 1 |".to_owned()), "{text}");
        assert!(lines.contains(&"* n0003 (r): torque_ripple(a)".to_owned()), "{text}");
    }

    #[test]
    fn power_is_listed_by_effect_and_magnitude() {
        let orders = Study::Power.orders(1, 5, CaseKind::Field);
        let outcomes: Vec<Outcome> = orders
            .iter()
            .map(|order| match order.margin {
                // no arm shows the smallest, and the next is missed
                Some(1.0) => Outcome { score: None, seconds: 0.0 },
                Some(2.0) => outcome(CaseScore {
                    missed: vec![order.effects[0].clone()],
                    false_names: vec!["torque_ripple(a)".to_owned()],
                    ..CaseScore::default()
                }),
                _ => outcome(CaseScore::default()),
            })
            .collect();
        let text = Study::Power.text(&orders, &outcomes);
        let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let lines: Vec<String> = text.lines().map(words).collect();
        let row = "| backlash | - | 0/1 | 1/1 | 1/1 | torque_ripple 1 | |";
        assert!(lines.contains(&row.to_owned()), "{text}");
        assert!(!text.contains("viscous_friction"), "field cases have it anyway");
    }
}
