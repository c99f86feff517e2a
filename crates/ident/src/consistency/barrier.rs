//! The log-det barrier: links inside the cone of real ones, followed along its central path.
//!
//! In unknowns `X_k = Λ_k⁻¹ J_k Λ_k⁻ᵀ` (one 4x4 matrix a link, the prior at 1) and scaled effects `t`
//! (the prior at 1),
//!
//! ```text
//! g(X, t) = ½ |B (X, t) - y|²                  d(X, t) = Σ (tr X - log det X - 4) + Σ (t - log t - 1)
//! ```
//!
//! `d` is the distance from the prior and the barrier of the cone in one: the minimiser of `g + μ d` is
//! inside the cone for every `μ > 0`, and for `μ → 0` it tends to the points of the smallest `g`, of
//! them to the one with the smallest `d`. This path is followed from the prior, where `μ = ∞`, down to
//! the weight asked for: by primal-dual steps ([`Scaled`]), because the path is curved where links
//! grow thin, and at its end by Newton's method with an exact line search.
//!
//! Where links grow far beyond the prior, `X = 1000`, the dual `S = μ X⁻¹` is the small difference of
//! `∇g` and `μ 1`, the dual of `μ tr X`: were `μ 1` to shrink along with `μ`, steps would be some hundredths long
//! and never end. From where the path turns, the trace is therefore held at the weight
//! of the end, and only the logarithm's `μ` goes down: the usual central path, with the same end.
//!
//! The state is a factor `L` of each `X = L Lᵀ`, and steps are `L (1 + Y) Lᵀ`: in `Y` the Hessian of
//! `d` is 1, so a step is a damped least-squares problem without any ill-conditioned matrix, and
//! eigenvalues of 1e-12 keep their relative accuracy.

use armident_kinematics::InertialParameters;
use armident_numeric::{DampedLeastSquares, Mat, NumericError};
use nalgebra::Matrix4;

use super::point::{FREE, Point, TEN};
use super::scaled::{Direction, ENTRIES, Pair, Scaled, coordinates, symmetric};

/// Predictors that reach less far than this share of the way to the end say that the path turns.
const TURNS: f64 = 0.3;
/// A step longer than this has led to the path.
const WHOLE: f64 = 0.9;
/// The bound of `g` is sought at this share of the weight,
const DEEPER: f64 = 1e-2;
/// unless the gap is below this share of `g` already.
const SMALL_GAP: f64 = 1e-2;
/// Share of `μ` that a step may aim at.
const QUICKEST: f64 = 1e-3;
/// `μ` relative to the end of the path, from where Newton's method finishes,
const AT_END: f64 = 1.5;
/// as it does after a step shorter than this.
const SHORTEST: f64 = 1e-3;
/// Steps of Newton's method at the end of the path.
const MOST_NEWTON_STEPS: usize = 60;
/// Decrement of the end: `g + μ d` is then within `μ` times its square of the minimum.
const CONVERGED: f64 = 1e-6;
/// Steps along the path at most; the usual number is 25.
const MOST_STEPS: usize = 150;
/// `μ` stays above this share of `g`: below it round-off decides.
const SMALLEST_SHARE: f64 = 1e-7;
/// Share of the way to the boundary that a step may take.
const TO_BOUNDARY: f64 = 0.999;
/// The certificate covers points this many times as large as the answer.
const CERTIFIED_SIZE: f64 = 10.0;
/// Weight of the data, relative to its largest column, when they are to be met exactly.
const HEAVY: f64 = 1e10;
/// Steps towards a point that meets the data; from near it 3 to 8 are enough.
const MOST_MEETING_STEPS: usize = 12;
/// Steps that the boundary cuts short before the way is given up.
const MOST_CUT_STEPS: usize = 3;
/// Two steps later a step is below this share of itself, or the way is given up.
const DWINDLES: f64 = 0.7;
/// Residual of data that are met, relative to the size of what makes them up.
const MET: f64 = 1e-9;

/// Which values an effect may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bound {
    /// Any.
    Free,
    /// Zero or more.
    NonNegative,
}

/// `g` of a set of links and effects.
#[derive(Debug, Clone)]
pub(super) struct Barrier {
    /// `Λ_k` of every link, any root of the prior's pseudo-inertia
    pub(super) roots: Vec<Matrix4<f64>>,
    pub(super) bounds: Vec<Bound>,
    /// `B` by the ten parameters of every link and the scaled effects
    pub(super) data: Mat<f64>,
    /// `y`
    pub(super) target: Vec<f64>,
}

