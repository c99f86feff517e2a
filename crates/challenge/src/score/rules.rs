//! The rules of the score: an answer against the truth.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use armident_effects::Scope;

use crate::contract::answer::{Answer, AnswerFinding, AnswerVerdict};
use crate::contract::case::Case;
use crate::contract::files::read_json;
use crate::contract::kind::CaseKind;
use crate::contract::truth::{TrueEffect, Truth};
use crate::error::ChallengeError;
use crate::hidden::UNLISTED;
use crate::score::blame::{Blame, Place, is_body, of_named, of_truth};
use crate::score::case_score::{BaselineScore, CaseScore};
use crate::score::exam::{ExamScore, Table, score_exam};
use crate::score::holdout::score_holdout;
use crate::score::judge::{Judged, Judgement, accepted, judge};
use crate::submission::Submission;

/// Baseline levels are right within this factor.
const RIGHT_FACTOR: f64 = 2.0;

/// Scores one case: a folder with `truth.json`, and one with `out.json` and `predicted.csv`.
///
/// # Errors
/// The truth or the exam of the case cannot be read.
pub fn score_case(case: &Path, result: &Path) -> Result<CaseScore, ChallengeError> {
    let truth: Truth = read_json(&case.join("truth.json"))?;
    let reason = |error: ChallengeError| format!("{}: {error}", error.place());
    let answer: Result<Answer, _> = read_json(&result.join("out.json")).map_err(reason);
    let recorded = |name: &str| Table::read(&case.join(name).with_extension("csv"));
    let predicted = || Table::read(&result.join("predicted.csv")).map_err(reason);
    let exam = match &truth.exam {
        Some(floors) => Some(score_exam(&recorded("exam")?, predicted(), floors, "exam")),
        None if result.join("predicted.csv").is_file() => {
            Some(score_exam(&recorded("holdout")?, predicted(), &truth.holdout, "holdout"))
        }
        None => None,
    };
    Ok(scored(&truth, &answer, exam))
}

/// Scores what a diagnosis made of a case in memory: its answer and its prediction of the exam.
pub fn score_submission(case: &Case, submission: Result<&Submission, String>) -> CaseScore {
    let predicted = submission.clone().and_then(|submission| match &submission.model {
        Some(model) => Ok(Table::of(&model.predicted)),
        None => Err("there is no prediction".to_owned()),
    });
    let floors = case.truth.exam.clone().unwrap_or_default();
    let exam = score_exam(&Table::of(&case.exam), predicted, &floors, "exam");
    let answer = submission.and_then(|submission| {
        let parsed = serde_json::from_str::<Answer>(&submission.out_json);
        parsed.map_err(|error| format!("out.json: {error}"))
    });
    scored(&case.truth, &answer, Some(exam))
}

fn scored(truth: &Truth, answer: &Result<Answer, String>, exam: Option<ExamScore>) -> CaseScore {
    let mut score = score_names(truth, answer.as_ref().ok());
    match answer {
        Ok(answer) => {
            score.holdout = score_holdout(&answer.fit.holdout, truth, exam.as_ref());
        }
        Err(reason) => score.unanswered = Some(reason.clone()),
    }
    score.exam = exam;
    score
}

fn score_names(truth: &Truth, answer: Option<&Answer>) -> CaseScore {
    let findings = answer.map(|answer| answer.findings.as_slice()).unwrap_or_default();
    let judged = judge(truth, findings);
    let false_names: Vec<&Blame> = judged.all(Judgement::False).collect();
    let discredited = false_names.len() > truth.effects.len();
    let mut score = CaseScore {
        case: truth.case.clone(),
        robot: truth.robot.clone(),
        kind: truth.kind().name(),
        effects: truth.effects.iter().map(|effect| effect.effect.clone()).collect(),
        naming_margins: truth.effects.iter().filter_map(|effect| effect.naming_margin).collect(),
        false_names: false_names.iter().map(ToString::to_string).collect(),
        discredited,
        ..CaseScore::default()
    };
    let alternatives: BTreeSet<Blame> = judged
        .findings
        .iter()
        .flat_map(|(finding, _)| finding.alternatives.iter().flat_map(|n| of_named(n, truth)))
        .collect();
    let mut slugs = BTreeSet::new();
    for effect in &truth.effects {
        let by_accept = !accepted(effect, truth, &judged.found).is_empty();
        let wanted = of_truth(effect, truth);
        let mut all_named = true;
        for blame in &wanted {
            score.pairs.push(blame.to_string());
            if !discredited && (by_accept || judged.found.contains(blame)) {
                score.named.push(blame.to_string());
            } else {
                all_named = false;
                score.missed.push(blame.to_string());
                if alternatives.contains(blame) {
                    score.in_alternatives.push(blame.to_string());
                }
            }
        }
        let slug = wanted.first().map_or(effect.effect.clone(), |blame| blame.effect.clone());
        if by_accept || judged.found.iter().any(|blame| blame.effect == slug) {
            score.named_slugs.push(slug.clone());
        }
        confuse(&mut score, &slug, all_named, &false_names);
        slugs.insert(slug);
        score_details(&mut score, effect, truth, &judged);
    }
    if truth.effects.is_empty() {
        confuse(&mut score, "nothing", false_names.is_empty(), &false_names);
    }
    let false_slugs: BTreeSet<&String> = false_names
        .iter()
        .map(|blame| &blame.effect)
        .filter(|slug| !slugs.contains(*slug))
        .collect();
    score.false_slugs = false_slugs.into_iter().cloned().collect();
    score_verdict(&mut score, truth, answer, &judged);
    score.baseline = score_baseline(truth, &judged, &mut score.standardized_errors);
    score.reliability = reliability(truth, findings);
    score
}

