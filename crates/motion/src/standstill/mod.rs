//! Where a joint stops: its acceleration jumps there, and its friction is no function of its motion.
//!
//! Friction helps a joint to stop, and is against what comes after. It turns back at once where its drive has overcome
//! friction by then, with what acceleration is left; else it rests, and breaks away with none. Much is known all the
//! same. The motion before a stop is smooth by itself, and so is that after it ([`segments`]), so that the stop is known to
//! a fraction of a sample ([`event_time`]). A drive does not jump: its effort is continuous where a joint stops and where it
//! breaks away, so while the joint rests it goes from what it needed before to what it needs after ([`actuator`]). The other
//! joints' efforts do not jump either, so their accelerations do ([`coupled_jumps`]). And what the drive follows goes on
//! meanwhile: how far it runs while friction reverses follows from the dwells in which the joint turns back ([`direction`]).

mod actuator;
mod coupled_jumps;
mod direction;
mod dwell;
mod event_time;
mod local_polynomial;
mod record_ends;
mod segments;

pub use actuator::continued;
pub(crate) use actuator::held;
pub(crate) use coupled_jumps::{CoupledJump, SmearedStep, coupled_jumps_of};
pub(crate) use direction::{directions_and_stops, dwells_of};
pub(crate) use record_ends::{stands_at_ends, starts_at_rest};
pub use segments::{ChannelSeries, Kind, filter_between};

use crate::EndExtension;
use direction::{spells, sure_speed};
use event_time::Around;

/// A stop shorter than this is none for friction that fades \[s\]: the joint turns back.
const DWELL_S: f64 = 0.008;

/// A joint that turns back comes from where it goes to, so long before a rest and after it \[s\].
const AWAY_S: f64 = 0.02;

/// Where a joint comes to a stop, and where it breaks away, in samples; the same where it turns back at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standstill {
    /// Where the joint comes to a stop, in samples.
    pub from: f64,
    /// Where it breaks away, in samples.
    pub to: f64,
    /// Signs of the velocity before and after, 0 where the recording begins or ends.
    pub directions: [f64; 2],
}

impl Standstill {
    /// Its samples, `[start, end)`: none where a joint turns back between two.
    pub fn samples(&self) -> (usize, usize) {
        let start = self.from.ceil() as usize;
        (start, if self.to > self.from { self.to.floor() as usize + 1 } else { start })
    }

    /// Whether the joint was in motion before.
    pub fn stops(&self) -> bool {
        self.from > 0.0
    }

    /// Whether the joint goes on the other way.
    fn turns(&self) -> bool {
        self.directions[0] * self.directions[1] < 0.0
    }

    /// Whether the joint stays where it is for a while.
    pub fn is_dwell(&self, rate_hz: f64) -> bool {
        self.to - self.from > DWELL_S * rate_hz
    }

    /// How much of the stop is over, a mean of the time around a sample.
    fn share_at(&self, sample: usize) -> f64 {
        let length = self.to - self.from;
        let until = |t: f64| {
            let since = (t - self.from).max(0.0);
            let (inside, beyond) = (since.min(length), (since - length).max(0.0));
            if length > 0.0 { beyond + inside * inside / (2.0 * length) } else { beyond }
        };
        until(sample as f64 + 0.5) - until(sample as f64 - 0.5)
    }

    /// Of every so many samples.
    pub fn thinned(&self, step: usize) -> Self {
        Self { from: self.from / step as f64, to: self.to / step as f64, ..*self }
    }
}

/// Position, velocity and acceleration of one joint.
pub(crate) struct SmoothMotion {
    pub(crate) position: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) acceleration: Vec<f64>,
}

/// What is recorded of the motion of one joint, on an even grid.
pub(crate) struct Channels<'a> {
    pub position: &'a [f64],
    /// to be used in place of the derivative of the position
    pub velocity: Option<&'a [f64]>,
    /// least difference of positions
    pub step: f64,
    pub rate_hz: f64,
    /// how position and velocity go on past the ends of the recording
    pub extensions: [EndExtension; 2],
    /// whether the joint stands at the first sample, and at the last
    pub stands: [bool; 2],
}

