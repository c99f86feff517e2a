//! How visible an effect is beside what a fit explains otherwise.

use armident_dynamics::{ParameterColumns, RigidArm};
use armident_effects::Baseline;
use nalgebra::{DMatrix, DVector};

use crate::cases::exact_motion::{Exact, rms};

/// Samples per second that are looked at.
const RATE_HZ: f64 = 40.0;
/// Of the normal equations, relative: base parameters are fewer than columns.
const RIDGE: f64 = 1e-9;

/// Baseline terms whose columns may be projected out, in their order on each joint.
const TERMS: [Baseline; 3] = [Baseline::Viscous, Baseline::Coulomb, Baseline::Offset];

/// Motions with their columns over noise.
pub(crate) struct Observer {
    sigma: Vec<f64>,
    /// Rows of each joint, one joint after another.
    rows: usize,
    columns: Vec<Vec<f64>>,
    norms: Vec<f64>,
    gram: DMatrix<f64>,
    dof: usize,
    strides: Vec<usize>,
}

/// What is projected out.
pub(crate) struct Projection {
    pub(crate) base: bool,
    /// Which baseline terms, by joint.
    pub(crate) plain: Box<dyn Fn(usize, Baseline) -> bool>,
}

impl Observer {
    pub(crate) fn new(arm: &RigidArm, motions: &[&Exact], sigma: &[f64]) -> Self {
        let n = arm.dof();
        let strides: Vec<usize> = motions
            .iter()
            .map(|motion| {
                let rate = motion.time_s.len() as f64 / motion.time_s.last().unwrap_or(&1.0);
                ((rate / RATE_HZ).round() as usize).max(1)
            })
            .collect();
        let thin = |columns: &[Vec<f64>], stride: usize| -> Vec<Vec<f64>> {
            columns.iter().map(|c| c.iter().copied().step_by(stride).collect()).collect()
        };
        let parameters = ParameterColumns::standard(n);
        let wanted: Vec<usize> = (0..10 * n).collect();
        let mut columns = vec![Vec::new(); 13 * n];
        for joint in 0..n {
            for (motion, &stride) in motions.iter().zip(&strides) {
                let q = thin(&motion.position, stride);
                let v = thin(&motion.velocity, stride);
                let a = thin(&motion.acceleration, stride);
                let rigid = parameters.of_motion(arm, joint, &q, &v, &a, &wanted);
                for (column, values) in columns.iter_mut().zip(&rigid) {
                    column.extend(values.iter().map(|x| x / sigma[joint]));
                }
                let speed = &v[joint];
                for other in 0..n {
                    let own = f64::from(u8::from(other == joint)) / sigma[joint];
                    let at = 10 * n + 3 * other;
                    columns[at].extend(speed.iter().map(|v| own * v));
                    columns[at + 1].extend(speed.iter().map(|v| own * sign(*v)));
                    columns[at + 2].extend(speed.iter().map(|_| own));
                }
            }
        }
        let rows = columns[0].len() / n;
        let norms: Vec<f64> = columns
            .iter()
            .map(|c| c.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE))
            .collect();
        for (column, norm) in columns.iter_mut().zip(&norms) {
            column.iter_mut().for_each(|x| *x /= norm);
        }
        let gram = DMatrix::from_fn(columns.len(), columns.len(), |a, b| {
            if a > b { 0.0 } else { dot(&columns[a], &columns[b]) }
        });
        let gram =
            DMatrix::from_fn(columns.len(), columns.len(), |a, b| gram[(a.min(b), a.max(b))]);
        Self { sigma: sigma.to_vec(), rows, columns, norms, gram, dof: n, strides }
    }

    /// A torque of the same motions, joint-major in each, over noise on the rows.
    pub(crate) fn rows_of(&self, torque: &[Vec<Vec<f64>>]) -> Vec<f64> {
        let mut rows = Vec::with_capacity(self.rows * self.dof);
        for joint in 0..self.dof {
            for (motion, &stride) in torque.iter().zip(&self.strides) {
                rows.extend(motion[joint].iter().step_by(stride).map(|x| x / self.sigma[joint]));
            }
        }
        rows
    }

    /// Which rows a mark at the samples of each motion picks.
    pub(crate) fn mask_of(&self, marks: &[Vec<f64>]) -> Vec<bool> {
        let thinned = marks.iter().zip(&self.strides);
        thinned.flat_map(|(m, &stride)| m.iter().step_by(stride).map(|m| *m > 0.0)).collect()
    }

    /// Residual of a torque after a projection, on the most affected joint: RMS over noise. With
    /// `active`, over these rows of each joint.
    pub(crate) fn visible(
        &self,
        torque: &[f64],
        projection: &Projection,
        active: Option<&[bool]>,
    ) -> f64 {
        let chosen: Vec<usize> = (0..self.columns.len())
            .filter(|&c| {
                if c < 10 * self.dof {
                    return projection.base;
                }
                let (joint, which) = ((c - 10 * self.dof) / 3, (c - 10 * self.dof) % 3);
                (projection.plain)(joint, TERMS[which])
            })
            .filter(|&c| self.norms[c] > 1e-9)
            .collect();
        let left = self.left_of(torque, &chosen);
        self.largest(&left, active)
    }

    fn left_of(&self, torque: &[f64], chosen: &[usize]) -> Vec<f64> {
        let mut left = torque.to_vec();
        if chosen.is_empty() {
            return left;
        }
        let mut gram = self.gram.select_rows(chosen).select_columns(chosen);
        for k in 0..chosen.len() {
            gram[(k, k)] += RIDGE;
        }
        let right = chosen.iter().map(|&c| dot(&self.columns[c], torque));
        let right = DVector::from_iterator(chosen.len(), right);
        if let Some(factor) = gram.cholesky() {
            for (&c, by) in chosen.iter().zip(&factor.solve(&right)) {
                left.iter_mut().zip(&self.columns[c]).for_each(|(l, x)| *l -= by * x);
            }
        }
        left
    }

    /// RMS of the rows of each joint, the largest.
    fn largest(&self, rows: &[f64], active: Option<&[bool]>) -> f64 {
        let of_joint = |rows: &[f64]| {
            let counted = |k: usize| active.is_none_or(|active| active[k]);
            let counted: Vec<f64> =
                rows.iter().enumerate().filter(|(k, _)| counted(*k)).map(|(_, x)| *x).collect();
            rms(&counted)
        };
        rows.chunks(self.rows.max(1)).map(of_joint).fold(0.0, f64::max)
    }

    /// Share over noise that columns of another law leave of a torque, on the most affected joint.
    pub(crate) fn unexplained(&self, torque: &[f64], columns: &[Vec<f64>]) -> f64 {
        let norm = |c: &Vec<f64>| dot(c, c).sqrt().max(f64::MIN_POSITIVE);
        let columns: Vec<Vec<f64>> = columns
            .iter()
            .map(|c| {
                let norm = norm(c);
                c.iter().map(|x| x / norm).collect()
            })
            .collect();
        let count = columns.len();
        let gram = DMatrix::from_fn(count, count, |a, b| {
            dot(&columns[a], &columns[b]) + if a == b { RIDGE } else { 0.0 }
        });
        let right = DVector::from_iterator(count, columns.iter().map(|c| dot(c, torque)));
        let mut left = torque.to_vec();
        if let Some(factor) = gram.cholesky() {
            for (column, by) in columns.iter().zip(&factor.solve(&right)) {
                left.iter_mut().zip(column).for_each(|(l, x)| *l -= by * x);
            }
        }
        self.largest(&left, None)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}
