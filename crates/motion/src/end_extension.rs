//! Motions up to the ends of their recording: a low-pass and derivatives need what comes before and after.

use armident_numeric::Cholesky;
use rayon::prelude::*;

use crate::differentiate::differentiate;
use crate::low_pass::ZeroPhaseLowPass;

/// EndExtension at each end, in periods of the cut-off: beyond it the low-pass remembers nothing.
const MARGIN_PERIODS: f64 = 3.0;
/// What is continued follows a quartic through so many periods of the cut-off...
const FITTED_PERIODS: f64 = 6.25;
/// ... or so many samples.
const FEWEST: usize = 20;
/// Coefficients of a quartic.
pub const QUARTIC_TERMS: usize = 5;
/// How many times e more an error at the end may count than one at the start.
const E_FOLDS: [f64; 6] = [0.0, 3.0, 6.0, 12.0, 24.0, 48.0];
/// The same where a signal is too short to try.
const USUAL: f64 = 6.0;
/// Places at which a signal is cut to see which of them is right: as many as so many samples allow, so that what is
/// seldom (a sample that came late) is met, but not fewer than this.
const TRIED_SAMPLES: usize = 60_000;
const FEWEST_CUTS: usize = 16;
/// What is looked at before such a cut, after it, and where errors count, in periods of the cut-off.
const BEFORE_PERIODS: f64 = 8.0;
const AFTER_PERIODS: f64 = 4.0;
const COUNTED_PERIODS: f64 = 1.0;
/// Samples on one side that a derivative is formed of, at most.
const REACH: usize = 4;

/// How a motion goes on past the ends of its recording: along a quartic through what is recorded there, so that a
/// recording that is cut out of a motion has its speed and acceleration up to the cut; held where the last tenth of
/// these samples does not move at all.
///
/// Continued by odd extension, as SciPy does, a motion turns its acceleration over at each end, and the few
/// samples of that are fewer than a low-pass remembers: at the ends of pieces cut out of recordings of five real
/// arms, accelerations were off by twice their root mean square, along a quartic by a tenth of it. Efforts jump and have no
/// polynomial: this is for positions and speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndExtension {
    /// the square of the last error counts this many times e more than that of the first
    e_folds: f64,
}

impl EndExtension {
    /// The one that suits a signal: cut at some places, its smoothed derivative of this order is nearest to what it is
    /// without the cut. A clean motion is followed by its last samples, a noisy one by more of them.
    pub fn of(values: &[f64], order: usize, low_pass: &ZeroPhaseLowPass) -> Self {
        let rate_hz = low_pass.rate_hz();
        let samples = |periods: f64| (periods * rate_hz / low_pass.cutoff_hz()).round() as usize;
        let before = samples(BEFORE_PERIODS).max(FEWEST);
        let (after, counted) = (samples(AFTER_PERIODS), samples(COUNTED_PERIODS).max(1));
        let room = values.len().saturating_sub(before + after);
        if room == 0 {
            return Self { e_folds: USUAL };
        }
        let ahead = E_FOLDS.map(|e_folds| Ahead::of(Self { e_folds }, before, low_pass));
        // all of it is linear: off is what the difference after the cut makes of nothing before it, of which as much
        // counts as formulas reach
        let first = before.saturating_sub(counted + low_pass.default_pad() + REACH * order);
        let cuts = (TRIED_SAMPLES / (before + after)).max(FEWEST_CUTS).min(room);
        let mut squares = [0.0; E_FOLDS.len()];
        for cut in 0..cuts {
            let start = cut * room / cuts;
            let mut piece = values[start..start + before + after].to_vec();
            // every other one is the start of a motion
            if cut % 2 == 1 {
                piece.reverse();
            }
            let (before_cut, after_cut) = piece.split_at(before);
            let mut off = ahead.each_ref().map(|ahead| {
                let next = ahead.next(before_cut, after);
                let off = next.iter().zip(after_cut).map(|(next, x)| next - x);
                std::iter::repeat_n(0.0, before - first).chain(off).collect::<Vec<f64>>()
            });
            low_pass.filter_together(off.each_mut().map(|off| &mut off[..]));
            for (square, off) in squares.iter_mut().zip(off) {
                let off = (0..order).fold(off, |values, _| differentiate(&values, rate_hz));
                let counted = &off[before - counted - first..before - first];
                *square += counted.iter().map(|x| x * x).sum::<f64>();
            }
        }
        let least = (0..E_FOLDS.len()).min_by(|a, b| squares[*a].total_cmp(&squares[*b]));
        Self { e_folds: least.map_or(USUAL, |k| E_FOLDS[k]) }
    }

