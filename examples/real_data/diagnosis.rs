//! The diagnosis beside a plain identification.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use armident_diagnose::{DiagnoseError, DiagnoseRequest, Diagnosis, Finding, Placebo, diagnose};
use armident_ident::estimators::{Estimator, Ols, TrainingData};
use armident_ident::{BatchProblem, BatchSettings, IdentifyRequest, MinimalSet, identify};
use armident_model::{ArmModel, BandPrediction, PredictError};
use armident_recording::Recording;
use armident_report::unit_after_number;

use crate::estimators::{BLOCKS, in_errors};
use crate::sets::{Data, KeptOut, SETS, part};

/// Share of a recording that is fitted where there is only one; it is cut in two.
const TRAINING_SHARE: f64 = 0.7;
/// Wrong terms a set.
const PLACEBOS: usize = 20;

/// The tables, what is named, and what becomes of wrong terms.
pub(crate) fn print(folder: &Path) -> Result<(), Box<dyn Error>> {
    println!("\n## Accuracy of the diagnosis\n");
    println!(
        "RMS effort error (unfiltered, all samples) on hold-out motion: the last {:.0} % of a single recording; \
         the two halves of the rest are the training recordings. *Plain* is plain least squares as above, \
         *identified* the model saved by `identify` with default options, on the same training recordings with \
         the same low-pass. In brackets: mean logarithm of the ratio over {BLOCKS} blocks of the hold-out, \
         in standard errors; above 1 in the last column `identify` is clearly better. The hold-out is not used for the findings. Joints whose column fails the input \
         check are excluded.\n",
        100.0 * (1.0 - TRAINING_SHARE)
    );
    println!(
        "| set | joint | given | plain | identified | diagnosed | diagnosed / plain | diagnosed / identified |"
    );
    println!("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |");
    let mut all = Vec::new();
    for set in &SETS {
        let data = Data::read(set, folder)?;
        let judged = Judged::of(&data, KeptOut::Last)?;
        judged.print_rows(set.folder);
        all.push((set.folder, data, judged));
    }
    let ratios: Vec<Ratios> = all.iter().flat_map(|(_, _, judged)| judged.ratios()).collect();
    let mean = |of: fn(&Ratios) -> f64, ratios: &[Ratios]| {
        (ratios.iter().map(|r| of(r).ln()).sum::<f64>() / ratios.len() as f64).exp()
    };
    let mut sorted: Vec<f64> = ratios.iter().map(|r| r.diagnosed).collect();
    sorted.sort_by(f64::total_cmp);
    let mut total = Placebo::default();
    let mut largest = Vec::new();
    for (set, _, Judged { diagnosis, .. }) in &all {
        let Some(placebo) = diagnosis.as_ref().and_then(|d| d.placebo.as_ref()) else { continue };
        total.terms += placebo.terms;
        total.improve += placebo.improve;
        total.named += placebo.named;
        largest.push(format!("{set} {:.0} %", 100.0 * placebo.largest));
    }
    println!(
        "\nGeometric mean of the ratio: **{:.3}**, median {:.2}, above 1 on {} of {} (`identify`: {:.3}). \
         Placebo test: of {} wrong terms (laws of the library with time-shifted regressors), {} lower the \
         cross-validated error by more than its standard error and {} would be reported. The largest reaches \
         this share of the materiality threshold: {}.",
        mean(|r| r.diagnosed, &ratios),
        sorted[sorted.len() / 2],
        sorted.iter().filter(|ratio| **ratio > 1.0).count(),
        sorted.len(),
        mean(|r| r.identified, &ratios),
        total.terms,
        total.improve,
        total.named,
        largest.join(", ")
    );
    println!(
        "\nThe same for other hold-outs: the last, first and middle {:.0} % of a recording, or other files. \
         Geometric means over the joints of a set; in brackets the number of joints with a ratio above 1.\n",
        100.0 * (1.0 - TRAINING_SHARE)
    );
    println!("| set | hold-out | joints | identified / plain | diagnosed / plain |");
    println!("| --- | --- | ---: | ---: | ---: |");
    let row = |set: &str, kept_out: &str, ratios: &[Ratios]| {
        let above = |of: fn(&Ratios) -> f64| ratios.iter().filter(|r| of(r) > 1.0).count();
        println!(
            "| {set} | {kept_out} | {} | {:.3} ({}) | {:.3} ({}) |",
            ratios.len(),
            mean(|r| r.identified, ratios),
            above(|r| r.identified),
            mean(|r| r.diagnosed, ratios),
            above(|r| r.diagnosed)
        );
    };
    let mut of_all = Vec::new();
    for (set, data, judged) in &all {
        for &kept_out in data.turns() {
            let ratios = match kept_out {
                KeptOut::Last => judged.ratios(),
                other => Judged::of(data, other)?.ratios(),
            };
            if !ratios.is_empty() {
                row(set, kept_out.name(), &ratios);
            }
            of_all.extend(ratios);
        }
    }
    row("all", "each", &of_all);
    for (set, _, Judged { diagnosis, .. }) in &all {
        let Some(diagnosis) = diagnosis else { continue };
        println!("\n### {set}\n");
        for fault in &diagnosis.input_checks.faults {
            let joint = fault.joint.as_deref().unwrap_or("all");
            println!("* columns of {joint}: {}", fault.message);
        }
        for finding in &diagnosis.findings {
            println!("* {}", in_words(finding));
        }
        if diagnosis.findings.is_empty() {
            println!("* no finding");
        }
    }
    Ok(())
}

