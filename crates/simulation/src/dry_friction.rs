//! The set-valued friction law in one step or at one instant.

use armident_effects::DryFriction;
use nalgebra::{DMatrix, DVector};

/// Relative size below which a violated sign or level is rounding.
const ROUNDING: f64 = 1e-12;
/// Most pivots; only matrices that are singular to rounding need more than a few per joint.
const MOST_PIVOTS: usize = 100_000;
/// Creep that makes friction elements independent of one another, relative to their mobility.
const CREEP: f64 = 1e-10;

/// Dry friction in the directions of the rows and in common directions of two of them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RowLevels {
    pub(crate) rows: Vec<DryFriction>,
    pub(crate) pairs: Vec<PairLevel>,
}

/// Dry friction in the direction `w_b + ratio w_a`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PairLevel {
    pub(crate) a: usize,
    pub(crate) b: usize,
    pub(crate) ratio: f64,
    pub(crate) level: f64,
}

impl PairLevel {
    pub(crate) fn speed(&self, w: &[f64]) -> f64 {
        w[self.b] + self.ratio * w[self.a]
    }

    /// Whether the common speed is zero up to rounding: what two rows that stick together have.
    pub(crate) fn rests(&self, w: &[f64]) -> bool {
        let terms = w[self.b].abs() + (self.ratio * w[self.a]).abs();
        self.speed(w).abs() <= ROUNDING * terms
    }
}

impl RowLevels {
    /// No friction on this many rows.
    pub(crate) fn none(rows: usize) -> Self {
        Self { rows: vec![DryFriction::default(); rows], pairs: Vec::new() }
    }

    /// All levels times a factor.
    pub(crate) fn times(&self, factor: f64) -> Self {
        let scaled = |row: &DryFriction| DryFriction {
            forward: row.forward * factor,
            backward: row.backward * factor,
        };
        let pair = |pair: &PairLevel| PairLevel { level: pair.level * factor, ..*pair };
        Self {
            rows: self.rows.iter().map(scaled).collect(),
            pairs: self.pairs.iter().map(pair).collect(),
        }
    }

    /// Whether some direction that has friction stops or reverses between two velocities.
    pub(crate) fn stops(&self, before: &[f64], after: &[f64]) -> bool {
        let stops = |before: f64, after: f64| before != 0.0 && before * after <= 0.0;
        let rows = (0..before.len()).any(|j| !self.rows[j].is_none() && stops(before[j], after[j]));
        rows || self.pairs.iter().any(|pair| {
            !pair.rests(before)
                && (pair.rests(after) || stops(pair.speed(before), pair.speed(after)))
        })
    }
}

/// The same for one row: `m w + λ = r`, `λ ∈ level Sign(w)`, with `m > 0`.
pub(crate) fn solve_one_row(m: f64, r: f64, level: DryFriction) -> f64 {
    match breaks_away(level, r, 0.0) {
        Some(sign) => (r - level.effort(sign)) / m,
        None => 0.0,
    }
}

/// Solves `M w + λ = r`, `λ_j ∈ level_j Sign(w_j)`: `w` of dry friction with stiction.
///
/// `Sign(0) = [-1, 1]`, with a level for each direction; a row that sticks has `w_j = 0` exactly, a
/// row without friction has `λ_j = 0`. `M` is symmetric positive definite, so that the solution exists,
/// is unique and minimises `½ wᵀ M w - rᵀ w + Σ level_j |w_j|`.
///
/// Every row with friction is assumed to slide forward, to slide backward or to stick, first as
/// `guess` says (its signs); the linear equations of the sliding ones are solved, and the first row
/// that contradicts its assumption changes it. This least-index principal pivoting ends after
/// finitely many steps for every such `M` (Júdice and Pires, Basic-set algorithm for a generalized
/// linear complementarity problem, J. Optim. Theory Appl. 74 (1992)).
///
/// Returns nothing if `M` is not positive definite, or only up to rounding.
pub(crate) fn solve_dry_friction(
    m: &DMatrix<f64>,
    r: &DVector<f64>,
    levels: &RowLevels,
    guess: &[f64],
) -> Option<DVector<f64>> {
    if !levels.pairs.is_empty() {
        return solve_with_pairs(m, r, levels, guess);
    }
    let level = &levels.rows;
    let n = r.len();
    let mut sign: Vec<f64> = guess.iter().map(|g| sign_of(*g)).collect();
    for _ in 0..MOST_PIVOTS {
        let sliding: Vec<usize> =
            (0..n).filter(|&j| level[j].is_none() || sign[j] != 0.0).collect();
        let mut w = DVector::zeros(n);
        if !sliding.is_empty() {
            let reduced = m.select_rows(&sliding).select_columns(&sliding);
            let driving = sliding.iter().map(|&j| r[j] - level[j].effort(sign[j]));
            let driving = DVector::from_iterator(sliding.len(), driving);
            let solved = reduced.cholesky()?.solve(&driving);
            for (&j, value) in sliding.iter().zip(&solved) {
                w[j] = *value;
            }
        }
        let held = r - m * &w;
        let smallest = ROUNDING * w.amax();
        let contradicted = (0..n).filter(|&j| !level[j].is_none()).find_map(|j| {
            if sign[j] != 0.0 {
                (w[j] * sign[j] < -smallest).then_some((j, 0.0))
            } else {
                let terms = (0..n).map(|k| (m[(j, k)] * w[k]).abs()).sum::<f64>();
                let rounding = ROUNDING * (r[j].abs() + terms + level[j].forward);
                breaks_away(level[j], held[j], rounding).map(|sign| (j, sign))
            }
        });
        match contradicted {
            Some((j, changed)) => sign[j] = changed,
            None => {
                for j in 0..n {
                    if !level[j].is_none() && w[j] * sign[j] <= 0.0 {
                        w[j] = 0.0;
                    }
                }
                return Some(w);
            }
        }
    }
    None
}

