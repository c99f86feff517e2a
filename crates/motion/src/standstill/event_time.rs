//! Where exactly a joint stops, and where it breaks away.
//!
//! A polynomial passes through the motion before the stop, another through that after it; the place in between is the
//! same for both. What is left of the positions says which two instants are the likeliest. A low-pass over all of the
//! motion takes a turn for later than it is: the acceleration before it is the larger one.

use std::array;
use std::ops::Range;

use armident_numeric::{Cholesky, dot};

use super::Standstill;
use super::local_polynomial::{Fit, Sample, nearness};

/// So much of the motion before and after a stop \[s\], and so many samples at least, say where it is...
const SIDE_S: f64 = 0.05;
const SIDE_SAMPLES: usize = 9;
/// ... within so much of where it was seen \[s\], or so many samples.
const OFF_S: f64 = 0.02;
const OFF_SAMPLES: f64 = 2.5;
/// A joint that goes on the same way stops so soon after the first sample at which it seems to rest \[s\].
const SEEN_EARLY_S: f64 = 0.008;
/// Places that are tried in a sample; and then around the best of them.
const COARSE: f64 = 2.0;
const FINE: f64 = 8.0;
/// Terms of a polynomial beside its place: half the square of time, and the two powers after it; after a rest the three
/// from the cube on, for a joint breaks away without acceleration.
const TERMS: usize = 3;
/// Samples that a side must have.
const LEAST: usize = TERMS + 2;
/// Terms of one polynomial through all: of a place, an instant, and as many others as a side has, and one more.
const SMOOTH_TERMS: usize = TERMS + 3;
/// Twice the logarithm of how much likelier it is that the joint stops than that its motion is smooth.
const CLEAR: f64 = 10.0;
/// A rest of fewer samples is none: what an encoder says of it is too little.
const SHORTEST: f64 = 1.0;

/// Squares of what is left of the samples of one side at a place `q` of the stop, `yy - 2 y q + n q²`; and the
/// acceleration at the stop, `a + b q`.
#[derive(Clone, Copy, Default)]
struct Side {
    n: f64,
    y: f64,
    yy: f64,
    acceleration: [f64; 2],
}

impl Side {
    fn and(self, other: Self) -> Self {
        let Self { n, y, yy, .. } = other;
        Self { n: self.n + n, y: self.y + y, yy: self.yy + yy, ..self }
    }

    /// At the likeliest place.
    fn left(&self) -> f64 {
        self.yy - self.y * self.y / self.n
    }

    fn place(&self) -> f64 {
        self.y / self.n
    }

    fn acceleration_at(&self, place: f64) -> f64 {
        self.acceleration[0] + self.acceleration[1] * place
    }
}

/// A stop, and the squares that it leaves.
#[derive(Clone, Copy)]
struct Tried {
    left: f64,
    stop: Standstill,
}

impl Tried {
    fn or_better(best: &mut Option<Self>, left: f64, stop: Standstill) {
        if best.is_none_or(|best| left < best.left) {
            *best = Some(Self { left, stop });
        }
    }
}

/// The likeliest of the stops that were tried, without a rest and with one.
#[derive(Default)]
struct Best {
    turn: Option<Tried>,
    rest: Option<Tried>,
}

/// Positions around a stop, the nearest of which count most.
pub(super) struct Around {
    /// from the middle one
    position: Vec<f64>,
    weight: Vec<f64>,
    /// where the stop was seen
    seen: [f64; 2],
    first: f64,
    rate_hz: f64,
}

