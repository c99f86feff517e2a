//! Robots whose parameters differ from those of the fleet.
//!
//! Hypothesis: a robot is one of the fleet. Statistic: its parameter less the median of the fleet, over the root of its squared
//! standard error and the squared spread between robots (median absolute deviation times 1.483, from five robots on). It is
//! compared with Student's t at the level of false alarms divided by the number of parameters and robots (Bonferroni). With
//! fewer than five robots nothing is known of the spread, and a robot that differs beyond its own error is reported.
//!
//! References: F. R. Hampel, The influence curve and its role in robust estimation, JASA 69 (1974).

use armident_inference::{median, student_t_tail};

use crate::history::RobotHistory;

/// Robots from which on their spread is known.
const KNOWN_SPREAD: usize = 5;
/// Standard deviations of a normal distribution per median absolute deviation.
const OF_NORMAL: f64 = 1.4826;

/// A parameter of a robot that is unlike the fleet's.
#[derive(Debug, Clone, PartialEq)]
pub struct FleetOutlier {
    /// The robot, index into the histories.
    pub robot: usize,
    /// The parameter.
    pub parameter: usize,
    /// Its value.
    pub value: f64,
    /// Median of the fleet.
    pub median: f64,
    /// Standard error of the difference, with the spread of the fleet where that is known.
    pub standard_error: f64,
    /// Probability of as large a difference of any parameter of any robot, at most.
    pub error: f64,
}

/// Robots unlike the others, at most this probability of one that is not, with the degrees of freedom of the scatter; three
/// robots or more.
pub fn outliers(robots: &[RobotHistory], false_alarm_rate: f64, freedom: f64) -> Vec<FleetOutlier> {
    let parameters = robots.first().map_or(0, |first| first.values.len());
    let mut found = Vec::new();
    for k in 0..parameters {
        let known: Vec<(usize, f64, f64)> = robots
            .iter()
            .enumerate()
            .filter_map(|(index, of)| Some((index, of.values[k], of.errors[k]?)))
            .collect();
        if known.len() < 3 {
            continue;
        }
        let values: Vec<f64> = known.iter().map(|of| of.1).collect();
        let Some(middle) = median(&values) else { continue };
        let off: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
        let spread = match median(&off) {
            Some(off) if known.len() >= KNOWN_SPREAD => OF_NORMAL * off,
            _ => 0.0,
        };
        for &(robot, value, error) in &known {
            // the median of few robots has an error too
            let own = error * (1.0 + 1.0 / known.len() as f64).sqrt();
            let standard_error = own.hypot(spread);
            // with a spread of few robots, the degrees of freedom are theirs
            let freedom = if spread > own { (known.len() - 1) as f64 } else { freedom };
            let t = (value - middle).abs() / standard_error;
            let tests = (parameters * robots.len()) as f64;
            let error = (2.0 * student_t_tail(t, freedom) * tests).min(1.0);
            if error < false_alarm_rate {
                let median = middle;
                found.push(FleetOutlier {
                    robot,
                    parameter: k,
                    value,
                    median,
                    standard_error,
                    error,
                });
            }
        }
    }
    found.sort_by(|a, b| {
        (a.robot, a.error).partial_cmp(&(b.robot, b.error)).unwrap_or(std::cmp::Ordering::Equal)
    });
    found
}
