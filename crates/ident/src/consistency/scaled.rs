//! Primal-dual steps along the central path, in the scaling of Nesterov and Todd.
//!
//! Source: M. J. Todd, K. C. Toh, R. H. Tütüncü, On the Nesterov-Todd direction in semidefinite
//! programming, SIAM J. Optim. 8(3), 1998.

use nalgebra::{Matrix4, Vector4};

use super::point::{FREE, Point, TEN};

/// Entries of a symmetric 4x4 matrix in the order of its coordinates.
pub(super) const ENTRIES: [(usize, usize); TEN] =
    [(0, 0), (1, 1), (2, 2), (3, 3), (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
/// Smallest eigenvalue of `X S` that a step may leave, relative to their mean: the wide neighbourhood of
/// the path.
const CENTRAL: f64 = 0.02;
/// Steps that leave the neighbourhood are cut to this share, so many times.
const CUT: f64 = 0.85;
const MOST_CUTS: usize = 30;
/// Share of the way to the wall that a step along the path may take.
const TO_WALL: f64 = 0.98;

/// A point with the duals `S_k` of its links and of its effects: on the path `X S = μ 1`.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub(super) point: Point,
    duals: Vec<Matrix4<f64>>,
    /// 0 for effects without a bound
    effect_duals: Vec<f64>,
}

impl Pair {
    /// The start: `X = 1`, `S = μ 1`.
    pub(super) fn new(point: Point, mu: f64) -> Self {
        Self {
            duals: vec![Matrix4::identity() * mu; point.factors.len()],
            effect_duals: point.effects.iter().map(|t| mu * t).collect(),
            point,
        }
    }

    /// Mean of the eigenvalues of `X S`.
    pub(super) fn mu(&self) -> f64 {
        let links = self.point.factors.iter().zip(&self.duals);
        let traces: f64 = links.map(|(l, s)| (l.transpose() * s * l).trace()).sum();
        let bounded = || self.effect_duals.iter().filter(|s| **s > 0.0);
        let effects: f64 =
            self.point.effects.iter().zip(&self.effect_duals).map(|(t, s)| t * s).sum();
        let degree = 4 * self.duals.len() + bounded().count();
        if degree == 0 { 0.0 } else { (traces + effects) / degree as f64 }
    }
}

/// A pair in the scaling in which the links and their duals are the same diagonal matrix `D`
/// (Nesterov and Todd): `X = G D Gᵀ`, `S = G⁻ᵀ D G⁻¹`.
pub(super) struct Scaled {
    /// `G` of every link, `G²` of every bounded effect
    pub(super) point: Point,
    inverses: Vec<Matrix4<f64>>,
    diagonals: Vec<Vector4<f64>>,
    /// `D` of every effect, 0 without a bound
    effect_diagonals: Vec<f64>,
}

/// Steps of a [`Pair`] in its scaling.
pub(super) struct Direction {
    primal: Vec<f64>,
    dual: Vec<f64>,
    /// length at which the first boundary is reached
    pub(super) longest: f64,
}

impl Scaled {
    pub(super) fn of(pair: &Pair) -> Self {
        let mut point = pair.point.clone();
        let (mut inverses, mut diagonals) = (Vec::new(), Vec::new());
        for (factor, dual) in point.factors.iter_mut().zip(&pair.duals) {
            let eigen = (factor.transpose() * dual * *factor).symmetric_eigen();
            let d = eigen.eigenvalues.map(|x| x.max(f64::MIN_POSITIVE).sqrt());
            let over_d = |power: f64| Matrix4::from_diagonal(&d.map(|d| d.powf(-power)));
            let g = *factor * eigen.eigenvectors * over_d(0.5);
            inverses.push(dual * g * over_d(1.0));
            diagonals.push(d);
            *factor = g;
        }
        let mut effect_diagonals = Vec::new();
        for (t, s) in point.effects.iter_mut().zip(&pair.effect_duals) {
            effect_diagonals.push((*t * s).max(0.0).sqrt());
            if *s > 0.0 {
                *t = (*t / s).sqrt();
            }
        }
        Self { point, inverses, diagonals, effect_diagonals }
    }

    /// `D` as coordinates.
    pub(super) fn centre(&self) -> Vec<f64> {
        let links = self.diagonals.iter().flat_map(|d| coordinates(&Matrix4::from_diagonal(d)));
        links.chain(self.effect_diagonals.iter().copied()).collect()
    }

    /// `c Gᵀ G` as coordinates: the dual of `c tr X`.
    pub(super) fn identities(&self, c: f64) -> Vec<f64> {
        let links = self.point.factors.iter().flat_map(|g| coordinates(&(g.transpose() * g * c)));
        let effects = self.point.effects.iter().zip(&self.effect_diagonals);
        links.chain(effects.map(|(square, d)| if *d > 0.0 { c * square } else { 0.0 })).collect()
    }

    /// Sum of primal and dual step that leads to `X S = aim 1`, to first or to second order.
    pub(super) fn wanted(&self, aim: f64, second_order: Option<(&Direction, f64)>) -> Vec<f64> {
        let n = self.diagonals.len();
        let mut wanted = Vec::with_capacity(TEN * n + self.effect_diagonals.len());
        for (k, d) in self.diagonals.iter().enumerate() {
            let mut step = Matrix4::from_diagonal(&d.map(|d| aim / d - d));
            if let Some((Direction { primal, dual, .. }, share)) = second_order {
                let own = TEN * k..TEN * (k + 1);
                let product = symmetric(&primal[own.clone()]) * symmetric(&dual[own]);
                for i in 0..4 {
                    for j in 0..4 {
                        let both = product[(i, j)] + product[(j, i)];
                        step[(i, j)] -= share * both / (d[i] + d[j]);
                    }
                }
            }
            wanted.extend(coordinates(&step));
        }
        for (k, d) in self.effect_diagonals.iter().enumerate() {
            let second = second_order
                .map_or(0.0, |(o, share)| share * o.primal[TEN * n + k] * o.dual[TEN * n + k]);
            wanted.push(if *d > 0.0 { (aim - second) / d - d } else { 0.0 });
        }
        wanted
    }

    pub(super) fn direction(&self, primal: Vec<f64>, wanted: &[f64]) -> Direction {
        let dual: Vec<f64> = wanted.iter().zip(&primal).map(|(w, p)| w - p).collect();
        let mut lowest = 0.0_f64;
        for (k, d) in self.diagonals.iter().enumerate() {
            let root = Matrix4::from_diagonal(&d.map(|d| d.sqrt().recip()));
            for side in [&primal, &dual] {
                let step = root * symmetric(&side[TEN * k..TEN * (k + 1)]) * root;
                lowest = lowest.min(step.symmetric_eigenvalues().min());
            }
        }
        let first = TEN * self.diagonals.len();
        for (k, d) in self.effect_diagonals.iter().enumerate().filter(|(_, d)| **d > 0.0) {
            lowest = lowest.min(primal[first + k] / d).min(dual[first + k] / d);
        }
        let longest = if lowest < 0.0 { -1.0 / lowest } else { f64::INFINITY };
        Direction { primal, dual, longest }
    }

    /// Mean eigenvalue of `X S` after a step; infinite outside the cone.
    pub(super) fn mean_after(&self, step: &Direction, length: f64) -> f64 {
        self.after(step, length, &mut Vec::new()).unwrap_or(f64::INFINITY)
    }

    /// The same with the products, symmetric ones of the same eigenvalues.
    fn after(
        &self,
        step: &Direction,
        length: f64,
        products: &mut Vec<Matrix4<f64>>,
    ) -> Option<f64> {
        products.clear();
        let (mut sum, mut degree) = (0.0, 0);
        for (k, d) in self.diagonals.iter().enumerate() {
            let own = TEN * k..TEN * (k + 1);
            let d = Matrix4::from_diagonal(d);
            let root = (d + symmetric(&step.primal[own.clone()]) * length).cholesky()?.l();
            let dual = d + symmetric(&step.dual[own]) * length;
            let product = root.transpose() * dual * root;
            sum += product.trace();
            degree += 4;
            products.push(product);
        }
        for product in self.effects_after(step, length) {
            sum += product;
            degree += 1;
        }
        Some(sum / f64::from(degree.max(1)))
    }

    fn effects_after(&self, step: &Direction, length: f64) -> impl Iterator<Item = f64> {
        let first = TEN * self.diagonals.len();
        let effects = self.effect_diagonals.iter().zip(&step.primal[first..]);
        effects
            .zip(&step.dual[first..])
            .filter(|((d, _), _)| **d > 0.0)
            .map(move |((d, primal), dual)| (d + length * primal) * (d + length * dual))
    }

    /// The longest step that keeps every eigenvalue of `X S` above a share of their mean: 1 at most.
    pub(super) fn length(&self, step: &Direction) -> f64 {
        let mut length = (TO_WALL * step.longest).min(1.0);
        let mut products = Vec::with_capacity(self.diagonals.len());
        for _ in 0..MOST_CUTS {
            let central = self.after(step, length, &mut products).is_some_and(|mean| {
                let least = CENTRAL * mean;
                let above = |product: &Matrix4<f64>| {
                    (product - Matrix4::identity() * least).cholesky().is_some()
                };
                self.effects_after(step, length).all(|product| product >= least)
                    && products.iter().all(above)
            });
            if central {
                break;
            }
            length *= CUT;
        }
        length
    }

    pub(super) fn take(&self, step: &Direction, length: f64, pair: &mut Pair) {
        for (k, d) in self.diagonals.iter().enumerate() {
            let own = TEN * k..TEN * (k + 1);
            let d = Matrix4::from_diagonal(d);
            if let Some(root) = (d + symmetric(&step.primal[own.clone()]) * length).cholesky() {
                pair.point.factors[k] = self.point.factors[k] * root.l();
            }
            let inverse = &self.inverses[k];
            let moved = inverse * (d + symmetric(&step.dual[own]) * length) * inverse.transpose();
            pair.duals[k] = (moved + moved.transpose()) * 0.5;
        }
        let first = TEN * self.diagonals.len();
        for (k, d) in self.effect_diagonals.iter().enumerate() {
            let (primal, dual) = (length * step.primal[first + k], length * step.dual[first + k]);
            let square = self.point.effects[k];
            if *d > 0.0 {
                pair.point.effects[k] = square * (d + primal);
                pair.effect_duals[k] = (d + dual) / square;
            } else {
                pair.point.effects[k] += FREE * primal;
            }
        }
    }
}

/// Coordinates of a symmetric matrix in which the Frobenius product is the scalar product.
pub(super) fn coordinates(m: &Matrix4<f64>) -> [f64; TEN] {
    ENTRIES.map(|(a, b)| if a == b { m[(a, a)] } else { std::f64::consts::SQRT_2 * m[(a, b)] })
}

/// Inverse of [`coordinates`].
pub(super) fn symmetric(y: &[f64]) -> Matrix4<f64> {
    let mut m = Matrix4::zeros();
    for (&(a, b), y) in ENTRIES.iter().zip(y) {
        let entry = if a == b { *y } else { std::f64::consts::FRAC_1_SQRT_2 * y };
        m[(a, b)] = entry;
        m[(b, a)] = entry;
    }
    m
}
