//! What the page of a diagnosis says in words: the verdict, what to do next, why not a look-alike.

use armident_effects::{Place, effect, is_less};
use armident_report::{small_terms_text, uncertain};

use super::{Diagnosis, DoubtfulChange, Errors, Fault, Finding, NextMotion, Number, OPEN, WHITE};
use crate::drawing::Drawing;
use crate::kinds::ByJoint;
use crate::page::{Step, number, percent};

/// The sentence; of findings its first clause, the rest is said below.
pub(super) fn headline(of: &Diagnosis) -> String {
    if of.sentence.is_empty() {
        return format!("{} findings", of.findings.len());
    }
    if !of.books.faults.is_empty() {
        return capital(&of.sentence);
    }
    capital(of.sentence.split([';', ',']).next().unwrap_or_default())
}

pub(super) fn title(slug: &str) -> String {
    effect(slug).map_or_else(
        || {
            if slug == "unmodelled" {
                "structure without a name".to_owned()
            } else {
                slug.replace('_', " ")
            }
        },
        |e| e.law().title.to_owned(),
    )
}

/// The title of what was found; of friction that falls, for one, that it is less.
pub(super) fn title_of(finding: &Finding) -> String {
    let value = |name: &str| finding.parameters.get(name).map(|number| number.value);
    let less = if is_less(&finding.effect, value) { "less " } else { "" };
    format!("{less}{}", title(&finding.effect))
}

/// Changes that are not named because they may have been there before, or because they may be chance.
fn doubtful(of: &Diagnosis, maybe_before: bool) -> Option<String> {
    let name =
        |change: &DoubtfulChange| title_on(&change.effect, change.link.as_ref(), &change.joints);
    let changes = of.doubtful_changes.iter().filter(|change| change.maybe_before == maybe_before);
    let names: Vec<String> = changes.map(name).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

pub(super) fn place(finding: &Finding) -> String {
    finding.link.clone().unwrap_or_else(|| finding.joints.join(", "))
}

pub(super) fn size(finding: &Finding) -> String {
    // in the order of the law, the first says most
    let names: Vec<&str> = match effect(&finding.effect) {
        Some(e) => e.law().parameters.iter().map(|p| p.name).collect(),
        None => finding.parameters.keys().map(String::as_str).collect(),
    };
    let first = names.iter().find_map(|n| finding.parameters.get_key_value(*n));
    let first = first.or_else(|| finding.parameters.iter().next());
    first.map_or_else(String::new, |(name, n)| {
        let (value, error) = written(n);
        let error = error.map_or_else(String::new, |e| format!(" \u{b1} {e}"));
        format!("{} {value}{error} {}", name.replace('_', " "), n.unit)
    })
}

pub(super) fn written(n: &Number) -> (String, Option<String>) {
    match n.stderr {
        Some(stderr) => {
            let (value, error) = uncertain(n.value, stderr);
            (value, Some(error))
        }
        None => (number(n.value, 3), None),
    }
}

fn sure(confidence: f64) -> &'static str {
    match confidence {
        c if c >= 0.9 => "clear",
        c if c >= 0.65 => "likely",
        _ => "at the limit of what these recordings show",
    }
}

/// How sure it is that there is an effect, and what these recordings cannot tell it from: its place may be open where the
/// effect itself is clear.
pub(super) fn certainty(finding: &Finding) -> String {
    let sure = sure(finding.confidence);
    let rivals: Vec<String> = finding
        .alternatives
        .iter()
        .map(|a| title_on(&a.effect, a.link.as_ref(), &a.joints))
        .collect();
    if rivals.is_empty() {
        return sure.to_owned();
    }
    format!("{sure}, but it may be {}", rivals.join(" or "))
}

/// An effect and its place.
fn title_on(slug: &str, link: Option<&String>, joints: &[String]) -> String {
    let place = link.cloned().unwrap_or_else(|| joints.join(", "));
    let title = title(slug);
    if place.is_empty() { title } else { format!("{title} on {place}") }
}

