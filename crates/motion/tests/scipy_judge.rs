//! The low-pass against SciPy: numbers and script in `tests/judges`.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::path::{Path, PathBuf};

use armident_motion::ZeroPhaseLowPass;

fn judge(file: &str) -> csv::Reader<std::fs::File> {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges");
    csv::Reader::from_path(folder.join(file)).unwrap()
}

fn numbers(row: &csv::StringRecord) -> Vec<f64> {
    row.iter().map(|field| field.parse().unwrap()).collect()
}

/// Largest difference over all orders and cutoffs, relative to the largest input.
fn worst_difference(file: &str) -> f64 {
    let mut reader = judge(file);
    let header = reader.headers().unwrap().clone();
    let rows: Vec<Vec<f64>> = reader.records().map(|row| numbers(&row.unwrap())).collect();
    let input: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let largest = input.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let mut worst = 0.0_f64;
    for (column, name) in header.iter().enumerate().skip(1) {
        let (order, cutoff) = name.split_once('/').unwrap();
        let (order, cutoff) = (order.parse().unwrap(), cutoff.parse::<f64>().unwrap());
        // another sample rate than SciPy's 1: only the ratio counts
        let filter = ZeroPhaseLowPass::new(order, 200.0 * cutoff, 200.0).unwrap();
        let filtered = filter.filter(&input);
        assert_eq!(filtered.len(), rows.len());
        for (got, row) in filtered.iter().zip(&rows) {
            worst = worst.max((got - row[column]).abs() / largest);
        }
    }
    worst
}

#[test]
fn agrees_on_signals() {
    for file in ["step.csv", "sine.csv", "ramp.csv", "noise.csv"] {
        let worst = worst_difference(file);
        println!("{file}: largest difference {worst:.1e} of the largest input");
        // at 0.002 of the rate the 64 samples are a small part of the response, hence not 1e-14
        assert!(worst < 1e-11, "{file}: {worst:e}");
    }
}

/// `sci_rs::signal::filter::sosfiltfilt_dyn` panics on these seven samples.
#[test]
fn agrees_on_a_signal_shorter_than_the_pad() {
    let worst = worst_difference("short.csv");
    println!("largest difference {worst:.1e}");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn agrees_on_the_noise_equivalent_bandwidth() {
    for row in judge("design.csv").records() {
        let row = numbers(&row.unwrap());
        let (order, cutoff, bandwidth) = (row[0] as usize, row[1], row[2]);
        let filter = ZeroPhaseLowPass::new(order, 500.0 * cutoff, 500.0).unwrap();
        let ratio = filter.effective_bandwidth_hz() / (500.0 * bandwidth);
        assert!((ratio - 1.0).abs() < 1e-9, "{order} {cutoff}: {ratio}");
    }
}
