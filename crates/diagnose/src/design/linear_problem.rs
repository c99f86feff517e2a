//! The weighted linear problem: columns, their products, and the candidates of columns that are laws.

use crate::design::candidate::Candidate;
use crate::design::link_error_prior::LinkErrorPrior;
use std::sync::OnceLock;

use armident_effects::{EffectOnJoint, Library};
use armident_numeric::{dot, products_of_columns};
use rayon::prelude::*;

use crate::design::observations::{JointColumns, Observations};

/// From so many new columns on their products come from one product of matrices, which has to copy all
/// columns first.
const FEWEST_AS_MATRIX: usize = 8;

/// Columns and their products; the first `rigid` columns are the standard parameters, and the baseline
/// terms of every joint where a change is sought.
#[derive(Debug, Clone)]
pub(crate) struct LinearProblem {
    pub(crate) observations: Observations,
    pub(crate) columns: Vec<JointColumns>,
    pub(crate) rigid: usize,
    /// lower triangle, row by row
    pub(crate) gram: Vec<Vec<f64>>,
    pub(crate) rhs: Vec<f64>,
    pub(crate) effort: JointColumns,
    pub(crate) square: f64,
    pub(crate) link_error_prior: LinkErrorPrior,
    /// products of its directions in the efforts, `W'W` at size 1: formed when first asked for
    pub(crate) of_directions: OnceLock<Vec<Vec<f64>>>,
    pub(crate) candidates: Vec<Candidate>,
    /// `[joint]`: effects that were subtracted from the recordings; a finding may be a decrease of these
    pub(crate) known: Vec<Vec<EffectOnJoint>>,
    /// laws of the candidates and of the known effects
    pub(crate) library: Library,
}

impl LinearProblem {
    pub(crate) fn new(
        observations: Observations,
        effort: JointColumns,
        rigid: Vec<JointColumns>,
        link_error_prior: LinkErrorPrior,
    ) -> Self {
        let square = effort.iter().flatten().map(|x| x * x).sum();
        let mut problem = Self {
            known: vec![Vec::new(); observations.joints()],
            observations,
            columns: Vec::new(),
            rigid: rigid.len(),
            gram: Vec::new(),
            rhs: Vec::new(),
            effort,
            square,
            link_error_prior,
            of_directions: OnceLock::new(),
            candidates: Vec::new(),
            library: Library::standard().clone(),
        };
        problem.push_columns(rigid);
        problem
    }

    /// Adds columns, and gives the id of the first.
    pub(crate) fn push_columns(&mut self, new: Vec<JointColumns>) -> usize {
        let first = self.columns.len();
        self.columns.extend(new);
        let total = self.columns.len();
        for k in first..total {
            self.gram.push(vec![0.0; k + 1]);
            self.rhs.push(0.0);
        }
        // joint by joint: columns that are there, and the products of the new ones among them
        let of_joint = |j: usize| -> (Vec<usize>, Vec<f64>, Vec<Vec<f64>>) {
            let block = |k: usize| self.columns[k][j].as_slice();
            let present: Vec<usize> = (0..total).filter(|&k| !block(k).is_empty()).collect();
            let old = present.partition_point(|k| *k < first);
            let fresh = &present[old..];
            let rhs = fresh.iter().map(|&k| dot(block(k), &self.effort[j])).collect();
            let products = if fresh.len() >= FEWEST_AS_MATRIX {
                let all: Vec<&[f64]> = present.iter().map(|&k| block(k)).collect();
                let products = products_of_columns(&all[old..], &all);
                let row = |a: usize| (0..=old + a).map(|b| products[(a, b)]).collect();
                (0..fresh.len()).map(row).collect()
            } else {
                let row = |a: usize| {
                    let others = &present[..=old + a];
                    others.iter().map(|&l| dot(block(fresh[a]), block(l))).collect()
                };
                (0..fresh.len()).map(row).collect()
            };
            (present, rhs, products)
        };
        let by_joint: Vec<_> =
            (0..self.observations.joints()).into_par_iter().map(of_joint).collect();
        for (present, rhs, products) in by_joint {
            let fresh = &present[present.len() - rhs.len()..];
            for ((&k, rhs), products) in fresh.iter().zip(rhs).zip(products) {
                self.rhs[k] += rhs;
                for (&l, product) in present.iter().zip(products) {
                    self.gram[k][l] += product;
                }
            }
        }
        first
    }

