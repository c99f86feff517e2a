//! Motions up to the ends of their recording: a low-pass and derivatives need what comes before and after.

use armident_numeric::Cholesky;
use rayon::prelude::*;

use crate::butterworth::ZeroPhaseLowPass;
use crate::differentiate::differentiate;

/// Continuation at each end, in periods of the cut-off: beyond it the low-pass remembers nothing.
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

/// How a motion goes on past the ends of its recording: along a quartic through what is recorded there, so that a
/// recording that is cut out of a motion has its speed and acceleration up to the cut; held where the last tenth of
/// these samples does not move at all.
///
/// Continued by odd extension, as SciPy does, a motion turns its acceleration over at each end, and the few
/// samples of that are fewer than a low-pass remembers: at the ends of pieces cut out of recordings of five real
/// arms, accelerations were off by twice their root mean square, along a quartic by a tenth of it. Efforts jump and have no
/// polynomial: this is for positions and speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Continuation {
    /// the square of the last error counts this many times e more than that of the first
    e_folds: f64,
}

impl Continuation {
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
        let derivative = |values: &[f64]| -> Vec<f64> {
            let smooth = low_pass.filter(values);
            (0..order).fold(smooth, |values, _| differentiate(&values, rate_hz))
        };
        let cuts = (TRIED_SAMPLES / (before + after)).max(FEWEST_CUTS).min(room);
        let mut squares = [0.0; E_FOLDS.len()];
        for cut in 0..cuts {
            let start = cut * room / cuts;
            let mut piece = values[start..start + before + after].to_vec();
            // every other one is the start of a motion
            if cut % 2 == 1 {
                piece.reverse();
            }
            let whole = derivative(&piece);
            for (square, e_folds) in squares.iter_mut().zip(E_FOLDS) {
                let after = Self { e_folds }.next(&piece[..before], after, low_pass);
                let cut = derivative(&[&piece[..before], &after].concat());
                let off = cut.iter().zip(&whole).take(before).skip(before - counted);
                *square += off.map(|(cut, whole)| (cut - whole).powi(2)).sum::<f64>();
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
        let before = self.next(&reversed, margin, low_pass);
        let after = self.next(values, margin, low_pass);
        let all = before.iter().rev().chain(values).chain(&after).copied().collect();
        (all, margin)
    }

    /// The next values of a series.
    fn next(self, values: &[f64], count: usize, low_pass: &ZeroPhaseLowPass) -> Vec<f64> {
        let fitted = (FITTED_PERIODS * low_pass.rate_hz() / low_pass.cutoff_hz()).round() as usize;
        let values = &values[values.len().saturating_sub(fitted.max(FEWEST))..];
        let n = values.len();
        let last = values[n - 1];
        if n < 2 * QUARTIC_TERMS || values[n - (n / 10).max(3)..].iter().all(|x| *x == last) {
            return vec![last; count];
        }
        match quartic_through(values, self.e_folds) {
            Some(quartic) => (n..n + count).map(|k| quartic(k as f64)).collect(),
            None => vec![last; count],
        }
    }
}

/// The least-squares quartic of the index; the square of the last error counts `e_folds` times e more than that of
/// the first. None through five values or fewer.
pub fn quartic_through(values: &[f64], e_folds: f64) -> Option<impl Fn(f64) -> f64> {
    let n = values.len();
    if n <= QUARTIC_TERMS {
        return None;
    }
    // index from the last value, in lengths of the series
    let powers = move |k: f64| -> [f64; QUARTIC_TERMS] {
        let x = (k - (n - 1) as f64) / n as f64;
        std::array::from_fn(|p| x.powi(p as i32))
    };
    let rows: Vec<[f64; QUARTIC_TERMS]> = (0..n).map(|k| powers(k as f64)).collect();
    let weights: Vec<f64> = rows.iter().map(|row| (e_folds * row[1]).exp()).collect();
    let weighted = || rows.iter().zip(&weights);
    let product = |a: usize, b: usize| weighted().map(|(row, w)| w * row[a] * row[b]).sum::<f64>();
    let rhs: Vec<f64> = (0..QUARTIC_TERMS)
        .map(|a| weighted().zip(values).map(|((row, w), x)| w * row[a] * x).sum())
        .collect();
    let c = Cholesky::of(QUARTIC_TERMS, product)?.solve(&rhs);
    Some(move |k: f64| c.iter().zip(powers(k)).map(|(c, p)| c * p).sum())
}

impl ZeroPhaseLowPass {
    /// Positions or speeds through the low-pass, and the first derivatives of that, each [continued](Continuation) past
    /// its ends before: `[signal][order][sample]`.
    pub fn with_derivatives<const ORDERS: usize>(
        &self,
        signals: &[Vec<f64>],
    ) -> Vec<[Vec<f64>; ORDERS]> {
        let longer = |values: &Vec<f64>| {
            Continuation::of(values, ORDERS.saturating_sub(1), self).past_ends(values, self).0
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
        let continuation = Continuation { e_folds: USUAL };
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
