//! `armident report A B`.

use armident_report::{ComparisonReport, standard_sections};

use crate::blocks::parts;
use crate::drawing::DrawnQuantity;
use crate::figures;
use crate::view::{Tone, View};

pub(crate) fn view(of: &ComparisonReport) -> View {
    let shown = standard_sections::COMPARISON.iter();
    let shown = shown.map(|section| (section.key(), section.page(of)));
    let headline = of.sentence.split_once(": ").map_or(&*of.sentence, |(_, clauses)| clauses);
    let joints: Vec<String> = of.effort_error.iter().map(|row| row.joint.clone()).collect();
    let errors = |side: usize| of.effort_error.iter().map(|row| row.rmse[side]).collect();
    let names: Vec<String> = of.results.iter().map(|result| result.file.clone()).collect();
    let series: Vec<(String, Vec<Option<f64>>)> =
        names.into_iter().enumerate().map(|(side, name)| (name, errors(side))).collect();
    View {
        kind: "Comparison",
        tone: if of.verdict == "equal" { Tone::Good } else { Tone::Open },
        headline: armident_report::capital(headline),
        sentences: of
            .results
            .iter()
            .zip(["First", "Second"])
            .map(|(result, which)| {
                format!("{which}: {}, fitted to {}.", result.file, result.recordings.join(", "))
            })
            .collect(),
        overview: figures::errors(&joints, &series, DrawnQuantity::Effort).into_iter().collect(),
        sections: parts(shown, |_| None),
        robot: of.robot.clone(),
        warnings: [&of.warnings[..], &of.notes].concat(),
        ..View::default()
    }
}