impl Around {
    /// Around a stop that was seen at samples `[start, end)`, between what was seen before and after it.
    pub(super) fn of(
        position: &[f64],
        (start, end): (usize, usize),
        (before, after): (usize, usize),
        rate_hz: f64,
    ) -> Self {
        let side = ((SIDE_S * rate_hz).round() as usize).max(SIDE_SAMPLES);
        let first = start.saturating_sub(side).max(before);
        let last = (end + side).min(after).min(position.len()).max(first);
        let middle = position[usize::midpoint(first, last.max(first + 1) - 1)];
        let weight = |t: usize| {
            let off = start.saturating_sub(t).max((t + 1).saturating_sub(end));
            nearness(off as f64, side as f64)
        };
        Self {
            position: position[first..last].iter().map(|q| q - middle).collect(),
            weight: (first..last).map(weight).collect(),
            seen: [start, end].map(|t| t as f64 - first as f64),
            first: first as f64,
            rate_hz,
        }
    }

    /// The likeliest stop, and whether it is clearly likelier than none. `noise` is that of the position.
    pub(super) fn stop(&self, directions: [f64; 2], noise: f64) -> Option<(Standstill, bool)> {
        if self.position.len() < 2 * LEAST || noise <= 0.0 {
            return None;
        }
        let turns = directions[0] * directions[1] < 0.0;
        let off = (OFF_S * self.rate_hz).max(OFF_SAMPLES);
        let [start, end] = self.seen;
        let coarse = self.places(start - off, end - 1.0 + off, COARSE);
        let latest = start + (SEEN_EARLY_S * self.rate_hz).max(1.0);
        let range = if turns { start - off..=start + off } else { start - 1.0..=latest };
        let from: Vec<f64> = coarse.iter().copied().filter(|t| range.contains(t)).collect();
        let mut best = Best::default();
        if turns {
            self.try_turns(&from, directions, &mut best);
        }
        self.try_dwells(&from, &coarse, directions, &mut best);
        let fine = |at: f64| self.places(at - 1.0 / COARSE, at + 1.0 / COARSE, FINE);
        if let Some(turn) = best.turn {
            self.try_turns(&fine(turn.stop.from), directions, &mut best);
        }
        if let Some(rest) = best.rest {
            self.try_dwells(&fine(rest.stop.from), &fine(rest.stop.to), directions, &mut best);
        }
        let Tried { left, stop } = match (best.turn, best.rest) {
            (Some(turn), Some(rest)) => {
                let is_short = rest.stop.to - rest.stop.from < SHORTEST;
                if turn.left < rest.left || is_short { turn } else { rest }
            }
            (turn, rest) => rest.or(turn)?,
        };
        // what the polynomials do not follow counts as noise
        let variance = (noise * noise).max(left / self.weight.iter().sum::<f64>());
        let is_clear = (self.left_by_one()? - left) / variance > CLEAR;
        let (from, to) = (stop.from + self.first, stop.to + self.first);
        Some((Standstill { from, to, ..stop }, is_clear))
    }

    /// Places between two, so many in a sample.
    fn places(&self, low: f64, high: f64, per_sample: f64) -> Vec<f64> {
        let first = (low.max(0.0) * per_sample).ceil() as usize;
        let last = (high.min(self.position.len() as f64 - 1.0) * per_sample).floor() as usize;
        (first..=last).map(|k| k as f64 / per_sample).collect()
    }

    /// Stops at which the joint turns back at once: friction was for what is now against it, so that less of the
    /// acceleration is left.
    fn try_turns(&self, at: &[f64], directions: [f64; 2], best: &mut Best) {
        for &t in at {
            let (Some(before), Some(after)) = (self.before(t), self.after(t, true)) else {
                continue;
            };
            let both = before.and(after);
            let [a, b] = [before, after].map(|side| side.acceleration_at(both.place()));
            if a * b > 0.0 && a.abs() > b.abs() {
                let stop = Standstill { from: t, to: t, directions };
                Tried::or_better(&mut best.turn, both.left(), stop);
            }
        }
    }