    /// The signal continued for a low-pass, and the number of samples added at each end.
    pub fn past_ends(self, values: &[f64], low_pass: &ZeroPhaseLowPass) -> (Vec<f64>, usize) {
        if values.is_empty() {
            return (Vec::new(), 0);
        }
        let margin = (MARGIN_PERIODS * low_pass.rate_hz() / low_pass.cutoff_hz()).round() as usize;
        // over more than that a polynomial goes astray
        let margin = margin.min(2 * values.len() / 3);
        let reversed: Vec<f64> = values.iter().rev().copied().collect();
        let ahead = Ahead::of(self, values.len(), low_pass);
        let before = ahead.next(&reversed, margin);
        let after = ahead.next(values, margin);
        let all = before.iter().rev().chain(values).chain(&after).copied().collect();
        (all, margin)
    }
}

/// What continues series of one length.
struct Ahead {
    /// how many of the last values are looked at
    fitted: usize,
    quartics: Option<Quartics>,
}

impl Ahead {
    /// For series of so many values.
    fn of(continuation: EndExtension, count: usize, low_pass: &ZeroPhaseLowPass) -> Self {
        let periods = FITTED_PERIODS * low_pass.rate_hz() / low_pass.cutoff_hz();
        let fitted = (periods.round() as usize).max(FEWEST).min(count);
        let enough = fitted >= 2 * QUARTIC_TERMS;
        let quartics = enough.then(|| Quartics::of_length(fitted, continuation.e_folds)).flatten();
        Self { fitted, quartics }
    }

    /// The next values of a series.
    fn next(&self, values: &[f64], count: usize) -> Vec<f64> {
        let values = &values[values.len() - self.fitted..];
        let n = values.len();
        let last = values[n - 1];
        match &self.quartics {
            Some(quartics) if values[n - (n / 10).max(3)..].iter().any(|x| *x != last) => {
                let quartic = quartics.through(values);
                (n..n + count).map(|k| quartic(k as f64)).collect()
            }
            _ => vec![last; count],
        }
    }
}

/// Least-squares quartics of the index through series of one length.
#[derive(Debug, Clone)]
pub struct Quartics {
    length: usize,
    /// powers of the index, each row times its weight
    weighted: Vec<[f64; QUARTIC_TERMS]>,
    cholesky: Cholesky,
}

impl Quartics {
    /// The square of the last error counts `e_folds` times e more than that of the first. None for five values or
    /// fewer.
    pub fn of_length(length: usize, e_folds: f64) -> Option<Self> {
        if length <= QUARTIC_TERMS {
            return None;
        }
        let rows: Vec<_> = (0..length).map(|k| powers(k as f64, length)).collect();
        let weighted: Vec<_> =
            rows.iter().map(|row| row.map(|x| (e_folds * row[1]).exp() * x)).collect();
        let product =
            |a: usize, b: usize| weighted.iter().zip(&rows).map(|(w, row)| w[a] * row[b]).sum();
        let cholesky = Cholesky::of(QUARTIC_TERMS, product)?;
        Some(Self { length, weighted, cholesky })
    }

    /// The quartic through values, as many as the length.
    pub fn through(&self, values: &[f64]) -> impl Fn(f64) -> f64 + use<> {
        let mut rhs = [0.0; QUARTIC_TERMS];
        for (row, x) in self.weighted.iter().zip(values) {
            for (sum, w) in rhs.iter_mut().zip(row) {
                *sum += w * x;
            }
        }
        let (c, length) = (self.cholesky.solve(&rhs), self.length);
        move |k: f64| c.iter().zip(powers(k, length)).map(|(c, p)| c * p).sum()
    }
}

/// Powers of an index, counted from the last value in lengths of the series.
fn powers(k: f64, length: usize) -> [f64; QUARTIC_TERMS] {
    let x = (k - (length - 1) as f64) / length as f64;
    let square = x * x;
    [1.0, x, square, x * square, square * square]
}

