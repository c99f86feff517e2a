//! Every method on every public recording, judged on motion it has not seen.
//!
//! The folder holds one folder a set, with its URDF, recordings and `dataset.toml`
//! (`joints`, `baseline.filter_hz`); sets of one recording are cut in two, two thirds for the fit.
//!
//! ```text
//! cargo run --release --example real_data_table -- ../shared/data > docs/real-data.md
//! ```

#![allow(clippy::print_stdout, reason = "the table is the output")]

use std::error::Error;
use std::path::Path;

use armident_ident::check::with_drive_signals;
use armident_ident::{
    ArmModel, BatchFit, BatchProblem, BatchSettings, Method, MinimalSet, Recorded, used_samples,
    with_recorded_velocity,
};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_recording::{
    JointChannels, Mapping, Motion, MotionSettings, Quantity, Recording, read_csv, read_csv_mapped,
};

/// Stretches that a hold-out is cut into, for the scatter of the difference of two errors.
const STRETCHES: usize = 8;
/// Share of a recording that is fitted where there is only one.
const TRAINING_SHARE: f64 = 2.0 / 3.0;

struct Set {
    folder: &'static str,
    training: &'static [&'static str],
    holdout: &'static [&'static str],
    /// makes efforts of what is recorded
    mapping: &'static str,
}

const TIAGO: &str = r#"
[[channel]]
column = "{joint}/current"
quantity = "effort"
unit = "A"
gain = { arm_1_joint = 13.6, arm_2_joint = 13.6, arm_3_joint = -8.7, arm_4_joint = -8.7, arm_5_joint = -20.6, arm_6_joint = -20.6, arm_7_joint = -20.6 }
[[channel]]
column = "{joint}/{quantity}"
"#;

