//! Every estimator of `identify` beside plain least squares.

use std::error::Error;
use std::path::Path;

use armident_ident::checks::with_drive_signals;
use armident_ident::estimators::{ALL, Estimator, Ols, TrainingData};
use armident_ident::{
    BatchProblem, BatchSettings, IdentifyRequest, MinimalSet, Prepared, used_samples,
};
use armident_motion::Motion;

use crate::sets::{Data, KeptOut, SETS, Set};

/// Blocks that a hold-out is divided into, for the standard error of the difference of two errors.
pub(crate) const BLOCKS: usize = 8;
/// The estimator of `identify` unless another is given.
const DEFAULT: &str = "irls";
/// Share of a recording that is fitted where there is only one.
const TRAINING_SHARE: f64 = 2.0 / 3.0;

/// The table, and how each method does against plain least squares.
pub(crate) fn print(folder: &Path) -> Result<(), Box<dyn Error>> {
    println!("## Estimators\n");
    println!(
        "RMS effort error (N m; N; V for bam-xl330) on hold-out motion, and in brackets on training motion. \
         Sets with one recording are split at two thirds of its length. Efforts are low-passed at the frequency \
         in the set's `dataset.toml`. *Plain* is ordinary least squares of the minimal set with viscous and \
         Coulomb friction, offset and rotor inertia: no weights, no sign constraints, no prior, velocities \
         differentiated from positions. The other columns are the results of `identify`: projected to \
         physically consistent links, with the model structure selected by cross-validation on the training \
         motion. Bold: lowest error of a row. Joints whose effort column has a dead zone are listed but not \
         counted: the column differs from the joint's effort, and predictions are scaled by the share of the \
         effort that it shows in the training motion.\n"
    );
    println!("| set | joint | plain | {} |", ALL.map(Estimator::name).join(" | "));
    println!("| --- | --- |{}", " ---: |".repeat(1 + ALL.len()));
    let mut gains = vec![Vec::new(); ALL.len()];
    let mut notes = Vec::new();
    for set in &SETS {
        table(set, folder, &mut gains, &mut notes)?;
    }
    println!("\nError relative to *plain*, geometric mean over all counted joints:\n");
    for (estimator, logs) in ALL.iter().zip(&gains) {
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let above = logs.iter().filter(|log| **log > 0.0).count();
        println!(
            "* `{}`: {:.3}, above *plain* on {above} of {}",
            estimator.name(),
            mean.exp(),
            logs.len()
        );
    }
    println!();
    for note in notes {
        println!("* {note}");
    }
    Ok(())
}

