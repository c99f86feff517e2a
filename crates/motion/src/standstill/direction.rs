//! The direction of a joint, and of its friction where it stops.

use std::ops::Range;

use super::Standstill;

/// A speed below this many standard deviations of its noise has no sign...
const SIGN_DEVIATIONS: f64 = 5.0;
/// ... nor one below this share of the root mean square speed.
const SIGN_SHARE: f64 = 0.002;
/// A joint sticks below this share of the root mean square speed...
const STICK_SHARE: f64 = 0.006;
/// ... if it stays there this long \[s\].
const STICK_S: f64 = 0.03;
/// A joint rests when it is slow for this long \[s\], whatever its friction; never where it has this share of the root
/// mean square speed.
const REST_S: f64 = 0.2;
const SLOW_SHARE: f64 = 0.1;
/// Friction fades to nothing in this time \[s\] when a joint slows down and goes on the same way, and in the second
/// one when it rests in between.
const DIP_S: f64 = 0.04;
const REST_DIP_S: f64 = 0.1;
/// A low-pass overshoots so long beside a stop \[s\].
const OVERSHOT_S: f64 = 0.02;
/// A joint that breaks away has the acceleration of what its drive follows so much later \[s\].
const LATER_S: f64 = 0.03;

/// Direction of motion, bridged where the speed has no sure sign, and where the joint sticks.
///
/// Between two directions the friction of a stopped joint goes from one level to the other, and a line
/// is the best guess; between two equal ones it gives way in between, but not at once where the joint rests.
pub(crate) fn directions_and_stops(
    velocity: &[f64],
    acceleration: &[f64],
    stops: &[Standstill],
    noise: f64,
    rate_hz: f64,
) -> (Vec<f64>, Vec<bool>) {
    let n = velocity.len();
    let (rms, threshold) = sure_speed(velocity, noise);
    let dwells: Vec<(usize, usize)> =
        stops.iter().map(Standstill::samples).filter(|(start, end)| start < end).collect();
    let mut velocity = velocity.to_vec();
    let mut resting = vec![false; n];
    for (start, end) in &dwells {
        velocity[*start..*end].fill(0.0);
        resting[*start..*end].fill(true);
    }
    for stop in stops {
        stop.overshoots(&mut velocity, threshold, rate_hz);
    }
    let mut direction: Vec<f64> =
        velocity.iter().map(|v| if v.abs() >= threshold { v.signum() } else { 0.0 }).collect();
    let bridge = |(start, end): (usize, usize)| {
        let mut within = dwells.iter().filter(|(from, to)| *from < end && start < *to);
        let first = within.next();
        let last = within.next_back().or(first);
        Bridge {
            start,
            end,
            before: if start == 0 { 0.0 } else { direction[start - 1] },
            after: if end == n { 0.0 } else { direction[end] },
            rest: first.zip(last).map(|(first, last)| (first.0.max(start), last.1.min(end))),
            stop: stop_in(stops, start, end),
        }
    };
    let bridges: Vec<Bridge> =
        doubtful(&velocity, threshold, stops).into_iter().map(bridge).collect();
    let turning_speed = turning_speed(&bridges, acceleration, rate_hz);
    for bridge in &bridges {
        bridge.cross(&mut direction, acceleration, turning_speed, rate_hz);
    }
    let mut stuck = resting;
    for (start, end) in spells(&velocity, threshold.max(STICK_SHARE * rms)) {
        if (end - start) as f64 >= STICK_S * rate_hz {
            stuck[start..end].fill(true);
        }
    }
    (direction, stuck)
}

/// Dwells of a joint, from its speed and the noise of that: slow spells that last.
pub(crate) fn dwells_of(velocity: &[f64], noise: f64, rate_hz: f64) -> Vec<Range<usize>> {
    let (rms, _) = sure_speed(velocity, noise);
    let slow = (SIGN_DEVIATIONS * noise).min(SLOW_SHARE * rms).max(STICK_SHARE * rms);
    let spells = spells(velocity, slow).into_iter();
    spells
        .filter(|(start, end)| (end - start) as f64 >= REST_S * rate_hz)
        .map(|(start, end)| start..end)
        .collect()
}

/// Samples in which the speed has no sure sign, `[start, end)`, the directions before and after, and the rest within.
struct Bridge {
    start: usize,
    end: usize,
    before: f64,
    after: f64,
    rest: Option<(usize, usize)>,
    /// the one stop that it is
    stop: Option<Standstill>,
}

/// Where the direction is not sure; a joint may also turn between two samples, `[start, start)`.
fn doubtful(velocity: &[f64], threshold: f64, stops: &[Standstill]) -> Vec<(usize, usize)> {
    let mut found = spells(velocity, threshold);
    for stop in stops.iter().filter(|stop| stop.turns() && stop.stops()) {
        let (start, end) = stop.samples();
        let is_between = start == end && start < velocity.len();
        if is_between && !found.iter().any(|spell| spell.0 <= end && start <= spell.1) {
            found.push((start, end));
        }
    }
    found
}

/// Speed below which the direction is not sure; and the root mean square.
pub(super) fn sure_speed(velocity: &[f64], noise: f64) -> (f64, f64) {
    let rms = (velocity.iter().map(|v| v * v).sum::<f64>() / velocity.len().max(1) as f64).sqrt();
    (rms, (SIGN_DEVIATIONS * noise).max(SIGN_SHARE * rms))
}

