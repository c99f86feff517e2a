//! The door: what a fleet has in common, then one robot after the other.

use armident_ident::{RecordingState, StateColumns, StateError};
use armident_inference::levels::CHANGE_ERROR;
use armident_numeric::Mat;
use rayon::prelude::*;

use crate::changes::{Level, ScaledExplanation, Search};
use crate::explanation::Explanation;
use crate::history::{ParameterTrend, RobotHistory, TrendPoint};
use crate::information::{Information, noise_of};
use crate::scatter::{self, Scatter};
use crate::series::{Series, SeriesFit, Step};

/// Share of the fleet's mean information below which a recording does not determine a parameter.
const NOT_DETERMINED: f64 = 1e-6;
/// Standard deviation in units of the scale above which a fit does not determine a parameter.
const FREE: f64 = 1e3;

/// Why a fleet cannot be analysed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FleetError {
    /// There are no states.
    #[error("no state of a recording")]
    None,
    /// A state does not fit.
    #[error(transparent)]
    State(#[from] StateError),
}

/// What is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FleetSettings {
    /// Probability that a change of a robot that does not change is reported.
    pub false_alarm_rate: f64,
}

impl Default for FleetSettings {
    fn default() -> Self {
        Self { false_alarm_rate: CHANGE_ERROR }
    }
}

/// An arm with what its fleet has in common.
pub struct FleetAnalysis<'a> {
    columns: &'a StateColumns<'a>,
    /// A parameter is this many times its scaled number.
    scale: Vec<f64>,
    explanations: Vec<ScaledExplanation>,
    scatter: Scatter,
    scaled_deviations: Vec<f64>,
    settings: FleetSettings,
}

impl<'a> FleetAnalysis<'a> {
    /// Learns the scatter of recordings from some robots, each with successive recordings.
    ///
    /// # Errors
    /// [`FleetError`]: no states, or states of another arm.
    pub fn learn(
        columns: &'a StateColumns<'a>,
        robots: &[Vec<RecordingState>],
        settings: FleetSettings,
    ) -> Result<Self, FleetError> {
        let problem = columns.problem();
        for state in robots.iter().flatten() {
            columns.check(state)?;
        }
        let unit = vec![1.0; problem.terms.len()];
        let informations = |scale: &[f64]| -> Vec<Vec<Information>> {
            robots
                .par_iter()
                .map(|robot| {
                    let states: Vec<&RecordingState> = robot.iter().collect();
                    let noise = noise_of(problem, &states);
                    robot.iter().map(|of| Information::of(problem, of, &noise, scale)).collect()
                })
                .collect()
        };
        let plain = informations(&unit);
        let count = plain.iter().flatten().count();
        if count == 0 {
            return Err(FleetError::None);
        }
        let scale: Vec<f64> = (0..unit.len())
            .map(|k| {
                let mean = plain.iter().flatten().map(|of| of.matrix[(k, k)]).sum::<f64>();
                let mean = mean / count as f64;
                if mean > 0.0 { 1.0 / mean.sqrt() } else { 1.0 }
            })
            .collect();
        drop(plain);
        let scaled = scatter::estimate(&informations(&scale));
        let scaled_deviations = scaled.deviations.clone();
        let deviations = scaled.deviations.iter().zip(&scale).map(|(d, s)| d * s).collect();
        Ok(Self {
            columns,
            explanations: Explanation::all(columns)
                .iter()
                .map(|of| ScaledExplanation::new(of, &scale))
                .collect(),
            scale,
            scatter: Scatter { deviations, ..scaled },
            scaled_deviations,
            settings,
        })
    }

    /// The scatter of recordings.
    pub fn scatter(&self) -> &Scatter {
        &self.scatter
    }

    /// What was chosen.
    pub fn settings(&self) -> FleetSettings {
        self.settings
    }

    /// Changes and trends of a robot from its recordings in their order.
    ///
    /// # Errors
    /// [`FleetError`]: no states, or states of another arm.
    pub fn robot(
        &self,
        robot: &str,
        states: &[RecordingState],
    ) -> Result<RobotHistory, FleetError> {
        if states.is_empty() {
            return Err(FleetError::None);
        }
        let problem = self.columns.problem();
        for state in states {
            self.columns.check(state)?;
        }
        let all: Vec<&RecordingState> = states.iter().collect();
        let noise = noise_of(problem, &all);
        let of_recording = |state: &RecordingState| {
            Information::of(problem, state, &noise, &self.scale).in_common(&self.scaled_deviations)
        };
        let series = Series::new(states.par_iter().map(of_recording).collect());
        let level =
            Level { of_robot: self.settings.false_alarm_rate, freedom: self.scatter.freedom };
        let (changes, steps) = Search::new(&series, &self.explanations, &level).changes();
        let fit = series.fit(&steps).ok_or(FleetError::None)?;
        let times: Option<Vec<f64>> = states.iter().map(|state| state.recorded_at_s).collect();
        let p = self.scale.len();
        let variance = |k: usize| fit.covariance[(k, k)];
        Ok(RobotHistory {
            robot: robot.to_owned(),
            recordings: states.iter().map(|state| state.recording.clone()).collect(),
            recorded_at_s: times,
            changes,
            trends: self.trends(&series, &fit, &steps),
            values: (0..p).map(|k| fit.values[k] * self.scale[k]).collect(),
            errors: (0..p)
                .map(|k| (variance(k) < FREE * FREE).then(|| variance(k).sqrt() * self.scale[k]))
                .collect(),
            noise,
        })
    }

    fn trends(&self, series: &Series, fit: &SeriesFit, steps: &[Step]) -> Vec<ParameterTrend> {
        let means: Vec<Vec<f64>> =
            (0..series.len()).map(|index| series.values_at(fit, steps, index)).collect();
        let residuals: Vec<Vec<f64>> =
            means.iter().enumerate().map(|(index, mean)| series.residual(index, mean)).collect();
        let own = |index: usize, k: usize| {
            let matrix: &Mat<f64> = &series.recordings[index].matrix;
            matrix[(k, k)]
        };
        (0..self.scale.len())
            .map(|k| {
                let scale = self.scale[k];
                let points: Vec<Option<TrendPoint>> = (0..series.len())
                    .map(|index| {
                        let information = own(index, k);
                        (information > NOT_DETERMINED).then(|| TrendPoint {
                            value: scale * (means[index][k] + residuals[index][k] / information),
                            standard_error: scale / information.sqrt(),
                        })
                    })
                    .collect();
                let beside: Vec<(f64, f64, f64)> = points
                    .iter()
                    .enumerate()
                    .filter_map(|(index, point)| {
                        let point = point.as_ref()?;
                        let beside = point.value - scale * means[index][k];
                        Some((index as f64, beside, point.standard_error))
                    })
                    .collect();
                ParameterTrend { points, drift: slope(&beside) }
            })
            .collect()
    }
}

/// Slope and its standard error of a weighted straight line through three points or more.
fn slope(points: &[(f64, f64, f64)]) -> Option<(f64, f64)> {
    if points.len() < 3 {
        return None;
    }
    let weight = |error: f64| 1.0 / (error * error);
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        points.iter().map(|&(t, y, error)| weight(error) * f(t, y)).sum()
    };
    let total = sum(&|_, _| 1.0);
    let middle = sum(&|t, _| t) / total;
    let mean = sum(&|_, y| y) / total;
    let spread = sum(&|t, _| (t - middle).powi(2));
    let slope = sum(&|t, y| (t - middle) * (y - mean)) / spread;
    (spread > 0.0).then(|| (slope, 1.0 / spread.sqrt()))
}
