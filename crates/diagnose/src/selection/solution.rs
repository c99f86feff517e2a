//! The result of a selection, and all that gives it a meaning.

use crate::design::compliant_link::Posed;
use crate::design::design::Evidence;
use crate::design::linear_problem::Problem;
use crate::regression::elimination::WrongBody;
use crate::regression::fit_set::Answer;
use crate::regression::marginalised::Whitened;
use crate::regression::relinearise::moves;
use crate::selection::change_significance::Doubt;
use armident_model::OperatingPoint;
use armident_numeric::dot;
use std::cell::OnceCell;
/// The answer of the selection, and all it stands on.
pub(crate) struct Selection {
    pub(crate) problem: Problem,
    pub(crate) answer: Answer,
    /// relative inertial error
    pub(crate) scale: f64,
    /// links with a wrong body
    pub(crate) wide: Vec<WrongBody>,
    /// where the columns were formed
    pub(crate) point: OperatingPoint,
    /// changes that are not certain
    pub(crate) doubtful: Vec<Doubt>,
}

impl Selection {
    pub(crate) fn metric(&self) -> Whitened<'_> {
        self.problem.whitened(self.scale, &self.wide)
    }

    /// Description length with so many independent samples a row, what is left on each joint in units of its own size:
    /// the score of selections that weighed joints differently.
    pub(crate) fn length(&self, share: f64) -> f64 {
        let (metric, rows, fit) = (self.metric(), &self.problem.rows, &self.answer.fit);
        let residual = metric.residual(fit);
        let squares: Vec<f64> = residual.iter().map(|r| dot(r, r)).collect();
        let misfit = |(j, square): (usize, &f64)| -> f64 {
            let samples = rows.effective_on(j);
            if samples == 0.0 {
                return 0.0;
            }
            // nothing is explained better than to the noise
            samples * (square * rows.misfit[j].powi(2) / samples).max(1.0).ln()
        };
        let left: f64 = squares.iter().enumerate().map(misfit).sum();
        let of_links = fit.sum_of_squares - squares.iter().sum::<f64>();
        let columns = metric.columns_of(&self.answer.set).len();
        share * left + rows.share * of_links + metric.price(columns, &self.answer.set)
    }

    /// The answer; the metric is that of the selection.
    pub(crate) fn view<'a, 'e>(
        &'a self,
        evidence: &'a Evidence<'e>,
        metric: &'a Whitened<'a>,
    ) -> View<'a, 'e> {
        View::new(evidence, metric, &self.answer, &self.point)
    }
}

/// An answer with all that gives it a meaning.
pub(crate) struct View<'a, 'e> {
    pub(crate) evidence: &'a Evidence<'e>,
    pub(crate) metric: &'a Whitened<'a>,
    pub(crate) answer: &'a Answer,
    /// where the columns were formed
    pub(crate) point: &'a OperatingPoint,
    /// of each joint's effort channel
    pub(crate) gain: Vec<f64>,
    /// the recordings there, formed when first asked for
    at: OnceCell<Vec<Posed<'a>>>,
}

impl<'a, 'e> View<'a, 'e> {
    pub(crate) fn new(
        evidence: &'a Evidence<'e>,
        metric: &'a Whitened<'a>,
        answer: &'a Answer,
        point: &'a OperatingPoint,
    ) -> Self {
        let gain = moves(metric.problem, answer, point).gain;
        Self { evidence, metric, answer, point, gain, at: OnceCell::new() }
    }

    /// The recordings where the columns were formed.
    pub(crate) fn at(&self) -> &[Posed<'a>] {
        self.at.get_or_init(|| self.evidence.at(self.point))
    }
}
