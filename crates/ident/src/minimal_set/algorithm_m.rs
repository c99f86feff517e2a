//! Algorithm M: the printed minimal set, Theorem 2 checked by the regressor itself.

use armident_dynamics::{
    BodyConstants, ParameterColumns, RigidArm, inverse_dynamics, standard_regressor,
};
use armident_numeric::{Mat, NumericError, RankDecision, eliminate_in_order, rank_of_columns};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::constant::{Constant, zero_bodies};
use super::theorem2::Theorem2;

/// Seed of the random states; any other gives the same set.
const SEED: u64 = 0x1992;
/// Cut between dependent and independent unit columns: kept ones are above 4e-5 and dropped ones
/// below 4e-12 over thousands of snapped chains.
const DEPENDENT: f64 = 1e-8;
/// Relative rank cut of the full regressor.
const RANK_TOLERANCE: f64 = 1e-9;
/// Sufficiency: largest relative effort error of the minimal constants.
const SUFFICIENT: f64 = 1e-9;

/// A Theorem-2 constant that cannot be determined on its own (at zero gravity only).
#[derive(Debug, Clone)]
pub struct DroppedConstant {
    /// The constant.
    pub constant: Constant,
    /// What it adds to kept constants: (index in [`MinimalSet::constants`], coefficient).
    pub regrouped_into: Vec<(usize, f64)>,
}

/// The constants an arm's efforts depend on, and nothing more.
#[doc(alias = "base parameters")]
#[derive(Debug, Clone)]
pub struct MinimalSet {
    /// Structure and constants of the theorem.
    pub theorem: Theorem2,
    /// The minimal constants, in the order of the theorem.
    pub constants: Vec<Constant>,
    /// Theorem-2 constants left out.
    pub dropped: Vec<DroppedConstant>,
    /// Rank of the regressor in all `10 n` standard parameters: the independent judge.
    pub rank: RankDecision,
    /// Largest relative effort error when the minimal constants stand for all (round-off when the
    /// set is sufficient).
    pub sufficiency_error: f64,
    columns: ParameterColumns,
    dof: usize,
}

impl MinimalSet {
    /// Determines the set of an arm with its gravity.
    ///
    /// Cost: `12 n + 30` random states, one QR of `n (12 n + 30)` rows by `10 n` columns.
    ///
    /// # Errors
    /// [`NumericError`] when the geometry holds numbers that are not finite.
    pub fn of(arm: &RigidArm) -> Result<Self, NumericError> {
        let n = arm.dof();
        let theorem = Theorem2::of(arm);
        let listed: Vec<Constant> = theorem.constants.iter().map(|&(_, c)| c).collect();
        let all_columns = unit_columns(arm, &listed);

        let states = random_states(arm, 12 * n + 30);
        let mut full = Vec::with_capacity(states.len() * n * 10 * n);
        for (q, dq, ddq) in &states {
            full.extend(standard_regressor(arm, q, dq, ddq));
        }
        let rows = states.len() * n;
        let standard = Mat::from_fn(rows, 10 * n, |i, j| full[i * 10 * n + j]);
        let rank = rank_of_columns(&standard, RANK_TOLERANCE)?;

        let mut mapped = vec![0.0; rows * listed.len()];
        for (row, out) in full.chunks(10 * n).zip(mapped.chunks_mut(listed.len().max(1))) {
            all_columns.map_row(row, out);
        }
        let listed_matrix = Mat::from_fn(rows, listed.len(), |i, j| mapped[i * listed.len() + j]);
        // masses, then inertias, then first moments: what depends is dropped from the end
        let mut order: Vec<usize> = (0..listed.len()).collect();
        order.sort_by_key(|&c| (listed[c].rank_in_algorithm_m(), listed[c].joint));
        let elimination = eliminate_in_order(&listed_matrix, &order, DEPENDENT);

        let mut kept = elimination.kept.clone();
        kept.sort_unstable();
        let place = |column: usize| kept.iter().position(|&k| k == column).unwrap_or(usize::MAX);
        let dropped = elimination
            .dropped
            .iter()
            .map(|d| DroppedConstant {
                constant: listed[d.column],
                regrouped_into: d.combination.iter().map(|&(k, x)| (place(k), x)).collect(),
            })
            .collect();
        let constants: Vec<Constant> = kept.iter().map(|&c| listed[c]).collect();
        let columns = unit_columns(arm, &constants);
        let mut set =
            Self { theorem, constants, dropped, rank, sufficiency_error: 0.0, columns, dof: n };
        set.sufficiency_error = set.measured_sufficiency(arm, &states);
        Ok(set)
    }