/// A minimiser of `g + μ d`.
#[derive(Debug, Clone)]
pub(super) struct Centre {
    pub(super) point: Point,
    /// `μ`.
    pub(super) weight: f64,
    /// Newton decrement of `g / μ + d`.
    pub(super) decrement: f64,
    /// Least-squares steps taken.
    pub(super) steps: usize,
}

/// A step along the path.
struct PathStep {
    length: f64,
    /// how far the predictor could have gone, 1 at most
    reach: f64,
}

/// Lower bound of `g` over the cone.
#[derive(Debug, Clone, Copy)]
pub(super) struct DualityGap {
    pub(super) at_least: f64,
    /// `Σ tr X + Σ t` up to which it holds.
    pub(super) size: f64,
}

impl Barrier {
    /// The prior.
    pub(super) fn start(&self) -> Point {
        Point {
            factors: vec![Matrix4::identity(); self.roots.len()],
            effects: self.bounds.iter().map(|b| f64::from(*b == Bound::NonNegative)).collect(),
        }
    }

    /// Follows the path from the prior down to `weight`, and settles there.
    pub(super) fn centre(&self, weight: f64) -> Result<Centre, NumericError> {
        let start = self.start();
        let residual = self.residual(&start, &self.target);
        let pull = norm(&transposed_times(&self.columns(&start, &[]), &residual));
        let mut pair = Pair::new(start, pull.max(weight));
        let mut held = false;
        let (mut end, mut steps, mut last) = (weight, 0, 1.0);
        while steps < MOST_STEPS {
            let residual = self.residual(&pair.point, &self.target);
            end = weight.max(SMALLEST_SHARE * 0.5 * norm(&residual).powi(2));
            if pair.mu() <= AT_END * end && last > WHOLE {
                break;
            }
            let PathStep { length, reach } = self.primal_dual(&mut pair, &residual, end, held)?;
            held |= reach < TURNS;
            steps += 1;
            if length < SHORTEST {
                break;
            }
            last = length;
        }
        let (weight, mut point) = (end, pair.point);
        let decrement = self.settle(&mut point, weight, &mut steps)?;
        Ok(Centre { point, weight, decrement, steps })
    }

    /// One step along the path (Mehrotra's predictor and corrector) towards `weight`, with the weight
    /// of the trace `held` there or shrinking along with `μ`.
    fn primal_dual(
        &self,
        pair: &mut Pair,
        residual: &[f64],
        weight: f64,
        held: bool,
    ) -> Result<PathStep, NumericError> {
        let scaled = Scaled::of(pair);
        let columns = self.columns(&scaled.point, &[]);
        let rhs: Vec<f64> = residual.iter().map(|r| -r).collect();
        let system = DampedLeastSquares::new(columns);
        let mu = pair.mu();
        let solve = |aim: f64, second_order: Option<(&Direction, f64)>| {
            let wanted = scaled.wanted(aim, second_order);
            // the dual of the prior's part of d
            let shift = scaled.identities(if held { weight } else { aim });
            let both: Vec<f64> = wanted
                .iter()
                .zip(scaled.centre())
                .zip(&shift)
                .map(|((w, d), c)| w + d - c)
                .collect();
            let primal = system.solve(&rhs, &both)?;
            Ok::<_, NumericError>(scaled.direction(primal, &wanted))
        };
        let predictor = solve(weight.min(mu), None)?;
        let reach = predictor.longest.min(1.0);
        let aim = (mu * (1.0 - reach).powi(2).max(QUICKEST)).max(weight);
        // the second order is only right as far as the predictor reaches: the share of it that leads
        // farthest down the path
        let mut best: Option<(f64, f64, Direction)> = None;
        for (aim, share) in [(aim, 1.0), (aim, reach * reach), (mu.max(weight), 0.0)] {
            let step = solve(aim, Some((&predictor, share)))?;
            let length = scaled.length(&step);
            let left = scaled.mean_after(&step, length);
            if best.as_ref().is_none_or(|b| left < b.0) {
                best = Some((left, length, step));
            }
        }
        let Some((_, length, step)) = best else { return Ok(PathStep { length: 0.0, reach }) };
        scaled.take(&step, length, pair);
        Ok(PathStep { length, reach })
    }