pub(super) fn proof(of: &Diagnosis) -> Option<(&Errors, &'static str)> {
    let holdout = of.fit.holdout.as_ref().map(|e| (e, "hold-out"));
    holdout.or_else(|| of.fit.train.as_ref().map(|e| (e, "training")))
}

pub(super) fn sentences(of: &Diagnosis) -> Vec<String> {
    if !of.books.faults.is_empty() {
        let mut all: Vec<String> =
            of.books.faults.iter().map(|f| format!("{}{}.", on(f), f.message)).collect();
        all.push("Nothing is said of physics before the columns are right.".to_owned());
        return all;
    }
    let mut all = Vec::new();
    let largest: Vec<String> = of
        .findings
        .iter()
        .take(OPEN)
        .map(|f| {
            let place = place(f);
            let on = if place.is_empty() { String::new() } else { format!(" on {place}") };
            format!("{}{on} ({}, {})", title_of(f), size(f), certainty(f))
        })
        .collect();
    if !largest.is_empty() {
        let lead = if of.findings.len() > largest.len() { "The largest: " } else { "" };
        all.push(capital(&format!("{lead}{}.", largest.join("; "))));
    }
    if let Some(clause) = unexplained(of) {
        all.push(capital(&format!("{clause}.")));
    }
    if let Some((errors, kind)) = proof(of) {
        let ratio = |after: &ByJoint| -> Vec<(f64, String)> {
            let mut all: Vec<(f64, String)> = of
                .joints
                .iter()
                .filter_map(|j| Some((j, *after.get(j)?, *errors.before.get(j)?)))
                // what was noise before can be no better after
                .filter(|(j, _, before)| of.effort_noise.get(*j).is_none_or(|n| *before > 2.0 * n))
                .map(|(j, after, before)| (after / before, j.clone()))
                .filter(|(r, _)| r.is_finite())
                .collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            all
        };
        let (after, rigid) = (ratio(&errors.after), ratio(&errors.rigid));
        if let (Some(middle), Some(middle_rigid), Some(worst)) =
            (after.get(after.len() / 2), rigid.get(rigid.len() / 2), after.last())
        {
            let model = match of.findings.is_empty() {
                true => "The model learned leaves",
                false => "With these effects the model leaves",
            };
            all.push(format!(
                "{model} {} of the given model's error on the {kind} recordings \
                 (median joint; {} on {}, the worst). Its links identified again without any effect leave {}.",
                percent(middle.0),
                percent(worst.0),
                worst.1,
                percent(middle_rigid.0),
            ));
        }
        let left = of
            .joints
            .iter()
            .filter_map(|j| Some((errors.after.get(j)? / of.effort_noise.get(j)?, j)))
            .filter(|(r, _)| r.is_finite())
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((times, joint)) = left {
            all.push(format!(
                "Sample by sample the model errs there by at most {} times the noise of a sample ({joint}).",
                number(times, 2)
            ));
        }
    }
    let unconfirmed: Vec<String> = of
        .findings
        .iter()
        .filter(|f| f.confirmed == Some(false))
        .map(|f| format!("{} on {}", title_of(f), place(f)))
        .collect();
    let confirmed = of.findings.iter().filter(|f| f.confirmed == Some(true)).count();
    if !unconfirmed.is_empty() {
        all.push(format!(
            "The hold-out does not confirm {}: it is predicted no better with it.",
            unconfirmed.join(", ")
        ));
    } else if confirmed > 0 && confirmed == of.findings.len() {
        all.push(format!(
            "The hold-out confirms {}: without it, all else fitted again, it is predicted worse.",
            if confirmed == 1 { "the finding" } else { "every finding" }
        ));
    }
    if let Some(replay) = &of.replay {
        let worst = replay.after.iter().max_by(|a, b| a.1.total_cmp(b.1));
        if let Some((joint, after)) = worst {
            let before = replay.before.get(joint).copied().unwrap_or(f64::NAN);
            all.push(format!(
                "Driven by the recorded efforts for {} s, the simulated arm is off by {} at most (RMS in rad or m of \
                 the position, {joint}; {} before).",
                number(replay.window_s, 3),
                number(*after, 2),
                number(before, 2)
            ));
        }
    }
    let coloured: Vec<&str> =
        of.whiteness_p.iter().filter(|w| *w.1 < WHITE).map(|w| w.0.as_str()).collect();
    if !coloured.is_empty() {
        all.push(format!(
            "What is left on {} is not white: something small is still left out there.",
            coloured.join(", ")
        ));
    }
    if !of.small_terms.is_empty() {
        all.push(format!(
            "Too small to be named, the model also has {}.",
            small_terms_text(&of.small_terms)
        ));
    }
    if let Some(hz) = of.narrowed_to_hz {
        all.push(format!(
            "Efforts and motions were compared below {hz} Hz: above, they do not go together as they do below (positions that \
             shake by themselves, or a controller that answers its encoder)."
        ));
    }
    if !of.beyond_reference.is_empty() {
        all.push(format!(
            "Motion much faster than the reference's was not compared, for the reference does not say what friction is there \
             (rad/s or m/s in the reference: {}).",
            speeds(&of.beyond_reference)
        ));
    }
    if let Some(names) = doubtful(of, true) {
        all.push(format!(
            "Not named, because it may have been so before (the reference does not show it): {names}."
        ));
    }
    if let Some(names) = doubtful(of, false) {
        all.push(format!("Not named, because it may be chance: {names}."));
    }
    let limit = of.findings.iter().filter(|f| f.confidence < 0.65).count();
    if limit > 0 {
        all.push(format!(
            "{} of the findings only just matter{} against the noise.",
            limit,
            if limit == 1 { "s" } else { "" }
        ));
    }
    all.extend(
        of.books.unchecked.iter().map(|why| format!("The columns were not checked: {why}.")),
    );
    if of.findings.is_empty() {
        all.push(
            "Effects clearly smaller than the noise of one recorded sample are not named."
                .to_owned(),
        );
    }
    all
}

