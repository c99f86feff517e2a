//! A description of structure that no law of the library explains: hat functions of one or two
//! variables, smooth unless the recordings insist. It predicts; it does not explain.

use armident_effects::Role;
use armident_numeric::{Cholesky, Mat, dot, gram_of_columns, symmetric_eigen};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::at::At;
use crate::evidence::Evidence;
use crate::problem::{Group, Meaning, Problem, Site};

/// Knots along the joint's own position, its own velocity, and along each axis of products.
const POSITION_KNOTS: usize = 64;
const VELOCITY_KNOTS: usize = 21;
const FACTOR_KNOTS: usize = 16;
const PLANE_KNOTS: usize = 8;
/// Speeds at which a saturating factor turns, over the root mean square speed.
const TURNS: [f64; 5] = [0.5, 0.7, 1.0, 1.4, 2.0];
/// Share of the range by which the knots reach beyond what training visited.
const MARGIN: f64 = 0.1;
/// Second differences of the coefficients, over the effort that is to be described: deviation of the
/// prior; and how many times weaker the coefficients themselves are held.
const ROUGHNESS: f64 = 2.0;
const LEVEL_OVER_ROUGHNESS: f64 = 10.0;
/// Most directions of a description.
const MOST_DIRECTIONS: usize = 40;
/// Descriptions offered to the search for one joint.
const OFFERED: usize = 2;

/// A recorded quantity of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Position.
    Position,
    /// Velocity.
    Velocity,
}

/// Knots along a quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Joint.
    pub joint: String,
    /// Quantity of the joint.
    pub quantity: Quantity,
    /// First and last knot.
    pub range: [f64; 2],
    /// Number of knots.
    pub knots: usize,
}

/// A function of a joint's velocity that multiplies the hats.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Factor {
    /// Joint.
    pub joint: String,
    /// Form.
    pub form: Form,
    /// Speed at which a saturating form turns \[rad/s or m/s\].
    pub scale: f64,
}

/// Forms of a [`Factor`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// `v`
    Linear,
    /// `v |v|`
    SignedSquare,
    /// `v³`
    Cube,
    /// `v / (1 + (v / scale)²)`
    Saturating,
    /// `|v|`
    Size,
    /// `v²`
    Square,
    /// Direction of motion, `sign(v)`, bridged where the joint stops.
    Direction,
}

impl Factor {
    fn value(&self, v: f64, direction: f64) -> f64 {
        match self.form {
            Form::Direction => direction,
            Form::Linear => v,
            Form::SignedSquare => v * v.abs(),
            Form::Cube => v * v * v,
            Form::Saturating => v / (1.0 + (v / self.scale).powi(2)),
            Form::Size => v.abs(),
            Form::Square => v * v,
        }
    }
}

/// Products of factors and hats.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Basis {
    /// Factors.
    pub factors: Vec<Factor>,
    /// Axes of hats: none, one, or two.
    pub axes: Vec<Axis>,
}

/// A flexible description in the search: its basis, and the coefficients of the hats from those of the
/// columns, `[column][hat]`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Flexible {
    pub(crate) basis: Basis,
    pub(crate) transform: Vec<Vec<f64>>,
}

/// A flexible description with its numbers, as a model file holds it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FlexibleTerm {
    /// Joint whose effort it describes.
    pub joint: String,
    /// Functions.
    pub basis: Basis,
    /// Their coefficients \[N m or N over the unit of the factors\].
    pub coefficients: Vec<f64>,
}

impl FlexibleTerm {
    /// Whether there is a coefficient for every function, and knots for every axis.
    pub(crate) fn is_whole(&self) -> bool {
        let axes = &self.basis.axes;
        let spans = |axis: &Axis| {
            let [first, last] = axis.range;
            axis.knots >= 2 && first < last && (last - first).is_finite()
        };
        let size = axes.iter().try_fold(1_usize, |size, axis| size.checked_mul(axis.knots));
        axes.len() <= 2 && axes.iter().all(spans) && size == Some(self.coefficients.len())
    }