const SETS: [Set; 7] = [
    Set { folder: "ur10-unisa", training: &["train.csv"], holdout: &[], mapping: "" },
    Set { folder: "panda-unisa", training: &["train.csv"], holdout: &[], mapping: "" },
    Set { folder: "staubli-tx40", training: &["train.csv"], holdout: &[], mapping: "" },
    Set { folder: "tiago-arm", training: &["train.csv"], holdout: &[], mapping: TIAGO },
    Set { folder: "dfki-double-pendulum", training: &["train.csv"], holdout: &[], mapping: "" },
    Set {
        folder: "dfki-simple-pendulum",
        training: &["ddp.csv"],
        holdout: &["direct_collocation.csv"],
        mapping: "",
    },
    // voltages: errors are in V, back-EMF is viscous friction
    Set {
        folder: "bam-xl330",
        training: &["sin_sin_kp100.csv", "sin_sin_kp200.csv", "up_and_down_kp200.csv"],
        holdout: &["sin_sin_kp400.csv"],
        mapping: "",
    },
];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("the folder of the sets is missing")?;
    println!("# Every method on public recordings\n");
    println!(
        "Root mean square effort error (N m; N; V for bam-xl330) on motion that was not fitted, and in \
         brackets on the fitted one. Sets of one recording are cut at two thirds of their length. Efforts \
         through the low-pass of the set's `dataset.toml`. *Plain* is least squares of the minimal constants \
         with viscous and Coulomb friction, offset and rotor inertia: no weights, no sign bounds, no prior, \
         velocities from positions. The others are as `identify` gives them: the nearest real links, with \
         what the fitted part chooses by stretches left out of the fit. Bold: the least of a row. Sources and licences are in each set's \
         `dataset.toml`.\n"
    );
    println!(
        "Made by `cargo run --release --example real_data_table -- ../shared/data`, armident {}.\n",
        env!("CARGO_PKG_VERSION")
    );
    println!("| set | joint | plain | {} |", Method::ALL.map(Method::name).join(" | "));
    println!("| --- | --- | ---: | ---: | ---: | ---: | ---: |");
    let mut gains = vec![Vec::new(); Method::ALL.len()];
    let mut notes = Vec::new();
    for set in &SETS {
        table(set, Path::new(&folder), &mut gains, &mut notes)?;
    }
    println!("\nGeometric mean over all joints of the error, relative to *plain*:\n");
    for (method, logs) in Method::ALL.iter().zip(&gains) {
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let above = logs.iter().filter(|log| **log > 0.0).count();
        println!(
            "* `{}`: {:.3}, above *plain* on {above} of {}",
            method.name(),
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
    let folder = root.join(set.folder);
    let dataset: toml::Table = std::fs::read_to_string(folder.join("dataset.toml"))?.parse()?;
    let text = |key: &str| dataset.get(key).and_then(toml::Value::as_str).ok_or("dataset.toml");
    let baseline = dataset.get("baseline").ok_or("no baseline")?;
    let cutoff_hz = baseline
        .get("filter_hz")
        .and_then(|f| f.as_float().or(f.as_integer().map(|i| i as f64)))
        .ok_or("no filter_hz")?;
    let joints: Vec<String> = baseline
        .get("joints")
        .or(dataset.get("joints"))
        .and_then(toml::Value::as_array)
        .ok_or("no joints")?
        .iter()
        .filter_map(|j| j.as_str().map(ToOwned::to_owned))
        .collect();
    let names: Vec<&str> = joints.iter().map(String::as_str).collect();

    let read = |file: &&str| -> Result<Recording, Box<dyn Error>> {
        let path = folder.join(file);
        let recording = if set.mapping.is_empty() {
            read_csv(&path)?
        } else {
            read_csv_mapped(&path, &Mapping::parse(set.mapping, "mapping")?)?
        };
        Ok(recording)
    };
    let read_all = |files: &[&str]| -> Result<Vec<Recording>, Box<dyn Error>> {
        let recordings: Vec<Recording> = files.iter().map(read).collect::<Result<_, _>>()?;
        Ok(with_drive_signals(&recordings).0)
    };
    let mut train = read_all(set.training)?;
    let mut holdout = read_all(set.holdout)?;
    if holdout.is_empty() {
        let whole = &train[0];
        let (first, last) = (whole.time_s[0], whole.time_s[whole.len() - 1]);
        let cut = first + TRAINING_SHARE * (last - first);
        holdout = vec![part(whole, |t| t >= cut)?];
        train = vec![part(whole, |t| t < cut)?];
    }

    let robot = load_urdf(&folder.join(text("urdf")?))?;
    let selection =
        ChainSelection { recorded_joints: Some(joints.clone()), ..ChainSelection::default() };
    let chain = DrivingAxisChain::from_chain(&SerialChain::from_description(&robot, &selection)?);
    let model = ArmModel::from_chain(chain);
    let arm = model.rigid_arm();
    let minimal = MinimalSet::of(&arm)?;
    let settings = MotionSettings { cutoff_hz: Some(cutoff_hz), ..MotionSettings::default() };
    let motions = |recordings: &[Recording]| -> Result<Vec<Motion>, Box<dyn Error>> {
        let of = |r: &Recording| Ok(Motion::from_recording(r, &names, &settings)?);
        recordings.iter().map(of).collect()
    };
    let (train_motions, holdout_motions) = (motions(&train)?, motions(&holdout)?);
    let all: Vec<&Motion> = train_motions.iter().collect();

    let plain = BatchProblem::new(&arm, &minimal);
    let rows = plain.accumulate(&all);
    let judged = plain.accumulate(&holdout_motions.iter().collect::<Vec<_>>());
    let mut default_stretches = None;
    let (_, found, _) = plain.solve_by(Method::Ols, &model, &all, &BatchSettings::PLAIN)?;
    let plain_stretches = stretches(&plain, &holdout_motions, &found.values);
    let mut columns = vec![(plain.fit(&judged, &found.values), plain.fit(&rows, &found.values))];
    let mut problem = BatchProblem::new(&arm, &minimal);
    let chosen = problem.choose(&all, &BatchSettings::default(), true)?;
    for found in &chosen.couplings {
        let [a, b] = found.coupling.joints().map(|joint| names[joint]);
        notes.push(format!(
            "{}: {a} and {b} share a transmission (ratio {}), {:.0} % lower error where it was not fitted",
            set.folder,
            found.coupling.ratio,
            100.0 * found.gain
        ));
    }
    if let Some(relative) = chosen.settings.link_prior {
        notes.push(format!("{}: URDF believed to {:.0} %", set.folder, 100.0 * relative));
    }
    for method in Method::ALL {
        let fitted = BatchFit::of(
            &problem,
            &model,
            method,
            &chosen.settings,
            Recorded { recordings: &train, motions: &train_motions },
            Recorded { recordings: &holdout, motions: &holdout_motions },
        );
        match fitted {
            Ok(fitted) => {
                let judged = fitted.holdout_rows.as_ref().ok_or("no hold-out")?;
                if let Some(found) = fitted.endogeneity {
                    let term = problem.label(&problem.terms[found.term], &names);
                    notes.push(format!(
                        "{}: Durbin-Wu-Hausman p = {:.2} ({term} moves by {:+.1} standard errors)",
                        set.folder, found.p, found.t
                    ));
                }
                let links = problem.nearest_consistent(&fitted.estimate)?;
                if method == Method::Irls {
                    let with_recorded = |(m, r)| with_recorded_velocity(m, r);
                    let recorded = holdout_motions.iter().zip(&holdout).map(with_recorded);
                    let motions = match fitted.velocity_gain {
                        Some(_) => recorded.collect::<Option<Vec<_>>>().ok_or("no velocities")?,
                        None => holdout_motions.clone(),
                    };
                    default_stretches = Some(stretches(&problem, &motions, &links.estimated));
                }
                columns.push((
                    problem.fit(judged, &links.estimated),
                    problem.fit(&fitted.rows, &links.estimated),
                ));
            }
            Err(error) => {
                notes.push(format!("{}, {}: {error}", set.folder, method.name()));
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
        let place = 1 + Method::ALL.iter().position(|m| *m == Method::Irls).unwrap_or(0);
        if let (Some(found), Some(plain), Some(of_default)) =
            (error(place), error(0), &default_stretches)
            && found > plain
        {
            notes.push(format!(
                "{}: {joint} is {:.0} % above *plain* with `irls`, {:.1} standard errors of the mean of {} \
                 stretches of the hold-out (logarithms of the errors)",
                set.folder,
                100.0 * (found / plain - 1.0),
                in_errors(&of_default[j], &plain_stretches[j]),
                plain_stretches[j].len(),
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

/// Per joint, the errors on stretches of motions.
fn stretches(problem: &BatchProblem<'_>, motions: &[Motion], values: &[f64]) -> Vec<Vec<f64>> {
    let mut errors = vec![Vec::new(); problem.arm().dof()];
    let each = STRETCHES.div_ceil(motions.len());
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
fn in_errors(of: &[f64], other: &[f64]) -> f64 {
    let logs: Vec<f64> = of.iter().zip(other).map(|(a, b)| (a / b).ln()).collect();
    let count = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / count;
    let scatter: f64 = logs.iter().map(|x| (x - mean).powi(2)).sum();
    mean / (scatter / (count * (count - 1.0))).sqrt()
}

/// The samples whose stamps are wanted.
fn part(
    whole: &Recording,
    wanted: impl Fn(f64) -> bool,
) -> Result<Recording, armident_recording::RecordingError> {
    let keep = |column: &[f64]| -> Vec<f64> {
        column.iter().zip(&whole.time_s).filter(|(_, t)| wanted(**t)).map(|(x, _)| *x).collect()
    };
    let joints = whole
        .joints
        .iter()
        .map(|joint| {
            let mut cut = JointChannels::new(&joint.name);
            for quantity in Quantity::ALL {
                *cut.channel_mut(quantity) = joint.channel(quantity).map(keep);
            }
            cut
        })
        .collect();
    Recording::new(&whole.source, keep(&whole.time_s), joints)
}
