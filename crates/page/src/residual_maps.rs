//! Where in the motion residuals lie.

use crate::drawing::Map;
use crate::reduce::{rounded, rounded_some};
use crate::sheet::Sheet;

const POSITIONS: usize = 28;
const SPEEDS: usize = 17;
const LOADS: usize = 21;
const TIMES: usize = 60;
/// Samples that a cell needs.
const LEAST_SAMPLES: usize = 4;
/// Speeds below this share of the largest are rest.
const REST: f64 = 0.02;

/// Equal classes from the smallest to the largest value.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Classes {
    from: f64,
    width: f64,
    pub(crate) count: usize,
}

impl Classes {
    pub(crate) fn between(from: f64, to: f64, count: usize) -> Self {
        let width = if to > from { (to - from) / count as f64 } else { 1.0 };
        Self { from, width, count }
    }

    pub(crate) fn of<'a>(values: impl Iterator<Item = &'a f64>, count: usize) -> Self {
        let (from, to) = values.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
        Self::between(from, to, count)
    }

    pub(crate) fn class(&self, x: f64) -> usize {
        (((x - self.from) / self.width).max(0.0) as usize).min(self.count - 1)
    }

    /// Ends of a class.
    fn ends(&self, class: usize) -> [f64; 2] {
        [class, class + 1].map(|k| self.from + k as f64 * self.width)
    }

    pub(crate) fn middles(&self) -> Vec<f64> {
        rounded(
            &(0..self.count)
                .map(|k| self.from + (k as f64 + 0.5) * self.width)
                .collect::<Vec<f64>>(),
        )
    }
}

/// Abscissa and ordinate of a sample of a sheet.
type Place = dyn Fn(&Sheet, usize) -> (f64, f64);

/// Cells of a map of one joint, and the place of a sample in it.
pub(crate) struct Cells {
    joint: usize,
    columns: Classes,
    rows: Classes,
    place: Box<Place>,
}

impl Cells {
    /// Number of the cell of a sample, row by row.
    fn cell(&self, sheet: &Sheet, k: usize) -> usize {
        let (x, y) = (self.place)(sheet, k);
        self.rows.class(y) * self.columns.count + self.columns.class(x)
    }

    /// Samples of a recording that maps sort.
    fn samples(&self, sheet: &Sheet) -> impl Iterator<Item = usize> + use<> {
        let recorded = sheet.measured[self.joint].len();
        sheet.kept.clone().take_while(move |k| *k < recorded)
    }

    /// Mean residual of each model.
    pub(crate) fn mean_residuals(&self, sheets: &[&Sheet]) -> Map {
        let models = sheets.first().map_or(0, |s| s.residual.len());
        let cells = self.columns.count * self.rows.count;
        let mut sums = vec![vec![0.0; cells]; models];
        let mut counts = vec![0_usize; cells];
        for sheet in sheets {
            for k in self.samples(sheet) {
                let at = self.cell(sheet, k);
                counts[at] += 1;
                for (m, sum) in sums.iter_mut().enumerate() {
                    sum[at] += sheet.residual[m][self.joint][k];
                }
            }
        }
        let values = sums
            .iter()
            .map(|sum| {
                let means: Vec<Option<f64>> = (sum.iter().zip(&counts))
                    .map(|(s, &n)| (n >= LEAST_SAMPLES).then(|| s / n as f64))
                    .collect();
                rounded_some(&means)
                    .chunks(self.columns.count)
                    .map(<[Option<f64>]>::to_vec)
                    .collect()
            })
            .collect();
        Map { x: self.columns.middles(), y: self.rows.middles(), values }
    }

    /// Rectangles \[left, right, bottom, top\] over the cells with a majority of samples in which
    /// `acts` holds; neighbours in a row are one rectangle.
    pub(crate) fn where_most<'s>(
        &self,
        sheets: impl Iterator<Item = (&'s Sheet, &'s dyn Fn(usize) -> bool)>,
    ) -> Vec<[f64; 4]> {
        let cells = self.columns.count * self.rows.count;
        let (mut acting, mut all) = (vec![0_usize; cells], vec![0_usize; cells]);
        for (sheet, acts) in sheets {
            for k in self.samples(sheet) {
                let at = self.cell(sheet, k);
                all[at] += 1;
                acting[at] += usize::from(acts(k));
            }
        }
        let marked = |at: usize| all[at] >= LEAST_SAMPLES && 2 * acting[at] > all[at];
        let mut found = Vec::new();
        for row in 0..self.rows.count {
            let [bottom, top] = self.rows.ends(row);
            let first = row * self.columns.count;
            let mut column = 0;
            while column < self.columns.count {
                let run = (column..self.columns.count).take_while(|c| marked(first + c)).count();
                if run > 0 {
                    let right = self.columns.ends(column + run - 1)[1];
                    let ends = rounded(&[self.columns.ends(column)[0], right, bottom, top]);
                    found.push([ends[0], ends[1], ends[2], ends[3]]);
                }
                column += run.max(1);
            }
        }
        found
    }
}