fn confuse(score: &mut CaseScore, slug: &str, named: bool, false_names: &[&Blame]) {
    let mut add = |to: &str| score.confusion.push((slug.to_owned(), to.to_owned()));
    if named {
        add(slug);
    } else if false_names.is_empty() {
        add("nothing");
    } else {
        false_names.iter().for_each(|blame| add(&blame.effect));
    }
}

/// Verdict, first finding and joints.
fn score_verdict(
    score: &mut CaseScore,
    truth: &Truth,
    answer: Option<&Answer>,
    judged: &Judged<'_>,
) {
    let mismatch = answer.is_some_and(|answer| answer.verdict == AnswerVerdict::Mismatch);
    if truth.effects.is_empty() {
        let exact = truth.background_inertial_error == 0.0 && truth.kind() == CaseKind::Clean;
        score.false_alarm = Some(!score.false_names.is_empty() || (exact && mismatch));
        return;
    }
    let wrong_body = truth.effects.iter().any(|effect| is_body(&effect.effect));
    let special = |blame: &Blame| match truth.kind() {
        // what is hidden may be friction
        CaseKind::Change => !judged.baseline.contains(blame),
        _ => !blame.is_baseline() && (wrong_body || !blame.is_body()),
    };
    score.detected = Some(match truth.kind() {
        CaseKind::Clean => mismatch,
        CaseKind::Field | CaseKind::Hard | CaseKind::Change => judged.found.iter().any(special),
    });
    let counts = |(_, blames): &&(&AnswerFinding, BTreeSet<Blame>)| {
        matches!(judged.of_finding(blames), Judgement::Right | Judgement::False)
    };
    if truth.effects.len() == 1 {
        let first = judged
            .findings
            .iter()
            .filter(counts)
            .max_by(|(a, _), (b, _)| a.confidence.total_cmp(&b.confidence));
        score.top1 =
            Some(first.is_some_and(|(_, blames)| judged.of_finding(blames) == Judgement::Right));
    }
    let wanted: BTreeSet<Blame> =
        truth.effects.iter().flat_map(|effect| of_truth(effect, truth)).collect();
    let right: BTreeSet<&str> = wanted.iter().flat_map(Blame::joints).collect();
    if right.is_empty() {
        return;
    }
    let blamed: BTreeSet<&str> = judged
        .all(Judgement::Right)
        .chain(judged.all(Judgement::False))
        .flat_map(Blame::joints)
        .collect();
    let hits = blamed.intersection(&right).count();
    score.located = Some(right.is_subset(&blamed) && 2 * hits >= blamed.len());
}

/// Windows, parameters and variables of one effect.
fn score_details(score: &mut CaseScore, effect: &TrueEffect, truth: &Truth, judged: &Judged<'_>) {
    let wanted = of_truth(effect, truth);
    let finding = judged
        .findings
        .iter()
        .filter(|(_, blames)| wanted.is_subset(blames))
        .map(|(finding, _)| *finding)
        .max_by(|a, b| a.confidence.total_cmp(&b.confidence));
    if let Some(window) = effect.window {
        let other = |finding: &AnswerFinding| {
            finding.recording.is_some() && finding.recording != effect.recording
        };
        let found = finding.filter(|finding| !other(finding)).and_then(|f| f.window);
        score.window_iou.push(found.map_or(0.0, |found| intersection_over_union(window, found)));
    }
    let Some(finding) = finding else { return };
    if effect.effect == UNLISTED {
        let (a, b): (BTreeSet<&String>, BTreeSet<&String>) =
            (effect.variables.iter().collect(), finding.evidence.variables.iter().collect());
        let union = a.union(&b).count().max(1) as f64;
        score.variables.push(a.intersection(&b).count() as f64 / union);
    }
    let worst = effect
        .main_parameters
        .iter()
        .map(|name| parameter_error(effect, finding, name))
        .max_by(f64::total_cmp);
    if let Some(worst) = worst {
        score.parameter_errors.push((effect.effect.clone(), worst));
    }
    if finding.joints == effect.joints {
        score.standardized_errors.extend(standardized(finding, &effect.parameters));
    }
}

