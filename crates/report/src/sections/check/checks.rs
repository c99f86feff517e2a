//! All checks with their verdicts.

use crate::layout::{Block, Table};
use crate::results::{CheckReport, CheckRow, CheckVerdict};
use crate::section::Section;

/// The checks: those of the arm, then joint by joint; on a page worst first.
pub(crate) struct Checks;

impl Section<CheckReport> for Checks {
    fn key(&self) -> &'static str {
        "checks"
    }

    fn text(&self, result: &CheckReport) -> Vec<Block> {
        let of = |which: &dyn Fn(&CheckRow) -> bool| -> Vec<Block> {
            result.checks.iter().filter(|check| which(check)).map(status).collect()
        };
        let mut blocks = vec![Block::heading("Recording")];
        blocks.extend(of(&|check| check.joint.is_none()));
        for joint in &result.joints {
            blocks.push(Block::heading(joint));
            blocks.extend(of(&|check| check.joint.as_ref() == Some(joint)));
        }
        let others = of(&|check| check.joint.as_ref().is_some_and(|j| !result.joints.contains(j)));
        if !others.is_empty() {
            blocks.push(Block::heading("Other joints"));
            blocks.extend(others);
        }
        blocks
    }

    fn page(&self, result: &CheckReport) -> Vec<Block> {
        let mut ordered: Vec<&CheckRow> = result.checks.iter().collect();
        ordered.sort_by_key(|check| std::cmp::Reverse(check.verdict));
        let rows = ordered.into_iter().map(|check| {
            vec![
                check.verdict.word().to_owned(),
                check.joint.clone().unwrap_or_else(|| "recording".to_owned()),
                check.topic.words().to_owned(),
                check.message.clone(),
                hint(check),
            ]
        });
        let table =
            Table::new("Checks, worst first", &["verdict", "joint", "topic", "result", "hint"]);
        vec![Block::heading("Checks"), Block::Table(table.with(rows))]
    }
}

fn status(check: &CheckRow) -> Block {
    Block::Status {
        verdict: check.verdict.word().to_owned(),
        text: format!("{}: {}", check.topic.words(), check.message),
        hint: hint(check),
    }
}

/// What to do, unless all is well.
fn hint(check: &CheckRow) -> String {
    check.advice.clone().filter(|_| check.verdict != CheckVerdict::Ok).unwrap_or_default()
}
