//! When the efforts were measured: their clock, and how late they come behind the motion.

use armident_motion::{Motion, QualityReport};
use armident_numeric::NumericError;
use armident_recording::Recording;

use super::arm_columns::JointMap;
use super::delay::{self, Delay, LookAlike};
use super::effort_clock::{self, Drift, EffortClock};
use super::effort_low_pass::{self, EffortLowPass, LateBy, LowPassOrDelay, is_clearly_late};
use super::lag::{self, Lags};
use super::problem_of;
use super::rows::{self, ChannelRows};
use crate::regression::BatchProblem;

/// Times the efforts are shifted by the remaining delay.
const ALIGNMENTS: usize = 2;
/// Times the drift of a clock is undone: each estimate is to first order about the one before.
const CLOCK_STEPS: usize = 2;

/// Recordings of an arm whose joints are as in its model.
#[derive(Clone, Copy)]
pub(super) struct Efforts<'a> {
    pub(super) motions: &'a [Motion],
    pub(super) recordings: &'a [Recording],
    pub(super) map: &'a JointMap,
    pub(super) quality: &'a [QualityReport],
    /// as recorded, of the joints of the model
    pub(super) names: &'a [&'a str],
    /// of the efforts, in the band of the fit
    pub(super) noise: &'a [f64],
    /// joints whose efforts show nothing
    pub(super) is_silent: &'a [bool],
    /// whether a drive may filter them
    pub(super) may_be_filtered: bool,
}

/// When the efforts were measured.
pub(super) struct EffortTiming {
    pub(super) clock: Option<EffortClock>,
    pub(super) delay: Option<Delay>,
    /// what the delay may be instead
    pub(super) look_alike: Option<LookAlike>,
    pub(super) low_pass: Option<EffortLowPass>,
    pub(super) low_pass_or_delay: Option<LowPassOrDelay>,
    /// the motions with their efforts by the clock of the positions
    pub(super) motions: Vec<Motion>,
    /// the same without the delay, and their rows
    pub(super) aligned: Vec<Motion>,
    pub(super) rows: Vec<ChannelRows>,
}

impl EffortTiming {
    /// Of efforts with these rows. The reversal speeds of the problem become those of the efforts in time.
    pub(super) fn of(
        efforts: Efforts<'_>,
        problem: &mut BatchProblem,
        mut rows: Vec<ChannelRows>,
    ) -> Result<Self, NumericError> {
        let Efforts { recordings, map, noise, is_silent, .. } = efforts;
        let mut delay = delay::delay(&rows, is_silent);
        let mut motions = efforts.motions.to_vec();
        let (mut late_by, mut clock) = (LateBy::NoLowPass, None);
        if efforts.may_be_filtered
            && let Some(lags) = efforts.lags(problem, &motions, &rows, 0.0)?
        {
            // efforts that are not clearly late went through no low-pass
            if delay.as_ref().is_none_or(|d| is_clearly_late(d.delay_s, d.evidence)) {
                late_by = effort_low_pass::late_by(&lags)?;
            }
            let mut so_far = effort_clock::drift(&lags, late_by.lag(delay.as_ref()))?;
            for _ in 0..CLOCK_STEPS {
                let Some(found) = so_far.filter(Drift::is_clear) else { break };
                motions = efforts.motions.to_vec();
                for motion in &mut motions {
                    *motion = rows::with_effort_before_clock(motion, found.share);
                }
                rows = rows::accumulate(problem, problem.arm(), &motions, noise)?;
                delay = delay::delay(&rows, is_silent);
                clock = Some(EffortClock::from(found));
                let Some(lags) = efforts.lags(problem, &motions, &rows, found.share)? else {
                    break;
                };
                let rest = effort_clock::drift(&lags, late_by.lag(delay.as_ref()))?;
                so_far = rest.map(|rest| found.and_then(&rest));
            }
        }
        // a delay distorts friction at its reversals: once more with the efforts shifted back
        let mut aligned = motions.clone();
        for _ in 0..ALIGNMENTS {
            let Some(so_far) = delay.clone().filter(Delay::excludes_zero) else { break };
            aligned = motions.iter().map(|m| rows::with_effort_from(m, so_far.delay_s)).collect();
            problem.choose_reversal_speeds(&aligned.iter().collect::<Vec<_>>())?;
            rows = rows::accumulate(problem, problem.arm(), &aligned, noise)?;
            let Some(rest) = delay::delay(&rows, is_silent) else { break };
            delay = Some(so_far.and_then(&rest));
        }
        let is_late = delay.as_ref().filter(|found| found.excludes_zero());
        let look_alike = match is_late {
            Some(found) => {
                let in_time = problem_of(problem.arm(), &motions)?;
                let recorded = (recordings, map);
                delay::look_alike(found, &in_time, (&motions, noise), recorded, is_silent)?
            }
            None => None,
        };
        let (low_pass, low_pass_or_delay) = match late_by {
            LateBy::LowPass(found) => (Some(found), None),
            LateBy::Either(either) => (None, is_late.map(|_| either)),
            LateBy::NoLowPass => (None, None),
        };
        let of_low_pass =
            low_pass_or_delay.map(|low_pass| LookAlike::LowPass(low_pass.time_constant_s));
        Ok(Self {
            clock,
            look_alike: look_alike.or(of_low_pass),
            delay,
            low_pass,
            low_pass_or_delay,
            motions,
            aligned,
            rows,
        })
    }
}

impl Efforts<'_> {
    /// Lags of the efforts by a clock that is fast by the share `drift`, in the band where the noise of the accelerations is little:
    /// it would favour any lag that smooths the columns. `motions` and their `rows` are by that clock too.
    fn lags(
        &self,
        problem: &BatchProblem,
        motions: &[Motion],
        rows: &[ChannelRows],
        drift: f64,
    ) -> Result<Option<Lags>, NumericError> {
        let Self { recordings, map, is_silent, .. } = *self;
        let alive = (0..self.names.len()).filter(|&j| !is_silent[j]);
        let noisiest = alive
            .filter_map(|j| {
                rows::acceleration_noise(self.quality, motions, j, self.names[map.source[j]])
            })
            .fold(0.0, f64::max);
        let rate_hz = motions.iter().map(|m| m.rate_hz).fold(f64::INFINITY, f64::min);
        let cutoff_hz = motions.iter().find_map(|m| Some(m.filter.as_ref()?.cutoff_hz()));
        let quiet = cutoff_hz
            .map(|hz| lag::band_of_lags_hz(hz, rate_hz, noisiest))
            .filter(|hz| Some(*hz) != cutoff_hz)
            .and_then(|hz| map.motions_with_cutoff(hz, recordings, &motions[0].joints));
        match &quiet {
            Some(quiet) => {
                let back = |m: &Motion| match drift == 0.0 {
                    true => m.clone(),
                    false => rows::with_effort_before_clock(m, drift),
                };
                let quiet: Vec<Motion> = quiet.iter().map(back).collect();
                let rows = rows::accumulate(problem, problem.arm(), &quiet, self.noise)?;
                Lags::of(problem, &quiet, &rows, is_silent)
            }
            None => Lags::of(problem, motions, rows, is_silent),
        }
    }
}