    /// Stops at which the joint rests before it breaks away.
    fn try_dwells(&self, from: &[f64], to: &[f64], directions: [f64; 2], best: &mut Best) {
        let before: Vec<Option<Side>> = from.iter().map(|t| self.before(*t)).collect();
        let after: Vec<Option<Side>> = to.iter().map(|t| self.after(*t, false)).collect();
        for (&from, before) in from.iter().zip(&before) {
            for (&to, after) in to.iter().zip(&after).filter(|(to, _)| **to >= from) {
                let (Some(before), Some(after)) = (before, after) else { continue };
                let stop = Standstill { from, to, directions };
                let resting = self.resting(from.ceil() as usize..to.floor() as usize + 1);
                Tried::or_better(&mut best.rest, before.and(*after).and(resting).left(), stop);
            }
        }
    }

    fn before(&self, stop: f64) -> Option<Side> {
        self.side(0..(stop.ceil() as usize).min(self.position.len()), stop, true)
    }

    fn after(&self, stop: f64, accelerates: bool) -> Option<Side> {
        self.side(stop.floor() as usize + 1..self.position.len(), stop, accelerates)
    }

    fn resting(&self, samples: Range<usize>) -> Side {
        let mut side = Side::default();
        for (w, y) in self.weight[samples.clone()].iter().zip(&self.position[samples]) {
            side.n += w;
            side.y += w * y;
            side.yy += w * y * y;
        }
        side
    }

    /// A side of a stop without its polynomial.
    fn side(&self, samples: Range<usize>, stop: f64, accelerates: bool) -> Option<Side> {
        if samples.len() < LEAST {
            return None;
        }
        let mut side = self.resting(samples.clone());
        let (mut gram, mut with_one, mut with_y) =
            ([[0.0; TERMS]; TERMS], [0.0; TERMS], [0.0; TERMS]);
        for t in samples {
            // in units in which all terms are of size 1
            let x = (t as f64 - stop) / self.rate_hz / SIDE_S;
            let (square, w, y) = (x * x, self.weight[t], self.position[t]);
            let terms = if accelerates {
                [square / 2.0, square * x / 6.0, square * square / 24.0]
            } else {
                [square * x / 6.0, square * square / 24.0, square * square * x / 120.0]
            };
            for (i, term) in terms.iter().enumerate() {
                with_one[i] += w * term;
                with_y[i] += w * term * y;
                for (j, other) in terms[..=i].iter().enumerate() {
                    gram[i][j] += w * term * other;
                }
            }
        }
        let factor = Cholesky::of(TERMS, |i, j| gram[i][j])?;
        let (one, y) = (factor.solve(&with_one), factor.solve(&with_y));
        side.n -= dot(&with_one, &one);
        side.y -= dot(&with_one, &y);
        side.yy -= dot(&with_y, &y);
        if accelerates {
            side.acceleration = [y[0], -one[0]].map(|a| a / SIDE_S.powi(2));
        }
        Some(side)
    }

