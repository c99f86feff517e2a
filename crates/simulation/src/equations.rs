//! The equations of motion at one state.

use armident_dynamics::{Sweep, composite_bodies, inertia_matrix_of};
use armident_effects::DryFriction;
use nalgebra::{DMatrix, DVector};

use crate::dry_friction::{PairLevel, RowLevels};
use crate::simulated_arm::SimulatedArm;

/// Rows of the equations: the links of all joints, then the motors that have a transmission.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    /// Row of the recorded position of each joint: its motor's, or its link's.
    pub(crate) recorded: Vec<usize>,
    /// Number of rows.
    pub(crate) count: usize,
}

impl Rows {
    pub(crate) fn of(arm: &SimulatedArm) -> Self {
        let mut count = arm.dof();
        let recorded = (0..arm.dof()).map(|joint| match arm.transmission(joint) {
            Some(_) => {
                count += 1;
                count - 1
            }
            None => joint,
        });
        let recorded = recorded.collect();
        Self { recorded, count }
    }
}

/// `M a + bias + dry friction = effort`, with the efforts on the recorded rows.
#[derive(Debug, Clone)]
pub(crate) struct Equations {
    pub(crate) inertia: DMatrix<f64>,
    pub(crate) bias: DVector<f64>,
    /// Coriolis, centrifugal and gravity efforts alone.
    rigid_bias: Vec<f64>,
    /// Effort through the transmission of each joint that has one.
    transmitted: Vec<Option<f64>>,
}

impl Equations {
    /// At a state of all rows; `deflections` are those of the arm's effects with memory.
    pub(crate) fn at(
        arm: &SimulatedArm,
        rows: &Rows,
        time_s: f64,
        q: &[f64],
        v: &[f64],
        deflections: &[f64],
        scratch: &mut EquationsScratch,
    ) -> Self {
        let n = arm.dof();
        let EquationsScratch { sweep, zero } = scratch;
        let mut rigid_bias = vec![0.0; n];
        armident_dynamics::inverse_dynamics_into(
            arm.rigid(),
            &q[..n],
            &v[..n],
            zero,
            sweep,
            &mut rigid_bias,
        );
        let bodies = composite_bodies(arm.rigid(), &sweep.poses);
        let links = inertia_matrix_of(arm.rigid(), &sweep.poses, &bodies);
        let mut inertia =
            if rows.count == n { links } else { links.resize(rows.count, rows.count, 0.0) };
        let mut bias = DVector::zeros(rows.count);
        bias.as_mut_slice()[..n].copy_from_slice(&rigid_bias);
        let mut transmitted = vec![None; n];
        for j in 0..n {
            let row = rows.recorded[j];
            inertia[(row, row)] += arm.added_inertia(j);
            bias[row] += arm.smooth_effort(j, time_s, q[row], v[row]);
            if let Some(transmission) = arm.transmission(j) {
                inertia[(row, row)] += transmission.motor_inertia;
                let effort = transmission.effort(q[row] - q[j], v[row] - v[j]);
                bias[row] += effort;
                bias[j] -= effort;
                transmitted[j] = Some(effort);
            }
        }
        for ((j, law), &deflection) in arm.deflections().zip(deflections) {
            let row = rows.recorded[j];
            bias[row] += law.effect.deflection_effort(&law.parameters, deflection, v[row]);
        }
        for pair in arm.pairs() {
            let (a, b) = (rows.recorded[pair.a], rows.recorded[pair.b]);
            let effort = pair.viscous * (v[b] + pair.ratio * v[a]);
            bias[b] += effort;
            bias[a] += pair.ratio * effort;
        }
        if let Some(contact) = arm.contact_effort(time_s, &q[..n]) {
            contact.iter().enumerate().for_each(|(j, effort)| bias[j] += effort);
        }
        Self { inertia, bias, rigid_bias, transmitted }
    }

    /// What each gear carries at these accelerations \[N m or N\].
    pub(crate) fn loads(&self, arm: &SimulatedArm, acceleration: &[f64]) -> Vec<f64> {
        let n = arm.dof();
        let rigid = |j: usize| {
            let inertial: f64 = (0..n).map(|k| self.inertia[(j, k)] * acceleration[k]).sum();
            inertial - arm.added_inertia(j) * acceleration[j] + self.rigid_bias[j]
        };
        (0..n).map(|j| self.transmitted[j].unwrap_or_else(|| rigid(j))).collect()
    }
}

/// Dry friction of all rows at their speeds and loads.
pub(crate) fn row_levels(arm: &SimulatedArm, rows: &Rows, v: &[f64], loads: &[f64]) -> RowLevels {
    let mut rows_levels = vec![DryFriction::default(); rows.count];
    for j in 0..arm.dof() {
        let row = rows.recorded[j];
        rows_levels[row] = arm.dry_friction(j, v[row], loads[j]);
    }
    let pairs = arm.pairs().iter().filter(|pair| pair.coulomb > 0.0);
    let pairs = pairs.map(|pair| PairLevel {
        a: rows.recorded[pair.a],
        b: rows.recorded[pair.b],
        ratio: pair.ratio,
        level: pair.coulomb,
    });
    RowLevels { rows: rows_levels, pairs: pairs.collect() }
}

/// Memory that [`Equations::at`] uses again and again.
#[derive(Debug, Clone)]
pub(crate) struct EquationsScratch {
    sweep: Sweep,
    zero: Vec<f64>,
}

impl EquationsScratch {
    pub(crate) fn new(dof: usize) -> Self {
        Self { sweep: Sweep::new(dof), zero: vec![0.0; dof] }
    }
}
