//! The problem with errors of all links integrated out: fits, their scores and their uncertainty.

use std::collections::HashSet;
use std::sync::Arc;

use armident_effects::{Onset, effect};
use armident_numeric::{Cholesky, Mat, dot};
use rayon::prelude::*;

use crate::problem::{Group, Meaning, Problem};
use crate::rows::Blocks;

/// Relative ridge on normalised columns: nested laws share columns, round-off does the rest.
const RIDGE: f64 = 1e-7;
/// Least unique part of a normalised column, squared: below it the column is a combination.
const LEAST_UNIQUE: f64 = 1e-6;
/// Price of a group in the score: the logarithm of the some three hundred groups it was chosen from,
/// doubled.
pub(crate) const PRICE_OF_CHOICE: f64 = 12.0;
/// Price of a law, or a change, that seldom comes about: odds of one in a hundred against those that often
/// do.
pub(crate) const PRICE_OF_SELDOM: f64 = 9.2;

/// A link whose body is wrong beyond what all links are off by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WrongBody {
    pub(crate) link: usize,
    /// how many times larger its errors may be than those of all others
    pub(crate) times: f64,
}

/// Relative size of the errors of a link where all others are off by `scale`.
fn size_of(link: usize, scale: f64, wide: &[WrongBody]) -> f64 {
    wide.iter().find(|body| body.link == link).map_or(scale, |body| body.times * scale)
}

/// What integrates inertial errors of one size out of columns: the same for all that are added later.
pub(crate) struct Integral {
    scale: f64,
    wide: Vec<WrongBody>,
    log_determinant: f64,
    prior: Option<Arc<Prior>>,
    /// the columns so far, their products and those with the efforts
    reduced: Vec<Vec<f64>>,
    gram: Vec<Vec<f64>>,
    rhs: Vec<f64>,
}

impl Integral {
    /// Forgets the columns from this one on.
    pub(crate) fn truncate(&mut self, columns: usize) {
        self.reduced.truncate(columns);
        self.gram.truncate(columns);
        self.rhs.truncate(columns);
    }
}

/// A [`Problem`] in the metric in which inertial errors of a given size are noise.
pub(crate) struct Whitened<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) scale: f64,
    /// links whose errors may be larger
    pub(crate) wide: Vec<WrongBody>,
    gram: Vec<Vec<f64>>,
    rhs: Vec<f64>,
    square: f64,
    /// the sample size of fits
    effective_rows: f64,
    log_determinant: f64,
    norm: Vec<f64>,
    prior: Option<Arc<Prior>>,
    /// columns whose coefficient is 1
    of_size_one: HashSet<usize>,
}

/// What integrates inertial errors out.
struct Prior {
    weight: f64,
    /// of `1 + weight W'W`
    cholesky: Cholesky,
    w_y: Vec<f64>,
    /// `D`, each scaled to its deviation
    directions: Vec<Vec<f64>>,
}

/// The least-squares fit of a set of columns.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// ids of columns whose coefficients were fitted
    pub(crate) columns: Vec<usize>,
    coefficients: Vec<f64>,
    /// ids of those whose coefficient is 1
    of_size_one: Vec<usize>,
    pub(crate) sum_of_squares: f64,
    cholesky: Cholesky,
    reduced: Vec<f64>,
}

impl Fit {
    pub(crate) fn coefficient(&self, column: usize) -> f64 {
        self.terms().find(|(c, _)| *c == column).map_or(0.0, |(_, x)| x)
    }

    /// Columns and their coefficients.
    fn terms(&self) -> impl Iterator<Item = (usize, f64)> {
        let fitted = self.columns.iter().copied().zip(self.coefficients.iter().copied());
        fitted.chain(self.of_size_one.iter().map(|c| (*c, 1.0)))
    }

    pub(crate) fn of_group(&self, group: &Group) -> Vec<f64> {
        group.columns.iter().map(|c| self.coefficient(*c)).collect()
    }
}

