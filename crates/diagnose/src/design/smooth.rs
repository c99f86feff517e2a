//! A description of structure that no law of the library explains: hat functions of one or two
//! variables, smooth unless the recordings insist. It predicts; it does not explain.

use crate::design::candidate::{Candidate, CandidateKind, Location, SmoothDirections};
use armident_effects::LawRole;
use armident_model::{AxisQuantity, FactorForm, SmoothAxis, SmoothBasis, SpeedFactor};
use armident_numeric::{Cholesky, Mat, dot, gram_of_columns, symmetric_eigen};
use rayon::prelude::*;

use crate::design::compliant_link::Posed;
use crate::design::linear_problem::LinearProblem;
use crate::design::training::Design;

/// Knots along the joint's own position, its own velocity, and along each axis of products.
const POSITION_KNOTS: usize = 64;
const VELOCITY_KNOTS: usize = 21;
const FACTOR_KNOTS: usize = 16;
const PLANE_KNOTS: usize = 8;
/// Speeds at which a saturating factor turns, over the root mean square speed.
const TURNS: [f64; 5] = [0.5, 0.7, 1.0, 1.4, 2.0];
/// Share of the range by which the knots reach beyond the training recordings.
const MARGIN: f64 = 0.1;
/// Second differences of the coefficients, over the effort that is to be described: deviation of the
/// prior; and how many times weaker the coefficients themselves are held.
const ROUGHNESS: f64 = 2.0;
const LEVEL_OVER_ROUGHNESS: f64 = 10.0;
/// Most directions of a smooth term.
const MOST_DIRECTIONS: usize = 40;
/// Smooth terms offered to the search for one joint.
const OFFERED: usize = 2;

/// Roles of the laws that these functions contain on their joint: beside the smooth term these are not distinguishable.
fn places(basis: &SmoothBasis, joint: &str) -> Vec<LawRole> {
    let mut places = vec![LawRole::Unnamed];
    let own = |name: &str| name == joint;
    if basis.axes.iter().any(|a| own(&a.joint) && a.quantity == AxisQuantity::Velocity) {
        places.extend([LawRole::Viscous, LawRole::Dry, LawRole::Drag]);
    }
    if let ([factor], false) = (&basis.factors[..], basis.axes.is_empty()) {
        match factor.form {
            FactorForm::Linear if own(&factor.joint) => places.push(LawRole::Viscous),
            FactorForm::SignedSquare if own(&factor.joint) => places.push(LawRole::Drag),
            FactorForm::Direction if own(&factor.joint) => places.push(LawRole::Dry),
            _ => {}
        }
    }
    places
}

/// The same with factors that saturate at speeds between those of the candidates.
fn turning_beside(basis: &SmoothBasis) -> Vec<SmoothBasis> {
    const BESIDE: [f64; 4] = [0.86, 0.93, 1.08, 1.17];
    if basis.factors.iter().all(|f| f.form != FactorForm::Saturating) {
        return Vec::new();
    }
    BESIDE
        .map(|by| {
            let mut basis = basis.clone();
            for factor in basis.factors.iter_mut().filter(|f| f.form == FactorForm::Saturating) {
                factor.scale *= by;
            }
            basis
        })
        .to_vec()
}