    /// Newton's method at one `μ`, to the end of its quadratic convergence. Returns the decrement.
    fn settle(&self, point: &mut Point, mu: f64, steps: &mut usize) -> Result<f64, NumericError> {
        let mut best = (f64::INFINITY, point.clone());
        for _ in 0..MOST_NEWTON_STEPS {
            let columns = self.columns(point, &[]);
            let residual = self.residual(point, &self.target);
            let step = self.newton(point, &columns, &residual, mu)?;
            *steps += 1;
            // round-off ends it
            let stalled = step.decrement < 1e-2 && step.decrement > 0.5 * best.0;
            if step.decrement < best.0 {
                best = (step.decrement, point.clone());
            }
            if step.decrement < CONVERGED || stalled {
                break;
            }
            let length = step.line_search(&residual, mu);
            *point = self.moved(point, &step.direction, length);
        }
        *point = best.1;
        Ok(best.0)
    }

    /// Minimiser of `d` among the points with `B x = target` and the effects of `absent` at 0, from a
    /// point near it; none when there is no such point inside the cone nearby.
    pub(super) fn meet(
        &self,
        from: &Point,
        target: &[f64],
        absent: &[bool],
    ) -> Result<Option<Point>, NumericError> {
        let mut point = from.clone();
        for (t, _) in point.effects.iter_mut().zip(absent).filter(|(_, absent)| **absent) {
            *t = 0.0;
        }
        let size = self.size_of_terms(&point).max(norm(target));
        let (mut left, mut cut) = (f64::INFINITY, 0);
        let mut lengths: Vec<f64> = Vec::new();
        for _ in 0..MOST_MEETING_STEPS {
            let columns = self.columns(&point, absent);
            let residual = self.residual(&point, target);
            let largest = (0..columns.ncols())
                .map(|j| (0..columns.nrows()).map(|i| columns[(i, j)].powi(2)).sum::<f64>())
                .fold(f64::MIN_POSITIVE, f64::max);
            let mut step = self.newton(&point, &columns, &residual, largest / (HEAVY * HEAVY))?;
            for (k, _) in absent.iter().enumerate().filter(|(_, absent)| **absent) {
                step.direction[TEN * self.roots.len() + k] = 0.0;
            }
            let moved = norm(&step.direction);
            let length = (TO_BOUNDARY * step.longest).min(1.0);
            // to the end of its quadratic convergence
            let met = norm(&residual) <= MET * size && norm(&residual) > 0.1 * left;
            left = norm(&residual);
            if met && moved < CONVERGED {
                return Ok(Some(point));
            }
            cut += usize::from(length < 1.0);
            lengths.push(moved);
            let before = lengths.len().checked_sub(3).map_or(f64::INFINITY, |k| lengths[k]);
            if cut > MOST_CUT_STEPS || moved > DWINDLES * before {
                break;
            }
            point = self.moved(&point, &step.direction, length);
        }
        Ok(None)
    }

    /// `|B x - y|`.
    pub(super) fn distance(&self, point: &Point) -> f64 {
        norm(&self.residual(point, &self.target))
    }

    /// `B x`.
    pub(super) fn value(&self, point: &Point) -> Vec<f64> {
        self.residual(point, &vec![0.0; self.target.len()])
    }

    /// `d`.
    pub(super) fn divergence(&self, point: &Point) -> f64 {
        let of_link = |l: &Matrix4<f64>| l.norm_squared() - 2.0 * l.determinant().abs().ln() - 4.0;
        let links: f64 = point.factors.iter().map(of_link).sum();
        let effects = point.effects.iter().zip(&self.bounds);
        links
            + effects
                .filter(|(t, bound)| **bound == Bound::NonNegative && **t > 0.0)
                .map(|(t, _)| t - t.ln() - 1.0)
                .sum::<f64>()
    }

    /// Lower bound of `g` over points up to [`CERTIFIED_SIZE`] times as large as a centre.
    ///
    /// The bound from the centre itself is off by its weight times that size, much for links far
    /// beyond the prior: the end of a path to a smaller weight gives a closer one.
    pub(super) fn bound(&self, centre: &Centre) -> Result<DualityGap, NumericError> {
        let Centre { point, weight, .. } = centre;
        let effects: f64 = point.effects.iter().map(|t| t.abs()).sum();
        let size = CERTIFIED_SIZE * (point.size_of_links() + effects);
        let own = self.weak_duality(point, size);
        let misfit = 0.5 * self.distance(point).powi(2);
        if misfit - own <= SMALL_GAP * misfit {
            return Ok(DualityGap { at_least: own, size });
        }
        let deeper = self.centre(DEEPER * weight)?;
        let at_least = own.max(self.weak_duality(&deeper.point, size));
        Ok(DualityGap { at_least, size })
    }

