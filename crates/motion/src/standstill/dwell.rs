//! Where a joint stays at one place though its motion around says that it would have left it.

use crate::{QUARTIC_TERMS, Quartics};

use super::Channels;

/// A joint rests while its recorded position stays within this many standard deviations of its noise...
const SAME_PLACE_DEVIATIONS: f64 = 6.0;
/// ... or of this many steps of its encoder...
const SAME_PLACE_STEPS: f64 = 1.5;
/// ... this long \[s\], where at its accelerations so far around \[s\] it would have gone this many times as
/// far...
const REST_S: f64 = 0.008;
const AROUND_S: f64 = 0.05;
const FAR: f64 = 5.0;
/// ... and where no quartic passes through all that is around, up to 1.5 deviations: a motion that comes near zero speed
/// and goes on is smooth.
const SMOOTH_DEVIATIONS: f64 = 1.5;
/// The rest begins and ends where the position is this near to its middle, in standard deviations of its noise.
const AT_REST_DEVIATIONS: f64 = 2.5;

impl Channels<'_> {
    /// Where the joint stays at one place though it would have left it at its accelerations around: among them the
    /// rests of stick and slip, too short to be seen in a filtered velocity. `noise` is that of the position.
    pub(super) fn dwells(&self, acceleration: &[f64], noise: f64) -> Vec<(usize, usize)> {
        // a joint that is mostly at rest has no noise from which its encoder's step could be estimated
        let deviation = noise.max(SAME_PLACE_STEPS / SAME_PLACE_DEVIATIONS * self.step);
        let mut found = dwells(self.position, acceleration, deviation, self.rate_hz);
        for (start, end) in &mut found {
            let mut places = self.position[*start..*end].to_vec();
            let (_, middle, _) = places.select_nth_unstable_by((*end - *start) / 2, f64::total_cmp);
            let at_rest =
                |t: &usize| (self.position[*t] - *middle).abs() <= AT_REST_DEVIATIONS * deviation;
            (*start, *end) = (
                (*start..*end).find(at_rest).unwrap_or(*start),
                (*start..*end).rfind(at_rest).map_or(*end, |last| last + 1),
            );
        }
        found
    }
}

/// Stretches in which a joint stays at one place though at its accelerations around it would have left: the
/// rests of stick and slip, too short to be seen in a filtered velocity.
fn dwells(
    position: &[f64],
    acceleration: &[f64],
    deviation: f64,
    rate_hz: f64,
) -> Vec<(usize, usize)> {
    let resolution = SAME_PLACE_DEVIATIONS * deviation;
    let least = (REST_S * rate_hz).ceil().max(4.0) as usize;
    let around = (AROUND_S * rate_hz).round() as usize;
    let n = position.len();
    let mut found = Vec::new();
    let mut start = 0;
    while start + least <= n {
        let (mut low, mut high) = (position[start], position[start]);
        let mut end = start;
        while end < n {
            low = low.min(position[end]);
            high = high.max(position[end]);
            if high - low > resolution {
                break;
            }
            end += 1;
        }
        if end - start < least {
            start += 1;
            continue;
        }
        let near = &acceleration[start.saturating_sub(around)..(end + around).min(n)];
        let square = near.iter().map(|a| a * a).sum::<f64>() / near.len() as f64;
        // turning back at that acceleration in the middle of the stretch
        let turned = square.sqrt() * ((end - start) as f64 / rate_hz).powi(2) / 8.0;
        let window = &position[start.saturating_sub(around)..(end + around).min(n)];
        if turned > FAR * resolution && !is_smooth(window, SMOOTH_DEVIATIONS * deviation) {
            found.push((start, end));
        }
        start = end;
    }
    found
}

/// Whether the residual of a quartic through the positions is within their noise.
fn is_smooth(position: &[f64], noise: f64) -> bool {
    let n = position.len();
    let Some(quartics) = Quartics::of_length(n, 0.0) else { return true };
    let quartic = quartics.through(position);
    let squares = position.iter().enumerate().map(|(k, q)| (q - quartic(k as f64)).powi(2));
    squares.sum::<f64>() <= (n - QUARTIC_TERMS) as f64 * noise * noise
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Holds of 25 ms between slides of 60 ms are found; the smooth reversals of a sine are not dwells.
    #[test]
    fn holds_between_slides_are_dwells() {
        const RATE_HZ: f64 = 400.0;
        let slides = |t: f64| {
            let (cycle, phase) = ((t / 0.085).floor(), t % 0.085);
            let x = ((phase - 0.025) / 0.06).max(0.0);
            0.02 * (cycle + x * x * (3.0 - 2.0 * x))
        };
        let twice = |values: &[f64]| -> Vec<f64> {
            let second = |w: &[f64]| (w[2] - 2.0 * w[1] + w[0]) * RATE_HZ * RATE_HZ;
            let inner = values.windows(3).map(second);
            std::iter::once(0.0).chain(inner).chain([0.0]).collect()
        };
        let sampled = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (0..800).map(|k| of(f64::from(k) / RATE_HZ)).collect()
        };
        let position = sampled(&slides);
        let found = dwells(&position, &twice(&position), 2e-5 / SAME_PLACE_DEVIATIONS, RATE_HZ);
        // 2 s hold 23 of them; the first samples of a slide are still at the place
        assert!((20..=24).contains(&found.len()), "{found:?}");
        assert!(found.iter().all(|(start, end)| (8..=14).contains(&(end - start))), "{found:?}");
        let sine = sampled(&|t: f64| (3.0 * t).sin());
        assert_eq!(dwells(&sine, &twice(&sine), 2e-5 / SAME_PLACE_DEVIATIONS, RATE_HZ), []);
        // nor is a speed that touches zero and goes on
        let through = sampled(&|t: f64| 0.4 * (t - 1.0).powi(3) + 0.02 * (t - 1.0).powi(4));
        assert_eq!(dwells(&through, &twice(&through), 1e-5, RATE_HZ), []);
        // a joint at rest is none of stick and slip either
        assert_eq!(dwells(&[0.5; 800], &[0.0; 800], 2e-5 / SAME_PLACE_DEVIATIONS, RATE_HZ), []);
    }
}
