//! Recordings of one robot in their order, fitted with parameters that all have in common and steps at some recordings.
//!
//! Method: generalised least squares. The information of recordings from the k-th on is summed once for each k, so that a
//! step at any recording is a few products of small matrices.
//!
//! References: W. H. Greene, Econometric Analysis (generalised least squares); the sums are own.

use armident_numeric::{Cholesky, Mat};

use crate::information::{Information, times};

/// Share of the information that is added to the diagonal: what nothing determines stays at 0 and takes part in nothing.
const RIDGE: f64 = 1e-10;

/// A change of the parameters from a recording on, in some directions (columns).
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub(crate) from: usize,
    pub(crate) directions: Mat<f64>,
}

/// Recordings of a robot.
pub(crate) struct Series {
    pub(crate) recordings: Vec<Information>,
    /// Sums from each recording on.
    pub(crate) from: Vec<Information>,
}

/// Parameters and sizes of steps.
pub(crate) struct SeriesFit {
    pub(crate) values: Vec<f64>,
    /// Inverse of the information on parameters and steps.
    pub(crate) covariance: Mat<f64>,
}

impl Series {
    pub(crate) fn new(recordings: Vec<Information>) -> Self {
        let mut from: Vec<Information> = Vec::with_capacity(recordings.len());
        for of in recordings.iter().rev() {
            let sum = match from.last() {
                Some(later) => Information {
                    matrix: &later.matrix + &of.matrix,
                    moment: later.moment.iter().zip(&of.moment).map(|(a, b)| a + b).collect(),
                },
                None => of.clone(),
            };
            from.push(sum);
        }
        from.reverse();
        Self { recordings, from }
    }

    pub(crate) fn len(&self) -> usize {
        self.recordings.len()
    }

    fn parameters(&self) -> usize {
        self.from[0].moment.len()
    }

    /// Least squares with these steps.
    pub(crate) fn fit(&self, steps: &[Step]) -> Option<SeriesFit> {
        let p = self.parameters();
        let sizes: usize = steps.iter().map(|step| step.directions.ncols()).sum();
        let mut matrix = Mat::zeros(p + sizes, p + sizes);
        let mut moment = self.from[0].moment.clone();
        matrix.submatrix_mut(0, 0, p, p).copy_from(&self.from[0].matrix);
        let mut at = p;
        for (index, step) in steps.iter().enumerate() {
            let with = &self.from[step.from].matrix * &step.directions;
            moment.extend(
                (0..step.directions.ncols())
                    .map(|c| dot_column(&step.directions, c, &self.from[step.from].moment)),
            );
            put(&mut matrix, 0, at, &with);
            let mut other_at = p;
            for other in &steps[..=index] {
                let later = step.from.max(other.from);
                let products =
                    other.directions.transpose() * &(&self.from[later].matrix * &step.directions);
                put(&mut matrix, other_at, at, &products);
                other_at += other.directions.ncols();
            }
            at += step.directions.ncols();
        }
        let mean = (0..p + sizes).map(|k| matrix[(k, k)]).sum::<f64>() / (p + sizes) as f64;
        let ridge = RIDGE * mean + f64::MIN_POSITIVE.sqrt();
        let factor =
            Cholesky::of(p + sizes, |i, j| matrix[(i, j)] + if i == j { ridge } else { 0.0 })?;
        Some(SeriesFit { values: factor.solve(&moment), covariance: factor.inverse() })
    }

    /// Information that a step from a recording on in these directions adds beyond a fit, and its score.
    pub(crate) fn score(
        &self,
        fit: &SeriesFit,
        steps: &[Step],
        from: usize,
        directions: &Mat<f64>,
    ) -> StepScore {
        let p = self.parameters();
        let own = &self.from[from].matrix * directions;
        let all = fit.values.len();
        let mut with = Mat::zeros(all, directions.ncols());
        with.submatrix_mut(0, 0, p, directions.ncols()).copy_from(&own);
        let mut at = p;
        let mut residual = self.from[from].moment.clone();
        subtract(&mut residual, &times(&self.from[from].matrix, &fit.values[..p]));
        for step in steps {
            let later = &self.from[from.max(step.from)].matrix;
            let sizes = step.directions.ncols();
            let products = step.directions.transpose() * &(later * directions);
            with.submatrix_mut(at, 0, sizes, directions.ncols()).copy_from(&products);
            let change = times(&step.directions, &fit.values[at..at + sizes]);
            subtract(&mut residual, &times(later, &change));
            at += sizes;
        }
        let information =
            directions.transpose() * &own - with.transpose() * &(&fit.covariance * &with);
        let moment =
            (0..directions.ncols()).map(|c| dot_column(directions, c, &residual)).collect();
        StepScore { information, moment }
    }

    /// The parameters at a recording.
    pub(crate) fn values_at(&self, fit: &SeriesFit, steps: &[Step], index: usize) -> Vec<f64> {
        let p = self.parameters();
        let mut values = fit.values[..p].to_vec();
        let mut at = p;
        for step in steps {
            let sizes = step.directions.ncols();
            if index >= step.from {
                let change = times(&step.directions, &fit.values[at..at + sizes]);
                values.iter_mut().zip(change).for_each(|(x, change)| *x += change);
            }
            at += sizes;
        }
        values
    }

    /// Score of one recording at these values.
    pub(crate) fn residual(&self, index: usize, values: &[f64]) -> Vec<f64> {
        let of = &self.recordings[index];
        let mut residual = of.moment.clone();
        subtract(&mut residual, &times(&of.matrix, values));
        residual
    }
}

/// Information on the sizes of a step, all else fitted, and the score of no step.
pub(crate) struct StepScore {
    pub(crate) information: Mat<f64>,
    pub(crate) moment: Vec<f64>,
}

fn put(matrix: &mut Mat<f64>, row: usize, column: usize, block: &Mat<f64>) {
    for i in 0..block.nrows() {
        for j in 0..block.ncols() {
            matrix[(row + i, column + j)] = block[(i, j)];
            matrix[(column + j, row + i)] = block[(i, j)];
        }
    }
}

fn dot_column(matrix: &Mat<f64>, column: usize, x: &[f64]) -> f64 {
    x.iter().enumerate().map(|(i, x)| matrix[(i, column)] * x).sum()
}

fn subtract(from: &mut [f64], x: &[f64]) {
    from.iter_mut().zip(x).for_each(|(from, x)| *from -= x);
}
