//! What the diagnosis says changed, where a known load is added to real efforts.

use std::error::Error;
use std::path::Path;

use armident_diagnose::{Books, DiagnosedModel, Diagnosis, Finding, diagnose_change};
use armident_ident::ArmModel;
use armident_kinematics::InertialParameters;
use armident_recording::{JointChannels, Recording};
use nalgebra::Matrix3;

use crate::diagnosis::named;
use crate::sets::{Data, Set, part};

/// A comparison of recordings after with recordings before.
struct Compared {
    title: String,
    before: Vec<Recording>,
    after: Vec<Recording>,
}

/// Loads \[kg\] of the sets that are one motion.
const LOADS_KG: [(&str, &[f64]); 4] = [
    ("staubli-tx40", &[0.0, 1.0, 3.0]),
    ("ur10-unisa", &[0.0, 1.0, 3.0]),
    ("panda-unisa", &[0.0, 0.5, 1.0]),
    ("dfki-double-pendulum", &[0.0, 0.03, 0.1]),
];

/// A pendulum of 0.49 kg on a servo whose drive voltage is recorded, with three gains of its controller.
const SERVO: Set = Set {
    folder: "bam-xl330",
    training: &["sin_sin_kp100.csv", "up_and_down_kp100.csv", "sin_time_square_kp100.csv"],
    holdout: &[
        "sin_sin_kp200.csv",
        "up_and_down_kp200.csv",
        "sin_sin_kp400.csv",
        "up_and_down_kp400.csv",
        "sin_time_square_kp400.csv",
    ],
    mapping: "",
};
const SERVO_LOADS_KG: [f64; 4] = [0.0, 0.1, 0.2, 0.49];
/// R / k_t that the makers of the set publish.
const SERVO_V_PER_NM: f64 = 7.68;

/// The table.
pub(crate) fn print(folder: &Path) -> Result<(), Box<dyn Error>> {
    println!("\n## What changed\n");
    println!(
        "Later parts of recordings against earlier ones (`--reference`), with the effort of a point mass at the centre of \
         the last link added as the dynamics give it; and the same without a load, where every claim is false. \
         Recordings are cut in three: *1, 2* is the second part against the first, *1 2, 3* the third against both. \
         The XL330 is told apart by the gain of its controller; its loads are added to voltages at the published \
         {SERVO_V_PER_NM} V/(N m). Numbers are of the last link: mass, or first moment where no effort holds the mass.\n"
    );
    println!("| set | compared | load, kg | said |");
    println!("| --- | --- | ---: | --- |");
    for (name, loads_kg) in LOADS_KG {
        let set = crate::sets::named(name).ok_or("no such set")?;
        let data = Data::read(set, folder)?;
        let whole = data.all().next().ok_or("no recording")?;
        let (first, last) = (whole.time_s[0], whole.time_s[whole.len() - 1]);
        let third = |k: f64| {
            let at = |share: f64| first + share / 3.0 * (last - first);
            part(whole, |t| at(k) <= t && t < at(k + 1.0))
        };
        let compared = [
            Compared {
                title: "1, 2".to_owned(),
                before: vec![third(0.0)?],
                after: vec![third(1.0)?],
            },
            Compared {
                title: "1 2, 3".to_owned(),
                before: vec![third(0.0)?, third(1.0)?],
                after: vec![third(2.0)?],
            },
        ];
        print_set(name, &data.model, &compared, loads_kg)?;
    }
    let data = Data::read(&SERVO, folder)?;
    let of_gain = |gain: &str| -> Vec<Recording> {
        data.all().filter(|r| r.source.contains(gain)).cloned().collect()
    };
    let compared = [("kp100", "kp200"), ("kp200", "kp400"), ("kp100", "kp400")].map(|(a, b)| {
        Compared { title: format!("{a}, {b}"), before: of_gain(a), after: of_gain(b) }
    });
    print_set(SERVO.folder, &data.model, &compared, &SERVO_LOADS_KG)
}

fn print_set(
    set: &str,
    model: &ArmModel,
    compared: &[Compared],
    loads_kg: &[f64],
) -> Result<(), Box<dyn Error>> {
    for Compared { title, before, after } in compared {
        for &load_kg in loads_kg {
            let after =
                after.iter().map(|r| loaded(model, r, load_kg)).collect::<Result<Vec<_>, _>>()?;
            let mut books = Books::of(model, before)?;
            let in_effort = |r: &[Recording]| -> Vec<Recording> {
                r.iter().map(|r| books.in_effort(r)).collect()
            };
            let (before, after) = (in_effort(before), in_effort(&after));
            let heard = books.hear(model.chain.dof(), &after, &before, |after, before| {
                diagnose_change(model, before, after)
            });
            let said = match heard {
                None => "columns in doubt".to_owned(),
                Some(heard) => {
                    let mut diagnosis = heard?;
                    diagnosis.doubt_gains(&books.drive_gains);
                    said(&diagnosis)
                }
            };
            println!("| {set} | {title} | {load_kg} | {said} |");
        }
    }
    Ok(())
}

/// The recording with the effort of a load on the last link.
fn loaded(
    model: &ArmModel,
    recording: &Recording,
    load_kg: f64,
) -> Result<Recording, Box<dyn Error>> {
    let mut heavier = model.clone();
    if let Some(joint) = heavier.chain.joints.last_mut() {
        let load = InertialParameters::from_com(load_kg, joint.link.com_m(), Matrix3::zeros());
        joint.link = joint.link.plus(&load);
    }
    let [with, without] =
        [&heavier, model].map(|model| DiagnosedModel::believed(model).predict(recording));
    let (with, without) = (with?, without?);
    let mut changed = recording.clone();
    for (j, name) in model.chain.joint_names().iter().enumerate() {
        let Some(channels) = changed.joints.iter_mut().find(|c| c.name == **name) else { continue };
        let JointChannels { effort, voltage, .. } = channels;
        let recorded = match (effort, voltage) {
            (Some(effort), _) => Some((effort, 1.0)),
            (None, Some(voltage)) => Some((voltage, SERVO_V_PER_NM)),
            (None, None) => None,
        };
        let Some((column, per_nm)) = recorded else { continue };
        for ((x, with), without) in column.iter_mut().zip(&with[j]).zip(&without[j]) {
            *x += per_nm * (with - without);
        }
    }
    Ok(changed)
}

fn said(diagnosis: &Diagnosis) -> String {
    if diagnosis.findings.is_empty() {
        return "nothing".to_owned();
    }
    diagnosis.findings.iter().map(in_words).collect::<Vec<_>>().join("; ")
}

/// What, where, and the numbers of a load.
fn in_words(finding: &Finding) -> String {
    let numbers: Vec<String> = ["mass", "delta_mass", "delta_mcx", "delta_mcy", "delta_mcz"]
        .iter()
        .filter_map(|name| finding.parameters.get(name))
        .take(if finding.parameters.contains_key("mass") { 1 } else { 3 })
        .map(|of| format!("{:.3} +- {:.3} {}", of.value, of.stderr.unwrap_or(0.0), of.unit))
        .collect();
    format!("{} {}", named(finding), numbers.join(", ")).trim_end().to_owned()
}
