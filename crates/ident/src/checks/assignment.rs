//! Which column belongs to which joint: the linear assignment problem.
//!
//! Method: the Hungarian algorithm on costs rounded to 2⁻²⁰, which makes sums exact. Among assignments of the same total
//! the last row takes the last column that any of them gives it, then the row before, and so on: equal columns stay in
//! the order of the header.
//!
//! References: H. W. Kuhn, The Hungarian method for the assignment problem, Naval Research Logistics Quarterly 2 (1955).

use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

/// Steps per unit of cost: log likelihoods that differ by less are the same.
const STEPS: f64 = 1_048_576.0;
/// Largest finite cost in steps; more is more than any sum of those.
const LARGEST: i64 = i64::MAX >> 16;

/// Row -> column of the assignment with the least sum of costs, which may be infinite off the diagonal.
///
/// `cost` is square, `[row][column]`.
pub(super) fn cheapest_assignment(cost: &[Vec<f64>]) -> Vec<usize> {
    let n = cost.len();
    let finite = cost.iter().flatten().copied().filter(|c| c.is_finite());
    let least = finite.fold(f64::INFINITY, f64::min);
    let steps: Vec<Vec<i64>> =
        cost.iter().map(|row| row.iter().map(|c| in_steps(c - least)).collect()).collect();
    let rows: Vec<usize> = (0..n).collect();
    let mut columns = rows.clone();
    let mut total = least_total(&steps, &rows, &columns);
    let mut order = vec![0; n];
    for row in (0..n).rev() {
        let chosen = columns.iter().rposition(|&column| {
            let others: Vec<usize> = columns.iter().copied().filter(|c| *c != column).collect();
            steps[row][column] + least_total(&steps, &rows[..row], &others) == total
        });
        // the optimum gives the row one of the columns
        let Some(place) = chosen else { return rows };
        order[row] = columns.remove(place);
        total -= steps[row][order[row]];
    }
    order
}

fn in_steps(cost: f64) -> i64 {
    // also of infinity; NaN is 0
    ((STEPS * cost).round() as i64).min(LARGEST)
}

/// Least sum of an assignment of all rows to some of as many columns.
fn least_total(steps: &[Vec<i64>], rows: &[usize], columns: &[usize]) -> i64 {
    if rows.is_empty() {
        return 0;
    }
    let picked = rows.iter().map(|&row| columns.iter().map(move |&column| steps[row][column]));
    Matrix::from_rows(picked).map_or(i64::MAX, |matrix| kuhn_munkres_min(&matrix).0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn cheapest_assignment_of_small_cases() {
        assert_eq!(cheapest_assignment(&[vec![1.0]]), [0]);
        let cost = [vec![9.0, 1.0, 5.0], vec![1.0, 9.0, 5.0], vec![5.0, 5.0, 1.0]];
        assert_eq!(cheapest_assignment(&cost), [1, 0, 2]);
        let cycle = [vec![9.0, 0.0, 9.0], vec![9.0, 9.0, 0.0], vec![0.0, 9.0, 9.0]];
        assert_eq!(cheapest_assignment(&cycle), [1, 2, 0]);
    }

    #[test]
    fn equal_costs_keep_the_header_order() {
        assert_eq!(cheapest_assignment(&vec![vec![0.0; 4]; 4]), [0, 1, 2, 3]);
        // columns 0 and 1 hold the same, 2 and 3 are swapped
        let infinite = f64::INFINITY;
        let cost = [
            vec![1.0, 1.0, 5.0, infinite],
            vec![2.0, 2.0, 5.0, 7.0],
            vec![5.0, 5.0, 9.0, 0.0],
            vec![5.0, 5.0, 0.0, 9.0],
        ];
        assert_eq!(cheapest_assignment(&cost), [0, 1, 3, 2]);
    }

    #[test]
    fn more_than_sixteen_columns_are_assigned() {
        let order: Vec<usize> = (0..20).map(|k| (7 * k + 3) % 20).collect();
        let cost: Vec<Vec<f64>> = order
            .iter()
            .map(|&own| (0..20).map(|k| if k == own { 0.0 } else { 1.0 + k as f64 }).collect())
            .collect();
        assert_eq!(cheapest_assignment(&cost), order);
    }

    /// Least total over subsets of columns, row by row; ties as above.
    fn by_subsets(cost: &[Vec<f64>]) -> Vec<usize> {
        let n = cost.len();
        let mut least = vec![(f64::INFINITY, 0); 1 << n];
        least[0].0 = 0.0;
        for set in 0..(1_usize << n) - 1 {
            let row = set.count_ones() as usize;
            for column in (0..n).filter(|c| set >> c & 1 == 0) {
                let next = set | 1 << column;
                let total = least[set].0 + cost[row][column];
                if total < least[next].0 {
                    least[next] = (total, column);
                }
            }
        }
        let mut order = vec![0; n];
        let mut set = (1_usize << n) - 1;
        for row in (0..n).rev() {
            order[row] = least[set].1;
            set &= !(1 << order[row]);
        }
        order
    }

    /// Costs of a few whole numbers have many ties.
    #[test]
    fn assignment_agrees_with_enumeration_of_subsets() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(5);
        for case in 0..500 {
            let n = 1 + case % 8;
            let range = [2.0, 4.0, 1e5][case % 3];
            let mut draw = |i: usize, j: usize| -> f64 {
                let cost: f64 = random.random_range(0.0..range);
                match case % 3 {
                    2 => cost,
                    _ if i != j && cost < 0.2 => f64::INFINITY,
                    _ => cost.round(),
                }
            };
            let cost: Vec<Vec<f64>> =
                (0..n).map(|i| (0..n).map(|j| draw(i, j)).collect()).collect();
            assert_eq!(cheapest_assignment(&cost), by_subsets(&cost), "{cost:?}");
        }
    }
}
