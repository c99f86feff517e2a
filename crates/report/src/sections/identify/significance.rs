//! What can and cannot be identified separately, and which parameters are significant.

use super::titles::MINIMAL_SET;
use crate::layout::{Block, significant};
use crate::results::IdentifyReport;
use crate::section::Section;

/// Regrouped and insignificant parameters, and the test of endogeneity.
pub(crate) struct Significance;

/// p-value below which least squares is biased.
const BIASED: f64 = 0.05;

impl Section<IdentifyReport> for Significance {
    fn key(&self) -> &'static str {
        "significance"
    }

    fn text(&self, result: &IdentifyReport) -> Vec<Block> {
        lines(result).into_iter().map(Block::Line).collect()
    }

    fn page(&self, result: &IdentifyReport) -> Vec<Block> {
        let lines = lines(result);
        let heading = (!lines.is_empty()).then(|| Block::heading(MINIMAL_SET));
        heading.into_iter().chain(lines.into_iter().map(Block::Line)).collect()
    }
}

fn lines(result: &IdentifyReport) -> Vec<String> {
    let factor = |(label, factor): (&String, &f64)| match (factor - 1.0).abs() < 1e-9 {
        true => label.clone(),
        false => format!("{} {label}", significant(*factor, 3, 0.0)),
    };
    let merged = result.merged.iter().map(|merged| {
        let into: Vec<String> = merged.into.iter().map(factor).collect();
        format!(
            "{} is not separately identifiable on this arm; it is included in {}",
            merged.term,
            into.join(", ")
        )
    });
    let mut lines: Vec<String> = merged.collect();
    let (all, others) = (result.parameters, result.not_significant.len());
    if result.estimator.is_some() && others > 0 {
        let include = match others {
            1 => "interval of the other includes".to_owned(),
            n => format!("intervals of the other {n} include"),
        };
        lines.push(format!(
            "{} of {all} parameters are significant; the 95 % {include} 0: {}",
            all - others,
            result.not_significant.join(", ")
        ));
    }
    lines.extend(result.endogeneity.as_ref().map(|tested| {
        let verdict = match tested.p < BIASED {
            true => "endogeneity, noise in the regressors biases least squares",
            false => "no evidence of endogeneity",
        };
        format!(
            "Durbin-Wu-Hausman test: {verdict} (largest shift: {}, {:+.1} standard errors, p = {})",
            tested.term,
            tested.t,
            significant(tested.p, 2, 0.0)
        )
    }));
    lines
}