    /// Squares that one polynomial through all leaves.
    fn left_by_one(&self) -> Option<f64> {
        let half = self.position.len() as f64 / 2.0;
        let sample = |(t, (weight, value)): (usize, (&f64, &f64))| -> Sample<SMOOTH_TERMS> {
            let x = (t as f64 - half) / half;
            Sample { weight: *weight, terms: array::from_fn(|k| x.powi(k as i32)), value: *value }
        };
        let samples: Vec<Sample<SMOOTH_TERMS>> =
            self.weight.iter().zip(&self.position).enumerate().map(sample).collect();
        Fit::of(&samples).map(|fit| fit.left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::standstill::quantisation;

    /// A joint of inertia 1 with dry friction behind a drive of this natural frequency \[rad/s\] follows two sines.
    /// Gives its positions at this rate, and its stops.
    fn followed(friction: f64, frequency: f64, rate_hz: f64) -> (Vec<f64>, Vec<Standstill>) {
        const STEP_S: f64 = 1e-5;
        const DAMPING: f64 = 0.7;
        let (mut q, mut v) = (0.0_f64, 0.0_f64);
        let (mut positions, mut stops) = (Vec::new(), Vec::new());
        let mut since: Option<(f64, f64)> = None;
        let per_sample = (1.0 / rate_hz / STEP_S).round() as usize;
        for k in 0..(4.0 / STEP_S) as usize {
            if k % per_sample == 0 {
                positions.push(q);
            }
            let t = k as f64 * STEP_S;
            let sines = [(0.5, 3.1), (0.2, 5.3)];
            let sum =
                |of: &dyn Fn(f64, f64) -> f64| sines.iter().map(|(r, w)| of(*r, *w)).sum::<f64>();
            let place = sum(&|r, w| r * (1.0 - (w * t).cos()));
            let speed = sum(&|r, w| r * w * (w * t).sin());
            let forward = sum(&|r, w| r * w * w * (w * t).cos());
            let effort =
                forward + frequency.powi(2) * (place - q) + 2.0 * DAMPING * frequency * (speed - v);
            if v == 0.0 {
                if effort.abs() > friction {
                    v = (effort - friction.copysign(effort)) * STEP_S;
                    if let Some((from, before)) = since.take() {
                        let directions = [before.signum(), v.signum()];
                        stops.push(Standstill { from, to: t * rate_hz, directions });
                    }
                }
            } else {
                let next = v + (effort - friction.copysign(v)) * STEP_S;
                if next * v <= 0.0 {
                    since = Some((t * rate_hz, v));
                    v = 0.0;
                } else {
                    v = next;
                }
            }
            q += v * STEP_S;
        }
        (positions, stops)
    }

    /// Stops of a simulated joint are found where they are, through its encoder: to 1.2 ms at 200 and 400 Hz, a tenth of
    /// the width of the low-pass, and break-aways to 2.5 ms. Where friction is next to nothing none is clear.
    #[test]
    fn stops_are_found_to_fractions_of_a_sample() {
        const STEP: f64 = 2e-5;
        let (mut turned, mut rested) = (0, 0);
        for rate_hz in [200.0, 400.0] {
            for (friction, frequency) in [(1.0, 20.0), (2.0, 40.0), (4.0, 40.0), (5.0, 60.0)] {
                let (positions, stops) = followed(friction, frequency, rate_hz);
                let recorded: Vec<f64> =
                    positions.iter().map(|q| (q / STEP).round() * STEP).collect();
                for stop in stops {
                    let seen = (stop.from.round() as usize, stop.to.round() as usize + 1);
                    let around = Around::of(&recorded, seen, (0, recorded.len()), rate_hz);
                    let (found, is_clear) =
                        around.stop(stop.directions, quantisation(STEP)).unwrap();
                    let ms = |samples: f64| samples / rate_hz * 1e3;
                    assert!(is_clear, "{stop:?} {found:?}");
                    if found.to > found.from {
                        assert!(ms(found.from - stop.from).abs() < 1.2, "{stop:?} {found:?}");
                        assert!(ms(found.to - stop.to).abs() < 2.5, "{stop:?} {found:?}");
                    } else {
                        // where it rests for less than two samples, too
                        let early = ms(stop.from - found.from);
                        let late = ms(found.from - stop.to);
                        assert!(early < 1.2 && late < 1.2, "{stop:?} {found:?}");
                        assert!(stop.to - stop.from < 2.0, "{stop:?}");
                    }
                    let is_dwell = stop.to - stop.from > 2.0;
                    (turned, rested) =
                        (turned + usize::from(!is_dwell), rested + usize::from(is_dwell));
                }
            }
        }
        assert!(turned > 20 && rested > 3, "{turned} {rested}");
        let (positions, stops) = followed(0.02, 40.0, 400.0);
        for stop in stops {
            let seen = (stop.from.round() as usize, stop.to.round() as usize + 1);
            let around = Around::of(&positions, seen, (0, positions.len()), 400.0);
            let found = around.stop(stop.directions, quantisation(STEP));
            assert!(found.is_none_or(|(_, is_clear)| !is_clear), "{found:?}");
        }
    }
}
