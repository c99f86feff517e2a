//! What `check` says of short pieces, as recorded and with one column made wrong.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use armident_ident::checks::{Check, Topic, Verdict, check, with_drive_signals};
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings, common_cutoff_hz};
use armident_recording::Recording;

use crate::sets::{Data, SETS, part};

/// Lengths of the pieces \[s\].
const LENGTHS_S: [f64; 3] = [3.0, 6.0, 12.0];
/// Share of a length that the last piece must have.
const LAST: f64 = 0.9;
/// Least samples of a piece.
const SAMPLES: usize = 60;
/// What a column in another unit is multiplied by.
const UNIT: f64 = 1000.0;

/// What is done to a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    None,
    Flipped,
    OtherUnit,
    Swapped,
}

/// Pieces, and what was said of them.
#[derive(Debug, Default, Clone, Copy)]
struct Count {
    pieces: usize,
    wrong: usize,
    doubtful: usize,
}

/// What is said of columns.
struct Said {
    worst: Verdict,
    /// joints
    wrong: Vec<String>,
}

/// The table.
pub(crate) fn print(folder: &Path) -> Result<(), Box<dyn Error>> {
    println!("\n## Input checks on short pieces\n");
    println!(
        "Pieces of {} s of each recording, each checked separately: as recorded, and with one effort column \
         (each joint in turn) with flipped sign, multiplied by {UNIT}, or swapped with the next one. The table \
         counts pieces in which a column as recorded, or the order of the columns, is reported as wrong or \
         doubtful, and pieces whose fault is. A few seconds of motion do not always reveal a fault, but must \
         not cause a false alarm. The effort columns of TIAGo's wrist are exactly 0 for up to two thirds of \
         their motion: only this is reported, and other faults of these columns are not detected.\n",
        LENGTHS_S.map(|l| format!("{l}")).join(", ")
    );
    println!(
        "| set | pieces | wrong | doubtful | sign found | doubtful | unit found | doubtful | swap found | doubtful |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    let mut blamed: BTreeMap<String, usize> = BTreeMap::new();
    for set in &SETS {
        let data = Data::read(set, folder)?;
        let mut counts = [Count::default(); 4];
        let faults = [Fault::None, Fault::Flipped, Fault::OtherUnit, Fault::Swapped];
        for (turn, piece) in pieces(&data)?.iter().enumerate() {
            for (count, fault) in counts.iter_mut().zip(faults) {
                if let Some(Said { worst, wrong }) = said(&data.model, piece, fault, turn)? {
                    if fault == Fault::None {
                        for joint in wrong {
                            *blamed.entry(format!("{} of {}", joint, set.folder)).or_default() += 1;
                        }
                    }
                    count.pieces += 1;
                    count.wrong += usize::from(worst == Verdict::Wrong);
                    count.doubtful += usize::from(worst == Verdict::Doubtful);
                }
            }
        }
        let cells: Vec<String> = counts
            .iter()
            .flat_map(|c| match c.pieces {
                0 => ["-".to_owned(), "-".to_owned()],
                _ => [c.wrong, c.doubtful].map(|k| k.to_string()),
            })
            .collect();
        println!("| {} | {} | {} |", set.folder, counts[0].pieces, cells.join(" | "));
    }
    let blamed: Vec<String> = blamed.iter().map(|(joint, k)| format!("{joint} ({k})")).collect();
    if !blamed.is_empty() {
        println!("\nReported as wrong without a fault: {}.", blamed.join(", "));
    }
    Ok(())
}

fn pieces(data: &Data) -> Result<Vec<Recording>, Box<dyn Error>> {
    let mut pieces = Vec::new();
    for whole in data.all() {
        let (first, last) = (whole.time_s[0], whole.time_s[whole.len() - 1]);
        for length in LENGTHS_S {
            let mut from = first;
            while from + LAST * length <= last {
                let piece = part(whole, |t| from <= t && t < from + length)?;
                if piece.len() >= SAMPLES {
                    pieces.push(piece);
                }
                from += length;
            }
        }
    }
    Ok(pieces)
}

/// The columns at fault; without a fault, all of them. None where the piece has no two columns to swap.
fn said(
    model: &ArmModel,
    piece: &Recording,
    fault: Fault,
    turn: usize,
) -> Result<Option<Said>, Box<dyn Error>> {
    let (recordings, signals) = with_drive_signals(std::slice::from_ref(piece));
    let mut recording = recordings[0].clone();
    let joints = model.chain.joint_names();
    let (one, next) = (turn % joints.len(), (turn + 1) % joints.len());
    if fault == Fault::Swapped && one == next {
        return Ok(None);
    }
    let place = |name: &str| {
        recording.joints.iter().position(|c| c.name == name).ok_or("a joint is missing")
    };
    let (a, b) = (place(joints[one])?, place(joints[next])?);
    let scaled = |by: f64, effort: &Option<Vec<f64>>| {
        effort.as_ref().map(|e| e.iter().map(|x| by * x).collect::<Vec<f64>>())
    };
    let effort = recording.joints[a].effort.clone();
    match fault {
        Fault::None => {}
        Fault::Flipped => recording.joints[a].effort = scaled(-1.0, &effort),
        Fault::OtherUnit => recording.joints[a].effort = scaled(UNIT, &effort),
        Fault::Swapped => {
            recording.joints[a].effort = recording.joints[b].effort.take();
            recording.joints[b].effort = effort;
        }
    }
    let recordings = [recording];
    let cutoff_hz = common_cutoff_hz(&recordings, &joints, model.cutoff_hz)?;
    let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
    let motion = Motion::from_recording(&recordings[0], &joints, &settings)?;
    let found = check(model, &recordings, &[motion], &signals)?;
    let about = |joint: &str| match fault {
        Fault::None => true,
        Fault::Flipped | Fault::OtherUnit => joint == joints[one],
        Fault::Swapped => joint == joints[one] || joint == joints[next],
    };
    let counts = |c: &&Check| match c.topic {
        Topic::Channel => c.joint.as_deref().is_some_and(about),
        Topic::Order => matches!(fault, Fault::None | Fault::Swapped),
        _ => false,
    };
    let of_columns: Vec<&Check> = found.checks.iter().filter(counts).collect();
    let worst = of_columns.iter().map(|c| c.verdict).max().unwrap_or(Verdict::Ok);
    let wrong = of_columns.iter().filter(|c| c.verdict == Verdict::Wrong);
    Ok(Some(Said { worst, wrong: wrong.filter_map(|c| c.joint.clone()).collect() }))
}
