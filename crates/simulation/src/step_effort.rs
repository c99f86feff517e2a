//! What drives an arm during one step.

/// Efforts of all joints during one step: the parabola through three values \[N m or N\].
#[derive(Debug, Clone, PartialEq)]
pub struct StepEffort {
    /// At the start of the step.
    pub start: Vec<f64>,
    /// In the middle.
    pub middle: Vec<f64>,
    /// At the end.
    pub end: Vec<f64>,
}

impl StepEffort {
    /// The same effort throughout, as a drive between two control cycles.
    pub fn constant(effort: &[f64]) -> Self {
        Self { start: effort.to_vec(), middle: effort.to_vec(), end: effort.to_vec() }
    }

    /// From one value to another on a line.
    pub fn linear(start: &[f64], end: &[f64]) -> Self {
        let middle = start.iter().zip(end).map(|(s, e)| 0.5 * (s + e)).collect();
        Self { start: start.to_vec(), middle, end: end.to_vec() }
    }

    /// At `share` of the step, from 0 to 1.
    fn at(&self, share: f64) -> Vec<f64> {
        let (s, m, e) = (
            (1.0 - share) * (1.0 - 2.0 * share),
            4.0 * share * (1.0 - share),
            share * (2.0 * share - 1.0),
        );
        (0..self.start.len())
            .map(|j| s * self.start[j] + m * self.middle[j] + e * self.end[j])
            .collect()
    }

    /// The two halves of the step.
    pub(crate) fn halves(&self) -> [Self; 2] {
        [self.part(0.0, 0.5), self.part(0.5, 1.0)]
    }

    /// From one share of the step to another.
    pub(crate) fn part(&self, from: f64, to: f64) -> Self {
        Self { start: self.at(from), middle: self.at(0.5 * (from + to)), end: self.at(to) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_same_efforts() {
        let whole = StepEffort { start: vec![1.0], middle: vec![-2.0], end: vec![0.5] };
        let [first, second] = whole.halves();
        for share in [0.0, 0.3, 0.5, 0.8, 1.0] {
            assert!((first.at(share)[0] - whole.at(0.5 * share)[0]).abs() < 1e-15);
            assert!((second.at(share)[0] - whole.at(0.5 + 0.5 * share)[0]).abs() < 1e-15);
        }
        let line = StepEffort::linear(&[1.0], &[3.0]);
        assert!((line.at(0.3)[0] - 1.6).abs() < 1e-15);
    }
}
