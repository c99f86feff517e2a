//! Logs as they come from real machines: every defect is found, and what is said about it.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::fmt::Write as _;

use armident_motion::{QualityReport, differences, quality};
use armident_recording::{Action, QualityIssueKind, Quantity, Recording, read_csv, read_csv_from};

#[path = "../../../tests/shared.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "a test file: each binary uses its part")]
mod shared;

const RATE_HZ: f64 = 200.0;
const SAMPLES: usize = 2000;

/// A log that defects are put into.
#[derive(Clone)]
struct Log {
    t: Vec<f64>,
    q: Vec<f64>,
    qd: Option<Vec<f64>>,
    qdd: Option<Vec<f64>>,
    tau: Vec<f64>,
}

/// Uniform in -1..1, the same on every run.
fn random(k: usize) -> f64 {
    let x = (k as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

fn position(t: f64) -> f64 {
    0.8 * (2.0 * t).sin() + 0.1 * (9.0 * t).sin()
}

fn velocity(t: f64) -> f64 {
    1.6 * (2.0 * t).cos() + 0.9 * (9.0 * t).cos()
}

fn effort(t: f64) -> f64 {
    -3.2 * (2.0 * t).sin() - 8.1 * (9.0 * t).sin()
}

fn rounded(value: f64, step: f64) -> f64 {
    (value / step).round() * step
}

/// 10 s at 200 Hz: encoder of 1 mrad, tachometer of 0.01 rad/s, effort with noise.
fn clean() -> Log {
    let t: Vec<f64> = (0..SAMPLES).map(|k| k as f64 / RATE_HZ).collect();
    Log {
        q: t.iter().map(|t| rounded(position(*t), 1e-3)).collect(),
        qd: Some(t.iter().map(|t| rounded(velocity(*t), 0.01)).collect()),
        qdd: None,
        tau: t.iter().enumerate().map(|(k, t)| effort(*t) + 0.05 * random(k)).collect(),
        t,
    }
}

fn with(change: impl FnOnce(&mut Log)) -> Log {
    let mut log = clean();
    change(&mut log);
    log
}

fn lose(log: &mut Log, from: usize, to: usize) {
    let columns = [Some(&mut log.t), Some(&mut log.q), log.qd.as_mut(), Some(&mut log.tau)];
    for column in columns.into_iter().flatten() {
        column.drain(from..to);
    }
}

fn text(log: &Log) -> String {
    let mut header = "t,elbow/position,elbow/effort".to_owned();
    for (name, column) in [("velocity", &log.qd), ("acceleration", &log.qdd)] {
        if column.is_some() {
            let _ = write!(header, ",elbow/{name}");
        }
    }
    let mut text = header + "\n";
    for k in 0..log.t.len() {
        let _ = write!(text, "{:.6},{},{}", log.t[k], log.q[k], log.tau[k]);
        for column in [&log.qd, &log.qdd].into_iter().flatten() {
            let _ = write!(text, ",{}", column[k]);
        }
        text.push('\n');
    }
    text
}

fn read(log: &Log) -> Recording {
    read_csv_from(text(log).as_bytes(), "swing.csv").unwrap()
}

fn cases() -> Vec<(&'static str, Log)> {
    let scaled = |column: &mut Option<Vec<f64>>, factor: f64| {
        column.iter_mut().flatten().for_each(|value| *value *= factor);
    };
    let exact_acceleration = |log: &mut Log| {
        let of = |t: &f64| -3.2 * (2.0 * t).sin() - 8.1 * (9.0 * t).sin();
        log.qdd = Some(log.t.iter().map(of).collect());
    };
    vec![
        ("clean", clean()),
        (
            "jittered stamps",
            with(|log| {
                for (k, t) in log.t.iter_mut().enumerate() {
                    *t += 0.1 / RATE_HZ * random(k);
                }
            }),
        ),
        (
            "stamps that repeat",
            with(|log| [300, 900].iter().for_each(|k| log.t[*k] = log.t[k - 1])),
        ),
        (
            "stamps that repeat often",
            with(|log| {
                (0..50).for_each(|k| log.t[10 + 20 * k] = log.t[9 + 20 * k]);
            }),
        ),
        (
            "two rows exchanged",
            with(|log| {
                log.t.swap(700, 701);
                log.q.swap(700, 701);
            }),
        ),
        (
            "clock set back twice",
            with(|log| {
                log.t[600..].iter_mut().for_each(|t| *t -= 1.0);
                log.t[1200..].iter_mut().for_each(|t| *t -= 1.0);
            }),
        ),
        (
            "gaps",
            with(|log| {
                lose(log, 1500, 1504);
                lose(log, 400, 480);
            }),
        ),
        ("a few NaN", with(|log| [77, 78, 1000].iter().for_each(|k| log.tau[*k] = f64::NAN))),
        ("NaN for 20 samples", with(|log| log.tau[800..820].fill(f64::NAN))),
        (
            "NaN in 2 % of the samples",
            with(|log| {
                (0..40).for_each(|k| log.q[5 + 50 * k] = f64::NAN);
            }),
        ),
        ("NaN at the end", with(|log| log.q[SAMPLES - 1] = f64::NAN)),
        ("one infinite value", with(|log| log.tau[500] = f64::INFINITY)),
        (
            "encoder stuck",
            with(|log| {
                let held = log.q[1000];
                log.q[1000..1100].fill(held);
            }),
        ),
        ("velocity stuck", with(|log| log.qd.as_mut().unwrap()[200..400].fill(0.53))),
        ("effort stuck", with(|log| log.tau[600..900].fill(1.25))),
        ("drive off", with(|log| log.tau[1500..].fill(0.0))),
        ("effort constant throughout", with(|log| log.tau.fill(0.0))),
        (
            "effort saturated",
            with(|log| {
                log.tau.iter_mut().for_each(|tau| *tau = tau.clamp(-7.0, 6.0));
            }),
        ),
        ("no velocity", with(|log| log.qd = None)),
        ("velocity in degrees per second", with(|log| scaled(&mut log.qd, 57.295_78))),
        (
            "velocity in rpm of a motor with gear 100",
            with(|log| {
                scaled(&mut log.qd, 954.929_66);
            }),
        ),
        ("velocity with the other sign", with(|log| scaled(&mut log.qd, -1.0))),
        (
            "velocity filtered with 20 ms of delay",
            with(|log| {
                log.qd = Some(log.t.iter().map(|t| rounded(velocity(*t - 0.02), 0.01)).collect());
            }),
        ),
        (
            "velocity of another joint",
            with(|log| {
                log.qd = Some(log.t.iter().map(|t| (3.7 * t).sin()).collect());
            }),
        ),
        (
            "velocity in degrees per second, used",
            with(|log| {
                scaled(&mut log.qd, 57.295_78);
                exact_acceleration(log);
            }),
        ),
        (
            "velocity with the other sign, used",
            with(|log| {
                scaled(&mut log.qd, -1.0);
                exact_acceleration(log);
            }),
        ),
        (
            "position in degrees, velocity in rad/s",
            with(|log| {
                log.q.iter_mut().for_each(|q| *q *= 57.295_78);
            }),
        ),
        (
            "position in degrees, no velocity",
            with(|log| {
                log.q.iter_mut().for_each(|q| *q *= 57.295_78);
                log.qd = None;
            }),
        ),
        (
            "position in millimetres, velocity in m/s",
            with(|log| {
                log.q.iter_mut().for_each(|q| *q *= 1e3);
            }),
        ),
        (
            "angle wrapped at pi",
            with(|log| {
                use std::f64::consts::{PI, TAU};
                for q in &mut log.q {
                    *q = rounded((*q + 2.8 + PI).rem_euclid(TAU) - PI, 1e-3);
                }
            }),
        ),
        ("days instead of seconds", with(|log| log.t.iter_mut().for_each(|t| *t *= 200.0))),
    ]
}

fn told(report: &QualityReport) -> String {
    let mut book = String::new();
    for finding in &report.findings {
        let action = match finding.action {
            Action::Repaired => "repaired",
            Action::Kept => "kept",
            Action::Refused => "refused",
        };
        let _ = writeln!(book, "{action}: {finding}");
        if let Some(advice) = &finding.advice {
            let _ = writeln!(book, "    hint: {advice}");
        }
    }
    if book.is_empty() { "nothing to say\n".to_owned() } else { book }
}

#[test]
fn messages_of_every_defect() {
    let mut book = String::new();
    for (name, log) in cases() {
        let _ = writeln!(book, "== {name}");
        match read_csv_from(text(&log).as_bytes(), "swing.csv") {
            Ok(recording) => {
                recording.check().unwrap();
                book += &told(&quality(&recording));
            }
            Err(error) => {
                let _ = writeln!(book, "error: {error}\n   in: {}", error.place());
                if let Some(hint) = error.hint() {
                    let _ = writeln!(book, " hint: {hint}");
                }
            }
        }
        book.push('\n');
    }
    insta::assert_snapshot!(book);
}

#[test]
fn repairs_bring_back_the_values() {
    let position_of = |log: &Log| read(log).joints[0].position.clone().unwrap();
    let effort_of = |log: &Log| read(log).joints[0].effort.clone().unwrap();
    let exact = clean();
    let holes = with(|log| [77, 78, 1000].iter().for_each(|k| log.tau[*k] = f64::NAN));
    for (filled, tau) in effort_of(&holes).iter().zip(&exact.tau) {
        // the noise of the neighbours, and what a cubic misses at 9 rad/s
        assert!((filled - tau).abs() < 0.2, "{filled} {tau}");
    }
    let wrapped = with(|log| {
        use std::f64::consts::{PI, TAU};
        log.q.iter_mut().for_each(|q| *q = (*q + 2.8 + PI).rem_euclid(TAU) - PI);
    });
    for (continuous, q) in position_of(&wrapped).iter().zip(&exact.q) {
        assert!((continuous - q - 2.8).abs() < 1e-9);
    }
    let repeated = with(|log| log.t[300] = log.t[299]);
    assert_eq!(read(&repeated).len(), SAMPLES - 1);
}

#[test]
fn places_and_shares() {
    let stuck = with(|log| log.tau[600..900].fill(1.25));
    let report = quality(&read(&stuck));
    let finding = report.findings.iter().find(|f| f.kind == QualityIssueKind::Stuck).unwrap();
    assert_eq!(
        (finding.joint.as_deref(), finding.quantity),
        (Some("elbow"), Some(Quantity::Effort))
    );
    assert_eq!(finding.spans.len(), 1);
    assert!((finding.spans[0].from_s - 3.0).abs() < 1e-9);
    assert!((finding.spans[0].to_s - 4.495).abs() < 1e-9);
    assert!((finding.share - 0.15).abs() < 1e-12);
    let of_effort = report.channels.iter().find(|c| c.quantity == Quantity::Effort).unwrap();
    assert_eq!(of_effort.stuck_share, finding.share);

    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["findings"][0]["kind"], "stuck");
    assert_eq!(json["findings"][0]["action"], "kept");
    assert_eq!(json["channels"][1]["quantity"], "velocity");
}

#[test]
fn what_can_be_measured() {
    let report = quality(&read(&clean()));
    assert_eq!((report.samples, report.timing.is_even), (SAMPLES, true));
    assert!((report.timing.rate_hz - RATE_HZ).abs() < 1e-6);
    let [position, velocity, effort] = &report.channels[..] else { panic!() };
    assert!((position.step.unwrap() / 1e-3 - 1.0).abs() < 1e-3);
    assert!((velocity.step.unwrap() / 0.01 - 1.0).abs() < 1e-3);
    assert_eq!(effort.step, None);
    let near = |found: Option<f64>, expected: f64, share: f64| {
        assert!((found.unwrap() / expected - 1.0).abs() < share, "{found:?} {expected}");
    };
    near(position.noise, 1e-3 / 12.0_f64.sqrt(), 0.2);
    near(effort.noise, 0.05 / 3.0_f64.sqrt(), 0.1);
    near(position.band_edge_hz, 9.0 / std::f64::consts::TAU, 0.2);
    assert_eq!(effort.band_edge_hz, None);
    assert!((position.largest - 0.87).abs() < 0.05 && position.smallest < -0.8);
}

#[test]
fn short_and_odd_recordings_are_measured_too() {
    for n in 8..60 {
        for step in [0.0, 1.0] {
            let rows: String = (0..n)
                .map(|k| format!("{},{}\n", 0.01 * f64::from(k), step * f64::from(k)))
                .collect();
            let recording =
                read_csv_from(format!("t,a/position\n{rows}").as_bytes(), "x.csv").unwrap();
            assert_eq!(quality(&recording).channels.len(), 1);
        }
    }
    let huge: String = (0..500)
        .map(|k| {
            format!("{},{},1e308\n", 0.01 * f64::from(k), if k % 2 == 0 { 1e308 } else { -1e308 })
        })
        .collect();
    let text = format!("t,a/position,a/velocity\n{huge}");
    quality(&read_csv_from(text.as_bytes(), "x.csv").unwrap());
}

#[test]
fn recordings_that_differ_among_each_other() {
    let first = read(&clean());
    let mut second = first.clone();
    second.source = "slow.csv".into();
    second.time_s.iter_mut().for_each(|t| *t *= 2.0);
    second.joints[0].velocity = None;
    assert!(differences(&[first.clone(), first.clone()]).is_empty());
    let said: Vec<String> = differences(&[first, second]).iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "sample rates differ (supported): 200.0 Hz in swing.csv, 100.0 Hz in slow.csv",
            "elbow/velocity: missing in slow.csv",
        ]
    );
}

