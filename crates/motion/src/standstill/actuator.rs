//! What a drive does where its joint stops: it does not jump, and goes on from what it needed before to what it needs
//! after.

use super::Standstill;

/// A drive gives up what its joint needed to slow down within this time of a rest \[s\].
const HELD_S: f64 = 0.3;
/// In a rest of less than this \[s\] all that changes is the drive, not what the other joints load on it.
const SHORT_S: f64 = 0.08;
/// While a joint rests, what its drive follows goes on with its acceleration. The drive answers its speed with damping, and
/// its way with stiffness, which is so many times as much \[1/s\]: the natural frequency over twice the damping ratio, here
/// of 4 Hz and 0.6.
const STIFFNESS_PER_DAMPING: f64 = 20.0;

impl Standstill {
    /// The same, but not longer than a drive gives up what its joint needed to slow down.
    fn while_held(&self, rate_hz: f64) -> Self {
        Self { to: self.to.min(self.from + HELD_S * rate_hz), ..*self }
    }

    /// How far a drive has come from what it needed before to what it needs after.
    fn driven_at(&self, sample: usize, rate_hz: f64) -> f64 {
        let x = self.share_at(sample);
        let bend = 0.5 * STIFFNESS_PER_DAMPING * (self.to - self.from) / rate_hz;
        (x + bend * x * x) / (1.0 + bend)
    }

    /// Its samples, if it has some and is a stop.
    fn rest(&self) -> Option<(usize, usize)> {
        let (start, end) = self.samples();
        (self.stops() && start < end).then_some((start, end))
    }
}

/// The acceleration that a drive answers: in a rest it goes from that of before to none.
pub(crate) fn held(acceleration: &[f64], stops: &[Standstill], rate_hz: f64) -> Vec<f64> {
    let mut held = acceleration.to_vec();
    for stop in stops {
        let Some((start, end)) = stop.rest() else { continue };
        let more = acceleration[start - 1] - acceleration[start];
        let gone = stop.while_held(rate_hz);
        held[start - 1] -= more * gone.share_at(start - 1);
        for (t, held) in held.iter_mut().enumerate().take(end).skip(start) {
            *held += more * (1.0 - gone.share_at(t));
        }
    }
    held
}

/// Efforts without a jump where the joint stops.
pub fn continued(effort: &[f64], stops: &[Standstill], rate_hz: f64) -> Vec<f64> {
    let mut all = effort.to_vec();
    for stop in stops {
        let Some((start, end)) = stop.rest() else { continue };
        let rest = all.iter_mut().enumerate().take(end).skip(start);
        let (before, gone) = (effort[start - 1], stop.while_held(rate_hz));
        let Some(after) = effort.get(end).filter(|_| stop.turns()) else {
            // it gives way and comes back
            let more = before - effort[start];
            rest.for_each(|(t, effort)| *effort += more * (1.0 - gone.share_at(t)));
            continue;
        };
        if end - start < 3 || stop.to - stop.from < SHORT_S * rate_hz {
            rest.for_each(|(t, effort)| {
                *effort = before + (after - before) * stop.driven_at(t, rate_hz);
            });
            continue;
        }
        // friction reverses in a line in these efforts: they go on to both ends of the rest
        let slope = (effort[end - 1] - effort[start]) / (end - 1 - start) as f64;
        let first = effort[start] - slope * (start as f64 - stop.from);
        let last = effort[end - 1] + slope * (stop.to - (end - 1) as f64);
        rest.for_each(|(t, effort)| {
            let (over, driven) = (stop.share_at(t), stop.driven_at(t, rate_hz));
            *effort += (before - first) * (1.0 - gone.share_at(t)) + (after - last) * over;
            *effort += (after - before) * (driven - over);
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 400.0;

    /// A drive that reverses its friction in a rest starts with the speed of what it follows and goes on with its way:
    /// slower than a line, the more so the longer it rests; and what it gives does not jump on either side.
    #[test]
    fn a_drive_does_not_jump() {
        for length in [12.0, 80.0] {
            let stop = Standstill { from: 20.25, to: 20.25 + length, directions: [1.0, -1.0] };
            let (start, end) = stop.samples();
            // half of the time gone, a quarter of the way
            let bend = 0.5 * STIFFNESS_PER_DAMPING * length / RATE_HZ;
            let half = stop.driven_at((stop.from + 0.5 * length).round() as usize, RATE_HZ);
            assert!((half - (0.5 + 0.25 * bend) / (1.0 + bend)).abs() < 0.6 / length, "{half}");
            // 5 before, -5 after, and a jump of the acceleration's 2 where it stops
            let line = |t: usize| 5.0 - 10.0 * stop.share_at(t);
            let effort: Vec<f64> =
                (0..200).map(|t| line(t) - if t < start { 2.0 } else { 0.0 }).collect();
            let all = continued(&effort, &[stop], RATE_HZ);
            assert_eq!(all[..start], effort[..start]);
            assert_eq!(all[end..], effort[end..]);
            let steps = all.windows(2).map(|e| (e[1] - e[0]).abs()).fold(0.0, f64::max);
            assert!(steps < 2.1 * 8.0 / length, "{length}: {steps}");
            let jump = (effort[start] - effort[start - 1]).abs();
            assert!(jump > 1.1 && (all[start] - all[start - 1]).abs() < 0.7 * jump, "{length}");
        }
    }

    /// A turn without a rest is no time to change anything.
    #[test]
    fn a_turn_is_left_as_it_is() {
        let effort: Vec<f64> = (0..50).map(f64::from).collect();
        let turn = Standstill { from: 20.5, to: 20.5, directions: [1.0, -1.0] };
        assert_eq!(continued(&effort, &[turn], RATE_HZ), effort);
        assert_eq!(held(&effort, &[turn], RATE_HZ), effort);
    }
}