/// A stop as it is seen at first.
struct Glimpse {
    start: usize,
    end: usize,
    /// whether the joint was seen to stay where it is, not only to turn
    is_dwell: bool,
    directions: [f64; 2],
}

impl Channels<'_> {
    /// Where the joint rests, and where it turns back with another acceleration, as exactly as its motion says. `motion`
    /// is that through a low-pass; the noises are those of the position and of the speed.
    pub(crate) fn stops(
        &self,
        motion: &SmoothMotion,
        noise: f64,
        of_speed: f64,
    ) -> Vec<Standstill> {
        let seen = self.glimpses(motion, noise, of_speed);
        let samples = self.position.len();
        let deviation = noise.max(quantisation(self.step));
        let exact = |(k, glimpse): (usize, &Glimpse)| {
            let &Glimpse { start, end, is_dwell, directions } = glimpse;
            let before = k.checked_sub(1).map_or(0, |k| seen[k].end);
            let after = seen.get(k + 1).map_or(samples, |next| next.start);
            let found = (start > 0 && end < samples).then(|| {
                Around::of(self.position, (start, end), (before, after), self.rate_hz)
                    .stop(directions, deviation)
            });
            match found.flatten() {
                // a motion that is smooth all through may turn as well
                Some((stop, is_clear)) => (is_clear || is_dwell).then_some(stop),
                None => is_dwell.then_some(Standstill {
                    from: start as f64,
                    to: end as f64 - 1.0,
                    directions,
                }),
            }
        };
        let mut found: Vec<Standstill> = seen.iter().enumerate().filter_map(exact).collect();
        found.sort_by(|a, b| a.from.total_cmp(&b.from));
        // one after the other: of two that overlap, noise moved one into the other
        let mut last = f64::MIN;
        found.retain(|stop| {
            let follows = stop.from > last;
            last = last.max(stop.to);
            follows
        });
        found
    }

    /// Where the joint rests, and where it is slow or reverses in between.
    fn glimpses(&self, motion: &SmoothMotion, noise: f64, of_speed: f64) -> Vec<Glimpse> {
        let velocity = &motion.velocity;
        let n = velocity.len();
        let dwells = self.dwells(&motion.acceleration, noise);
        let touches =
            |start: usize, end: usize| dwells.iter().any(|rest| rest.0 <= end && start <= rest.1);
        let (_, threshold) = sure_speed(velocity, of_speed);
        let reverses = |t: &usize| {
            let [before, after] = [velocity[t - 1], velocity[*t]];
            before * after < 0.0 && before.abs().min(after.abs()) >= threshold
        };
        let crossings = (1..n).filter(reverses).map(|t| (t, t));
        let turns = spells(velocity, threshold).into_iter().chain(crossings).filter_map(|spell| {
            let (start, end) = spell;
            let inside = start > 0 && end < n && !touches(start, end);
            let directions =
                inside.then(|| [velocity[start - 1], velocity[end]].map(f64::signum))?;
            let turns = directions[0] * directions[1] < 0.0;
            turns.then_some(Glimpse { start, end, is_dwell: false, directions })
        });
        let at_rest = dwells.iter().map(|&(start, end)| {
            let directions = self.ways_beside((start, end));
            Glimpse { start, end, is_dwell: true, directions }
        });
        let mut seen: Vec<Glimpse> = turns.chain(at_rest).collect();
        seen.sort_by_key(|glimpse| (glimpse.start, glimpse.end));
        seen
    }

    /// Signs of the ways to a rest and from it: after a sudden stop that of a smoothed speed may be wrong.
    fn ways_beside(&self, (start, end): (usize, usize)) -> [f64; 2] {
        let last = self.position.len() - 1;
        let away = ((AWAY_S * self.rate_hz).round() as usize).max(3);
        let place = self.position[usize::midpoint(start, end).min(last)];
        let sign = |way: f64| if way == 0.0 { 0.0 } else { way.signum() };
        let before = place - self.position[start.saturating_sub(away)];
        let after = self.position[(end + away).min(last)] - place;
        [if start > 0 { sign(before) } else { 0.0 }, if end <= last { sign(after) } else { 0.0 }]
    }
}

/// Standard deviation of what is rounded to this step.
pub(crate) fn quantisation(step: f64) -> f64 {
    step / 12.0_f64.sqrt()
}