/// The stop in some samples or beside them, if it is one.
fn stop_in(stops: &[Standstill], start: usize, end: usize) -> Option<Standstill> {
    let within = |stop: &&Standstill| stop.to > start as f64 - 1.0 && stop.from < end as f64;
    let mut stops = stops.iter().filter(within);
    let stop = stops.next()?;
    stops.next().is_none().then_some(*stop)
}

impl Standstill {
    /// Takes away what a low-pass makes of a sudden stop or break-away: speeds beside it of the wrong sign.
    fn overshoots(&self, velocity: &mut [f64], threshold: f64, rate_hz: f64) {
        let [before, after] = self.directions;
        let (start, end) = self.samples();
        let beside = (OVERSHOT_S * rate_hz).ceil() as usize;
        let wrong =
            |direction: f64| move |v: &&mut f64| direction != 0.0 && **v * direction < threshold;
        let earlier = velocity[start.saturating_sub(beside)..start].iter_mut().rev();
        earlier.take_while(wrong(before)).for_each(|v| *v = 0.0);
        let last = (end + beside).min(velocity.len());
        let later = velocity[end.min(last)..last].iter_mut();
        later.take_while(wrong(after)).for_each(|v| *v = 0.0);
    }
}

impl Bridge {
    fn turns(&self) -> bool {
        self.before * self.after < 0.0
    }

    /// Sets the directions in between.
    fn cross(
        &self,
        direction: &mut [f64],
        acceleration: &[f64],
        turning_speed: Option<f64>,
        rate_hz: f64,
    ) {
        let Self { before, after, .. } = *self;
        if let Some(stop) = self.stop.filter(|_| self.turns()) {
            for t in self.start.saturating_sub(1)..(self.end + 1).min(direction.len()) {
                direction[t] = before + (after - before) * stop.share_at(t);
            }
            return;
        }
        // where the joint rests, and only there, friction is no longer that of before, not yet that of after
        let (start, end) = self.rest.unwrap_or((self.start, self.end));
        direction[self.start..start].fill(before);
        direction[end..self.end].fill(after);
        let length = (end - start + 1) as f64;
        let dip = match self.rest {
            Some(_) => (REST_DIP_S * rate_hz).min(length),
            None => (DIP_S * rate_hz).max(1.0),
        };
        let pushed_back = (self.rest)
            .zip(turning_speed)
            .filter(|_| before * after > 0.0)
            .map(|(rest, speed)| reference_speed(rest, acceleration, rate_hz).map(|v| v / speed));
        for (t, direction) in direction.iter_mut().enumerate().take(end).skip(start) {
            let (from_start, to_end) = ((t - start + 1) as f64, (end - t) as f64);
            let x = from_start / length;
            let between = if self.turns() {
                before + (after - before) * x
            } else if let Some([rising, falling]) = pushed_back {
                let runs_back = falling * x * x * (1.0 - x) - rising * x * (1.0 - x).powi(2);
                before * (1.0 - gives_way(2.0 * before * runs_back))
            } else {
                before * (1.0 - from_start / dip).max(0.0) + after * (1.0 - to_end / dip).max(0.0)
            };
            *direction = between.clamp(-1.0, 1.0);
        }
    }
}

/// Speed by which what the drive follows runs on while friction goes from one level to the other: the acceleration
/// with which a joint came to rest, times the rest, at the median of the rests in which it turned back. The stiffer
/// the drive, the less.
fn turning_speed(bridges: &[Bridge], acceleration: &[f64], rate_hz: f64) -> Option<f64> {
    let turned = bridges.iter().filter(|b| b.turns());
    let mut speeds: Vec<f64> = turned
        .filter_map(|b| b.rest)
        .map(|(start, end)| acceleration[start - 1].abs() * (end - start) as f64 / rate_hz)
        .collect();
    let half = speeds.len() / 2;
    (!speeds.is_empty()).then(|| *speeds.select_nth_unstable_by(half, f64::total_cmp).1)
}

/// How far friction gives way, 2 where it would reverse, in a rest after which the joint goes on the same way: where all that
/// is known of what its drive follows says so far. Never as far as that, or the joint had turned back.
fn gives_way(far: f64) -> f64 {
    let far = far.max(0.0);
    far / (1.0 + 0.5 * far)
}

/// What the drive follows while its joint rests goes on with the accelerations of before and after: the two
/// coefficients of its speed, a cubic that is zero at both ends.
fn reference_speed((start, end): (usize, usize), acceleration: &[f64], rate_hz: f64) -> [f64; 2] {
    let length_s = (end - start) as f64 / rate_hz;
    let later = end + (LATER_S * rate_hz).round() as usize;
    let [before, after] = [start.saturating_sub(1), later.min(acceleration.len() - 1)];
    [acceleration[before] * length_s, acceleration[after] * length_s]
}

/// Stretches of samples with a speed below a threshold.
pub(super) fn spells(velocity: &[f64], threshold: f64) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for (t, v) in velocity.iter().enumerate() {
        match (v.abs() < threshold || threshold == 0.0, start) {
            (true, None) => start = Some(t),
            (false, Some(from)) => {
                found.push((from, t));
                start = None;
            }
            _ => {}
        }
    }
    found.extend(start.map(|from| (from, velocity.len())));
    found
}
