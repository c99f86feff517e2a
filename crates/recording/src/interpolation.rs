//! Local cubic interpolation between sample times.

/// Gaps up to this many median steps are interpolated by the cubic through the two samples on
/// either side, longer ones linearly.
pub const BRIDGED_STEPS: f64 = 10.0;

/// Local cubic interpolation from one set of times to another: the polynomial of third degree
/// through the four nearest samples, two on either side; at the ends through the last four.
/// It reproduces cubics exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolation {
    /// Index of the first sample used and the weights of the samples from there on.
    taps: Vec<(usize, [f64; 4])>,
}

impl Interpolation {
    /// From samples at `from_s` to values at `to_s`, both increasing \[s\]. Between two samples
    /// more than `longest_step_s` apart interpolation is linear, and no cubic reaches across.
    /// Before the first and after the last sample their values are held.
    pub fn new(from_s: &[f64], to_s: &[f64], longest_step_s: f64) -> Self {
        let n = from_s.len();
        if n == 0 {
            return Self { taps: Vec::new() };
        }
        let mut interval = 0;
        // the segment without long steps around the interval: samples start..=end
        let (mut start, mut end) = segment(from_s, 0, longest_step_s);
        let taps = to_s.iter().map(|&t| {
            while interval + 2 < n && from_s[interval + 1] <= t {
                interval += 1;
                if interval > end {
                    (start, end) = segment(from_s, interval, longest_step_s);
                }
            }
            let t = t.clamp(from_s[0], from_s[n - 1]);
            let (first, last) = if interval == end && interval + 1 < n {
                (interval, interval + 1)
            } else {
                let first = interval
                    .saturating_sub(1)
                    .max(start)
                    .min((end + 1).saturating_sub(4).max(start));
                (first, (first + 3).min(end))
            };
            // all four indices must exist; unused ones have weight 0
            let base = first.min(n.saturating_sub(4));
            let mut weights = [0.0; 4];
            for i in first..=last {
                weights[i - base] = (first..=last)
                    .filter(|j| *j != i)
                    .map(|j| (t - from_s[j]) / (from_s[i] - from_s[j]))
                    .product();
            }
            (base, weights)
        });
        Self { taps: taps.collect() }
    }

    /// Values at the new times, from `values` at the sample times.
    pub fn apply(&self, values: &[f64]) -> Vec<f64> {
        let one = |(first, weights): &(usize, [f64; 4])| {
            values.iter().skip(*first).zip(weights).map(|(value, weight)| value * weight).sum()
        };
        self.taps.iter().map(one).collect()
    }
}

/// The segment from `index` to the next long step: its first and last sample.
fn segment(from_s: &[f64], index: usize, longest_step_s: f64) -> (usize, usize) {
    let steps = from_s[index..].windows(2);
    let length = steps.take_while(|pair| pair[1] - pair[0] <= longest_step_s).count();
    (index, index + length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_segments_between_gaps_are_linear() {
        let from_s = [0.0, 1.0, 2.0, 50.0, 51.0, 90.0, 130.0, 131.0, 132.0, 133.0];
        let to_s: Vec<f64> = (-5..140).map(f64::from).collect();
        let values: Vec<f64> = from_s.iter().map(|t| 2.0 * t - 1.0).collect();
        for (got, t) in Interpolation::new(&from_s, &to_s, 5.0).apply(&values).iter().zip(&to_s) {
            assert!((got - (2.0 * t.clamp(0.0, 133.0) - 1.0)).abs() < 1e-9, "{t}: {got}");
        }
    }

    #[test]
    fn few_samples_are_held_or_linear() {
        assert!(Interpolation::new(&[], &[1.0], 1.0).apply(&[]).is_empty());
        assert_eq!(Interpolation::new(&[0.0], &[-1.0, 0.0, 2.0], 1.0).apply(&[7.0]), [7.0; 3]);
        let line = Interpolation::new(&[0.0, 2.0], &[0.5, 1.0], 9.0).apply(&[1.0, 3.0]);
        assert_eq!(line, [1.5, 2.0]);
    }
}