    /// Over a motion; joints that are not there count as resting at 0.
    pub(crate) fn effort(&self, at: &At<'_>, index: impl Fn(&str) -> Option<usize>) -> Vec<f64> {
        let hats = self.basis.hats(at, &index);
        let value = |there: &[(usize, f64)]| {
            there.iter().map(|(function, weight)| self.coefficients[*function] * weight).sum()
        };
        hats.chunks_exact(self.basis.overlap()).map(value).collect()
    }
}

impl Basis {
    /// Names of the recorded columns it depends on.
    pub(crate) fn variables(&self) -> Vec<String> {
        let mut names: Vec<String> = self
            .axes
            .iter()
            .map(|axis| match axis.quantity {
                Quantity::Position => format!("{}/position", axis.joint),
                Quantity::Velocity => format!("{}/velocity", axis.joint),
            })
            .chain(self.factors.iter().map(|f| format!("{}/velocity", f.joint)))
            .collect();
        names.sort();
        names.dedup();
        names
    }

    /// Places of the laws that these functions contain on their joint: beside the description these
    /// cannot be told apart.
    fn places(&self, joint: &str) -> Vec<Role> {
        let mut places = vec![Role::Unnamed];
        let own = |name: &str| name == joint;
        if self.axes.iter().any(|a| own(&a.joint) && a.quantity == Quantity::Velocity) {
            places.extend([Role::Viscous, Role::Dry, Role::Drag]);
        }
        if let ([factor], false) = (&self.factors[..], self.axes.is_empty()) {
            match factor.form {
                Form::Linear if own(&factor.joint) => places.push(Role::Viscous),
                Form::SignedSquare if own(&factor.joint) => places.push(Role::Drag),
                Form::Direction if own(&factor.joint) => places.push(Role::Dry),
                _ => {}
            }
        }
        places
    }

    /// The same with factors that saturate at speeds between those of the candidates.
    fn turning_beside(&self) -> Vec<Self> {
        const BESIDE: [f64; 4] = [0.86, 0.93, 1.08, 1.17];
        if self.factors.iter().all(|f| f.form != Form::Saturating) {
            return Vec::new();
        }
        BESIDE
            .map(|by| {
                let mut basis = self.clone();
                for factor in basis.factors.iter_mut().filter(|f| f.form == Form::Saturating) {
                    factor.scale *= by;
                }
                basis
            })
            .to_vec()
    }

    /// Number of functions.
    fn size(&self) -> usize {
        self.axes.iter().map(|a| a.knots).product()
    }

    /// Product of the factors over a motion; joints that are not there rest.
    fn factor_values(&self, at: &At<'_>, index: &impl Fn(&str) -> Option<usize>) -> Vec<f64> {
        let mut product = vec![1.0; at.signals.len()];
        for factor in &self.factors {
            let joint = index(&factor.joint);
            for (t, p) in product.iter_mut().enumerate() {
                let of = |values: &[Vec<f64>]| joint.map_or(0.0, |j| values[j][t]);
                *p *= factor.value(of(&at.signals.velocity), of(&at.signals.direction));
            }
        }
        product
    }

    /// How many functions are not zero at a sample: hats overlap in pairs along each axis.
    fn overlap(&self) -> usize {
        1 << self.axes.len()
    }

    /// The functions that are not zero and their values, [`Self::overlap`] a sample.
    fn hats(&self, at: &At<'_>, index: &impl Fn(&str) -> Option<usize>) -> Vec<(usize, f64)> {
        let axes: Vec<Option<&[f64]>> = self
            .axes
            .iter()
            .map(|axis| {
                index(&axis.joint).map(|j| match axis.quantity {
                    Quantity::Position => at.position[j].as_slice(),
                    Quantity::Velocity => at.signals.velocity[j].as_slice(),
                })
            })
            .collect();
        let factors = self.factor_values(at, index);
        let mut hats = Vec::with_capacity(factors.len() * self.overlap());
        for (t, factor) in factors.into_iter().enumerate() {
            let first = hats.len();
            hats.push((0, factor));
            for (axis, values) in self.axes.iter().zip(&axes) {
                let span = (axis.knots - 1) as f64;
                let x = (values.map_or(0.0, |v| v[t]) - axis.range[0])
                    / (axis.range[1] - axis.range[0])
                    * span;
                let x = x.clamp(0.0, span);
                let left = (x.floor() as usize).min(axis.knots - 2);
                let share = x - left as f64;
                for k in first..hats.len() {
                    let (cell, weight) = hats[k];
                    hats[k] = (cell * axis.knots + left, weight * (1.0 - share));
                    hats.push((cell * axis.knots + left + 1, weight * share));
                }
            }
        }
        hats
    }