    /// Number of constants.
    pub fn len(&self) -> usize {
        self.constants.len()
    }

    /// Whether the arm's efforts depend on nothing (a massless set never is).
    pub fn is_empty(&self) -> bool {
        self.constants.is_empty()
    }

    /// Whether size and rank agree and the constants suffice.
    pub fn is_confirmed(&self) -> bool {
        self.len() == self.rank.rank && self.sufficiency_error <= SUFFICIENT
    }

    /// Labels in order.
    pub fn labels(&self) -> Vec<String> {
        self.constants.iter().map(Constant::label).collect()
    }

    /// Values for given body constants, regrouped.
    pub fn values(&self, bodies: &[BodyConstants]) -> Vec<f64> {
        let mut values: Vec<f64> = self.constants.iter().map(|c| c.value(bodies)).collect();
        for dropped in &self.dropped {
            let value = dropped.constant.value(bodies);
            for &(kept, factor) in &dropped.regrouped_into {
                values[kept] += factor * value;
            }
        }
        values
    }

    /// Body constants that have these values and zeros everywhere else: the input of Algorithm 1.
    ///
    /// They reproduce `H`, `τᵍ` and `τ` of every arm with the same minimal constants.
    pub fn body_constants(&self, values: &[f64]) -> Vec<BodyConstants> {
        let mut bodies = zero_bodies(self.dof);
        for (constant, &value) in self.constants.iter().zip(values) {
            constant.add_to(value, &mut bodies);
        }
        bodies
    }

    /// Regressor columns of the constants.
    pub fn columns(&self) -> &ParameterColumns {
        &self.columns
    }

    /// Largest effort difference, relative to the largest effort, between random constants and
    /// their minimal values.
    fn measured_sufficiency(&self, arm: &RigidArm, states: &[State]) -> f64 {
        let mut random = Pcg64::seed_from_u64(SEED + 1);
        let mut bodies = zero_bodies(self.dof);
        for body in &mut bodies {
            let numbers: [f64; 10] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
            *body = BodyConstants::from_array(&numbers);
        }
        let all = arm.with_constants(&bodies);
        let minimal = arm.with_constants(&self.body_constants(&self.values(&bodies)));
        let (mut difference, mut size) = (0.0_f64, 0.0_f64);
        for (q, dq, ddq) in states.iter().take(20) {
            let expected = inverse_dynamics(&all, q, dq, ddq);
            let found = inverse_dynamics(&minimal, q, dq, ddq);
            for (e, f) in expected.iter().zip(found) {
                difference = difference.max((e - f).abs());
                size = size.max(e.abs());
            }
        }
        if size > 0.0 { difference / size } else { 0.0 }
    }
}

/// One state: `q`, `q̇`, `q̈`.
pub(crate) type State = (Vec<f64>, Vec<f64>, Vec<f64>);

/// Random states of an arm: angles in ±π, lengths in ±1 m, speeds and accelerations in ±2.
pub(crate) fn random_states(arm: &RigidArm, count: usize) -> Vec<State> {
    let mut random = Pcg64::seed_from_u64(SEED);
    let mut draw = |range: f64| random.random_range(-range..range);
    (0..count)
        .map(|_| {
            let q = arm
                .joints
                .iter()
                .map(|j| draw(if j.kind.is_rotational() { std::f64::consts::PI } else { 1.0 }))
                .collect();
            let dq = arm.joints.iter().map(|_| draw(2.0)).collect();
            let ddq = arm.joints.iter().map(|_| draw(2.0)).collect();
            (q, dq, ddq)
        })
        .collect()
}

/// "This constant 1, every other 0" for each constant.
fn unit_columns(arm: &RigidArm, constants: &[Constant]) -> ParameterColumns {
    let sets: Vec<_> = constants
        .iter()
        .map(|constant| {
            let mut bodies = zero_bodies(arm.dof());
            constant.add_to(1.0, &mut bodies);
            bodies
        })
        .collect();
    ParameterColumns::from_constants(arm, &sets)
}
