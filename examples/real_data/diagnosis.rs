//! The diagnosis beside a plain identification.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use armident_diagnose::{
    Books, DiagnosedModel, Diagnosis, Finding, Placebo, diagnose_with_placebo,
};
use armident_ident::{
    ArmModel, BatchFit, BatchProblem, BatchSettings, Method, MinimalSet, Recorded, unreported,
};
use armident_recording::Recording;

use crate::estimators::{STRETCHES, in_errors};
use crate::sets::{Data, SETS, part};

/// Share of a recording that is fitted where there is only one; it is cut in two.
const TRAINING_SHARE: f64 = 0.7;
/// Wrong terms a set.
const PLACEBOS: usize = 20;

/// The tables, what is named, and what becomes of wrong terms.
pub(crate) fn print(folder: &Path) -> Result<(), Box<dyn Error>> {
    println!("\n## What the diagnosis is worth\n");
    println!(
        "Root mean square error of the efforts as recorded, not filtered, no sample left out, on motion that \
         was not fitted: of a single recording the last {:.0} %, the rest in two halves is the training. *Plain* \
         is the plain least squares of above, *identified* `identify` with its default (`irls`, the nearest real links), on \
         the same training. In brackets the mean logarithm of the ratio \
         over {STRETCHES} stretches of the hold-out, in its standard errors. What is named was named \
         without the hold-out. A joint whose column is not what its name says is left out.\n",
        100.0 * (1.0 - TRAINING_SHARE)
    );
    println!("| set | joint | as given | plain | identified | diagnosed | diagnosed / plain |");
    println!("| --- | --- | ---: | ---: | ---: | ---: | ---: |");
    let mut logs = Vec::new();
    let mut of_identified = Vec::new();
    let mut found = Vec::new();
    let mut total = Placebo::default();
    let mut largest = Vec::new();
    for set in &SETS {
        let data = Data::read(set, folder)?;
        let (train, holdout) = data.train_and_holdout(|whole| {
            let (first, last) = (whole.time_s[0], whole.time_s[whole.len() - 1]);
            let at = |share: f64| first + share * (last - first);
            let between = |from: f64, to: f64| part(whole, |t| at(from) <= t && t < at(to));
            let half = 0.5 * TRAINING_SHARE;
            let kept_out = part(whole, |t| t >= at(TRAINING_SHARE))?;
            Ok((vec![between(0.0, half)?, between(half, TRAINING_SHARE)?], vec![kept_out]))
        })?;
        let books = Books::of(&data.model, &train)?;
        let in_effort = |r: &Vec<Recording>| -> Vec<Recording> {
            r.iter().map(|r| books.in_effort(r)).collect()
        };
        let (train, holdout) = (in_effort(&train), in_effort(&holdout));
        let heard = heard(&data.model, books, &train)?;
        let Some(Said { mut diagnosis, placebo, books }) = heard else {
            println!("| {} | all | - | - | - | columns in doubt |", set.folder);
            continue;
        };
        diagnosis.confirm(&diagnosis.see(&holdout)?)?;
        let plain = plain_errors(&data, &train, &holdout)?;
        let identified = identified_errors(&data, &train, &holdout)?;
        let after = diagnosed_errors(&diagnosis.model, &holdout)?;
        let given = diagnosed_errors(&diagnosis.believed, &holdout)?;
        for (j, joint) in data.model.chain.joint_names().iter().enumerate() {
            let [given, plain, identified, after] =
                [&given[j], &plain[j], &identified[j], &after[j]];
            if books.faults.iter().any(|fault| fault.joint.as_deref() == Some(joint)) {
                println!(
                    "| {} | {joint} | {:.4} | {:.4} | {:.4} | - | left out |",
                    set.folder, given.rmse, plain.rmse, identified.rmse
                );
                continue;
            }
            let ratio = after.rmse / plain.rmse;
            logs.push(ratio.ln());
            of_identified.push((identified.rmse / plain.rmse).ln());
            println!(
                "| {} | {joint} | {:.4} | {:.4} | {:.4} | {:.4} | {ratio:.2} ({:+.1}) |",
                set.folder,
                given.rmse,
                plain.rmse,
                identified.rmse,
                after.rmse,
                in_errors(&after.stretches, &plain.stretches),
            );
        }
        total.terms += placebo.terms;
        total.improve += placebo.improve;
        total.named += placebo.named;
        let of_set = format!("{} {:.0} %", set.folder, 100.0 * placebo.largest);
        largest.push(of_set);
        found.push((set.folder, diagnosis, books));
    }
    let mean = logs.iter().sum::<f64>() / logs.len() as f64;
    let identified = (of_identified.iter().sum::<f64>() / of_identified.len() as f64).exp();
    logs.sort_by(f64::total_cmp);
    let median = logs[logs.len() / 2].exp();
    let above = logs.iter().filter(|log| **log > 0.0).count();
    println!(
        "\nGeometric mean of the ratio: **{:.3}**, median {median:.2}, above 1 on {above} of {} (`identify`: {identified:.3}). Of {} wrong terms (laws of the \
         library on columns shifted in time) {} lower the error of stretches that were not fitted by more \
         than its standard error, {} would have been named. The largest matters, in what a name asks for: {}.",
        mean.exp(),
        logs.len(),
        total.terms,
        total.improve,
        total.named,
        largest.join(", ")
    );
    for (set, diagnosis, books) in &found {
        println!("\n### {set}\n");
        for fault in &books.faults {
            let joint = fault.joint.as_deref().unwrap_or("all");
            println!("* columns of {joint}: {}", fault.message);
        }
        for finding in &diagnosis.findings {
            println!("* {}", in_words(finding));
        }
        if diagnosis.findings.is_empty() {
            println!("* nothing is named");
        }
    }
    Ok(())
}

