//! All recordings of the shared data are read and turned into motions.

use std::path::{Path, PathBuf};

use armident_motion::{Motion, MotionSettings};
use armident_recording::read_csv;

#[path = "../../../tests/shared.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "a test file: each binary uses its part")]
mod shared;

fn csv_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries
        .flatten()
        .flat_map(|entry| {
            let path = entry.path();
            if path.is_dir() { csv_files(&path) } else { vec![path] }
        })
        .filter(|path| path.extension().is_some_and(|extension| extension == "csv"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_shared_recording_becomes_a_motion() {
    let test = "every_shared_recording_becomes_a_motion";
    let folders = ["data", "challenge/dev"].map(|folder| shared::shared(test, folder));
    let files: Vec<PathBuf> = folders.iter().flatten().flat_map(|f| csv_files(f)).collect();
    for path in files {
        let recording = read_csv(&path).unwrap();
        let joints = recording.joint_names();
        let motion =
            Motion::from_recording(&recording, &joints, &MotionSettings::default()).unwrap();
        let name = path.display();
        println!("{name}: {} joints, {:.2} Hz", joints.len(), motion.rate_hz);
        for note in &motion.notes {
            println!("    {note}");
        }
        assert!((0.8..1.3).contains(&(motion.len() as f64 / recording.len() as f64)), "{name}");
        for columns in [&motion.position, &motion.velocity, &motion.acceleration] {
            assert!(columns.iter().flatten().all(|value| value.is_finite()), "{name}");
        }
        for (joint, filtered) in joints.iter().zip(&motion.position) {
            let recorded = recording.joint(joint).and_then(|joint| joint.position.clone()).unwrap();
            let span = |values: &[f64]| {
                let largest = values.iter().copied().fold(f64::MIN, f64::max);
                largest - values.iter().copied().fold(f64::MAX, f64::min)
            };
            let difference = motion
                .at_stamps(filtered)
                .iter()
                .zip(&recorded)
                .map(|(a, b)| (a - b).powi(2))
                .sum::<f64>();
            let rms = (difference / recorded.len() as f64).sqrt();
            assert!(rms <= 0.01 * span(&recorded) + 1e-3, "{name} {joint}: {rms}");
        }
    }
}