fn table(
    set: &Set,
    root: &Path,
    gains: &mut [Vec<f64>],
    notes: &mut Vec<String>,
) -> Result<(), Box<dyn Error>> {
    let data = Data::read(set, root)?;
    let (train, holdout) = data.split(KeptOut::Last, 1.0 - TRAINING_SHARE)?;
    let [train, holdout] = [train, holdout].map(|r| with_drive_signals(&r).0);
    let Data { model, .. } = &data;
    let names = model.chain.joint_names();
    let arm = model.rigid_arm();
    let minimal = MinimalSet::of(&arm)?;
    let (train_motions, holdout_motions) = (data.motions(&train)?, data.motions(&holdout)?);
    let all: Vec<&Motion> = train_motions.iter().collect();

    let plain = BatchProblem::new(&arm, &minimal);
    let rows = plain.accumulate(&all);
    let judged = plain.accumulate(&holdout_motions.iter().collect::<Vec<_>>());
    let mut default_blocks = None;
    let training = TrainingData { model, motions: &all, rows: &rows };
    let found = Ols.fit(&plain, &training, &BatchSettings::PLAIN)?;
    let plain_blocks = block_errors(&plain, &holdout_motions, &found.values);
    let mut columns = vec![(plain.fit(&judged, &found.values), plain.fit(&rows, &found.values))];
    let request = IdentifyRequest {
        holdout: &holdout,
        cutoff_hz: Some(data.cutoff_hz),
        decimate: false,
        ..IdentifyRequest::new(model, &train)
    };
    let prepared = Prepared::of(&request)?;
    let dead_zone_shares = prepared.dead_zone_shares();
    for (name, share) in names.iter().zip(dead_zone_shares) {
        let Some(share) = share else { continue };
        notes.push(format!(
            "{}: the effort column of {name} has a dead zone (one value in {:.0} % of the moving samples), not counted",
            set.folder,
            100.0 * share
        ));
    }
    let chosen = prepared.structure();
    for found in &chosen.couplings {
        let [a, b] = found.coupling.joints().map(|joint| names[joint]);
        notes.push(format!(
            "{}: coupled transmission of {a} and {b} (ratio {}, cross-validated error {:.0} % lower)",
            set.folder,
            found.coupling.ratio,
            100.0 * found.gain
        ));
    }
    if let Some(relative) = chosen.settings.link_prior {
        notes.push(format!("{}: prior scale {:.0} %", set.folder, 100.0 * relative));
    }
    for estimator in ALL {
        match prepared.fit(estimator) {
            Ok(found) => {
                let judged = found.errors.holdout.clone().ok_or("no hold-out")?;
                if let Some(tested) = found.estimate.endogeneity() {
                    let term = found.problem.label(&found.problem.terms[tested.term], &names);
                    notes.push(format!(
                        "{}: Durbin-Wu-Hausman p = {:.2} (largest shift: {term}, {:+.1} standard errors)",
                        set.folder, tested.p, tested.t
                    ));
                }
                if estimator.name() == DEFAULT {
                    default_blocks =
                        Some(block_errors(&found.problem, &found.holdout_motions, found.values()));
                }
                columns.push((judged, found.errors.train.clone()));
            }
            Err(error) => {
                notes.push(format!("{}, {}: {error}", set.folder, estimator.name()));
                columns.push((Vec::new(), Vec::new()));
            }
        }
    }
    for (j, joint) in names.iter().enumerate() {
        let error = |k: usize| columns[k].0.get(j).map(|f| f.rmse);
        let least = (0..columns.len()).filter_map(error).fold(f64::INFINITY, f64::min);
        let cells: Vec<String> = columns
            .iter()
            .map(|(judged, trained)| match (judged.get(j), trained.get(j)) {
                (Some(judged), Some(trained)) => {
                    let bold = if judged.rmse == least { "**" } else { "" };
                    format!("{bold}{:.4}{bold} ({:.4})", judged.rmse, trained.rmse)
                }
                _ => "-".to_owned(),
            })
            .collect();
        println!("| {} | {joint} | {} |", set.folder, cells.join(" | "));
        if dead_zone_shares[j].is_some() {
            continue;
        }
        let place = 1 + ALL.iter().position(|estimator| estimator.name() == DEFAULT).unwrap_or(0);
        if let (Some(found), Some(plain), Some(of_default)) =
            (error(place), error(0), &default_blocks)
            && found > plain
        {
            notes.push(format!(
                "{}: {joint} is {:.0} % above *plain* with `irls`, {:.1} standard errors of the mean of {} \
                 blocks of the hold-out (logarithms of the errors)",
                set.folder,
                100.0 * (found / plain - 1.0),
                in_errors(&of_default[j], &plain_blocks[j]),
                plain_blocks[j].len(),
            ));
        }
        for (k, gains) in gains.iter_mut().enumerate() {
            if let (Some(found), Some(plain)) = (error(k + 1), error(0)) {
                gains.push((found / plain).ln());
            }
        }
    }
    Ok(())
}

/// Per joint, the errors on blocks of motions.
fn block_errors(problem: &BatchProblem, motions: &[Motion], values: &[f64]) -> Vec<Vec<f64>> {
    let mut errors = vec![Vec::new(); problem.arm().dof()];
    let each = BLOCKS.div_ceil(motions.len());
    for motion in motions {
        let used = used_samples(motion);
        let at = |k: usize| used.start + k * used.len() / each;
        for k in 0..each {
            let rows = problem.accumulate_part(motion, at(k)..at(k + 1));
            for (errors, fit) in errors.iter_mut().zip(problem.fit(&rows, values)) {
                errors.push(fit.rmse);
            }
        }
    }
    errors
}

/// Mean logarithm of the ratio of errors, over its standard error.
pub(crate) fn in_errors(of: &[f64], other: &[f64]) -> f64 {
    let logs: Vec<f64> = of.iter().zip(other).map(|(a, b)| (a / b).ln()).collect();
    let count = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / count;
    let scatter: f64 = logs.iter().map(|x| (x - mean).powi(2)).sum();
    mean / (scatter / (count * (count - 1.0))).sqrt()
}