    /// `P`: squared second differences along every axis, and a weak hold on the coefficients.
    fn penalty(&self) -> Mat<f64> {
        let size = self.size();
        let hold = 1.0 / (LEVEL_OVER_ROUGHNESS * LEVEL_OVER_ROUGHNESS);
        let mut penalty = Mat::from_fn(size, size, |i, j| if i == j { hold } else { 0.0 });
        let mut stride = size;
        for axis in &self.axes {
            stride /= axis.knots;
            for start in 0..size {
                let place = start / stride % axis.knots;
                if place + 2 >= axis.knots {
                    continue;
                }
                let difference = [(start, 1.0), (start + stride, -2.0), (start + 2 * stride, 1.0)];
                for (a, x) in difference {
                    for (b, y) in difference {
                        penalty[(a, b)] += x * y;
                    }
                }
            }
        }
        penalty
    }
}

/// Adds the two best flexible descriptions of what a joint leaves over; gives their ids.
pub(crate) fn offer(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    problem: &mut Problem,
    joint: usize,
    residual: &[f64],
) -> Vec<usize> {
    let size = problem.rows.in_sample_noise(joint, residual) * problem.rows.sample_deviation[joint];
    let beside = beside(evidence, at, joint);
    let samples = residual.len() as f64 * problem.rows.share;
    let judged = |basis: Basis| -> Option<(f64, Flexible)> {
        let (flexible, left) = fitted(evidence, at, joint, basis, size, &beside, residual)?;
        let columns = flexible.transform.len();
        // a description length
        Some((samples * left.ln() + samples.ln() * columns as f64, flexible))
    };
    let mut found: Vec<_> =
        candidates(evidence, at, joint).into_par_iter().filter_map(judged).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(OFFERED);
    for best in &mut found {
        let closer = best.1.basis.turning_beside().into_iter().filter_map(judged);
        if let Some(closer) = closer.min_by(|a, b| a.0.total_cmp(&b.0))
            && closer.0 < best.0
        {
            *best = closer;
        }
    }
    found
        .into_iter()
        .map(|(_, flexible)| recreate(evidence, at, problem, joint, &flexible))
        .collect()
}

/// Adds a description to a problem; gives its id.
pub(crate) fn recreate(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    problem: &mut Problem,
    joint: usize,
    flexible: &Flexible,
) -> usize {
    let rows = rows_of(evidence, at, joint, &flexible.basis);
    let ids = flexible
        .transform
        .iter()
        .map(|transform| {
            let mut blocks = vec![Vec::new(); problem.rows.joints()];
            blocks[joint] = combined(&rows, transform);
            problem.push_columns(vec![blocks])
        })
        .collect();
    problem.groups.push(Group {
        meaning: Meaning::Flexible(flexible.clone()),
        site: Site { joints: vec![joint], window: None },
        shape: Vec::new(),
        columns: ids,
        searched: 2,
        places: flexible.basis.places(&evidence.names[joint]),
        transform: None,
        hidden: Vec::new(),
        above_band: 1.0,
        is_of_size_one: false,
    });
    problem.groups.len() - 1
}

/// What the plain terms of the joint explain anyway: they are fitted beside every description.
fn beside(evidence: &Evidence<'_>, at: &[At<'_>], joint: usize) -> Vec<Vec<f64>> {
    let form = |of: &dyn Fn(&At<'_>) -> Vec<f64>| {
        let pieces: Vec<Vec<f64>> = at.iter().map(of).collect();
        evidence.rows.form_law(&evidence.signals, joint, pieces.iter().map(Vec::as_slice))
    };
    vec![
        form(&|at| at.signals.velocity[joint].clone()),
        form(&|at| at.signals.direction[joint].clone()),
        form(&|at| vec![1.0; at.signals.len()]),
        form(&|at| at.signals.acceleration[joint].clone()),
        form(&|at| at.position[joint].clone()),
    ]
}

