//! Many arms without efforts, and a table of what was named.

use armident_diagnose::diagnose_servos;
use armident_ident::ServoRequest;
use rayon::prelude::*;
use serde::Serialize;

use super::command_case::command_case;
use super::command_score::{CommandScore, ControllerEstimate, NamedEffect};
use crate::error::ChallengeError;
use crate::score::scoreboard::Rate;
use crate::studies::study::{counted, fraction, markdown, percent};

/// Keeps the seeds of two series apart, and those of nulls from those of cases.
const SERIES_SEEDS: u64 = 1_000_033;
const NULL_SEEDS: u64 = 500_000;
/// Sizes at which the power is given, in standard deviations of the noise of a position.
const SIZES: [f64; 5] = [1.0, 3.0, 10.0, 30.0, 100.0];
/// Share of a stiffness, and time \[s\], within which an estimate is said to be right.
const STIFFNESS_WITHIN: f64 = 0.05;
const DELAY_WITHIN_S: f64 = 0.003;

/// A series of cases. The same series gives the same cases.
#[derive(Debug, Clone, Copy)]
pub struct CommandSeries {
    /// Arms with hidden effects.
    pub cases: u64,
    /// Arms with controllers alone.
    pub nulls: u64,
    /// Random seed.
    pub seed: u64,
}

/// The scores of a series.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CommandScoreboard {
    /// `armident.command-scoreboard/1`.
    pub schema: &'static str,
    /// Case by case, nulls last.
    pub cases: Vec<CommandScore>,
}

impl CommandSeries {
    /// Makes, diagnoses and scores all cases; `done` is called after each.
    ///
    /// # Errors
    /// A case that cannot be simulated.
    pub fn run(self, done: &(dyn Fn() + Sync)) -> Result<CommandScoreboard, ChallengeError> {
        let start = self.seed.wrapping_mul(SERIES_SEEDS);
        let cases =
            (0..self.cases).map(|k| (format!("c{:04}", k + 1), start.wrapping_add(k), false));
        let nulls = (0..self.nulls)
            .map(|k| (format!("n{:04}", k + 1), start.wrapping_add(NULL_SEEDS + k), true));
        let orders: Vec<(String, u64, bool)> = cases.chain(nulls).collect();
        let scores: Result<Vec<CommandScore>, ChallengeError> = orders
            .into_par_iter()
            .map(|(name, seed, is_null)| {
                let score = score(name, seed, is_null);
                done();
                score
            })
            .collect();
        Ok(CommandScoreboard { schema: "armident.command-scoreboard/1", cases: scores? })
    }
}

fn score(name: String, seed: u64, is_null: bool) -> Result<CommandScore, ChallengeError> {
    let case = command_case(seed, is_null)?;
    let found = diagnose_servos(&ServoRequest {
        model: &case.model,
        train: &case.train,
        train_gains: &vec![1.0; case.train.len()],
        holdout: std::slice::from_ref(&case.holdout),
        holdout_gains: &[1.0],
        ablations: true,
    });
    Ok(match found {
        Ok(found) => CommandScore::of(name, is_null, &case, &found),
        Err(error) => CommandScore::failed(name, is_null, &case.robot, error.to_string()),
    })
}

impl CommandScoreboard {
    /// Nulls with a false name, of all.
    pub fn false_alarms(&self) -> Rate {
        let nulls = self.cases.iter().filter(|case| case.is_null);
        let alarms: Vec<bool> = nulls.map(|case| !case.false_names.is_empty()).collect();
        Rate::over(alarms.iter())
    }