/// The least that successive samples differ by, if they do.
pub(crate) fn least_step(position: &[f64]) -> f64 {
    let steps = position.windows(2).map(|p| (p[1] - p[0]).abs()).filter(|step| *step > 0.0);
    steps.reduce(f64::min).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decimate::kinematics_filter;

    const RATE_HZ: f64 = 400.0;

    /// Slows down at 3 rad/s2, rests from 0.5 s for as long as is said, and breaks away with an acceleration that grows from
    /// nothing, back or on the same way.
    fn stopping(rest_s: f64, way: f64) -> Vec<f64> {
        let position = |t: f64| {
            let later = (t - 0.5 - rest_s).max(0.0);
            -1.5 * (0.5 - t).max(0.0).powi(2) - way * 5.0 * later.powi(3)
        };
        (0..600).map(|k| position(f64::from(k) / RATE_HZ)).collect()
    }

    fn channels(position: &[f64]) -> Channels<'_> {
        let extensions = EndExtension::of(position, 2, &kinematics_filter(RATE_HZ).unwrap());
        let (extensions, stands) = ([extensions; 2], [false; 2]);
        Channels { position, velocity: None, step: 0.0, rate_hz: RATE_HZ, extensions, stands }
    }

    fn seen(position: &[f64]) -> (Vec<Standstill>, SmoothMotion, SmoothMotion) {
        let low_pass = kinematics_filter(RATE_HZ).unwrap();
        let channels = channels(position);
        let blurred = channels.smooth(&low_pass);
        let stops = channels.stops(&blurred, 1e-6, 1e-6);
        let sharp = channels.smooth_between(&stops, &low_pass, channels.smooth(&low_pass));
        (stops, blurred, sharp)
    }

    /// Up to a stop the acceleration is what it was, at the rest there is none, and then it grows from nothing; a filter
    /// over all of it is half off at the stop.
    #[test]
    fn a_stop_keeps_its_acceleration() {
        let (stops, blurred, sharp) = seen(&stopping(0.1, 1.0));
        let &[stop] = stops.as_slice() else { panic!("{stops:?}") };
        assert!(stop.turns() && stop.is_dwell(RATE_HZ));
        assert!((stop.from - 200.0).abs() < 0.3 && (stop.to - 240.0).abs() < 0.5, "{stop:?}");
        let (start, end) = stop.samples();
        let off = |motion: &SmoothMotion, t: usize, expected: f64| {
            (motion.acceleration[t] - expected).abs()
        };
        assert!(off(&sharp, start - 1, -3.0) < 0.15, "{}", sharp.acceleration[start - 1]);
        assert!(off(&blurred, start - 1, -3.0) > 0.8, "{}", blurred.acceleration[start - 1]);
        assert!(sharp.acceleration[start..end].iter().all(|a| *a == 0.0));
        for t in end..end + 30 {
            let expected = -30.0 * (t as f64 - 240.0) / RATE_HZ;
            assert!(off(&sharp, t, expected) < 0.1, "{t}: {}", sharp.acceleration[t]);
        }
        let held = held(&sharp.acceleration, &stops, RATE_HZ);
        let middle = usize::midpoint(start, end);
        assert!((held[middle] + 1.5).abs() < 0.15, "{}", held[middle]);
        assert_eq!(held[end..], sharp.acceleration[end..]);
    }

    /// A joint that turns back between two samples with a third of its acceleration has the one up to there and the other
    /// from there on, and its friction reverses there and not where the smeared speed crosses zero.
    #[test]
    fn a_turn_keeps_both_accelerations() {
        let position = |k: u32| {
            let t = (f64::from(k) - 300.4) / RATE_HZ;
            -0.5 * t * t * if t < 0.0 { 3.0 } else { 1.0 }
        };
        let position: Vec<f64> = (0..600).map(position).collect();
        let (stops, blurred, sharp) = seen(&position);
        let &[turn] = stops.as_slice() else { panic!("{stops:?}") };
        assert!(
            (turn.from - 300.4).abs() < 0.15 && turn.to == turn.from && turn.turns(),
            "{turn:?}"
        );
        for (t, expected) in [(290, -3.0), (299, -3.0), (302, -1.0), (310, -1.0)] {
            assert!(
                (sharp.acceleration[t] - expected).abs() < 0.1,
                "{t}: {}",
                sharp.acceleration[t]
            );
        }
        assert!(blurred.velocity[301] > 0.0 && sharp.velocity[301] < 0.0);
        let (direction, stuck) =
            directions_and_stops(&sharp.velocity, &sharp.acceleration, &stops, 1e-6, RATE_HZ);
        assert_eq!((direction[299], direction[302]), (1.0, -1.0));
        // nine tenths of the time around sample 300
        assert!((direction[300] - 0.8).abs() < 0.3 && !stuck[300], "{}", direction[300]);
    }

    /// A smooth motion that turns has no stop.
    #[test]
    fn a_smooth_turn_is_no_stop() {
        let sine: Vec<f64> = (0..1200).map(|k| (3.0 * f64::from(k) / RATE_HZ).sin()).collect();
        let (stops, blurred, sharp) = seen(&sine);
        assert_eq!(stops, []);
        assert_eq!(blurred.acceleration, sharp.acceleration);
    }

    /// Joints that are off at once start at rest; the same motion cut out of its middle does not.
    #[test]
    fn a_sudden_start_is_one_from_rest() {
        const STEP: f64 = 1e-5;
        // 0.3 rad/s within some 10 ms, and a sine beside
        let position =
            |t: f64| 0.3 * (t - 0.01 * (1.0 - (-t / 0.01).exp())) + 0.2 * (1.0 - (2.0 * t).cos());
        let arm_from = |start_s: f64| -> Vec<Vec<f64>> {
            let of = |j: usize| {
                let at = |k: usize| (1.0 + 0.3 * j as f64) * position(start_s + k as f64 / RATE_HZ);
                (0..2000).map(|k| (at(k) / STEP).round() * STEP).collect()
            };
            (0..3).map(of).collect()
        };
        let is_at_rest = |positions: Vec<Vec<f64>>| {
            let joints: Vec<Channels<'_>> = positions.iter().map(|q| channels(q)).collect();
            starts_at_rest(&joints, &[quantisation(STEP); 3])
        };
        assert!(is_at_rest(arm_from(0.0)));
        assert!(!is_at_rest(arm_from(0.02)));
        assert!(!is_at_rest(arm_from(1.0)));
    }

    /// While a joint rests and turns back its friction reverses in a line. Where it goes on the same way, friction gives
    /// way as far as what the drive follows runs back meanwhile, and never reverses: nothing to speak of for a soft drive,
    /// whose joint turned back in a longer rest.
    #[test]
    fn friction_of_a_joint_at_rest() {
        let joined = |turning_s: f64| -> Vec<f64> {
            let (turns, extensions) = (stopping(turning_s, 1.0), stopping(0.1, -1.0));
            let offset = turns[599] - extensions[0];
            // the end of the first and the start of the second move fast and differently: cut there
            turns.iter().copied().chain(extensions.iter().map(|q| q + offset)).collect()
        };
        let middles = |turning_s: f64| -> [f64; 2] {
            let (stops, _, motion) = seen(&joined(turning_s));
            let SmoothMotion { velocity, acceleration, .. } = &motion;
            let (direction, stuck) =
                directions_and_stops(velocity, acceleration, &stops, 1e-6, RATE_HZ);
            // the middle of it is neither
            let dwells: Vec<&Standstill> =
                stops.iter().filter(|stop| stop.is_dwell(RATE_HZ)).collect();
            let &[turns, extensions] = dwells.as_slice() else { panic!("{stops:?}") };
            assert!(turns.turns() && !extensions.turns());
            [turns, extensions].map(|stop| {
                let middle = (0.5 * (stop.from + stop.to)).round() as usize;
                assert!(stuck[middle]);
                direction[middle]
            })
        };
        let [turned, extensions] = middles(0.02);
        // it tells of four fifths of a reversal; of a joint that did not turn back, of half as much
        assert!(
            turned.abs() < 0.3 && extensions > 0.0 && extensions < 0.3,
            "{turned} {extensions}"
        );
        let [turned, extensions] = middles(0.29);
        assert!(turned.abs() < 0.05 && extensions > 0.7, "{turned} {extensions}");
    }
}