impl Whitened<'_> {
    fn product(&self, a: usize, b: usize) -> f64 {
        let value = if a >= b { self.gram[a][b] } else { self.gram[b][a] };
        value / (self.norm[a] * self.norm[b])
    }

    /// Of a coefficient for that of the normalised column: 0 of a column of nothing, whose coefficient is 0.
    fn per_norm(&self, column: usize) -> f64 {
        let norm = self.norm[column];
        if norm > f64::MIN_POSITIVE.sqrt() { 1.0 / norm } else { 0.0 }
    }

    /// Columns of a set of groups, each once.
    pub(crate) fn columns_of(&self, set: &[usize]) -> Vec<usize> {
        let groups = &self.problem.groups;
        let mut columns: Vec<usize> =
            set.iter().flat_map(|g| groups[*g].columns.iter().copied()).collect();
        columns.sort_unstable();
        columns.dedup();
        columns
    }

    /// Fits a set of columns; none where they are numerically dependent beyond the ridge.
    pub(crate) fn fit(&self, columns: Vec<usize>) -> Option<Fit> {
        let (of_size_one, columns): (Vec<usize>, Vec<usize>) =
            columns.into_iter().partition(|c| self.of_size_one.contains(c));
        let cholesky = Cholesky::of(columns.len(), |i, j| {
            self.product(columns[i], columns[j]) + if i == j { RIDGE } else { 0.0 }
        })?;
        let rhs: Vec<f64> = columns.iter().map(|&k| self.rhs_beside(&of_size_one, k)).collect();
        let reduced = cholesky.forward(&rhs);
        // what is left beside those of size one
        let explained = |&u: &usize| {
            self.norm[u] * (self.rhs[u] / self.norm[u] + self.rhs_beside(&of_size_one, u))
        };
        let square = self.square - of_size_one.iter().map(explained).sum::<f64>();
        let sum_of_squares = (square - dot(&reduced, &reduced)).max(f64::MIN_POSITIVE);
        let coefficients = cholesky
            .backward(&reduced)
            .iter()
            .zip(&columns)
            .map(|(x, &k)| x / self.norm[k])
            .collect();
        Some(Fit { columns, coefficients, of_size_one, sum_of_squares, cholesky, reduced })
    }

    /// Product of a normalised column with the efforts beside columns of size one.
    fn rhs_beside(&self, of_size_one: &[usize], column: usize) -> f64 {
        let beside = |&u: &usize| self.norm[u] * self.product(column, u);
        self.rhs[column] / self.norm[column] - of_size_one.iter().map(beside).sum::<f64>()
    }

    /// What the sum of squares would lose if these columns were added to a fit.
    pub(crate) fn gain(&self, fit: &Fit, added: &[usize]) -> f64 {
        if added.is_empty() {
            return 0.0;
        }
        let across: Vec<Vec<f64>> = added
            .iter()
            .map(|&g| {
                let products: Vec<f64> = fit.columns.iter().map(|&c| self.product(c, g)).collect();
                fit.cholesky.forward(&products)
            })
            .collect();
        let rhs: Vec<f64> = added
            .iter()
            .zip(&across)
            .map(|(&g, z)| self.rhs_beside(&fit.of_size_one, g) - dot(z, &fit.reduced))
            .collect();
        let own = Cholesky::of(added.len(), |i, j| {
            self.product(added[i], added[j]) - dot(&across[i], &across[j])
                + if i == j { LEAST_UNIQUE } else { 0.0 }
        });
        own.map_or(0.0, |own| {
            let reduced = own.forward(&rhs);
            dot(&reduced, &reduced)
        })
    }

    /// A description length: misfit in units of its own size, and its price.
    pub(crate) fn score(&self, sum_of_squares: f64, columns: usize, set: &[usize]) -> f64 {
        let rows = self.effective_rows;
        let samples = rows * self.problem.rows.share;
        samples * (sum_of_squares / rows).ln() + self.price(columns, set)
    }

    /// A price for every column, every searched constant, every choice of a group, and for how much the errors of links
    /// could explain.
    pub(crate) fn price(&self, columns: usize, set: &[usize]) -> f64 {
        let samples = self.effective_rows * self.problem.rows.share;
        let searched: usize = set.iter().map(|g| self.problem.groups[*g].searched).sum();
        samples.ln() * (columns + searched) as f64
            + PRICE_OF_CHOICE * (set.len() + self.wide.len()) as f64
            + self.price_of_onsets(set)
            + self.log_determinant
    }

    /// Nothing but where a change is sought.
    fn price_of_onsets(&self, set: &[usize]) -> f64 {
        if self.problem.rows.changed_from == 0 {
            return 0.0;
        }
        set.iter().map(|g| self.problem.price_of_onset(&self.problem.groups[*g])).sum()
    }

    /// Relative size of the errors of a link.
    pub(crate) fn size_of(&self, link: usize) -> f64 {
        size_of(link, self.scale, &self.wide)
    }

    /// Posterior mean of the relative inertial errors, and with it the change of all standard
    /// parameters; zeros at scale 0.
    pub(crate) fn inertial_errors(&self, fit: &Fit) -> Vec<f64> {
        let problem = self.problem;
        let mut change = vec![0.0; problem.rigid];
        let Some(prior) = &self.prior else { return change };
        let Prior { weight, cholesky, w_y, directions } = &**prior;
        let rhs: Vec<f64> = directions
            .iter()
            .zip(w_y)
            .map(|(d, w_y)| {
                let explained: f64 = fit
                    .terms()
                    .map(|(c, x)| {
                        x * (0..problem.rigid).map(|p| d[p] * problem.product(c, p)).sum::<f64>()
                    })
                    .sum();
                weight * (w_y - explained)
            })
            .collect();
        for (direction, c) in directions.iter().zip(cholesky.solve(&rhs)) {
            for (change, d) in change.iter_mut().zip(direction) {
                *change += c * d;
            }
        }
        change
    }

    /// Posterior covariance of some standard parameters' errors, the fit of the laws as it is.
    pub(crate) fn inertial_covariance(&self, parameters: &[usize]) -> Vec<Vec<f64>> {
        let Some(Prior { cholesky, directions, .. }) = self.prior.as_deref() else {
            return vec![vec![0.0; parameters.len()]; parameters.len()];
        };
        let rows: Vec<Vec<f64>> =
            parameters.iter().map(|p| directions.iter().map(|d| d[*p]).collect()).collect();
        let solved: Vec<Vec<f64>> = rows.iter().map(|row| cholesky.solve(row)).collect();
        rows.iter().map(|row| solved.iter().map(|s| dot(row, s)).collect()).collect()
    }

    /// Rows whose outer products add up to the prior covariance of all standard parameters; none without
    /// inertial errors.
    pub(crate) fn prior_factors(&self) -> Option<Vec<Vec<f64>>> {
        self.prior.as_ref().map(|prior| prior.directions.clone())
    }

    /// The same of the posterior with the laws as they are, and what a unit of each coefficient of the fit
    /// does to the standard parameters.
    pub(crate) fn inertial_posterior(&self, fit: &Fit) -> Option<[Vec<Vec<f64>>; 2]> {
        let Prior { weight, cholesky, directions, .. } = self.prior.as_deref()?;
        let rigid = self.problem.rigid;
        // A = L L': the rows of L^-1 D
        let columns: Vec<Vec<f64>> = (0..rigid)
            .map(|p| cholesky.forward(&directions.iter().map(|d| d[p]).collect::<Vec<_>>()))
            .collect();
        let rows = (0..directions.len()).map(|k| columns.iter().map(|c| c[k]).collect()).collect();
        let sensitivity = fit
            .columns
            .iter()
            .map(|&c| {
                let along = |d: &Vec<f64>| -> f64 {
                    (0..rigid).map(|p| d[p] * self.problem.product(c, p)).sum()
                };
                let solved = cholesky.solve(&directions.iter().map(along).collect::<Vec<_>>());
                (0..rigid)
                    .map(|p| {
                        -weight * directions.iter().zip(&solved).map(|(d, s)| d[p] * s).sum::<f64>()
                    })
                    .collect()
            })
            .collect();
        Some([rows, sensitivity])
    }

    /// Rows whose outer products add up to the covariance of the coefficients of a fit.
    pub(crate) fn coefficient_factors(&self, fit: &Fit) -> Vec<Vec<f64>> {
        let scale = |k: usize| self.per_norm(fit.columns[k]) / self.problem.rows.share.sqrt();
        let count = fit.columns.len();
        let columns: Vec<Vec<f64>> = (0..count)
            .map(|c| {
                let unit: Vec<f64> = (0..count).map(|k| f64::from(u8::from(k == c))).collect();
                fit.cholesky.forward(&unit)
            })
            .collect();
        (0..count).map(|k| (0..count).map(|c| columns[c][k] * scale(c)).collect()).collect()
    }

    /// Weighted rows that a fit leaves, inertial errors at their posterior mean.
    pub(crate) fn residual(&self, fit: &Fit) -> Blocks {
        self.residual_of(fit, self.problem)
    }

    /// The same of the rows of another problem of the same columns.
    pub(crate) fn residual_of(&self, fit: &Fit, problem: &Problem) -> Blocks {
        let mut residual = problem.effort.clone();
        let errors = self.inertial_errors(fit);
        let rigid = errors.iter().enumerate().filter(|(_, x)| **x != 0.0);
        let rigid = rigid.map(|(k, x)| (k, *x));
        for (k, x) in rigid.chain(fit.terms()) {
            for (residual, column) in residual.iter_mut().zip(&problem.columns[k]) {
                for (r, c) in residual.iter_mut().zip(column) {
                    *r -= x * c;
                }
            }
        }
        residual
    }

    /// Covariance of the coefficients of some columns of a fit.
    pub(crate) fn covariance(&self, fit: &Fit, columns: &[usize]) -> Vec<Vec<f64>> {
        let reduced: Vec<Vec<f64>> = columns
            .iter()
            .map(|c| {
                let unit: Vec<f64> =
                    fit.columns.iter().map(|k| f64::from(u8::from(k == c))).collect();
                fit.cholesky.forward(&unit)
            })
            .collect();
        let scale = |k: usize| self.per_norm(columns[k]);
        (0..columns.len())
            .map(|a| {
                (0..columns.len())
                    .map(|b| {
                        dot(&reduced[a], &reduced[b]) * scale(a) * scale(b)
                            / self.problem.rows.share
                    })
                    .collect()
            })
            .collect()
    }
}

