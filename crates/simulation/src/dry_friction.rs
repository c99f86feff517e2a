//! The set-valued friction law in one step or at one instant.

use nalgebra::{DMatrix, DVector};

/// Relative size below which a violated sign or level is rounding.
const ROUNDING: f64 = 1e-12;
/// Most pivots; only matrices that are singular to rounding need more than a few per joint.
const MOST_PIVOTS: usize = 100_000;

/// Solves `M w + λ = r`, `λ_j ∈ level_j Sign(w_j)`: `w` and `λ` of Coulomb friction with stiction.
///
/// `Sign(0) = [-1, 1]`; a joint that sticks has `w_j = 0` exactly, a joint with level 0 has `λ_j = 0`.
/// `M` is symmetric positive definite, so that the solution exists, is unique and minimises
/// `½ wᵀ M w - rᵀ w + Σ level_j |w_j|`.
///
/// Every joint with friction is assumed to slide forward, to slide backward or to stick, first as
/// `guess` says (its signs); the linear equations of the sliding ones are solved, and the first joint
/// that contradicts its assumption changes it. This least-index principal pivoting ends after
/// finitely many steps for every such `M` (Júdice and Pires, Basic-set algorithm for a generalized
/// linear complementarity problem, J. Optim. Theory Appl. 74 (1992)).
///
/// Returns nothing if `M` is not positive definite, or only up to rounding.
pub(crate) fn solve_dry_friction(
    m: &DMatrix<f64>,
    r: &DVector<f64>,
    level: &[f64],
    guess: &[f64],
) -> Option<DVector<f64>> {
    let n = r.len();
    let mut sign: Vec<f64> =
        guess.iter().map(|g| if *g == 0.0 { 0.0 } else { g.signum() }).collect();
    for _ in 0..MOST_PIVOTS {
        let sliding: Vec<usize> = (0..n).filter(|&j| level[j] == 0.0 || sign[j] != 0.0).collect();
        let mut w = DVector::zeros(n);
        if !sliding.is_empty() {
            let reduced = m.select_rows(&sliding).select_columns(&sliding);
            let driving = sliding.iter().map(|&j| r[j] - level[j] * sign[j]);
            let driving = DVector::from_iterator(sliding.len(), driving);
            let solved = reduced.cholesky()?.solve(&driving);
            for (&j, value) in sliding.iter().zip(&solved) {
                w[j] = *value;
            }
        }
        let held = r - m * &w;
        let smallest = ROUNDING * w.amax();
        let contradicted = (0..n).filter(|&j| level[j] > 0.0).find_map(|j| {
            if sign[j] != 0.0 {
                (w[j] * sign[j] < -smallest).then_some((j, 0.0))
            } else {
                let terms = (0..n).map(|k| (m[(j, k)] * w[k]).abs()).sum::<f64>();
                let rounding = ROUNDING * (r[j].abs() + terms + level[j]);
                let beyond = held[j].abs() > level[j] + rounding;
                beyond.then_some((j, held[j].signum()))
            }
        });
        match contradicted {
            Some((j, changed)) => sign[j] = changed,
            None => {
                for j in 0..n {
                    if level[j] > 0.0 && w[j] * sign[j] <= 0.0 {
                        w[j] = 0.0;
                    }
                }
                return Some(w);
            }
        }
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
            let w = solve_dry_friction(&m, &r, &level, &guess).unwrap();
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

    #[test]
    fn refuses_matrices_that_are_not_positive_definite() {
        let m = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, -1.0]));
        let r = DVector::from_vec(vec![1.0, 5.0]);
        assert!(solve_dry_friction(&m, &r, &[0.0, 1.0], &[0.0, 0.0]).is_none());
    }
}