    /// Weak duality at any point: for every other one, `X'` with `S = Bᵀ(B X - y)`,
    ///
    /// ```text
    /// g(X') ≥ g(X) + <S, X' - X> ≥ g(X) - <S, X> - c tr X'            where S + c 1 ⪰ 0
    /// ```
    ///
    /// for those of a `size` `Σ tr X' + Σ t'` at most.
    fn weak_duality(&self, point: &Point, size: f64) -> f64 {
        let columns = self.columns(point, &[]);
        let dual = transposed_times(&columns, &self.residual(point, &self.target));
        let (mut product, mut below) = (0.0, 0.0_f64);
        for (factor, s) in point.factors.iter().zip(dual.chunks(TEN)) {
            // in the coordinates of Y: <S, X> = tr, and S of X itself is L⁻ᵀ s L⁻¹
            let s = symmetric(s);
            product += s.trace();
            let inverse = factor.try_inverse().unwrap_or_else(Matrix4::zeros);
            let own = inverse.transpose() * s * inverse;
            below = below.max(-((own + own.transpose()) * 0.5).symmetric_eigenvalues().min());
        }
        for ((s, t), bound) in
            dual[TEN * self.roots.len()..].iter().zip(&point.effects).zip(&self.bounds)
        {
            match bound {
                Bound::NonNegative => {
                    product += s;
                    below = below.max(if *t > 0.0 { -s / t } else { 0.0 });
                }
                Bound::Free => below = below.max(s.abs() / FREE),
            }
        }
        let misfit = 0.5 * self.distance(point).powi(2);
        (misfit - product - below * size).max(0.0)
    }