/// Errors of one joint over those of plain least squares.
struct Ratios {
    identified: f64,
    diagnosed: f64,
}

/// A set with something kept out.
struct Judged {
    /// none where the columns fail the input checks
    diagnosis: Option<Diagnosis>,
    joints: Vec<String>,
    given: Vec<JointError>,
    plain: Vec<JointError>,
    identified: Vec<JointError>,
    diagnosed: Vec<JointError>,
}

impl Judged {
    fn of(data: &Data, kept_out: KeptOut) -> Result<Self, Box<dyn Error>> {
        let (mut train, holdout) = data.split(kept_out, 1.0 - TRAINING_SHARE)?;
        if data.is_one_recording()
            && let [whole] = train.as_slice()
        {
            train = halves(whole)?;
        }
        let joints: Vec<String> =
            data.model.chain.joint_names().iter().map(|name| (*name).to_owned()).collect();
        let request = DiagnoseRequest {
            holdout: &holdout,
            placebo_terms: Some(PLACEBOS),
            ..DiagnoseRequest::new(&data.model, &train)
        };
        let diagnosis = match diagnose(&request) {
            Err(DiagnoseError::WrongColumns(_)) => {
                let [given, plain, identified, diagnosed] = [const { Vec::new() }; 4];
                return Ok(Self { diagnosis: None, joints, given, plain, identified, diagnosed });
            }
            found => found?,
        };
        let (train, holdout) = (&diagnosis.recordings, &diagnosis.holdout);
        Ok(Self {
            given: diagnosed_errors(&diagnosis.believed, holdout)?,
            plain: plain_errors(data, train, holdout)?,
            identified: identified_errors(data, train, holdout)?,
            diagnosed: diagnosed_errors(&diagnosis.model, holdout)?,
            diagnosis: Some(diagnosis),
            joints,
        })
    }

    /// Whether a joint's column is what its name says.
    fn is_right(&self, joint: usize) -> bool {
        let faults = self.diagnosis.as_ref().map_or(&[][..], |found| &found.input_checks.faults);
        faults.iter().all(|fault| fault.joint.as_ref() != Some(&self.joints[joint]))
    }

    fn ratios(&self) -> Vec<Ratios> {
        let of = |j: usize| Ratios {
            identified: self.identified[j].rmse / self.plain[j].rmse,
            diagnosed: self.diagnosed[j].rmse / self.plain[j].rmse,
        };
        (0..self.plain.len()).filter(|j| self.is_right(*j)).map(of).collect()
    }