/// Of one set.
struct Said {
    diagnosis: Diagnosis,
    placebo: Placebo,
    books: Books,
}

fn heard(
    model: &ArmModel,
    mut books: Books,
    train: &[Recording],
) -> Result<Option<Said>, Box<dyn Error>> {
    let mut placebo = Placebo::default();
    let heard = books.hear(model.chain.dof(), train, &[], |train, _| {
        let (diagnosis, tried) = diagnose_with_placebo(model, train, Some(PLACEBOS))?;
        placebo = tried.unwrap_or_default();
        Ok(diagnosis)
    });
    Ok(match heard {
        Some(heard) => Some(Said { diagnosis: heard?, placebo, books }),
        None => None,
    })
}

/// Of one joint on the hold-out.
struct JointError {
    rmse: f64,
    stretches: Vec<f64>,
}

/// Errors of predicted efforts, `[recording][joint][sample]`.
fn errors(
    joints: &[&str],
    holdout: &[Recording],
    predicted: &[Vec<Vec<f64>>],
) -> Result<Vec<JointError>, Box<dyn Error>> {
    let of_joint = |(j, name): (usize, &&str)| {
        let mut squares = Vec::new();
        for (recording, predicted) in holdout.iter().zip(predicted) {
            let channels = recording.joints.iter().find(|c| c.name == **name);
            let effort = channels.and_then(|c| c.effort.as_ref()).ok_or("no effort")?;
            squares.extend(effort.iter().zip(&predicted[j]).map(|(e, p)| (e - p).powi(2)));
        }
        squares.retain(|s| !s.is_nan());
        let rms = |s: &[f64]| (s.iter().sum::<f64>() / s.len() as f64).sqrt();
        let stretches = squares.chunks(squares.len().div_ceil(STRETCHES)).map(rms).collect();
        Ok(JointError { rmse: rms(&squares), stretches })
    };
    joints.iter().enumerate().map(of_joint).collect()
}