    /// `B` in the coordinates of the step, unit for unit with the Hessian of `d`.
    fn columns(&self, point: &Point, absent: &[bool]) -> Mat<f64> {
        let (rows, n) = (self.data.nrows(), self.roots.len());
        let mut columns = Mat::zeros(rows, TEN * n + self.bounds.len());
        for (k, (root, factor)) in self.roots.iter().zip(&point.factors).enumerate() {
            let half = root * factor;
            for (c, &(a, b)) in ENTRIES.iter().enumerate() {
                let (pa, pb) = (half.column(a), half.column(b));
                let moved = if a == b {
                    pa * pa.transpose()
                } else {
                    (pa * pb.transpose() + pb * pa.transpose()) * std::f64::consts::FRAC_1_SQRT_2
                };
                let parameters = InertialParameters::from_pseudo_inertia(&moved).to_array();
                let column = columns.col_as_slice_mut(TEN * k + c);
                for (p, x) in parameters.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                    add(column, *x, self.data.col_as_slice(TEN * k + p));
                }
            }
        }
        for (k, (bound, t)) in self.bounds.iter().zip(&point.effects).enumerate() {
            let scale = match bound {
                _ if absent.get(k) == Some(&true) => 0.0,
                Bound::Free => FREE,
                Bound::NonNegative => *t,
            };
            add(columns.col_as_slice_mut(TEN * n + k), scale, self.data.col_as_slice(TEN * n + k));
        }
        columns
    }

    fn parameters(&self, point: &Point) -> Vec<f64> {
        let links = point.links(&self.roots);
        links.iter().flat_map(|l| l.to_array()).chain(point.effects.iter().copied()).collect()
    }

    /// `B x - target`.
    fn residual(&self, point: &Point, target: &[f64]) -> Vec<f64> {
        let mut residual: Vec<f64> = target.iter().map(|y| -y).collect();
        for (j, x) in self.parameters(point).iter().enumerate() {
            add(&mut residual, *x, self.data.col_as_slice(j));
        }
        residual
    }

    /// Norm of the terms that `B x` sums: what round-off is measured against.
    fn size_of_terms(&self, point: &Point) -> f64 {
        let x = self.parameters(point);
        let row = |i: usize| -> f64 {
            x.iter().enumerate().map(|(j, x)| (self.data[(i, j)] * x).powi(2)).sum()
        };
        (0..self.data.nrows()).map(row).sum::<f64>().sqrt()
    }

    /// Newton's step of `g / μ + d`.
    fn newton(
        &self,
        point: &Point,
        columns: &Mat<f64>,
        residual: &[f64],
        mu: f64,
    ) -> Result<Step, NumericError> {
        let weight = mu.sqrt();
        let heavy = Mat::from_fn(columns.nrows(), columns.ncols(), |i, j| columns[(i, j)] / weight);
        let rhs: Vec<f64> = residual.iter().map(|r| -r / weight).collect();
        let (mut downhill, mut traces) = (Vec::with_capacity(columns.ncols()), 0.0);
        for factor in &point.factors {
            let gradient = factor.transpose() * factor - Matrix4::identity();
            downhill.extend(coordinates(&-gradient));
        }
        for (bound, t) in self.bounds.iter().zip(&point.effects) {
            downhill.push(match bound {
                Bound::NonNegative if *t > 0.0 => 1.0 - t,
                _ => 0.0,
            });
        }
        let direction = DampedLeastSquares::accurate(heavy).solve(&rhs, &downhill)?;
        let mut change = vec![0.0; columns.nrows()];
        for (j, y) in direction.iter().enumerate() {
            add(&mut change, *y, columns.col_as_slice(j));
        }
        let mut eigenvalues = Vec::with_capacity(4 * point.factors.len() + self.bounds.len());
        for (y, factor) in direction.chunks(TEN).zip(&point.factors) {
            let y = symmetric(y);
            eigenvalues.extend(y.symmetric_eigenvalues().iter());
            traces += (factor.transpose() * factor * y).trace();
        }
        let steps = &direction[TEN * point.factors.len()..];
        for ((bound, t), y) in self.bounds.iter().zip(&point.effects).zip(steps) {
            if *bound == Bound::NonNegative && *t > 0.0 {
                eigenvalues.push(*y);
                traces += t * y;
            }
        }
        let decrement = (norm(&change).powi(2) / mu + norm(&direction).powi(2)).sqrt();
        let lowest = eigenvalues.iter().fold(0.0_f64, |a, &b| a.min(b));
        let longest = if lowest < 0.0 { -1.0 / lowest } else { f64::INFINITY };
        Ok(Step { direction, change, eigenvalues, traces, decrement, longest })
    }

    fn moved(&self, point: &Point, direction: &[f64], length: f64) -> Point {
        let factors = point.factors.iter().zip(direction.chunks(TEN)).map(|(factor, y)| {
            let moved = Matrix4::identity() + symmetric(y) * length;
            // positive definite by the length of the step, but for round-off: then it is not taken
            moved.cholesky().map_or(*factor, |c| factor * c.l())
        });
        let steps = &direction[TEN * point.factors.len()..];
        let effects = self.bounds.iter().zip(&point.effects).zip(steps);
        Point {
            factors: factors.collect(),
            effects: effects
                .map(|((bound, t), y)| match bound {
                    Bound::Free => t + FREE * length * y,
                    Bound::NonNegative => t * (1.0 + length * y),
                })
                .collect(),
        }
    }
}

/// A direction with what the line search needs.
struct Step {
    direction: Vec<f64>,
    /// change of `B x` along it
    change: Vec<f64>,
    /// of all `Y`
    eigenvalues: Vec<f64>,
    /// `Σ tr(X-part of d)`, its linear change
    traces: f64,
    decrement: f64,
    /// length at which the boundary is reached
    longest: f64,
}

impl Step {
    /// Length at which `g / μ + d` is smallest along the direction: a convex function of one number.
    fn line_search(&self, residual: &[f64], mu: f64) -> f64 {
        let linear: f64 = residual.iter().zip(&self.change).map(|(r, c)| r * c).sum();
        let square = norm(&self.change).powi(2);
        let slope = |length: f64| {
            let barrier: f64 = self.eigenvalues.iter().map(|l| l / (1.0 + length * l)).sum();
            (linear + length * square) / mu + self.traces - barrier
        };
        // Newton's own length where it is right
        let (mut low, mut high) = (0.0, (TO_BOUNDARY * self.longest).min(4.0));
        if slope(high) <= 0.0 {
            return high;
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if slope(middle) > 0.0 { high = middle } else { low = middle }
        }
        low
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn transposed_times(a: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    let product = |j: usize| a.col_as_slice(j).iter().zip(x).map(|(a, x)| a * x).sum();
    (0..a.ncols()).map(product).collect()
}

/// Adds `factor` times a column.
fn add(to: &mut [f64], factor: f64, column: &[f64]) {
    to.iter_mut().zip(column).for_each(|(y, x)| *y += factor * x);
}
