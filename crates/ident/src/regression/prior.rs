//! What a fit knows beside the recordings: signs of effects, a prior of the links, a prior of loads.
//!
//! Method: Gaussian priors as rows of least squares, sign constraints as bounds; both vanish where the recordings
//! determine more. On 25 fits of recorded motions of UR10, Panda, TX40 and two pendulums, judged on motions that follow,
//! they remove the largest errors: a fit of motions that leave constants undetermined extrapolates by its prior.
//!
//! References: C. M. Bishop, Pattern Recognition and Machine Learning (2006), section 3.3; link prior in
//! [`link_prior`](super::link_prior).

use armident_effects::Admissible;
use armident_numeric::{AccumulatedQr, Mat, NumericError};

use super::link_prior::LinkPrior;
use super::problem::BatchProblem;
use super::unknown::Term;

/// What a fit knows beside the recordings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchSettings {
    /// Parameters whose law admits no negative value are held at zero or above.
    pub admissible_signs: bool,
    /// Prior scale: standard deviation of the mass of every URDF link and of its second moments, along every line,
    /// relative to their size; none: no prior. At 1 a link may as well have no mass, or twice its mass.
    pub link_prior: Option<f64>,
}

impl Default for BatchSettings {
    fn default() -> Self {
        Self { admissible_signs: true, link_prior: Some(1.0) }
    }
}

impl BatchSettings {
    /// The recordings alone: plain weighted least squares.
    pub const PLAIN: Self = Self { admissible_signs: false, link_prior: None };
}

impl BatchProblem {
    /// Settings in the form the solver takes.
    pub(crate) fn regularisation(
        &self,
        settings: &BatchSettings,
    ) -> Result<Regularisation, NumericError> {
        Ok(Regularisation {
            bound: settings.admissible_signs.then(|| self.bound()),
            prior: self.prior(settings)?,
        })
    }

    /// Which terms may not be negative.
    pub(crate) fn bound(&self) -> Vec<bool> {
        let of_law = |term: &Term| match *term {
            Term::Constant(_) | Term::Load { .. } => false,
            Term::Effect { .. } | Term::Shared { .. } => term
                .parameter()
                .is_some_and(|parameter| parameter.admissible == Admissible::NonNegative),
        };
        self.terms.iter().map(of_law).collect()
    }

    /// The prior over all terms.
    pub(crate) fn prior(
        &self,
        settings: &BatchSettings,
    ) -> Result<Option<TermPrior>, NumericError> {
        let of_links = match settings.link_prior {
            Some(relative) => self.link_prior_over_terms(relative)?,
            None => None,
        };
        let nothing = || TermPrior { mean: vec![0.0; self.terms.len()], rows: Vec::new() };
        let mut prior = of_links.unwrap_or_else(nothing);
        prior.rows.extend(self.load_prior());
        Ok((!prior.rows.is_empty()).then_some(prior))
    }

    /// The link prior over all terms; none where the URDF gives no link a mass.
    pub(crate) fn link_prior_over_terms(
        &self,
        relative: f64,
    ) -> Result<Option<TermPrior>, NumericError> {
        let with_rotor: Vec<usize> = (self.merged.iter().flat_map(|m| &m.into))
            .filter_map(|&(k, _)| match self.terms[k] {
                Term::Constant(c) => Some(c),
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => None,
            })
            .collect();
        let Some(prior) = LinkPrior::of(self.arm(), self.set(), &with_rotor, relative)? else {
            return Ok(None);
        };
        let over_terms = |row: &[f64]| -> Vec<f64> {
            let of_term = |term: &Term| match *term {
                Term::Constant(c) => row[c],
                Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => 0.0,
            };
            self.terms.iter().map(of_term).collect()
        };
        Ok(Some(TermPrior {
            mean: over_terms(&prior.mean),
            rows: prior.rows.iter().map(|row| over_terms(row)).collect(),
        }))
    }

    /// The prior of the unknown parameters of loads, as rows over all terms with residuals of variance 1.
    pub(crate) fn load_prior(&self) -> Vec<Vec<f64>> {
        let rows = self.terms.iter().enumerate().filter_map(|(k, term)| {
            let Term::Load { load, number } = *term else { return None };
            let error = self.loads[load].errors()[number - 1];
            let at = |column: usize| if column == k { error.recip() } else { 0.0 };
            Some((0..self.terms.len()).map(at).collect())
        });
        rows.collect()
    }
}

/// Rows of a prior about its mean.
pub(crate) fn triangle_of(rows: &[Vec<f64>], unknowns: usize) -> AccumulatedQr {
    let mut prior = AccumulatedQr::new(unknowns);
    prior.push_rows(&rows.iter().map(|r| [r, &[0.0][..]].concat()).collect::<Vec<_>>());
    prior
}

/// Settings in the form the solver takes.
pub(crate) struct Regularisation {
    pub(crate) bound: Option<Vec<bool>>,
    pub(crate) prior: Option<TermPrior>,
}

/// [`LinkPrior`] over all terms; it has no information on effects.
#[derive(Debug, Clone)]
pub(crate) struct TermPrior {
    pub(crate) mean: Vec<f64>,
    pub(crate) rows: Vec<Vec<f64>>,
}

impl TermPrior {
    /// `C P C`: the part of the covariance `C` of an estimate that comes from the prior.
    pub(crate) fn carried(&self, covariance: &Mat<f64>) -> Mat<f64> {
        let p = covariance.nrows();
        // rows of B C
        let carried: Vec<Vec<f64>> = self
            .rows
            .iter()
            .map(|row| {
                (0..p).map(|j| (0..p).map(|k| row[k] * covariance[(k, j)]).sum::<f64>()).collect()
            })
            .collect();
        Mat::from_fn(p, p, |i, j| carried.iter().map(|row| row[i] * row[j]).sum())
    }

    /// Diagonal of `C P`, with `C` the covariance and `P` the information of the prior.
    pub(crate) fn share_of(&self, covariance: &Mat<f64>) -> Vec<f64> {
        let p = covariance.nrows();
        let mut share = vec![0.0; p];
        for row in &self.rows {
            for (k, share) in share.iter_mut().enumerate() {
                if row[k] != 0.0 {
                    *share += row[k] * (0..p).map(|j| covariance[(k, j)] * row[j]).sum::<f64>();
                }
            }
        }
        share.iter().map(|s| s.clamp(0.0, 1.0)).collect()
    }
}