/// Cells by position (columns) and speed (rows).
pub(crate) fn speed_position(sheets: &[&Sheet], joint: usize) -> Cells {
    let columns = Classes::of(sheets.iter().flat_map(|s| &s.motion.position[joint]), POSITIONS);
    let fastest = fastest(sheets, joint);
    let rows = Classes::between(-fastest, fastest, SPEEDS);
    let place = Box::new(move |s: &Sheet, k: usize| {
        (s.motion.position[joint][k], s.motion.velocity[joint][k])
    });
    Cells { joint, columns, rows, place }
}

/// Cells by load (columns: effort of the last model) and direction of motion (rows: -1 backward, 0 at
/// rest, 1 forward).
pub(crate) fn load_direction(sheets: &[&Sheet], joint: usize) -> Cells {
    let load = move |s: &Sheet, k: usize| s.predicted.last().map_or(0.0, |p| p[joint][k]);
    let loads = sheets.iter().filter_map(|s| s.predicted.last()).flat_map(|p| &p[joint]);
    let columns = Classes::of(loads, LOADS);
    let rest = REST * fastest(sheets, joint);
    let place = Box::new(move |s: &Sheet, k: usize| {
        let v = s.motion.velocity[joint][k];
        (load(s, k), if v.abs() > rest { v.signum() } else { 0.0 })
    });
    Cells { joint, columns, rows: Classes::between(-1.5, 1.5, 3), place }
}

fn fastest(sheets: &[&Sheet], joint: usize) -> f64 {
    let all = sheets.iter().flat_map(|s| &s.motion.velocity[joint]);
    all.fold(0.0_f64, |m, v| m.max(v.abs())).max(f64::MIN_POSITIVE)
}

/// Root mean square residual by time over all recordings, one after the other; one row a model.
pub(crate) fn time(sheets: &[&Sheet], joint: usize) -> Map {
    let models = sheets.first().map_or(0, |s| s.residual.len());
    let total: f64 = sheets.iter().map(|s| s.motion.len() as f64 / s.motion.rate_hz).sum();
    let classes = Classes::between(0.0, total, TIMES);
    let mut squares = vec![vec![0.0; TIMES]; models];
    let mut counts = vec![0_usize; TIMES];
    let mut before = 0.0;
    for sheet in sheets {
        for k in sheet.kept.clone().take_while(|k| *k < sheet.measured[joint].len()) {
            let at = classes.class(before + k as f64 / sheet.motion.rate_hz);
            counts[at] += 1;
            for (m, squares) in squares.iter_mut().enumerate() {
                squares[at] += sheet.residual[m][joint][k].powi(2);
            }
        }
        before += sheet.motion.len() as f64 / sheet.motion.rate_hz;
    }
    let rows: Vec<Vec<Option<f64>>> = squares
        .iter()
        .map(|row| {
            let rms: Vec<Option<f64>> = (row.iter().zip(&counts))
                .map(|(s, &n)| (n > 0).then(|| (s / n as f64).sqrt()))
                .collect();
            rounded_some(&rms)
        })
        .collect();
    let y = (0..models).map(|m| m as f64).collect();
    Map { x: classes.middles(), y, values: vec![rows] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_hold_their_ends() {
        let classes = Classes::between(-1.0, 1.0, 4);
        assert_eq!([-1.0, -0.6, 0.1, 1.0, 9.0].map(|x| classes.class(x)), [0, 0, 2, 3, 3]);
        assert_eq!(classes.middles(), [-0.75, -0.25, 0.25, 0.75]);
        // one value only
        assert_eq!(Classes::of([2.0, 2.0].iter(), 3).class(2.0), 0);
    }
}