fn candidates(evidence: &Evidence<'_>, at: &[At<'_>], joint: usize) -> Vec<Basis> {
    let name = |j: usize| evidence.names[j].clone();
    let axis = |j: usize, quantity: Quantity, knots: usize| {
        let values = at.iter().flat_map(|at| match quantity {
            Quantity::Position => at.position[j].iter(),
            Quantity::Velocity => at.signals.velocity[j].iter(),
        });
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        let margin = MARGIN * (high - low).max(f64::MIN_POSITIVE);
        Axis { joint: name(j), quantity, range: [low - margin, high + margin], knots }
    };
    let turning = |j: usize, form: Form, turn: f64| Factor {
        joint: name(j),
        form,
        scale: turn * evidence.scale[j].speed_rms,
    };
    let factor = |j: usize, form: Form| turning(j, form, 1.0);
    let moves = |j: usize| {
        let axis = axis(j, Quantity::Position, 2);
        axis.range[1] - axis.range[0] > 1e-4
    };
    let others: Vec<usize> = (0..evidence.joints()).filter(|o| *o != joint && moves(*o)).collect();
    let mut bases = vec![
        Basis { factors: Vec::new(), axes: vec![axis(joint, Quantity::Position, POSITION_KNOTS)] },
        Basis { factors: Vec::new(), axes: vec![axis(joint, Quantity::Velocity, VELOCITY_KNOTS)] },
    ];
    // the teeth of a gear or the poles of a motor are felt in its friction too
    for form in [Form::Linear, Form::Direction] {
        bases.push(Basis {
            factors: vec![factor(joint, form)],
            axes: vec![axis(joint, Quantity::Position, POSITION_KNOTS)],
        });
    }
    let plain = [Form::Linear, Form::Direction, Form::SignedSquare, Form::Cube];
    let saturating = TURNS.map(|turn| turning(joint, Form::Saturating, turn));
    for own in plain.map(|form| factor(joint, form)).into_iter().chain(saturating) {
        for along in std::iter::once(joint).chain(others.iter().copied()) {
            bases.push(Basis {
                factors: vec![own.clone()],
                axes: vec![axis(along, Quantity::Position, FACTOR_KNOTS)],
            });
        }
    }
    for &other in &others {
        bases.push(Basis {
            factors: Vec::new(),
            axes: vec![
                axis(joint, Quantity::Position, PLANE_KNOTS),
                axis(other, Quantity::Position, PLANE_KNOTS),
            ],
        });
        for own in [Form::Linear, Form::SignedSquare, Form::Cube] {
            for theirs in [Form::Size, Form::Square, Form::Linear] {
                bases.push(Basis {
                    factors: vec![factor(joint, own), factor(other, theirs)],
                    axes: Vec::new(),
                });
            }
        }
    }
    bases
}

/// Weighted rows of all functions of a basis.
fn rows_of(evidence: &Evidence<'_>, at: &[At<'_>], joint: usize, basis: &Basis) -> Vec<Vec<f64>> {
    let index = |name: &str| evidence.names.iter().position(|n| n == name);
    let mut rows = vec![Vec::with_capacity(evidence.rows.len()); basis.size()];
    for at in at {
        let (hats, overlap) = (basis.hats(at, &index), basis.overlap());
        at.signals.band.rows_of_few(&hats, overlap, &mut rows);
    }
    for rows in &mut rows {
        evidence.rows.weigh_law(joint, rows);
    }
    rows
}

fn combined(rows: &[Vec<f64>], transform: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; rows.first().map_or(0, Vec::len)];
    for (row, t) in rows.iter().zip(transform) {
        for (s, x) in sum.iter_mut().zip(row) {
            *s += t * x;
        }
    }
    sum
}