fn sign_of(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// The direction in which a held effort overcomes the friction, if it does.
fn breaks_away(level: DryFriction, held: f64, rounding: f64) -> Option<f64> {
    if held > level.forward + rounding {
        Some(1.0)
    } else if held < -level.backward - rounding {
        Some(-1.0)
    } else {
        None
    }
}

/// A row or a pair of rows with friction.
struct Element {
    weights: Vec<(usize, f64)>,
    level: DryFriction,
}

impl Element {
    fn speed(&self, w: &[f64]) -> f64 {
        self.weights.iter().map(|(row, weight)| weight * w[*row]).sum()
    }
}

/// The same with common directions. Friction on two rows and on their common direction holds them
/// in more ways than there are rows, so that single efforts `λ` are not unique: each element may
/// creep, relative to its mobility by [`CREEP`], and what sticks is put to rest afterwards.
///
/// `G λ + s = g` with `G = W M⁻¹ Wᵀ`, `g = W M⁻¹ r`, `s = W w` is solved by the same pivoting.
fn solve_with_pairs(
    m: &DMatrix<f64>,
    r: &DVector<f64>,
    levels: &RowLevels,
    guess: &[f64],
) -> Option<DVector<f64>> {
    let rows = levels.rows.iter().enumerate().filter(|(_, level)| !level.is_none());
    let rows = rows.map(|(row, level)| Element { weights: vec![(row, 1.0)], level: *level });
    let pairs = levels.pairs.iter().map(|pair| Element {
        weights: vec![(pair.b, 1.0), (pair.a, pair.ratio)],
        level: DryFriction::both(pair.level),
    });
    let elements: Vec<Element> = rows.chain(pairs).collect();
    let count = elements.len();
    let mut directions = DMatrix::zeros(r.len(), count);
    for (k, element) in elements.iter().enumerate() {
        element.weights.iter().for_each(|(row, weight)| directions[(*row, k)] = *weight);
    }
    let factor = m.clone().cholesky()?;
    let free = factor.solve(r);
    let mobility = factor.solve(&directions);
    let mut g = directions.transpose() * &mobility;
    for k in 0..count {
        g[(k, k)] *= 1.0 + CREEP;
    }
    let free_speed = directions.transpose() * &free;
    let fastest = free_speed.amax();
    let mut sign: Vec<f64> = elements.iter().map(|e| sign_of(e.speed(guess))).collect();
    for _ in 0..MOST_PIVOTS {
        let mut friction = DVector::from_iterator(
            count,
            elements.iter().zip(&sign).map(|(element, sign)| element.level.effort(*sign)),
        );
        let stuck: Vec<usize> = (0..count).filter(|&k| sign[k] == 0.0).collect();
        if !stuck.is_empty() {
            let reduced = g.select_rows(&stuck).select_columns(&stuck);
            let driving = (&free_speed - &g * &friction).select_rows(&stuck);
            let solved = reduced.cholesky()?.solve(&driving);
            stuck.iter().zip(&solved).for_each(|(&k, value)| friction[k] = *value);
        }
        let speed = &free_speed - &g * &friction;
        let contradicted = (0..count).find_map(|k| {
            let level = elements[k].level;
            if sign[k] != 0.0 {
                (speed[k] * sign[k] < -ROUNDING * fastest).then_some((k, 0.0))
            } else {
                let rounding = 1e-9 * (level.forward + level.backward);
                breaks_away(level, friction[k], rounding).map(|sign| (k, sign))
            }
        });
        if let Some((k, changed)) = contradicted {
            sign[k] = changed;
            continue;
        }
        let mut w = free - mobility * friction;
        let resting = |row: usize, w: &DVector<f64>| w[row] == 0.0;
        for k in (0..count).filter(|&k| sign[k] == 0.0) {
            match elements[k].weights[..] {
                [(row, _)] => w[row] = 0.0,
                [(b, _), (a, ratio)] if !resting(b, &w) => w[b] = -ratio * w[a],
                [_, (a, _)] => w[a] = 0.0,
                _ => {}
            }
        }
        return Some(w);
    }
    None
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    /// The defining conditions, on random problems of up to ten joints from bad guesses.
    #[test]
    fn satisfies_the_friction_law() {
        let mut random = Pcg64::seed_from_u64(3);
        let mut stuck = 0;
        for case in 0..600 {
            let n = 1 + case % 10;
            let a = DMatrix::from_fn(n, n, |_, _| random.random_range(-1.0..1.0));
            let scale: Vec<f64> =
                (0..n).map(|_| 10_f64.powf(random.random_range(-1.5..0.5))).collect();
            let m = (&a * a.transpose()) + DMatrix::identity(n, n) * 0.02;
            let m = DMatrix::from_fn(n, n, |i, j| m[(i, j)] * scale[i] * scale[j]);
            let r = DVector::from_fn(n, |j, _| random.random_range(-2.0..2.0) * scale[j]);
            let level: Vec<f64> = (0..n)
                .map(|j| scale[j] * [0.0, 0.3, 1.0, 3.0][random.random_range(0..4)])
                .collect();
            let guess: Vec<f64> = (0..n).map(|_| random.random_range(-1..2).into()).collect();
            let levels = RowLevels {
                rows: level.iter().map(|level| DryFriction::both(*level)).collect(),
                pairs: Vec::new(),
            };
            let w = solve_dry_friction(&m, &r, &levels, &guess).unwrap();
            let friction = &r - &m * &w;
            for j in 0..n {
                let tolerance = 1e-9 * scale[j];
                if w[j] == 0.0 {
                    stuck += 1;
                    assert!(friction[j].abs() <= level[j] + tolerance);
                } else {
                    assert!((friction[j] - level[j] * w[j].signum()).abs() <= tolerance);
                }
            }
        }
        assert!(stuck > 500, "{stuck}");
    }

    /// Against the solution for several rows.
    #[test]
    fn one_row_is_solved_as_several_are() {
        let mut random = Pcg64::seed_from_u64(7);
        let mut stuck = 0;
        for _ in 0..400 {
            let [m, r] = [random.random_range(0.1..3.0), random.random_range(-2.0..2.0)];
            let level = DryFriction { forward: 0.7, backward: random.random_range(0.0..1.5) };
            let levels = RowLevels { rows: vec![level], pairs: Vec::new() };
            let [of_rows, right] = [DMatrix::from_element(1, 1, m), DMatrix::from_element(1, 1, r)];
            let rows = solve_dry_friction(&of_rows, &right.column(0).into(), &levels, &[0.0]);
            let alone = solve_one_row(m, r, level);
            stuck += usize::from(alone == 0.0);
            assert!((alone - rows.unwrap()[0]).abs() < 1e-12, "{m} {r}");
        }
        assert!((50..350).contains(&stuck), "{stuck}");
    }

    #[test]
    fn refuses_matrices_that_are_not_positive_definite() {
        let m = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, -1.0]));
        let r = DVector::from_vec(vec![1.0, 5.0]);
        let mut levels = RowLevels::none(2);
        levels.rows[1] = DryFriction::both(1.0);
        assert!(solve_dry_friction(&m, &r, &levels, &[0.0, 0.0]).is_none());
    }

    /// With a common direction the solution still is the minimum of the same convex function.
    #[test]
    fn common_directions_satisfy_the_friction_law() {
        let mut random = Pcg64::seed_from_u64(5);
        let (mut stuck, mut sliding) = (0, 0);
        for case in 0..300 {
            let n = 2 + case % 6;
            let a = DMatrix::from_fn(n, n, |_, _| random.random_range(-1.0..1.0));
            let m = (&a * a.transpose()) + DMatrix::identity(n, n) * 0.05;
            let r = DVector::from_fn(n, |_, _| random.random_range(-2.0..2.0));
            let both = |level: f64| DryFriction { forward: level, backward: 0.5 * level };
            let rows = (0..n).map(|_| both([0.0, 0.4, 1.0][random.random_range(0..3)])).collect();
            let ratio = [-1.0, 0.5, 2.0][case % 3];
            let pairs = vec![PairLevel { a: 0, b: 1, ratio, level: 0.5 }];
            let levels = RowLevels { rows, pairs };
            let guess: Vec<f64> = (0..n).map(|_| random.random_range(-1..2).into()).collect();
            let w = solve_dry_friction(&m, &r, &levels, &guess).unwrap();
            let common = levels.pairs[0].speed(w.as_slice());
            if common.abs() < 1e-12 {
                stuck += 1;
            } else {
                sliding += 1;
            }
            let cost = |w: &DVector<f64>| {
                let rows = levels.rows.iter().zip(w.iter());
                let dry: f64 = rows.map(|(level, w)| level.effort(*w) * w).sum();
                let pair = levels.pairs[0];
                0.5 * (w.transpose() * &m * w)[0] - r.dot(w)
                    + dry
                    + pair.level * pair.speed(w.as_slice()).abs()
            };
            let least = cost(&w);
            for _ in 0..40 {
                let step = DVector::from_fn(n, |_, _| random.random_range(-1e-3..1e-3));
                assert!(cost(&(&w + &step)) > least - 1e-12, "case {case}");
            }
        }
        assert!(stuck > 40 && sliding > 40, "{stuck} {sliding}");
    }
}
