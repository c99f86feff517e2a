//! Accelerations of the other joints where one stops.
//!
//! Their efforts do not jump there, nor does their friction: with the acceleration of the one that stops, theirs jump. A
//! low-pass smears both. On the rows of the other joints that cancels, for they stay as smeared together as they are; on
//! the row of the joint that stops, whose own acceleration is known up to the stop, theirs have to be.

use armident_recording::RecordingError;

use super::Standstill;
use super::local_polynomial::{Fit, Sample, nearness};
use crate::decimate::low_pass;

/// So much of a motion around a stop \[s\], and so many samples a side at least, say by how much an acceleration jumps.
const SIDE_S: f64 = 0.04;
const SIDE_SAMPLES: f64 = 7.0;
/// Samples that there must be on either side.
const LEAST_BESIDE: f64 = 5.0;
/// Terms of a quartic, and the jump.
const TERMS: usize = 6;
/// A low-pass smears a jump over so much on either side of it \[s\]; known every so often.
const SMEARED_S: f64 = 0.1;
const SMEARED_HZ: f64 = 4000.0;

/// By how much the accelerations of all joints jump where one of them stops, and nothing for itself.
#[derive(Debug, Clone)]
pub(crate) struct CoupledJump {
    stop: Standstill,
    jumps: Vec<f64>,
}

/// A motion with jumps of its accelerations: positions of all joints, and their noises.
pub(crate) fn coupled_jumps_of(
    stops: &[Standstill],
    of: usize,
    positions: &[Vec<f64>],
    noises: &[f64],
    rate_hz: f64,
) -> Vec<CoupledJump> {
    let jumps = |stop: &Standstill| {
        let jump = |(j, (position, noise)): (usize, (&Vec<f64>, &f64))| {
            if j == of { 0.0 } else { jump_at(position, stop.from, *noise, rate_hz) }
        };
        positions.iter().zip(noises).enumerate().map(jump).collect()
    };
    let stops = stops.iter().filter(|stop| stop.stops());
    stops.map(|stop| CoupledJump { stop: *stop, jumps: jumps(stop) }).collect()
}

impl CoupledJump {
    /// Restores the jumps of accelerations that went through a low-pass; while the joint rests they go on in a line where
    /// what its drive answers is asked for (`held`).
    pub(crate) fn restore(
        &self,
        accelerations: &mut [Vec<f64>],
        held: bool,
        step: &SmearedStep,
        rate_hz: f64,
    ) {
        let Self { stop, jumps } = self;
        let samples = accelerations.first().map_or(0, Vec::len);
        let wide = (SMEARED_S * rate_hz).ceil();
        let first = (stop.from - wide).max(0.0) as usize;
        let last = ((stop.to + wide) as usize).min(samples);
        let begun = Standstill { to: stop.from, ..*stop };
        for t in first..last {
            let sharp = if held { stop.share_at(t) } else { begun.share_at(t) };
            let more = sharp - step.at((t as f64 - stop.from) / rate_hz);
            for (acceleration, jump) in accelerations.iter_mut().zip(jumps) {
                acceleration[t] += jump * more;
            }
        }
    }

    pub(crate) fn thinned(&self, step: usize) -> Self {
        Self { stop: self.stop.thinned(step), jumps: self.jumps.clone() }
    }
}

/// What a low-pass makes of a step.
#[derive(Debug)]
pub(crate) struct SmearedStep(Vec<f64>);

impl SmearedStep {
    /// Of the low-pass of motions with this cut-off.
    ///
    /// # Errors
    /// None for a cut-off far below 4000 Hz.
    pub(crate) fn of(cutoff_hz: f64) -> Result<Self, RecordingError> {
        let half = (SMEARED_S * SMEARED_HZ) as usize;
        let step: Vec<f64> = (0..8 * half).map(|k| f64::from(u8::from(k >= 4 * half))).collect();
        let smooth = low_pass(cutoff_hz, SMEARED_HZ)?.filter(&step);
        Ok(Self(smooth[3 * half..5 * half].to_vec()))
    }

    fn at(&self, time_s: f64) -> f64 {
        let x = (time_s + SMEARED_S) * SMEARED_HZ;
        if x <= 0.0 {
            return 0.0;
        }
        let (k, rest) = (x as usize, x.fract());
        match self.0.get(k..k + 2) {
            Some(step) => step[0] + rest * (step[1] - step[0]),
            None => 1.0,
        }
    }
}