impl Problem {
    /// The problem with inertial errors integrated out: of relative deviation `scale`, and more on the links in
    /// `wide`.
    pub(crate) fn whitened(&self, scale: f64, wide: &[WrongBody]) -> Whitened<'_> {
        self.whitened_by(&mut self.integral(scale, wide))
    }

    /// What integrates inertial errors of that size out, no column reduced by it yet.
    pub(crate) fn integral(&self, scale: f64, wide: &[WrongBody]) -> Integral {
        let sizes: Vec<f64> =
            (0..self.background.links).map(|link| size_of(link, scale, wide)).collect();
        Integral { scale, wide: wide.to_vec(), ..self.integral_of(&sizes) }
    }

    /// The same with a size for every link.
    pub(crate) fn integral_of(&self, sizes: &[f64]) -> Integral {
        let mut integral = Integral {
            scale: sizes.iter().copied().fold(0.0, f64::max),
            wide: Vec::new(),
            log_determinant: 0.0,
            prior: None,
            reduced: Vec::new(),
            gram: Vec::new(),
            rhs: Vec::new(),
        };
        if integral.scale == 0.0 && self.background.free == 0 {
            return integral;
        }
        let weight = self.rows.share;
        let inertial = self.background.directions.len() - self.background.free;
        let per_link = (inertial / self.background.links.max(1)).max(1);
        let size = |k: usize| if k < inertial { sizes[k / per_link] } else { 1.0 };
        let directions: Vec<Vec<f64>> = self
            .background
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
            integral.log_determinant = cholesky.log_determinant();
            let w_y = directions.iter().map(|d| dot(d, &self.rhs[..self.rigid])).collect();
            integral.prior = Some(Arc::new(Prior { weight, cholesky, w_y, directions }));
        }
        integral
    }

    /// `W'W` of directions at size 1. On one thread: one that waits for others here could be given work that waits for this.
    fn products_of_directions(&self) -> Vec<Vec<f64>> {
        let directions = &self.background.directions;
        let with_rigid: Vec<Vec<f64>> =
            (0..self.rigid).map(|k| self.along(directions, k)).collect();
        let with = |a: usize| {
            let with_a: Vec<f64> = with_rigid.iter().map(|w| w[a]).collect();
            directions.iter().map(|d| dot(d, &with_a)).collect()
        };
        (0..directions.len()).map(with).collect()
    }

    /// Products of a column with directions of the standard parameters.
    fn along(&self, directions: &[Vec<f64>], column: usize) -> Vec<f64> {
        let products: Vec<f64> = (0..self.rigid).map(|p| self.product(column, p)).collect();
        directions.iter().map(|d| dot(d, &products)).collect()
    }

    /// The same where some of the columns were reduced before.
    pub(crate) fn whitened_by(&self, integral: &mut Integral) -> Whitened<'_> {
        let count = self.columns.len();
        let Integral { reduced, gram, rhs, .. } = integral;
        let known = gram.len();
        gram.extend_from_slice(&self.gram[known..]);
        rhs.extend_from_slice(&self.rhs[known..]);
        for column in self.held_columns().filter(|k| *k >= known) {
            gram[column][column] += 1.0 / self.rows.share;
        }
        let mut square = self.square;
        if let Some(prior) = &integral.prior {
            let Prior { weight, cholesky, w_y, directions } = &**prior;
            let reduce = |k: usize| cholesky.forward(&self.along(directions, k));
            if known == 0 {
                reduced.par_extend((0..count).into_par_iter().map(reduce));
                let matrix = Mat::from_fn(directions.len(), count, |i, j| reduced[j][i]);
                let correction = matrix.transpose() * &matrix;
                for (k, row) in gram.iter_mut().enumerate() {
                    for (l, product) in row.iter_mut().enumerate() {
                        *product -= weight * correction[(k, l)];
                    }
                }
            } else {
                reduced.extend((known..count).map(reduce));
                for (k, row) in gram.iter_mut().enumerate().skip(known) {
                    for (product, other) in row.iter_mut().zip(reduced.iter()) {
                        *product -= weight * dot(&reduced[k], other);
                    }
                }
            }
            let reduced_y = cholesky.forward(w_y);
            for (product, reduced) in rhs.iter_mut().zip(reduced.iter()).skip(known) {
                *product -= weight * dot(reduced, &reduced_y);
            }
            square -= weight * dot(&reduced_y, &reduced_y);
        }
        let norm = (0..count).map(|k| gram[k][k].max(f64::MIN_POSITIVE).sqrt()).collect();
        Whitened {
            problem: self,
            scale: integral.scale,
            wide: integral.wide.clone(),
            gram: gram.clone(),
            rhs: rhs.clone(),
            square,
            effective_rows: self.rows.effective(),
            log_determinant: integral.log_determinant,
            norm,
            prior: integral.prior.clone(),
            of_size_one: self.columns_of_size_one().collect(),
        }
    }

    /// Columns whose coefficients have a prior of deviation 1: directions of a description that a stretch of the
    /// recordings does not visit stay at nothing there.
    fn held_columns(&self) -> impl Iterator<Item = usize> {
        let described = |group: &&Group| matches!(group.meaning, Meaning::SmoothDirections(_));
        self.groups.iter().filter(described).flat_map(|group| group.columns.iter().copied())
    }

    /// Columns whose coefficient is 1.
    fn columns_of_size_one(&self) -> impl Iterator<Item = usize> {
        self.groups.iter().filter(|group| group.is_of_size_one).map(|group| group.columns[0])
    }

    /// What it costs, as a change between two recordings, that a group seldom comes about.
    pub(crate) fn price_of_onset(&self, group: &Group) -> f64 {
        let onset = match group.meaning {
            Meaning::Law(slug) => effect(slug).map_or(Onset::Seldom, |law| law.onset()),
            Meaning::SmoothDirections(_) => Onset::Seldom,
        };
        let of_last_link =
            group.site.joints.last() == self.background.links.checked_sub(1).as_ref();
        match onset {
            Onset::OftenOfLastLink if of_last_link => 0.0,
            Onset::Often => 0.0,
            Onset::OftenOfLastLink | Onset::Seldom => PRICE_OF_SELDOM,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flexible::SmoothDirections;
    use crate::problem::{Background, Site};
    use crate::rows::Rows;
    use armident_model::SmoothBasis;
    use armident_motion::BAND_HZ;
    use armident_motion::Signals;
    use armident_recording::{JointChannels, Recording};

    /// A hinge that swings for 10 s.
    fn swinging() -> Rows {
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) / 200.0).collect();
        let position = Some(time.iter().map(|t| (3.0 * t).sin()).collect());
        let joint = JointChannels { position, ..JointChannels::new("hinge") };
        let recording = Recording::new("made", time, vec![joint]).unwrap();
        let signals = Signals::below(&recording, &["hinge".to_owned()], BAND_HZ).unwrap();
        Rows::new(&[signals], &[vec![vec![1.0]]])
    }

    fn group(meaning: Meaning, columns: Vec<usize>) -> Group {
        Group {
            meaning,
            site: Site::default(),
            shape: Vec::new(),
            columns,
            searched: 0,
            places: Vec::new(),
            transform: None,
            hidden: Vec::new(),
            above_band: 1.0,
            is_of_size_one: false,
        }
    }

    /// A column whose coefficient is 1 is taken from the efforts, and all others are fitted to the rest.
    #[test]
    fn what_has_size_one_is_taken_from_the_efforts() {
        let rows = swinging();
        let along = |of: &dyn Fn(f64) -> f64| -> Blocks {
            vec![(0..rows.len()).map(|row| of(row as f64)).collect()]
        };
        let columns = vec![
            along(&|x| (0.1 * x).sin()),
            along(&|x| (0.13 * x).cos()),
            along(&|x| (0.07 * x).sin()),
        ];
        let effort = along(&|x| 2.0 * (0.1 * x).sin() + 0.3 * (0.13 * x).cos() + (0.11 * x).sin());
        let rest: Blocks =
            vec![effort[0].iter().zip(&columns[0][0]).map(|(effort, one)| effort - one).collect()];
        let problem = |effort: &Blocks| {
            let mut problem =
                Problem::new(rows.clone(), effort.clone(), Vec::new(), Background::default());
            problem.push_columns(columns.clone());
            for column in 0..columns.len() {
                problem.groups.push(group(Meaning::Law("viscous_friction"), vec![column]));
            }
            problem
        };
        let mut fixed = problem(&effort);
        fixed.groups[0].is_of_size_one = true;
        let fixed = fixed.whitened(0.0, &[]);
        let fit = fixed.fit(vec![0, 1]).unwrap();
        let expected = problem(&rest);
        let expected = expected.whitened(0.0, &[]);
        let of_rest = expected.fit(vec![1]).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs().max(1.0);
        assert_eq!(fit.coefficient(0), 1.0);
        assert!(near(fit.coefficient(1), of_rest.coefficient(1)));
        assert!(near(fit.sum_of_squares, of_rest.sum_of_squares));
        assert!(near(fixed.gain(&fit, &[2]), expected.gain(&of_rest, &[2])));
        assert_eq!(fixed.covariance(&fit, &[0, 1])[0], [0.0, 0.0]);
        // nor does a column of nothing have a coefficient or scatter
        let mut idle = problem(&effort);
        let first = idle.push_columns(vec![vec![Vec::new()]]);
        idle.groups.push(group(Meaning::Law("viscous_friction"), vec![first]));
        let idle = idle.whitened(0.0, &[]);
        let of_idle = idle.fit(vec![0, first]).unwrap();
        assert_eq!(of_idle.coefficient(first), 0.0);
        let covariance = idle.covariance(&of_idle, &[0, first]);
        assert!(covariance[0][0] > 0.0 && covariance[0][1] == 0.0 && covariance[1] == [0.0, 0.0]);
        let (left, left_of_rest) = (fixed.residual(&fit), expected.residual(&of_rest));
        assert!(left[0].iter().zip(&left_of_rest[0]).all(|(a, b)| near(*a, *b)));
    }

    /// Two directions of a description that a stretch can hardly tell apart stay within their prior there; columns of
    /// a law, which have none, do not.
    #[test]
    fn descriptions_stay_near_nothing_where_nothing_shows_them() {
        let rows = swinging();
        let along = |of: &dyn Fn(f64) -> f64| -> Blocks {
            vec![(0..rows.len()).map(|row| of(row as f64)).collect()]
        };
        let effort = along(&|x| (7.3 * x * x).sin());
        let largest = |meaning: Meaning| {
            let mut problem =
                Problem::new(rows.clone(), effort.clone(), Vec::new(), Background::default());
            let first = problem.push_columns(vec![
                along(&|x| (0.1 * x).sin()),
                along(&|x| (0.1 * x).sin() + 1e-3 * (0.37 * x).cos()),
            ]);
            problem.groups.push(group(meaning, vec![first, first + 1]));
            let metric = problem.whitened(0.0, &[]);
            let fit = metric.fit(metric.columns_of(&[0])).unwrap();
            fit.coefficients.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
        };
        let basis = SmoothBasis { factors: Vec::new(), axes: Vec::new() };
        let described =
            largest(Meaning::SmoothDirections(SmoothDirections { basis, transform: Vec::new() }));
        assert!(described < 3.0, "{described}");
        let of_law = largest(Meaning::Law("viscous_friction"));
        assert!(of_law > 10.0, "{of_law}");
    }
}
