//! Moves of one joint from rest to rest, with a plateau of constant speed where there is room.
//!
//! The speed rises over a time `r` as `v (x - sin(2πx) / 2π)`, `x = t / r`: the acceleration is zero at both ends and
//! `2 v / r` at most, the jerk `2π v / r²`.

use std::f64::consts::TAU;

use crate::limits::MotionLimits;

/// A move from one position to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sweep {
    from: f64,
    to: f64,
    /// largest speed \[rad/s or m/s\]
    speed: f64,
    rise_s: f64,
}

/// Bisections of the speed of a short move.
const BISECTIONS: usize = 60;

impl Sweep {
    /// A move at most as fast as `speed`, inside the limits of speed, acceleration and jerk.
    pub(crate) fn new(from: f64, to: f64, speed: f64, limits: &MotionLimits) -> Self {
        let rise = |v: f64| (2.0 * v / limits.acceleration).max((TAU * v / limits.jerk).sqrt());
        let distance = (to - from).abs();
        let most = speed.min(limits.velocity);
        let mut speed = most;
        if speed * rise(speed) > distance {
            let (mut low, mut high) = (0.0, most);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if middle * rise(middle) > distance {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            speed = low;
        }
        Self { from, to, speed, rise_s: rise(speed) }
    }

    /// How long it takes \[s\].
    pub(crate) fn duration_s(&self) -> f64 {
        match self.speed > 0.0 {
            true => self.rise_s + (self.to - self.from).abs() / self.speed,
            false => 0.0,
        }
    }

    /// Position, velocity and acceleration at a time; at rest before the start and after the end.
    pub(crate) fn at(&self, time_s: f64) -> [f64; 3] {
        let duration_s = self.duration_s();
        if time_s <= 0.0 || self.speed <= 0.0 {
            return [self.from, 0.0, 0.0];
        }
        if time_s >= duration_s {
            return [self.to, 0.0, 0.0];
        }
        // the fall of the speed mirrors its rise
        if time_s > 0.5 * duration_s {
            let [q, v, a] = self.rising(duration_s - time_s);
            let sign = (self.to - self.from).signum();
            return [self.to - sign * q, sign * v, -sign * a];
        }
        let [q, v, a] = self.rising(time_s);
        let sign = (self.to - self.from).signum();
        [self.from + sign * q, sign * v, sign * a]
    }

    /// Distance, speed and acceleration in the first half.
    fn rising(&self, time_s: f64) -> [f64; 3] {
        let (v, r) = (self.speed, self.rise_s);
        if time_s >= r {
            return [v * (time_s - 0.5 * r), v, 0.0];
        }
        let x = time_s / r;
        let (sin, cos) = (TAU * x).sin_cos();
        [
            v * r * (0.5 * x * x + (cos - 1.0) / (TAU * TAU)),
            v * (x - sin / TAU),
            v / r * (1.0 - cos),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: MotionLimits = MotionLimits {
        lower: -2.0,
        upper: 2.0,
        velocity: 1.5,
        acceleration: 4.0,
        jerk: 60.0,
        effort: None,
        noise: None,
    };

    #[test]
    fn moves_arrive_inside_the_limits() {
        for (from, to, speed) in [(-1.0, 1.5, 9.0), (0.5, 0.4, 9.0), (0.0, 1.0, 0.1)] {
            let sweep = Sweep::new(from, to, speed, &LIMITS);
            let (steps, duration_s) = (20_000, sweep.duration_s());
            let h = duration_s / f64::from(steps);
            let mut before = sweep.at(0.0);
            for k in 1..=steps {
                let now = sweep.at(f64::from(k) * h);
                assert!(now[1].abs() <= LIMITS.velocity.min(speed) + 1e-9);
                assert!(now[2].abs() <= LIMITS.acceleration + 1e-9);
                assert!((now[2] - before[2]).abs() / h <= LIMITS.jerk * (1.0 + 1e-6));
                for k in 0..2 {
                    let mean = 0.5 * (now[k + 1] + before[k + 1]);
                    assert!(((now[k] - before[k]) / h - mean).abs() < 1e-4, "{now:?} {before:?}");
                }
                before = now;
            }
            assert!((before[0] - to).abs() < 1e-9 && before[1].abs() < 1e-9);
        }
    }

    #[test]
    fn no_way_takes_no_time() {
        let sweep = Sweep::new(0.3, 0.3, 1.0, &LIMITS);
        assert!(sweep.duration_s() < 1e-6);
        assert!((sweep.at(1.0)[0] - 0.3).abs() < 1e-12);
    }
}