    /// The tables, in Markdown.
    pub fn text(&self) -> String {
        let hidden = || self.cases.iter().filter(|case| !case.is_null);
        let effects: Vec<&NamedEffect> = hidden().flat_map(|case| &case.effects).collect();
        let mut slugs: Vec<&str> = effects.iter().map(|effect| effect.effect).collect();
        slugs.sort_unstable();
        slugs.dedup();
        let rate = |slug: Option<&str>, from: f64, to: f64| {
            let of = effects.iter().filter(|effect| slug.is_none_or(|slug| effect.effect == slug));
            let named: Vec<bool> = of
                .filter(|effect| (from..to).contains(&effect.size))
                .map(|effect| effect.is_named)
                .collect();
            fraction(Rate::over(named.iter()))
        };
        let ends = SIZES[1..].iter().copied().chain([f64::INFINITY]);
        let bins: Vec<(f64, f64)> = SIZES.into_iter().zip(ends).collect();
        let row = |name: &str, slug: Option<&str>| {
            let by_size = bins.iter().map(|(from, to)| rate(slug, *from, *to));
            std::iter::once(name.to_owned()).chain(by_size).collect::<Vec<String>>()
        };
        let mut rows: Vec<Vec<String>> = slugs.iter().map(|slug| row(slug, Some(slug))).collect();
        rows.push(row("all", None));
        let titles = bins.iter().map(|(from, to)| match to.is_finite() {
            true => format!("{from} to {to}"),
            false => format!("above {from}"),
        });
        let titles: Vec<String> = std::iter::once("effect".to_owned()).chain(titles).collect();
        let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
        let alarms = self.false_alarms();
        let false_names = |is_null: bool| {
            let of = self.cases.iter().filter(|case| case.is_null == is_null);
            let names = of.flat_map(|case| &case.false_names);
            let names = names.map(|name| name.split(' ').next().unwrap_or(name).to_owned());
            let names = counted(names);
            if names.is_empty() { "none".to_owned() } else { names }
        };
        let failed: Vec<String> = self
            .cases
            .iter()
            .filter_map(|case| {
                Some(format!("* {} ({}): {}\n", case.case, case.robot, case.error.as_ref()?))
            })
            .collect();
        let title = if failed.is_empty() { "" } else { "\nNo diagnosis:\n\n" };
        format!(
            "Named on the right joint, or listed as what a named law may be instead, by size: RMS change of the positions\n\
             without it, in standard deviations of the noise of a recorded position, before other laws take a share of it.\n\n\
             {}\nFalse positives (dry friction or an offset on a joint without it): {} in {} cases with effects.\n\
             Nulls with a false positive: {} (at most {}, 95 %): {}.\n\n{}{title}{}",
            markdown(&titles, &rows, 1),
            false_names(false),
            hidden().count(),
            fraction(alarms),
            percent(alarms.at_most()),
            false_names(true),
            self.numbers(),
            failed.concat(),
        )
    }

    /// How far controllers are from the true ones.
    fn numbers(&self) -> String {
        let all: Vec<&ControllerEstimate> =
            self.cases.iter().flat_map(|case| &case.controllers).collect();
        let rate = |of: &dyn Fn(&ControllerEstimate) -> Option<bool>| {
            let values: Vec<bool> = all.iter().filter_map(|one| of(one)).collect();
            fraction(Rate::over(values.iter()))
        };
        let near = |one: &ControllerEstimate| {
            one.stiffness_ratio.map(|ratio| (ratio - 1.0).abs() <= STIFFNESS_WITHIN)
        };
        let is_within = |deviation: f64| deviation.abs() <= 2.0;
        let rows = [
            ("stiffness determined", rate(&|one| Some(one.stiffness_ratio.is_some()))),
            ("stiffness within 5 %, of those", rate(&near)),
            (
                "stiffness within two standard errors",
                rate(&|one| one.stiffness_deviation.map(is_within)),
            ),
            ("delay within 3 ms", rate(&|one| Some(one.delay_error_s.abs() <= DELAY_WITHIN_S))),
            ("delay within two standard errors", rate(&|one| one.delay_deviation.map(is_within))),
        ];
        let rows: Vec<Vec<String>> =
            rows.into_iter().map(|(name, rate)| vec![name.to_owned(), rate]).collect();
        markdown(&["controllers, all cases", "joints"], &rows, 1)
    }
}