/// The clause of the first sentence that says what is left unexplained.
fn unexplained(of: &Diagnosis) -> Option<&str> {
    of.sentence.split("; ").find(|clause| clause.ends_with("left unexplained"))
}

/// Joints with their speeds.
fn speeds(of: &ByJoint) -> String {
    let of_joint = |(joint, speed): (&String, &f64)| format!("{joint} {}", number(*speed, 2));
    of.iter().map(of_joint).collect::<Vec<_>>().join(", ")
}

/// The joint of a fault.
fn on(fault: &Fault) -> String {
    fault.joint.as_ref().map_or_else(String::new, |joint| format!("{joint}: "))
}

pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}

pub(super) fn next(of: &Diagnosis, drawing: &Drawing) -> Vec<Step> {
    if !of.books.faults.is_empty() {
        let mut steps: Vec<Step> = of
            .books
            .faults
            .iter()
            .filter_map(|f| Some(Step::new(format!("{}{}", on(f), f.advice.as_ref()?))))
            .collect();
        steps.push(Step::new("Diagnose again; --trust-columns takes the columns as they are."));
        return steps;
    }
    let mut steps = Vec::new();
    let channel: Vec<String> = of
        .findings
        .iter()
        .filter(|f| {
            let place = effect(&f.effect).and_then(|e| e.law().roles.first().copied());
            matches!(place, Some(Place::Gain | Place::Zero | Place::Time))
        })
        .map(|f| format!("{} {}", title_of(f), f.joints.join(", ")).trim().to_owned())
        .collect();
    if !channel.is_empty() {
        steps.push(Step::new(format!(
            "Correct the channels first ({}): in a mapping file, or in the drive.",
            channel.join("; ")
        )));
    }
    if of.findings.iter().any(|f| f.effect == "external_contact") {
        steps.push(Step::new(
            "Record the motion again with nothing near the arm: a contact hides other effects.",
        ));
    }
    let rivals: Vec<&Finding> = of.findings.iter().filter(|f| !f.alternatives.is_empty()).collect();
    match &of.next_motion {
        Some(NextMotion {
            file: Some(file),
            description: Some(motion),
            told_apart,
            pairs,
            separation,
        }) => {
            let by = separation.map_or_else(String::new, |s| {
                format!(", efforts differ by {} times the noise of a sample", number(s, 2))
            });
            steps.push(Step::new(format!(
                "Record the motion in {file} ({motion}): it tells {told_apart} of {pairs} pairs of look-alikes \
                 apart{by}."
            )));
        }
        _ if !rivals.is_empty() => {
            let names: Vec<String> = rivals
                .iter()
                .take(OPEN)
                .map(|f| format!("{} on {}", title_of(f), place(f)))
                .collect();
            steps.push(
                Step::new(format!(
                    "To be sure of {}, record a motion that tells {} from the alternatives.",
                    names.join(", "),
                    if names.len() == 1 { "it" } else { "them" }
                ))
                .by(with_option(drawing, "--next-motion FOLDER")),
            );
        }
        _ => {}
    }
    if !of.findings.is_empty() {
        let step = Step::new(
            "Use the model with these effects: save it, and predict the efforts of other motions.",
        );
        let command = &drawing.provenance.command;
        steps.push(if command.is_empty() || command.iter().any(|a| a.contains("--save-model")) {
            step.by("armident predict model.json motion.csv -o predicted.csv")
        } else {
            step.by(with_option(drawing, "--save-model model.json"))
        });
    }
    if of.holdout_recordings.is_empty() {
        steps.push(
            Step::new("Prove it on a recording that was not fitted.")
                .by(with_option(drawing, "--holdout other.csv")),
        );
    }
    if !of.beyond_reference.is_empty() {
        steps.push(Step::new(format!(
            "Record a reference that is as fast as these recordings (rad/s or m/s so far: {}).",
            speeds(&of.beyond_reference)
        )));
    }
    if let Some(names) = doubtful(of, true) {
        steps.push(Step::new(format!(
            "To know whether {names} changed, record the motions of these recordings with the arm as it was, as reference."
        )));
    }
    if of.findings.is_empty() {
        steps.push(Step::new(match unexplained(of) {
            Some(_) => {
                "What is left has no name: what it goes with stands with the joint. Longer recordings, and other \
                 motions, may name it."
            }
            None => {
                "Nothing has to change. To see smaller effects record more slowly, more often, or with less noise."
            }
        }));
    }
    steps
}