/// Errors of the parameters of a finding, in standard errors.
fn standardized(finding: &AnswerFinding, exact: &BTreeMap<String, f64>) -> Vec<f64> {
    let error = |(name, exact): (&String, &f64)| {
        let found = finding.parameters.get(name)?;
        let stderr = found.stderr.filter(|stderr| *stderr > 0.0)?;
        Some((found.value? - exact).abs() / stderr)
    };
    exact.iter().filter_map(error).collect()
}

/// Relative error of a parameter; a missing one counts 100 %.
fn parameter_error(effect: &TrueEffect, finding: &AnswerFinding, name: &str) -> f64 {
    let (Some(&exact), Some(found)) =
        (effect.parameters.get(name), finding.parameters.get(name).and_then(|p| p.value))
    else {
        return 1.0;
    };
    let law = armident_effects::effect(&effect.effect).map(|effect| effect.law());
    let parameter = law.and_then(|law| law.parameters.iter().find(|p| p.name == name));
    let neutral = parameter.map_or(0.0, |parameter| parameter.neutral);
    let is_ratio = law.is_some_and(|law| law.scope == Scope::Neighbours)
        && parameter.is_some_and(|parameter| parameter.is_main);
    let (exact, found) = if is_ratio && finding.joints.first() != effect.joints.first() {
        // s = v_b + r v_a over r is v_a + v_b / r: the same pair the other way round
        (exact, 1.0 / found)
    } else {
        (exact - neutral, found - neutral)
    };
    ((found - exact) / exact).abs()
}

fn intersection_over_union(a: [f64; 2], b: [f64; 2]) -> f64 {
    let common = (a[1].min(b[1]) - a[0].max(b[0])).max(0.0);
    let union = (a[1] - a[0]) + (b[1] - b[0]) - common;
    if union > 0.0 { common / union } else { 0.0 }
}

fn score_baseline(truth: &Truth, judged: &Judged<'_>, errors: &mut Vec<f64>) -> BaselineScore {
    let mut score = BaselineScore::default();
    for term in truth.baseline.iter().filter(|term| term.counted) {
        score.counted += 1;
        let at = |effect: &str| Blame {
            effect: effect.to_owned(),
            place: Place::Joint(term.joints.first().cloned().unwrap_or_default()),
        };
        let covered = term.covered_by.as_deref().is_some_and(|law| judged.found.contains(&at(law)));
        let itself = at(&term.effect);
        let finding = judged.findings.iter().find(|(_, blames)| blames.contains(&itself));
        score.named += usize::from(covered || finding.is_some());
        if let Some((finding, _)) = finding {
            // beside a law that contains it the level is not its own
            if term.covered_by.is_none() {
                errors.extend(standardized(finding, &term.parameters));
            }
            score.with_level += 1;
            let near = term.parameters.iter().any(|(name, exact)| {
                let found = finding.parameters.get(name).and_then(|p| p.value);
                let factor = found.map_or(0.0, |found| found / exact);
                (1.0 / RIGHT_FACTOR..=RIGHT_FACTOR).contains(&factor)
            });
            score.within_factor_2 += usize::from(near);
        }
    }
    score
}

/// All findings, also those of little confidence, judged as if they stood.
fn reliability(truth: &Truth, findings: &[AnswerFinding]) -> Vec<(f64, bool)> {
    let sure: Vec<AnswerFinding> = findings
        .iter()
        .map(|finding| AnswerFinding { confidence: 1.0, ..finding.clone() })
        .collect();
    let judged = judge(truth, &sure);
    let pairs = judged.findings.iter().zip(findings).filter_map(|((_, blames), finding)| {
        match judged.of_finding(blames) {
            Judgement::Right => Some((finding.confidence, true)),
            Judgement::False => Some((finding.confidence, false)),
            Judgement::Tolerated | Judgement::Baseline => None,
        }
    });
    pairs.collect()
}
