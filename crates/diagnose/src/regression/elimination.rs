//! Elimination of the link errors (nuisance parameters with a Gaussian prior) from products of columns.
//!
//! ```text
//! y = A x + W z + e,   z ~ N(0, s² I),   e ~ N(0, I):   A' (1 + s² W W')⁻¹ A = A'A - A'W (s⁻² + W'W)⁻¹ W'A
//! ```
//!
//! Method: marginalisation of the link errors by the matrix inversion lemma.
//! References: M. A. Woodbury, Inverting modified matrices, Memorandum report 42, Princeton University, 1950.

use crate::design::linear_problem::LinearProblem;
use armident_numeric::{Cholesky, dot};
use std::sync::Arc;

/// Prior scales of an inflated link over that of all others: a link of a draft, another body, one many times as heavy.
pub(crate) const INFLATIONS: [f64; 3] = [4.0, 12.0, 40.0];

/// A link with a larger prior scale than all others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct InflatedLink {
    pub(crate) link: usize,
    /// its prior scale over that of all others
    pub(crate) times: f64,
}

/// Prior scale of a link, `scale` where it is not inflated.
pub(crate) fn size_of_link(link: usize, scale: f64, inflated: &[InflatedLink]) -> f64 {
    inflated.iter().find(|body| body.link == link).map_or(scale, |body| body.times * scale)
}

/// Elimination of link errors of one prior scale, with the columns reduced so far.
pub(crate) struct NuisanceElimination {
    pub(super) scale: f64,
    pub(super) inflated: Vec<InflatedLink>,
    pub(super) log_determinant: f64,
    pub(super) prior: Option<Arc<Prior>>,
    /// the columns so far, their products and those with the efforts
    pub(super) reduced: Vec<Vec<f64>>,
    pub(super) gram: Vec<Vec<f64>>,
    pub(super) rhs: Vec<f64>,
}

impl NuisanceElimination {
    /// Forgets the columns from this one on.
    pub(crate) fn truncate(&mut self, columns: usize) {
        self.reduced.truncate(columns);
        self.gram.truncate(columns);
        self.rhs.truncate(columns);
    }
}

/// Prior of the link errors.
pub(crate) struct Prior {
    pub(super) weight: f64,
    /// of `1 + weight W'W`
    pub(super) cholesky: Cholesky,
    pub(super) w_y: Vec<f64>,
    /// `D`, each scaled to its deviation
    pub(super) directions: Vec<Vec<f64>>,
}

impl LinearProblem {
    /// The elimination at a prior scale, no column reduced yet.
    pub(crate) fn elimination(&self, scale: f64, inflated: &[InflatedLink]) -> NuisanceElimination {
        let sizes: Vec<f64> = (0..self.link_error_prior.links)
            .map(|link| size_of_link(link, scale, inflated))
            .collect();
        NuisanceElimination { scale, inflated: inflated.to_vec(), ..self.elimination_of(&sizes) }
    }

    /// The elimination with a prior scale for every link.
    pub(crate) fn elimination_of(&self, sizes: &[f64]) -> NuisanceElimination {
        let mut elimination = NuisanceElimination {
            scale: sizes.iter().copied().fold(0.0, f64::max),
            inflated: Vec::new(),
            log_determinant: 0.0,
            prior: None,
            reduced: Vec::new(),
            gram: Vec::new(),
            rhs: Vec::new(),
        };
        if elimination.scale == 0.0 && self.link_error_prior.free == 0 {
            return elimination;
        }
        let weight = self.observations.weights.share;
        let inertial = self.link_error_prior.directions.len() - self.link_error_prior.free;
        let per_link = (inertial / self.link_error_prior.links.max(1)).max(1);
        let size = |k: usize| if k < inertial { sizes[k / per_link] } else { 1.0 };
        let directions: Vec<Vec<f64>> = self
            .link_error_prior
            .directions
            .iter()
            .enumerate()
            .map(|(k, d)| d.iter().map(|x| size(k) * x).collect())
            .collect();
        let w_w = self.of_directions.get_or_init(|| self.products_of_directions());
        let cholesky = Cholesky::of(directions.len(), |i, j| {
            f64::from(u8::from(i == j)) + weight * size(i) * size(j) * w_w[i][j]
        });
        if let Some(cholesky) = cholesky {
            elimination.log_determinant = cholesky.log_determinant();
            let w_y = directions.iter().map(|d| dot(d, &self.rhs[..self.rigid])).collect();
            elimination.prior = Some(Arc::new(Prior { weight, cholesky, w_y, directions }));
        }
        elimination
    }

    /// `W'W` of directions at size 1. On one thread: a thread that waits here could be given work that waits for this value.
    fn products_of_directions(&self) -> Vec<Vec<f64>> {
        let directions = &self.link_error_prior.directions;
        let with_rigid: Vec<Vec<f64>> =
            (0..self.rigid).map(|k| self.along(directions, k)).collect();
        let with = |a: usize| {
            let with_a: Vec<f64> = with_rigid.iter().map(|w| w[a]).collect();
            directions.iter().map(|d| dot(d, &with_a)).collect()
        };
        (0..directions.len()).map(with).collect()
    }

    /// Products of a column with directions of the standard parameters.
    pub(super) fn along(&self, directions: &[Vec<f64>], column: usize) -> Vec<f64> {
        let products: Vec<f64> = (0..self.rigid).map(|p| self.product(column, p)).collect();
        directions.iter().map(|d| dot(d, &products)).collect()
    }
}
