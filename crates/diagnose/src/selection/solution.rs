//! The result of a selection, and an estimate with its operating point and metric.

use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;
use crate::regression::elimination::InflatedLink;
use crate::regression::fit_set::Estimate;
use crate::regression::marginalised::Marginalised;
use crate::regression::relinearise::moves;
use crate::selection::change_significance::Inconclusive;
use armident_model::OperatingPoint;
use armident_numeric::dot;
use std::cell::OnceCell;
/// The estimate of the selection with its problem, prior scale and operating point.
pub(crate) struct Selection {
    pub(crate) problem: LinearProblem,
    pub(crate) estimate: Estimate,
    /// relative inertial error
    pub(crate) scale: f64,
    /// inflated links
    pub(crate) inflated: Vec<InflatedLink>,
    /// where the columns were formed
    pub(crate) point: OperatingPoint,
    /// changes that are not significant
    pub(crate) inconclusive: Vec<Inconclusive>,
}

impl Selection {
    pub(crate) fn metric(&self) -> Marginalised<'_> {
        self.problem.marginalised(self.scale, &self.inflated)
    }

    /// Score with so many independent samples a row, the residual of each joint in units of its own size: comparable between
    /// selections with different weights.
    pub(crate) fn length(&self, share: f64) -> f64 {
        let (metric, rows, fit) = (self.metric(), &self.problem.observations, &self.estimate.fit);
        let residual = metric.residual(fit);
        let squares: Vec<f64> = residual.iter().map(|r| dot(r, r)).collect();
        let discrepancy = |(j, square): (usize, &f64)| -> f64 {
            let samples = rows.effective_on(j);
            if samples == 0.0 {
                return 0.0;
            }
            // no joint is explained better than to its noise
            samples * (square * rows.weights.discrepancy[j].powi(2) / samples).max(1.0).ln()
        };
        let left: f64 = squares.iter().enumerate().map(discrepancy).sum();
        let of_links = fit.sum_of_squares - squares.iter().sum::<f64>();
        let columns = metric.columns_of(&self.estimate.set).len();
        share * left + rows.weights.share * of_links + metric.price(columns, &self.estimate.set)
    }

    /// The estimate; the metric is that of the selection.
    pub(crate) fn solution<'a, 'e>(
        &'a self,
        design: &'a Design<'e>,
        metric: &'a Marginalised<'a>,
    ) -> Solution<'a, 'e> {
        Solution::new(design, metric, &self.estimate, &self.point)
    }
}

/// An estimate with its metric and operating point.
pub(crate) struct Solution<'a, 'e> {
    pub(crate) design: &'a Design<'e>,
    pub(crate) metric: &'a Marginalised<'a>,
    pub(crate) estimate: &'a Estimate,
    /// where the columns were formed
    pub(crate) point: &'a OperatingPoint,
    /// of each joint's effort channel
    pub(crate) gain: Vec<f64>,
    /// the recordings there, formed when first asked for
    at: OnceCell<Vec<Posed<'a>>>,
}

impl<'a, 'e> Solution<'a, 'e> {
    pub(crate) fn new(
        design: &'a Design<'e>,
        metric: &'a Marginalised<'a>,
        estimate: &'a Estimate,
        point: &'a OperatingPoint,
    ) -> Self {
        let gain = moves(metric.problem, estimate, point).gain;
        Self { design, metric, estimate, point, gain, at: OnceCell::new() }
    }

    /// The recordings where the columns were formed.
    pub(crate) fn at(&self) -> &[Posed<'a>] {
        self.at.get_or_init(|| self.design.at(self.point))
    }
}
