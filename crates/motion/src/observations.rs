//! Samples as observations of the effort: one each in motion, one for a whole rest.

use std::ops::Range;

/// Samples of one joint, a rest being one observation: a joint that rests answers with any effort between the breakaway
/// levels, one unknown value however many samples record it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Observations {
    /// samples in motion, and those of a rest
    spans: Vec<(Range<usize>, bool)>,
}

impl Observations {
    /// The samples `of`, in which these dwells lie.
    pub(crate) fn new(dwells: &[Range<usize>], of: Range<usize>) -> Self {
        let mut spans = Vec::new();
        let mut at = of.start;
        for rest in dwells {
            let rest = rest.start.max(of.start)..rest.end.min(of.end);
            if rest.is_empty() {
                continue;
            }
            if at < rest.start {
                spans.push((at..rest.start, false));
            }
            at = rest.end;
            spans.push((rest, true));
        }
        if at < of.end {
            spans.push((at..of.end, false));
        }
        Self { spans }
    }

    /// The same for columns that begin at this sample.
    #[must_use]
    pub fn beginning_at(mut self, first: usize) -> Self {
        for (span, _) in &mut self.spans {
            *span = span.start - first..span.end - first;
        }
        self
    }

    /// Number of observations.
    pub fn len(&self) -> usize {
        self.spans.iter().map(|(span, is_dwell)| if *is_dwell { 1 } else { span.len() }).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// The samples, where none of them is of a rest.
    pub fn without_rest(&self) -> Option<Range<usize>> {
        match self.spans.as_slice() {
            [] => Some(0..0),
            [(span, false)] => Some(span.clone()),
            _ => None,
        }
    }

    /// A column given at every sample, at the observations: its mean over each rest.
    pub fn of(&self, column: &[f64]) -> Vec<f64> {
        let mut observed = Vec::with_capacity(self.len());
        for (span, is_dwell) in &self.spans {
            let samples = &column[span.clone()];
            match is_dwell {
                true => observed.push(samples.iter().sum::<f64>() / samples.len() as f64),
                false => observed.extend_from_slice(samples),
            }
        }
        observed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rest_is_one_observation() {
        let column: Vec<f64> = (0..10).map(f64::from).collect();
        let all = Observations::new(&[0..2, 5..8], 1..9);
        assert_eq!(all.of(&column), [1.0, 2.0, 3.0, 4.0, 6.0, 8.0]);
        assert_eq!((all.len(), all.without_rest()), (6, None));
        let moving = Observations::new(&[0..2, 5..8], 2..5);
        assert_eq!(moving.without_rest(), Some(2..5));
    }
}
