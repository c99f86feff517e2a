//! The scoreboard for people.

use std::fmt::Write as _;

use armident_report::aligned;

use crate::score::scoreboard::{GroupScore, Rate, ReliabilityBin, Scoreboard, Spread};

impl Scoreboard {
    /// Tables: the sums, effect by effect, confusion, reliability, then cases with something wrong.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for group in &self.groups {
            text += &group_text(group);
        }
        if self.groups.len() > 1 {
            let _ =
                writeln!(text, "Reliability over all cases\n{}", reliability(&self.reliability));
        }
        let wrong: Vec<String> = self.cases.iter().filter_map(case_line).collect();
        if !wrong.is_empty() {
            let _ = writeln!(text, "Cases with something wrong\n{}", wrong.join("\n"));
        }
        text
    }
}

/// A count with its share.
pub(crate) fn rate(rate: Rate) -> String {
    if rate.of == 0 {
        return "-".to_owned();
    }
    format!("{} of {} ({:.1} %)", rate.count, rate.of, 100.0 * rate.share())
}

/// With what it is at most, with 95 % certainty.
fn bounded(of: Rate) -> String {
    if of.of == 0 {
        return "-".to_owned();
    }
    format!("{}, at most {:.1} % with 95 % certainty", rate(of), 100.0 * of.at_most())
}

fn spread(spread: Option<Spread>) -> String {
    spread.map_or("-".to_owned(), |s| {
        format!("median {:.3}, 90 % {:.3}, worst {:.3} ({})", s.median, s.p90, s.largest, s.count)
    })
}

/// Of numbers that should be large.
fn spread_down(spread: Option<Spread>) -> String {
    spread.map_or("-".to_owned(), |s| {
        format!("median {:.3}, worst {:.3} ({})", s.median, s.least, s.count)
    })
}

fn group_text(group: &GroupScore) -> String {
    let baseline = group.baseline;
    let line = |name: &str, value: String| vec![name.to_owned(), value];
    let mut rows = vec![
        line("cases", group.cases.to_string()),
        line("failed", group.unanswered.to_string()),
        line("detected", rate(group.detected)),
        line("false alarms", bounded(group.false_alarms)),
        line("recall", rate(group.recall)),
        line("precision", rate(group.precision)),
        line("F1", format!("{:.3}", group.f1)),
        line("effect only: recall", rate(group.slug_recall)),
        line("effect only: precision", rate(group.slug_precision)),
        line("missed, listed as alternative", rate(group.missed_in_alternatives)),
        line("cases with more false positives than effects", group.discredited.to_string()),
        line("first finding right", rate(group.top1)),
        line("located", rate(group.located)),
        line("window, intersection over union", spread_down(group.window_iou)),
        line("parameter error, relative", spread(group.parameter_error)),
        line("95 % interval coverage", rate(group.within_interval)),
        line("standardised error", spread(group.standardized_error)),
        line("variables, Jaccard", spread_down(group.variables)),
        line("hold-out after / noise", spread(group.after_over_oracle)),
        line("hold-out after / attainable", spread(group.after_over_attainable)),
        line("hold-out after / reachable", spread(group.after_over_reachable)),
        line("hold-out before / after", spread_down(group.improvement)),
        line("prediction / noise", spread(group.exam_over_oracle)),
        line("prediction / attainable", spread(group.exam_over_attainable)),
        line("predictions failed", rate(group.exam_failed)),
        line("over-optimistic cases", rate(group.over_claims)),
        line("suspicious", group.suspicious.to_string()),
    ];
    if baseline.counted > 0 {
        let named = Rate { count: baseline.named, of: baseline.counted };
        let near = Rate { count: baseline.within_factor_2, of: baseline.with_level };
        rows.push(line("baseline friction found", rate(named)));
        rows.push(line("baseline level within a factor of 2", rate(near)));
    }
    let mut text = format!("{} cases\n{}\n", group.kind, aligned(&["", ""], &rows, 2).trim_start());
    let effects: Vec<Vec<String>> = group
        .effects
        .iter()
        .map(|row| {
            let error = row.parameter_error.map_or("-".to_owned(), |s| {
                format!("{:.1} %, worst {:.1} %", 100.0 * s.median, 100.0 * s.largest)
            });
            let named = format!("{}/{}", row.named.count, row.named.of);
            vec![row.effect.clone(), named, row.false_names.to_string(), error]
        })
        .collect();
    text += &aligned(&["effect", "named", "false", "parameter error"], &effects, 1);
    let mut confusion = String::new();
    for (truth, named) in &group.confusion {
        let wrong: Vec<String> = named
            .iter()
            .filter(|(name, _)| *name != truth)
            .map(|(name, count)| format!("{name} {count}"))
            .collect();
        if !wrong.is_empty() {
            let _ = writeln!(confusion, "  {truth}: {}", wrong.join(", "));
        }
    }
    if !confusion.is_empty() {
        let _ = write!(text, "\nConfusion (hidden: reported instead)\n{confusion}");
    }
    text += "\nReliability\n";
    text += &reliability(&group.reliability);
    text.push('\n');
    text
}

/// Claims and right ones by confidence.
fn reliability(bins: &[ReliabilityBin]) -> String {
    let width = 1.0 / bins.len() as f64;
    let rows: Vec<Vec<String>> = bins
        .iter()
        .enumerate()
        .map(|(k, bin)| {
            let mean = format!("{:.2}", bin.confidence);
            vec![
                format!("{:.1} to {:.1}", k as f64 * width, (k + 1) as f64 * width),
                if bin.right.of > 0 { mean } else { "-".to_owned() },
                rate(bin.right),
            ]
        })
        .collect();
    aligned(&["confidence", "mean", "right"], &rows, 1)
}

/// What is wrong with a case, if anything.
fn case_line(case: &crate::score::case_score::CaseScore) -> Option<String> {
    let mut wrong = Vec::new();
    let mut list = |what: &str, items: &[String]| {
        if !items.is_empty() {
            wrong.push(format!("{what} {}", items.join(", ")));
        }
    };
    list("failed:", case.unanswered.as_slice());
    list("missed", &case.missed);
    list("false positives", &case.false_names);
    list("over-optimistic on", &case.holdout.over_claimed);
    list("suspicious:", &case.holdout.suspicious);
    if let Some(exam) = &case.exam {
        list("prediction failed:", exam.failed.as_slice());
        let far =
            |(joint, ratio): (&String, &f64)| (*ratio > FAR).then(|| format!("{joint} {ratio:.2}"));
        let far: Vec<String> = exam.over_attainable.iter().filter_map(far).collect();
        list("prediction / attainable:", &far);
    }
    if case.false_alarm == Some(true) && case.false_names.is_empty() {
        wrong.push("mismatch on an exact null case".to_owned());
    }
    (!wrong.is_empty()).then(|| format!("  {} ({}): {}", case.case, case.robot, wrong.join("; ")))
}

/// Predictions beyond this multiple of the attainable error are listed.
const FAR: f64 = 1.2;