/// By how much the acceleration of a joint that stays in motion jumps: of a quartic that bends there. Drawn to nothing as
/// far as noise would bend it as well (James and Stein, Estimation with quadratic loss, 1961).
fn jump_at(position: &[f64], at: f64, noise: f64, rate_hz: f64) -> f64 {
    let side = (SIDE_S * rate_hz).max(SIDE_SAMPLES);
    let first = (at - side).max(0.0).ceil() as usize;
    let last = ((at + side).floor() as usize + 1).min(position.len());
    let beside = (at - first as f64).min(last as f64 - 1.0 - at);
    if last < first + 2 * TERMS || beside < LEAST_BESIDE {
        return 0.0;
    }
    let middle = position[usize::midpoint(first, last)];
    let sample = |t: usize| -> Sample<TERMS> {
        let x = (t as f64 - at) / side;
        let terms = [1.0, x, x * x, x.powi(3), x.powi(4), x.max(0.0) * x / 2.0];
        Sample { weight: nearness((t as f64 - at).abs(), side), terms, value: position[t] - middle }
    };
    let samples: Vec<Sample<TERMS>> = (first..last).map(sample).collect();
    let Some(bent) = Fit::of(&samples) else { return 0.0 };
    let jump = bent.coefficients[TERMS - 1];
    let variance = (bent.left / bent.weight).max(noise * noise) * bent.variances[TERMS - 1];
    jump * (1.0 - variance / jump.powi(2)).max(0.0) * (rate_hz / side).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decimate::{kinematics_cutoff_hz, kinematics_filter};
    use crate::standstill::quantisation;

    const RATE_HZ: f64 = 400.0;
    const STEP: f64 = 2e-5;
    const AT: f64 = 400.3;

    /// A joint in motion whose acceleration jumps by so much.
    fn jumping(by: f64) -> Vec<f64> {
        let position = |k: usize| {
            let since = ((k as f64 - AT) / RATE_HZ).max(0.0);
            (3.0 * k as f64 / RATE_HZ).sin() + 0.5 * by * since * since
        };
        (0..800).map(|k| (position(k) / STEP).round() * STEP).collect()
    }

    /// A jump is found through the encoder to three of its standard deviations, and none where there is none.
    #[test]
    fn a_jump_is_as_large_as_it_is() {
        for by in [-5.0, 2.0, 0.0] {
            let found = jump_at(&jumping(by), AT, quantisation(STEP), RATE_HZ);
            assert!((found - by).abs() < 0.4, "{by}: {found}");
        }
        // at an end of the recording it is not known
        assert_eq!(jump_at(&jumping(2.0)[..403], AT, quantisation(STEP), RATE_HZ), 0.0);
    }

    /// What a low-pass smeared is as sharp as it was, where the other joint stops; and goes over in a line while that rests.
    #[test]
    fn a_smeared_jump_is_restored() {
        let sharp: Vec<f64> = (0..800).map(|k| 4.0 * f64::from(u8::from(k as f64 >= AT))).collect();
        let smeared = kinematics_filter(RATE_HZ).unwrap().filter(&sharp);
        let step = SmearedStep::of(kinematics_cutoff_hz(RATE_HZ)).unwrap();
        let stop = Standstill { from: AT, to: AT + 20.0, directions: [1.0, -1.0] };
        let reaction = CoupledJump { stop, jumps: vec![4.0] };
        let off = |held: bool, expected: &dyn Fn(usize) -> f64| -> f64 {
            let mut restored = vec![smeared.clone()];
            reaction.restore(&mut restored, held, &step, RATE_HZ);
            let off = |t: usize| (restored[0][t] - expected(t)).abs();
            (0..800_usize).filter(|t| t.abs_diff(400) > 1).map(off).fold(0.0, f64::max)
        };
        let smear = smeared.iter().zip(&sharp).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // the step of the samples is not quite where the jump is
        assert!(smear > 1.5 && off(false, &|t| sharp[t]) < 0.25, "{smear}");
        assert!(off(true, &|t| 4.0 * stop.share_at(t)) < 0.25);
    }
}