impl ZeroPhaseLowPass {
    /// Positions or speeds through the low-pass, and the first derivatives of that, each [continued](EndExtension) past
    /// its ends before: `[signal][order][sample]`.
    pub fn with_derivatives<const ORDERS: usize>(
        &self,
        signals: &[Vec<f64>],
    ) -> Vec<[Vec<f64>; ORDERS]> {
        let longer = |values: &Vec<f64>| {
            EndExtension::of(values, ORDERS.saturating_sub(1), self).past_ends(values, self).0
        };
        let mut longer: Vec<Vec<f64>> = signals.par_iter().map(longer).collect();
        self.filter_columns_in_parallel(&mut longer);
        let derived = |(signal, longer): (&Vec<f64>, Vec<f64>)| {
            let margin = (longer.len() - signal.len()) / 2;
            let mut value = longer;
            std::array::from_fn(|order| {
                if order > 0 {
                    value = differentiate(&value, self.rate_hz());
                }
                value[margin..margin + signal.len()].to_vec()
            })
        };
        signals.par_iter().zip(longer).map(derived).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 200.0;

    fn swing(t: f64) -> [f64; 3] {
        let (a, b) = (3.0, 7.0);
        [
            (a * t).sin() + 0.2 * (b * t).cos(),
            a * (a * t).cos() - 0.2 * b * (b * t).sin(),
            -a * a * (a * t).sin() - 0.2 * b * b * (b * t).cos(),
        ]
    }

    /// Cut anywhere, a motion in the middle of the band has its derivatives up to the cut.
    #[test]
    fn derivatives_hold_up_to_the_ends() {
        let low_pass = ZeroPhaseLowPass::new(4, 6.0, RATE_HZ).unwrap();
        for cut in 0..20 {
            let time = |k: usize| f64::from(cut) * 0.17 + k as f64 / RATE_HZ;
            let position: Vec<f64> = (0..800).map(|k| swing(time(k))[0]).collect();
            let [smooth] = &low_pass.with_derivatives::<3>(&[position])[..] else { panic!() };
            for (order, smooth) in smooth.iter().enumerate() {
                assert_eq!(smooth.len(), 800);
                let squares = |off: &dyn Fn(usize) -> f64, samples: &[usize]| {
                    samples.iter().map(|k| off(*k).powi(2)).sum::<f64>() / samples.len() as f64
                };
                let all: Vec<usize> = (0..800).collect();
                // a period of the cut-off at each end
                let ends = [&all[..33], &all[767..]].concat();
                let off = squares(&|k| smooth[k] - swing(time(k))[order], &ends).sqrt();
                let size = squares(&|k| swing(time(k))[order], &all).sqrt();
                assert!(off < 0.1 * size, "cut {cut}, order {order}: {off} of {size}");
            }
        }
    }

    /// What stands at an end goes on standing, and a line is a line.
    #[test]
    fn rest_and_lines_go_on() {
        let standing = [vec![1.0; 30], vec![2.0; 60]].concat();
        let low_pass = ZeroPhaseLowPass::new(4, 10.0, RATE_HZ).unwrap();
        let continuation = EndExtension { e_folds: USUAL };
        let (all, front) = continuation.past_ends(&standing, &low_pass);
        assert_eq!((front, all.len()), (60, 210));
        assert!(all[150..].iter().all(|x| *x == 2.0));
        let line: Vec<f64> = (0..100).map(|k| 0.5 * f64::from(k) - 3.0).collect();
        let (all, front) = continuation.past_ends(&line, &low_pass);
        for (k, x) in all.iter().enumerate() {
            let expected = 0.5 * (k as f64 - front as f64) - 3.0;
            assert!((x - expected).abs() < 1e-6, "{x} {expected}");
        }
    }

    #[test]
    fn short_signals() {
        let low_pass = ZeroPhaseLowPass::new(4, 6.0, RATE_HZ).unwrap();
        for n in 0..12 {
            let [smooth] = &low_pass.with_derivatives::<3>(&[vec![1.5; n]])[..] else { panic!() };
            assert!(smooth.iter().all(|x| x.len() == n));
            assert!(smooth[0].iter().all(|x| (x - 1.5).abs() < 1e-9));
            assert!(smooth[2].iter().all(|x| x.abs() < 1e-6));
        }
    }
}
