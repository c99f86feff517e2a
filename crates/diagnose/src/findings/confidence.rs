//! Confidence of a name.
//!
//! ```text
//! c = L(3 (r - 1)) · 1 / (1 + Σ exp(-Δ / 2)) · h,   r = (m^-2 + s^-2)^(-1/2),   L(x) = 1 / (1 + exp(-x))
//! ```
//!
//! `m` is the materiality over its threshold, which holds the error of the model, `s` the size over two honest standard errors:
//! the two errors add as independent ones do. Where one is small a name has 0.50 at the threshold of the other and 0.95 at
//! twice that. `Δ` is by how much worse each rival scores, twice a log odds: what two laws explain equally well has either with
//! the same probability. `h` is one half where the hold-out contradicts the finding; where it is predicted equally well
//! without it, the odds of the name are halved instead. The threshold of `m` is the residual of the model on the joint. Of a
//! change it is a share of the residual of the model in the reference too, which repeats; what came since, on motion that the
//! reference did not show, counts in full. Nor is a change more material than it is where no joint moves faster than in the
//! reference: beyond that, what was there before is not known.
//!
//! References: own.

use crate::selection::materiality::{LEAST_CHANGE, Materiality, SHARE_FOR_CHANGE, SHARE_OF_EXCESS};

/// Steepness: twice the threshold is 0.95.
const STEEPNESS: f64 = 3.0;
/// Factor of a finding without which the hold-out is predicted better.
pub(crate) const NOT_CONFIRMED: f64 = 0.5;

/// The confidence with its odds multiplied by a factor.
pub(crate) fn with_odds(confidence: f64, factor: f64) -> f64 {
    factor * confidence / (1.0 - confidence + factor * confidence)
}

/// The confidence where something beyond the laws explains the same and scores worse by this much: no surer than the name is against
/// that alone.
pub(crate) fn beside_other(confidence: f64, behind: f64) -> f64 {
    confidence.min(1.0 / (1.0 + odds_of_rival(behind)))
}

/// Odds of a rival that scores worse by this much, twice a log odds; no rival is more likely than the name by its score alone.
fn odds_of_rival(behind: f64) -> f64 {
    (-0.5 * behind.max(0.0)).exp()
}

/// What a confidence is formed of.
pub(crate) struct Evidence<'a> {
    pub(crate) materiality: &'a Materiality,
    /// over two standard errors, if it is known
    pub(crate) size: Option<f64>,
    /// residual beyond the noise, in noise levels, on the joint of the materiality: before a change, and after it; none
    /// without a reference
    pub(crate) left: Option<[f64; 2]>,
    /// by how much worse rivals score
    pub(crate) behind: Vec<f64>,
}

impl Evidence<'_> {
    /// The confidence, the hold-out aside.
    pub(crate) fn confidence(&self) -> f64 {
        let materiality = match self.left {
            None => self.materiality.ratio(),
            Some([before, after]) => {
                let repeated = SHARE_FOR_CHANGE * after.min(before);
                let new = SHARE_OF_EXCESS * (after * after - before * before).max(0.0).sqrt();
                let least = LEAST_CHANGE.max(repeated.hypot(new)).max(self.materiality.least);
                self.materiality.value / least
            }
        };
        let of_size = self.size.map_or(0.0, |size| size.powi(-2));
        let both = (materiality.powi(-2) + of_size).powf(-0.5);
        let alone = 1.0 / (1.0 + (-STEEPNESS * (both - 1.0)).exp());
        let rivals: f64 = self.behind.iter().map(|behind| odds_of_rival(*behind)).sum();
        alone / (1.0 + rivals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn confidence(ratio: f64, size: f64, left: Option<[f64; 2]>, behind: &[f64]) -> f64 {
        let materiality = Materiality { value: ratio, least: 1.0, joint: 0 };
        let behind = behind.to_vec();
        Evidence { materiality: &materiality, size: Some(size), left, behind }.confidence()
    }

    #[test]
    fn either_threshold_alone_gives_one_half() {
        assert!((confidence(1.0, 99.0, None, &[]) - 0.5).abs() < 1e-3);
        assert!((confidence(99.0, 1.0, None, &[]) - 0.5).abs() < 1e-3);
        assert!(confidence(1.0, 1.0, None, &[]) < 0.3);
        assert!(confidence(2.0, 20.0, None, &[]) > 0.94);
    }

    #[test]
    fn halved_odds_matter_where_a_name_is_doubtful() {
        assert!((with_odds(0.5, NOT_CONFIRMED) - 1.0 / 3.0).abs() < 1e-12);
        assert!(with_odds(0.99, NOT_CONFIRMED) > 0.98);
        assert_eq!([with_odds(0.0, NOT_CONFIRMED), with_odds(1.0, NOT_CONFIRMED)], [0.0, 1.0]);
    }

    #[test]
    fn name_is_no_surer_than_against_what_is_beyond_laws() {
        assert_eq!(beside_other(1.0 - 1e-9, 0.0), 0.5);
        assert_eq!(beside_other(0.3, 0.0), 0.3);
        assert_eq!(beside_other(0.9, -7.0), 0.5);
        assert!((beside_other(1.0, 2.0 * 3.0_f64.ln()) - 0.75).abs() < 1e-12);
    }

    #[test]
    fn rivals_and_new_discrepancy_lower_confidence() {
        // an equal rival halves it, one of odds of 20 to 1 hardly lowers it
        let alone = confidence(4.0, 4.0, None, &[]);
        assert!((confidence(4.0, 4.0, None, &[0.0]) / alone - 0.5).abs() < 1e-12);
        assert!(confidence(4.0, 4.0, None, &[6.0]) > 0.94 * alone);
        // discrepancy of the reference repeats; twice as much after it does not
        assert!(confidence(3.0, 9.0, Some([3.0, 3.0]), &[]) > 0.95);
        assert!(confidence(3.0, 9.0, Some([1.0, 4.0]), &[]) < 0.5);
    }
}