/// `P`: squared second differences along every axis, and a weak hold on the coefficients.
fn penalty(basis: &SmoothBasis) -> Mat<f64> {
    let size = basis.size();
    let hold = 1.0 / (LEVEL_OVER_ROUGHNESS * LEVEL_OVER_ROUGHNESS);
    let mut penalty = Mat::from_fn(size, size, |i, j| if i == j { hold } else { 0.0 });
    let mut stride = size;
    for axis in &basis.axes {
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

/// Adds the two best smooth terms for the residual of a joint; returns their ids.
pub(crate) fn offer(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    joint: usize,
    residual: &[f64],
) -> Vec<usize> {
    let size = problem.observations.in_sample_noise(joint, residual)
        * problem.observations.sample_deviation[joint];
    let beside = beside(design, at, joint);
    let samples = residual.len() as f64 * problem.observations.weights.share;
    let judged = |basis: SmoothBasis| -> Option<(f64, SmoothDirections)> {
        let (flexible, left) = fitted(design, at, joint, basis, size, &beside, residual)?;
        let columns = flexible.transform.len();
        // a description length
        Some((samples * left.ln() + samples.ln() * columns as f64, flexible))
    };
    let mut found: Vec<_> =
        candidates(design, at, joint).into_par_iter().filter_map(judged).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(OFFERED);
    for best in &mut found {
        let closer = turning_beside(&best.1.basis).into_iter().filter_map(judged);
        if let Some(closer) = closer.min_by(|a, b| a.0.total_cmp(&b.0))
            && closer.0 < best.0
        {
            *best = closer;
        }
    }
    found
        .into_iter()
        .map(|(_, flexible)| push_smooth(design, at, problem, joint, &flexible))
        .collect()
}

/// Adds a description to a problem; gives its id.
pub(crate) fn push_smooth(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    joint: usize,
    flexible: &SmoothDirections,
) -> usize {
    let rows = rows_of(design, at, joint, &flexible.basis);
    let ids = flexible
        .transform
        .iter()
        .map(|transform| {
            let mut blocks = vec![Vec::new(); problem.observations.joints()];
            blocks[joint] = combined(&rows, transform);
            problem.push_columns(vec![blocks])
        })
        .collect();
    problem.candidates.push(Candidate {
        kind: CandidateKind::SmoothDirections(flexible.clone()),
        location: Location { joints: vec![joint], window: None },
        shape: Vec::new(),
        columns: ids,
        searched: 2,
        places: places(&flexible.basis, &design.names[joint]),
        transform: None,
        hidden: Vec::new(),
        above_band: 1.0,
        is_of_size_one: false,
    });
    problem.candidates.len() - 1
}

/// Baseline terms of the joint, which are fitted beside every smooth term.
fn beside(design: &Design<'_>, at: &[Posed<'_>], joint: usize) -> Vec<Vec<f64>> {
    let form = |of: &dyn Fn(&Posed<'_>) -> Vec<f64>| {
        let pieces: Vec<Vec<f64>> = at.iter().map(of).collect();
        design.observations.form_law(&design.signals, joint, pieces.iter().map(Vec::as_slice))
    };
    vec![
        form(&|at| at.signals.velocity[joint].clone()),
        form(&|at| at.signals.direction[joint].clone()),
        form(&|at| vec![1.0; at.signals.len()]),
        form(&|at| at.signals.acceleration[joint].clone()),
        form(&|at| at.position[joint].clone()),
    ]
}

fn candidates(design: &Design<'_>, at: &[Posed<'_>], joint: usize) -> Vec<SmoothBasis> {
    let name = |j: usize| design.names[j].clone();
    let axis =
        |j: usize, quantity: AxisQuantity, knots: usize| axis(design, at, j, quantity, knots);
    let fastest: Vec<f64> = (0..design.joints())
        .map(|j| {
            let speeds = at.iter().flat_map(|at| at.signals.velocity[j].iter());
            speeds.fold(0.0_f64, |most, v| most.max(v.abs()))
        })
        .collect();
    let turning = |j: usize, form: FactorForm, turn: f64| SpeedFactor {
        joint: name(j),
        form,
        scale: turn * design.scale[j].speed_rms,
        fastest: Some(fastest[j]),
    };
    let factor = |j: usize, form: FactorForm| turning(j, form, 1.0);
    let moves = |j: usize| {
        let axis = axis(j, AxisQuantity::Position, 2);
        axis.range[1] - axis.range[0] > 1e-4
    };
    let others: Vec<usize> = (0..design.joints()).filter(|o| *o != joint && moves(*o)).collect();
    let mut bases = vec![
        SmoothBasis {
            factors: Vec::new(),
            axes: vec![axis(joint, AxisQuantity::Position, POSITION_KNOTS)],
        },
        SmoothBasis {
            factors: Vec::new(),
            axes: vec![axis(joint, AxisQuantity::Velocity, VELOCITY_KNOTS)],
        },
    ];
    // the teeth of a gear or the poles of a motor are felt in its friction too
    for form in [FactorForm::Linear, FactorForm::Direction] {
        bases.push(SmoothBasis {
            factors: vec![factor(joint, form)],
            axes: vec![axis(joint, AxisQuantity::Position, POSITION_KNOTS)],
        });
    }
    let plain =
        [FactorForm::Linear, FactorForm::Direction, FactorForm::SignedSquare, FactorForm::Cube];
    let saturating = TURNS.map(|turn| turning(joint, FactorForm::Saturating, turn));
    for own in plain.map(|form| factor(joint, form)).into_iter().chain(saturating) {
        for along in std::iter::once(joint).chain(others.iter().copied()) {
            bases.push(SmoothBasis {
                factors: vec![own.clone()],
                axes: vec![axis(along, AxisQuantity::Position, FACTOR_KNOTS)],
            });
        }
    }
    for &other in &others {
        bases.push(SmoothBasis {
            factors: Vec::new(),
            axes: vec![
                axis(joint, AxisQuantity::Position, PLANE_KNOTS),
                axis(other, AxisQuantity::Position, PLANE_KNOTS),
            ],
        });
        for own in [FactorForm::Linear, FactorForm::SignedSquare, FactorForm::Cube] {
            for theirs in [FactorForm::Size, FactorForm::Square, FactorForm::Linear] {
                bases.push(SmoothBasis {
                    factors: vec![factor(joint, own), factor(other, theirs)],
                    axes: Vec::new(),
                });
            }
        }
    }
    bases
}