/// The command of the result with one more option.
fn with_option(drawing: &Drawing, option: &str) -> String {
    format!("{} {option}", without_report(&drawing.provenance.command).join(" ")).trim().to_owned()
}

fn without_report(command: &[String]) -> Vec<&str> {
    let mut kept = Vec::new();
    let mut words = command.iter();
    while let Some(word) = words.next() {
        if word == "--report" || word == "--json" {
            words.next();
        } else if word != "--traces" {
            kept.push(word.as_str());
        }
    }
    kept
}

/// What a finding may be taken for: what the result says of it, and what tells them apart.
pub(super) fn look_alikes(finding: &Finding, of: &Diagnosis) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = finding
        .alternatives
        .iter()
        .map(|a| {
            let more = a.left_more.map_or_else(String::new, |m| {
                format!("; it leaves only {} noise levels of a sample more", number(m.max(0.0), 2))
            });
            let apart = a.separated_by.as_ref().map_or_else(
                || "; a motion that tells them apart: --next-motion".to_owned(),
                |motion| format!(". What tells them apart: {motion}"),
            );
            (
                title_on(&a.effect, a.link.as_ref(), &a.joints),
                format!("these recordings cannot tell it from this finding{more}{apart}"),
            )
        })
        .collect();
    let Some(law) = effect(&finding.effect).map(|e| e.law()) else { return all };
    for other in law.look_alikes {
        if finding.alternatives.iter().any(|a| a.effect == other.slug) {
            continue;
        }
        let beside =
            of.findings.iter().any(|f| f.effect == other.slug && f.joints == finding.joints);
        let lead = if beside {
            "found beside it, each counted with the other fitted. What tells them apart:"
        } else if effect(other.slug).is_some() {
            "was tried and not chosen. What tells them apart:"
        } else {
            "what tells them apart:"
        };
        all.push((title(other.slug), format!("{lead} {}", other.separated_by)));
    }
    all
}