    /// The column with these rows, if there is one already among those from `from` on.
    pub(crate) fn find_column(&self, blocks: &JointColumns, from: usize) -> Option<usize> {
        (from..self.columns.len()).find(|&k| self.columns[k] == *blocks)
    }

    pub(crate) fn product(&self, a: usize, b: usize) -> f64 {
        if a >= b { self.gram[a][b] } else { self.gram[b][a] }
    }

    /// The problem with an effort added that some of its columns explain.
    pub(crate) fn with_added(&self, added: &[(usize, f64)]) -> Self {
        let mut problem = self.clone();
        for &(column, amount) in added {
            for (effort, block) in problem.effort.iter_mut().zip(&self.columns[column]) {
                for (e, x) in effort.iter_mut().zip(block) {
                    *e += amount * x;
                }
            }
            for k in 0..self.columns.len() {
                problem.rhs[k] += amount * self.product(k, column);
            }
        }
        problem.square = problem.effort.iter().flatten().map(|x| x * x).sum();
        problem
    }

    /// How many candidates and columns there are, for [`Self::back_to`].
    pub(crate) fn mark(&self) -> Mark {
        Mark { candidates: self.candidates.len(), columns: self.columns.len() }
    }

    /// Forgets the candidates and columns that came after a mark.
    pub(crate) fn back_to(&mut self, mark: Mark) {
        self.candidates.truncate(mark.candidates);
        self.columns.truncate(mark.columns);
        self.gram.truncate(mark.columns);
        self.rhs.truncate(mark.columns);
    }

    /// The problem with the columns of some candidates only, and the ids of these candidates there.
    pub(crate) fn restricted(&self, set: &[usize]) -> (Self, Vec<usize>) {
        let mut kept: Vec<usize> = (0..self.rigid).collect();
        let mut candidates = Vec::new();
        for &g in set {
            let mut candidate = self.candidates[g].clone();
            for column in &mut candidate.columns {
                let place = kept.iter().position(|k| k == column).unwrap_or_else(|| {
                    kept.push(*column);
                    kept.len() - 1
                });
                *column = place;
            }
            candidates.push(candidate);
        }
        let gram = (0..kept.len())
            .map(|k| (0..=k).map(|l| self.product(kept[k], kept[l])).collect())
            .collect();
        let problem = Self {
            observations: self.observations.clone(),
            columns: kept.iter().map(|k| self.columns[*k].clone()).collect(),
            rigid: self.rigid,
            gram,
            rhs: kept.iter().map(|k| self.rhs[*k]).collect(),
            effort: self.effort.clone(),
            square: self.square,
            link_error_prior: self.link_error_prior.clone(),
            of_directions: self.of_directions.clone(),
            candidates,
            known: self.known.clone(),
            library: self.library.clone(),
        };
        let ids = (0..set.len()).collect();
        (problem, ids)
    }

    /// The problem of some of its rows. The sizes in `rows` stay those of the whole.
    pub(crate) fn of_rows(&self, kept: impl Fn(usize) -> bool) -> Self {
        let cut = |blocks: &JointColumns| -> JointColumns {
            let of = |block: &Vec<f64>| {
                block.iter().enumerate().filter(|(row, _)| kept(*row)).map(|(_, x)| *x).collect()
            };
            blocks.iter().map(of).collect()
        };
        let columns = self.columns.iter().map(cut).collect();
        let mut problem = Self::new(
            self.observations.clone(),
            cut(&self.effort),
            columns,
            self.link_error_prior.clone(),
        );
        problem.rigid = self.rigid;
        problem.candidates.clone_from(&self.candidates);
        problem.known.clone_from(&self.known);
        problem.library.clone_from(&self.library);
        problem
    }
}

/// How many candidates and columns a problem had.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mark {
    candidates: usize,
    pub(crate) columns: usize,
}