/// Weighted rows of linear B-splines of the position of a joint over its range.
pub(crate) fn functions_of_position(
    design: &Design<'_>,
    at: &[Posed<'_>],
    joint: usize,
    knots: usize,
) -> Vec<Vec<f64>> {
    let axis = axis(design, at, joint, AxisQuantity::Position, knots);
    rows_of(design, at, joint, &SmoothBasis { factors: Vec::new(), axes: vec![axis] })
}

/// Knots over the range of a quantity, and a margin beyond it.
fn axis(
    design: &Design<'_>,
    at: &[Posed<'_>],
    joint: usize,
    quantity: AxisQuantity,
    knots: usize,
) -> SmoothAxis {
    let values = at.iter().flat_map(|at| match quantity {
        AxisQuantity::Position => at.position[joint].iter(),
        AxisQuantity::Velocity => at.signals.velocity[joint].iter(),
    });
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    let margin = MARGIN * (high - low).max(f64::MIN_POSITIVE);
    let name = design.names[joint].clone();
    SmoothAxis { joint: name, quantity, range: [low - margin, high + margin], knots }
}

/// Weighted rows of all functions of a basis.
fn rows_of(
    design: &Design<'_>,
    at: &[Posed<'_>],
    joint: usize,
    basis: &SmoothBasis,
) -> Vec<Vec<f64>> {
    let index = |name: &str| design.names.iter().position(|n| n == name);
    let mut rows = vec![Vec::with_capacity(design.observations.len()); basis.size()];
    for at in at {
        let (hats, overlap) = (basis.hats(at, &index), basis.overlap());
        at.signals.band.rows_of_few(&hats, overlap, &mut rows);
    }
    for rows in &mut rows {
        design.observations.weigh_law(joint, rows);
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
    design: &Design<'_>,
    at: &[Posed<'_>],
    joint: usize,
    basis: SmoothBasis,
    effort: f64,
    beside: &[Vec<f64>],
    residual: &[f64],
) -> Option<(SmoothDirections, f64)> {
    let rows = rows_of(design, at, joint, &basis);
    let others: Vec<&[f64]> = beside.iter().map(Vec::as_slice).chain([residual]).collect();
    let all: Vec<&[f64]> = others.iter().copied().chain(rows.iter().map(Vec::as_slice)).collect();
    let products = gram_of_columns(&all);
    let transform = known_directions(design, at, &basis, effort, &products, others.len())?;
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
    Some((SmoothDirections { basis, transform }, left))
}

/// Coefficients of the functions along these directions, largest first; `products` are those of the functions
/// from `first` on.
fn known_directions(
    design: &Design<'_>,
    at: &[Posed<'_>],
    basis: &SmoothBasis,
    effort: f64,
    products: &Mat<f64>,
    first: usize,
) -> Option<Vec<Vec<f64>>> {
    let index = |name: &str| design.names.iter().position(|n| n == name);
    let factors: Vec<f64> = at.iter().flat_map(|at| basis.factor_values(at, &index)).collect();
    let factor = (dot(&factors, &factors) / factors.len().max(1) as f64).sqrt();
    let deviation = ROUGHNESS * effort / factor.max(f64::MIN_POSITIVE);
    let (values, vectors) = symmetric_eigen(&penalty(basis)).ok()?;
    let size = basis.size();
    // coefficients = deviation P^(-1/2) z with z of deviation 1
    let smooth =
        Mat::from_fn(size, size, |i, k| vectors[(i, k)] * deviation / values[k].max(1e-12).sqrt());
    let of_functions = products.as_ref().submatrix(first, first, size, size);
    let along = smooth.transpose() * (of_functions * &smooth);
    let (known, directions) = symmetric_eigen(&along).ok()?;
    let kept: Vec<usize> = (0..size)
        .rev()
        .filter(|k| known[*k] * design.observations.weights.share > 1.0)
        .take(MOST_DIRECTIONS)
        .collect();
    if kept.is_empty() {
        return None;
    }
    let transform = &smooth * &directions;
    Some(kept.iter().map(|&k| (0..size).map(|i| transform[(i, k)]).collect()).collect())
}

/// Residual beside the best smooth term: its sum of squares over that of the residual, each
/// column paid for with an independent sample. Not more than 1.
pub(crate) fn least_left(
    design: &Design<'_>,
    at: &[Posed<'_>],
    joint: usize,
    residual: &[f64],
) -> f64 {
    let rows = &design.observations;
    let size = rows.in_sample_noise(joint, residual) * rows.sample_deviation[joint];
    let samples = residual.len() as f64 * rows.weights.share;
    let beside = beside(design, at, joint);
    let before = dot(residual, residual).max(f64::MIN_POSITIVE);
    candidates(design, at, joint)
        .into_par_iter()
        .filter_map(|basis| {
            let (flexible, left) = fitted(design, at, joint, basis, size, &beside, residual)?;
            let free = 1.0 - (beside.len() + flexible.transform.len()) as f64 / samples;
            (free > 0.0).then_some(left / (before * free))
        })
        .reduce(|| 1.0, f64::min)
}

/// From the products of all columns: the residual of the one at `place` on all others.
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