#[test]
fn known_defects_of_shared_recordings() {
    let Some(data) = shared::shared("known_defects_of_shared_recordings", "data") else { return };
    let of = |file: &str| quality(&read_csv(data.join(file)).unwrap());
    let kinds = |report: &QualityReport, kind: QualityIssueKind| -> Vec<String> {
        let named = report.findings.iter().filter(|f| f.kind == kind);
        named.map(|f| f.joint.clone().unwrap_or_default()).collect()
    };
    // drives that filter the velocity over 0.2 s, and currents that are mostly one step or none
    let tiago = of("tiago-arm/train.csv");
    assert_eq!(kinds(&tiago, QualityIssueKind::VelocityDelay).len(), 8, "{}", told(&tiago));
    assert_eq!(
        kinds(&tiago, QualityIssueKind::Stuck),
        ["arm_5_joint", "arm_6_joint", "arm_7_joint"],
        "{}",
        told(&tiago)
    );
    let servo = of("bam-xl330/sin_sin_kp400.csv");
    assert_eq!(kinds(&servo, QualityIssueKind::Saturated), ["servo"], "{}", told(&servo));
    assert!(told(&servo).contains("at its limit of -7.4"), "{}", told(&servo));
    assert!((servo.channels[0].step.unwrap() - 1.534e-3).abs() < 1e-6);
    // the bridge is off
    let dropped = of("bam-xl330/lift_and_drop_kp100.csv");
    assert_eq!(kinds(&dropped, QualityIssueKind::Stuck), ["servo"], "{}", told(&dropped));
    let staubli = of("staubli-tx40/train.csv");
    assert_eq!(staubli.findings.len(), 1, "{}", told(&staubli));
    assert_eq!(staubli.findings[0].kind, QualityIssueKind::MissingVelocity);
    for clean in ["ur10-unisa/train.csv", "dfki-simple-pendulum/tracking.csv"] {
        let report = of(clean);
        let other = report.findings.iter().find(|f| f.kind != QualityIssueKind::UnevenStamps);
        assert_eq!(other, None, "{clean}");
    }
}
