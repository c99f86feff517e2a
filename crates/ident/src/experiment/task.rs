//! The steps of Algorithm 2 in order: who moves, who is observed, what is sought.

use armident_dynamics::RigidArm;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::equations::Equation;
use crate::minimal_set::{ConstantKind, MinimalSet};

/// One step of the algorithm, before configurations are chosen. Joints count from 0.
#[derive(Debug, Clone)]
pub struct Task {
    /// Number of the step in the paper: `1`, `2.1`, `2.2`, `3.1a`, `3.1b`, `3.1c`, `3.2`.
    pub step: &'static str,
    /// Equation used.
    pub equation: Equation,
    /// Joint whose effort is used.
    pub observed: usize,
    /// Joints that may be the moving one; the best conditioned is taken.
    pub movers: Vec<usize>,
    /// Joints moved alone in addition when one mover does not suffice (zero gravity only).
    pub further_movers: Vec<usize>,
    /// Constants sought, as indices into [`MinimalSet::constants`].
    pub unknowns: Vec<usize>,
    /// How many configurations to measure in.
    pub configurations: usize,
}

/// Random positions at which "for all q" is tested.
const TRIALS: usize = 12;
/// A component below this is zero on a snapped chain.
const EXACT: f64 = 1e-9;

/// All steps for an arm; steps without unknowns are left out.
pub fn tasks(arm: &RigidArm, set: &MinimalSet) -> Vec<Task> {
    let n = arm.dof();
    let trials = Trials::new(arm);
    let turns = |j: usize| arm.joints[j].kind.is_rotational();
    let of_joint = |joint: usize, wanted: &dyn Fn(&ConstantKind) -> bool| -> Vec<usize> {
        (0..set.len())
            .filter(|&k| set.constants[k].joint == joint && wanted(&set.constants[k].quantity))
            .collect()
    };
    let any = |_: &ConstantKind| true;
    let not_mass = |q: &ConstantKind| *q != ConstantKind::Mass;
    let (r, s) = (set.theorem.r, set.theorem.s);
    let mut all = Vec::new();
    let mut add = |step, observed: usize, movers: Vec<usize>, unknowns: Vec<usize>, count| {
        if unknowns.is_empty() || movers.is_empty() {
            return;
        }
        let seeks_c = unknowns.iter().any(|&k| {
            matches!(set.constants[k].quantity, ConstantKind::C1(_) | ConstantKind::C2(_))
        });
        let further = (0..observed).filter(|i| !movers.contains(i)).collect();
        all.push(Task {
            step,
            equation: Equation::of(arm, movers[0], observed, seeks_c),
            observed,
            movers,
            further_movers: further,
            unknowns,
            configurations: count,
        });
    };

    for k in (0..n).filter(|&k| !turns(k)) {
        add("1", k, vec![k], of_joint(k, &|q| *q == ConstantKind::Mass), 2);
    }
    let Some(r) = r else { return all };
    let s_start = s.unwrap_or(n);
    for j in (s_start..n).rev() {
        if turns(j) {
            let perpendicular =
                trials.all(|poses| arm.axis_in_frames(poses, r)[j - r].0.z.abs() <= EXACT);
            let own = of_joint(j, &|q| *q == ConstantKind::U33);
            if !perpendicular {
                add("2.1", j, vec![r], of_joint(j, &any), 5);
            } else if arm.gravity_e0.norm() == 0.0 {
                // (58) then holds U33 alone, and the other equations need it
                add("2.1", j, vec![j], own, 2);
                add("2.1", j, vec![r], of_joint(j, &|q| *q != ConstantKind::U33), 5);
            } else {
                add("2.1", j, vec![r], of_joint(j, &|q| *q != ConstantKind::U33), 5);
                add("2.1", j, vec![j], own, 2);
            }
        } else {
            add("2.2", j, vec![r], of_joint(j, &not_mass), 4);
        }
    }
    let gravity_across = {
        let gravity: nalgebra::Vector3<f64> = arm.gravity_in_frames(&arm.poses(&vec![0.0; n]))[r];
        gravity.x.hypot(gravity.y) > EXACT * gravity.norm()
    };
    for j in (r..s_start).rev() {
        if !turns(j) {
            add("3.2", j, vec![r], of_joint(j, &not_mass), 2);
            continue;
        }
        let everything = of_joint(j, &any);
        if gravity_across {
            add("3.1a", j, vec![r], everything, 4);
            continue;
        }
        let eccentric: Vec<usize> = (r..j)
            .filter(|&i| {
                turns(i)
                    && !trials.all(|poses| {
                        let s = arm.axis_in_frames(poses, i)[j - i].1;
                        s.x.hypot(s.y) <= EXACT
                    })
            })
            .collect();
        if eccentric.is_empty() {
            add("3.1c", j, vec![r], of_joint(j, &|q| *q == ConstantKind::U33), 2);
            let across: Vec<usize> = (0..j)
                .filter(|&k| {
                    !turns(k)
                        && !trials.all(|poses| {
                            let u = arm.axis_in_frames(poses, k)[j - k].0;
                            u.x.hypot(u.y) <= EXACT
                        })
                })
                .collect();
            add("3.1c", j, across, of_joint(j, &|q| *q != ConstantKind::U33), 4);
        } else {
            add("3.1b", j, eccentric, everything, 4);
        }
    }
    all
}

struct Trials {
    poses: Vec<Vec<armident_dynamics::JointPose>>,
}

impl Trials {
    fn new(arm: &RigidArm) -> Self {
        let mut random = Pcg64::seed_from_u64(1);
        let poses = (0..TRIALS)
            .map(|_| {
                let q: Vec<f64> = (0..arm.dof()).map(|_| random.random_range(-1.5..1.5)).collect();
                arm.poses(&q)
            })
            .collect();
        Self { poses }
    }

    fn all(&self, test: impl Fn(&[armident_dynamics::JointPose]) -> bool) -> bool {
        self.poses.iter().all(|poses| test(poses))
    }
}