/// The directions of a basis that the recordings know better than the prior does, and the sum of squares that
/// they and the plain terms leave of a residual.
fn fitted(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    joint: usize,
    basis: Basis,
    effort: f64,
    beside: &[Vec<f64>],
    residual: &[f64],
) -> Option<(Flexible, f64)> {
    let rows = rows_of(evidence, at, joint, &basis);
    let others: Vec<&[f64]> = beside.iter().map(Vec::as_slice).chain([residual]).collect();
    let all: Vec<&[f64]> = others.iter().copied().chain(rows.iter().map(Vec::as_slice)).collect();
    let products = gram_of_columns(&all);
    let transform = known_directions(evidence, at, &basis, effort, &products, others.len())?;
    // the same products of the directions in place of the functions
    let to_directions = Mat::from_fn(all.len(), others.len() + transform.len(), |i, j| {
        match (i.checked_sub(others.len()), j.checked_sub(others.len())) {
            (Some(function), Some(direction)) => transform[direction][function],
            (None, None) => f64::from(u8::from(i == j)),
            _ => 0.0,
        }
    });
    let products = to_directions.transpose() * (&products * &to_directions);
    let left = sum_of_squares_left(&products, beside.len())?;
    Some((Flexible { basis, transform }, left))
}

/// Coefficients of the functions along these directions, largest first; `products` are those of the functions
/// from `first` on.
fn known_directions(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    basis: &Basis,
    effort: f64,
    products: &Mat<f64>,
    first: usize,
) -> Option<Vec<Vec<f64>>> {
    let index = |name: &str| evidence.names.iter().position(|n| n == name);
    let factors: Vec<f64> = at.iter().flat_map(|at| basis.factor_values(at, &index)).collect();
    let factor = (dot(&factors, &factors) / factors.len().max(1) as f64).sqrt();
    let deviation = ROUGHNESS * effort / factor.max(f64::MIN_POSITIVE);
    let (values, vectors) = symmetric_eigen(&basis.penalty()).ok()?;
    let size = basis.size();
    // coefficients = deviation P^(-1/2) z with z of deviation 1
    let smooth =
        Mat::from_fn(size, size, |i, k| vectors[(i, k)] * deviation / values[k].max(1e-12).sqrt());
    let of_functions = products.as_ref().submatrix(first, first, size, size);
    let along = smooth.transpose() * (of_functions * &smooth);
    let (known, directions) = symmetric_eigen(&along).ok()?;
    let kept: Vec<usize> = (0..size)
        .rev()
        .filter(|k| known[*k] * evidence.rows.share > 1.0)
        .take(MOST_DIRECTIONS)
        .collect();
    if kept.is_empty() {
        return None;
    }
    let transform = &smooth * &directions;
    Some(kept.iter().map(|&k| (0..size).map(|i| transform[(i, k)]).collect()).collect())
}

/// What the best description leaves of a residual: its sum of squares over that of the residual, each
/// column paid for with an independent sample. Not more than 1.
pub(crate) fn least_left(
    evidence: &Evidence<'_>,
    at: &[At<'_>],
    joint: usize,
    residual: &[f64],
) -> f64 {
    let rows = &evidence.rows;
    let size = rows.in_sample_noise(joint, residual) * rows.sample_deviation[joint];
    let samples = residual.len() as f64 * rows.share;
    let beside = beside(evidence, at, joint);
    let before = dot(residual, residual).max(f64::MIN_POSITIVE);
    candidates(evidence, at, joint)
        .into_par_iter()
        .filter_map(|basis| {
            let (flexible, left) = fitted(evidence, at, joint, basis, size, &beside, residual)?;
            let free = 1.0 - (beside.len() + flexible.transform.len()) as f64 / samples;
            (free > 0.0).then_some(left / (before * free))
        })
        .reduce(|| 1.0, f64::min)
}

/// From the products of all columns: what all of them leave of the one at `place`.
fn sum_of_squares_left(products: &Mat<f64>, place: usize) -> Option<f64> {
    const HOLD: f64 = 1e-7;
    let columns: Vec<usize> = (0..products.nrows()).filter(|k| *k != place).collect();
    let norm: Vec<f64> =
        columns.iter().map(|&k| products[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let cholesky = Cholesky::of(columns.len(), |i, j| {
        products[(columns[i], columns[j])] / (norm[i] * norm[j]) + if i == j { HOLD } else { 0.0 }
    })?;
    let rhs: Vec<f64> = columns.iter().zip(&norm).map(|(&k, n)| products[(k, place)] / n).collect();
    let reduced = cholesky.forward(&rhs);
    Some((products[(place, place)] - dot(&reduced, &reduced)).max(f64::MIN_POSITIVE))
}
