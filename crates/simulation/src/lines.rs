//! Samples with lines between them.

/// The value at a time; before the first and after the last sample these go on.
pub(crate) fn at(time_s: &[f64], values: &[f64], t: f64) -> f64 {
    let last = time_s.len() - 1;
    let after = time_s.partition_point(|stamp| *stamp <= t).clamp(1, last);
    between(time_s, values, after, t)
}

/// Samples with lines between them, at times that never fall.
pub(crate) struct Forward<'a> {
    time_s: &'a [f64],
    values: &'a [f64],
    after: usize,
}

impl<'a> Forward<'a> {
    pub(crate) fn new(time_s: &'a [f64], values: &'a [f64]) -> Self {
        Self { time_s, values, after: 1 }
    }

    /// As [`at`], of a time that is no earlier than the one before.
    pub(crate) fn at(&mut self, t: f64) -> f64 {
        let last = self.time_s.len() - 1;
        while self.after < last && self.time_s[self.after] <= t {
            self.after += 1;
        }
        between(self.time_s, self.values, self.after, t)
    }
}

fn between(time_s: &[f64], values: &[f64], after: usize, t: f64) -> f64 {
    let (from, to) = (time_s[after - 1], time_s[after]);
    let share = ((t - from) / (to - from)).clamp(0.0, 1.0);
    values[after - 1] + share * (values[after] - values[after - 1])
}

#[cfg(test)]
mod tests {
    use super::{Forward, at};

    #[test]
    fn forward_reads_what_a_search_finds() {
        let (time_s, values) = ([0.0, 0.1, 0.3, 0.4], [1.0, 2.0, 0.0, 5.0]);
        let mut forward = Forward::new(&time_s, &values);
        for k in 0..60 {
            let t = -0.1 + 0.01 * f64::from(k);
            assert_eq!(forward.at(t), at(&time_s, &values, t), "{t}");
        }
    }
}