    fn print_rows(&self, set: &str) {
        if self.diagnosis.is_none() {
            println!("| {set} | all | - | - | - | - | failed input check | - |");
        }
        for (j, diagnosed) in self.diagnosed.iter().enumerate() {
            let [given, plain, identified] =
                [&self.given, &self.plain, &self.identified].map(|of| &of[j]);
            let joint = &self.joints[j];
            if !self.is_right(j) {
                println!(
                    "| {set} | {joint} | {:.4} | {:.4} | {:.4} | - | excluded | - |",
                    given.rmse, plain.rmse, identified.rmse
                );
                continue;
            }
            println!(
                "| {set} | {joint} | {:.4} | {:.4} | {:.4} | {:.4} | {:.2} ({:+.1}) | {:.2} ({:+.1}) |",
                given.rmse,
                plain.rmse,
                identified.rmse,
                diagnosed.rmse,
                diagnosed.rmse / plain.rmse,
                in_errors(&diagnosed.block_rms, &plain.block_rms),
                diagnosed.rmse / identified.rmse,
                in_errors(&diagnosed.block_rms, &identified.block_rms),
            );
        }
    }
}

/// A recording in two.
fn halves(whole: &Recording) -> Result<Vec<Recording>, Box<dyn Error>> {
    let middle = 0.5 * (whole.time_s[0] + whole.time_s[whole.len() - 1]);
    Ok(vec![part(whole, |t| t < middle)?, part(whole, |t| t >= middle)?])
}

/// Of one joint on the hold-out.
struct JointError {
    rmse: f64,
    block_rms: Vec<f64>,
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
        let block_rms = squares.chunks(squares.len().div_ceil(BLOCKS)).map(rms).collect();
        Ok(JointError { rmse: rms(&squares), block_rms })
    };
    joints.iter().enumerate().map(of_joint).collect()
}

fn diagnosed_errors(
    model: &ArmModel,
    holdout: &[Recording],
) -> Result<Vec<JointError>, Box<dyn Error>> {
    let predicted = holdout
        .iter()
        .map(|r| Ok(model.predict(r, None)?.efforts))
        .collect::<Result<Vec<_>, PredictError>>()?;
    errors(&model.chain.joint_names(), holdout, &predicted)
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
    let rows = problem.accumulate(&all);
    let training = TrainingData { model, motions: &all, rows: &rows };
    let found = Ols.fit(&problem, &training, &BatchSettings::PLAIN)?;
    errors_with(data, &problem, &minimal, &found.values, holdout)
}

/// With the values of an estimate, through the low-pass of the set's baseline.
fn errors_with(
    data: &Data,
    problem: &BatchProblem,
    minimal: &MinimalSet,
    values: &[f64],
    holdout: &[Recording],
) -> Result<Vec<JointError>, Box<dyn Error>> {
    let model = minimal.applied_to(data.model.clone(), &problem.constants(values));
    let mut found = model.links_in_band();
    found.effects = problem.effects(values, &model.chain.joint_names());
    let band = BandPrediction::of(found.chain.dof());
    found.band = Some(BandPrediction { rigid_cutoff_hz: data.cutoff_hz, ..band });
    diagnosed_errors(&found, holdout)
}

/// What, where, how large, how sure.
fn in_words(finding: &Finding) -> String {
    let number = |(name, of): (&&str, &armident_diagnose::Value)| {
        let error = of.stderr.map_or_else(String::new, |e| format!(" +- {e:.2}"));
        let unit = unit_after_number(of.unit);
        format!("{name} {:.3}{error} {unit}", of.value).trim_end().to_owned()
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

/// Of the model that `identify` saves with its defaults, fitted through the same low-pass, predicted as `predict` does.
fn identified_errors(
    data: &Data,
    train: &[Recording],
    holdout: &[Recording],
) -> Result<Vec<JointError>, Box<dyn Error>> {
    let model = &data.model;
    let names = model.chain.joint_names();
    let request = IdentifyRequest {
        cutoff_hz: Some(data.cutoff_hz),
        decimate: false,
        ..IdentifyRequest::new(model, train)
    };
    let found = identify(&request)?.model;
    let predicted = |recording: &Recording| -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
        let motions = data.motions(std::slice::from_ref(recording))?;
        let motion = motions.into_iter().next().ok_or("no motion")?;
        let motion = found.motion_of(motion, recording);
        Ok(found.predict_motion(&motion)?.iter().map(|effort| motion.at_stamps(effort)).collect())
    };
    let predicted = holdout.iter().map(predicted).collect::<Result<Vec<_>, _>>()?;
    errors(&names, holdout, &predicted)
}