fn diagnosed_errors(
    model: &DiagnosedModel,
    holdout: &[Recording],
) -> Result<Vec<JointError>, Box<dyn Error>> {
    let predicted = holdout.iter().map(|r| model.predict(r)).collect::<Result<Vec<_>, _>>()?;
    errors(&model.arm.chain.joint_names(), holdout, &predicted)
}

/// Of plain least squares, fitted through the low-pass of the set's baseline. It predicts from the same
/// positions, velocities and accelerations as the diagnosed model.
fn plain_errors(
    data: &Data,
    train: &[Recording],
    holdout: &[Recording],
) -> Result<Vec<JointError>, Box<dyn Error>> {
    let model = &data.model;
    let arm = model.rigid_arm();
    let minimal = MinimalSet::of(&arm)?;
    let problem = BatchProblem::new(&arm, &minimal);
    let motions = data.motions(train)?;
    let all: Vec<_> = motions.iter().collect();
    let (_, found, _) = problem.solve_by(Method::Ols, model, &all, &BatchSettings::PLAIN)?;
    errors_with(data, &problem, &minimal, &found.values, holdout)
}

/// With the values of an estimate, through the low-pass of the set's baseline.
fn errors_with(
    data: &Data,
    problem: &BatchProblem<'_>,
    minimal: &MinimalSet,
    values: &[f64],
    holdout: &[Recording],
) -> Result<Vec<JointError>, Box<dyn Error>> {
    let model = data.model.clone().with_constants(minimal, &problem.constants(values));
    let mut found = DiagnosedModel::believed(&model);
    let effects = problem.effects(values, &model.chain.joint_names());
    let (couplings, own) = effects.into_iter().partition(|on| on.other_joint.is_some());
    (found.learned.couplings, found.arm.effects) = (couplings, own);
    found.learned.rigid_cutoff_hz = data.cutoff_hz;
    diagnosed_errors(&found, holdout)
}

/// What, where, how large, how sure.
fn in_words(finding: &Finding) -> String {
    let number = |(name, of): (&&str, &armident_diagnose::Value)| {
        let error = of.stderr.map_or_else(String::new, |e| format!(" +- {e:.2}"));
        format!("{name} {:.3}{error} {}", of.value, of.unit).trim_end().to_owned()
    };
    let parameters: &BTreeMap<_, _> = &finding.parameters;
    let numbers: Vec<String> = parameters.iter().map(number).collect();
    let confirmed = match finding.confirmed {
        Some(true) => ", confirmed",
        Some(false) => ", not confirmed",
        None => "",
    };
    let numbers =
        if numbers.is_empty() { String::new() } else { format!(": {}", numbers.join(", ")) };
    format!("{} (confidence {:.2}{confirmed}){numbers}", named(finding), finding.confidence)
}

/// What, and where.
pub(crate) fn named(finding: &Finding) -> String {
    let place = finding.link.clone().unwrap_or_else(|| finding.joints.join(", "));
    format!("{}, {place}", finding.effect.replace('_', " "))
}

/// Of the default of `identify`, through the same low-pass, predicted the same way.
fn identified_errors(
    data: &Data,
    train: &[Recording],
    holdout: &[Recording],
) -> Result<Vec<JointError>, Box<dyn Error>> {
    let model = &data.model;
    let names = model.chain.joint_names();
    let arm = model.rigid_arm();
    let minimal = MinimalSet::of(&arm)?;
    let is_unreported = unreported(train, &names).iter().map(Option::is_some).collect();
    let mut problem = BatchProblem::new(&arm, &minimal).with_unreported(is_unreported);
    let motions = data.motions(train)?;
    let chosen =
        problem.choose(&motions.iter().collect::<Vec<_>>(), &BatchSettings::default(), true)?;
    let none = Recorded { recordings: &[], motions: &[] };
    let fitted = BatchFit::of(
        &problem,
        model,
        Method::Irls,
        &chosen.settings,
        Recorded { recordings: train, motions: &motions },
        none,
    )?;
    let values = problem.nearest_consistent(&fitted.estimate)?.estimated;
    errors_with(data, &problem, &minimal, &values, holdout)
}
