//! The batch problem: the parameters of an arm, and the joints in whose effort each appears.
//!
//! ```text
//! τ_j = Σ Y_jk x_k + Σ φ_jl(motion) p_l + noise_j
//! ```
//!
//! Method: the constants of the minimal set and the parameters of the baseline laws of every joint; what the arm's
//! structure makes a combination of others is found by ordered elimination at random states and merged.
//!
//! References: M. Gautier, W. Khalil, Direct calculation of minimum set of inertial parameters of serial robots, IEEE
//! T-RA 6(3), 1990 (regrouping of columns); the rest is own.

use std::sync::Arc;

use armident_dynamics::RigidArm;
use armident_effects::{
    BASELINE, Effect, EffectOnJoint, JointMotion, ReversalModel, SublinearViscousFriction,
    directions_with,
};
use armident_kinematics::InertialParameters;
use armident_numeric::{Mat, eliminate_in_order};

use super::known_load::KnownLoad;
use super::unknown::{Coupling, LAWS, MergedTerm, SHARED, Term};
use crate::minimal_set::{MinimalSet, random_states};

/// Cut of the structural elimination at random states.
const DEPENDENT: f64 = 1e-8;
/// Names of the ten parameters of a body.
const NUMBERS: [&str; 10] = ["m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];

/// The parameters of an arm and where they appear.
#[derive(Debug, Clone)]
pub struct BatchProblem {
    arm: Arc<RigidArm>,
    set: Arc<MinimalSet>,
    /// Parameters estimated.
    pub terms: Vec<Term>,
    /// Parameters merged into others by the arm's structure (rotor inertia of joint 1 and `U1_33`).
    pub merged: Vec<MergedTerm>,
    pub(crate) by_joint: Vec<Vec<usize>>,
    /// Loads with unknowns.
    pub(crate) loads: Vec<KnownLoad>,
    /// How each joint's dry friction reverses; none: regularised below a share of the RMS speed of the motion at hand.
    pub reversals: Option<Vec<ReversalModel>>,
    /// Joints whose effort channels have a dead zone.
    pub(crate) has_dead_zone: Vec<bool>,
}

impl BatchProblem {
    /// The minimal set and every linear effect of the library on every joint, less what the arm's
    /// structure merges (decided at random states: rotor inertia of the first joint is its `U_33`).
    pub fn new(arm: &RigidArm, set: &MinimalSet) -> Self {
        let n = arm.dof();
        let mut all: Vec<Term> = (0..set.len()).map(Term::Constant).collect();
        for joint in 0..n {
            for (effect, law) in BASELINE.iter().enumerate() {
                for parameter in 0..law.law().parameters.len() {
                    all.push(Term::Effect { joint, effect, parameter });
                }
            }
        }
        // effect by effect, so that what is merged away is an effect and not a rigid constant, and
        // rotor inertia (last in the library) before friction
        let states = random_states(arm, 12 * n + 30);
        let columns_of = |joint: usize, pick: usize| -> Vec<f64> {
            states.iter().map(|s| [&s.0, &s.1, &s.2][pick][joint]).collect()
        };
        let mut matrix = Mat::<f64>::zeros(states.len() * n, all.len());
        for (row, (q, dq, ddq)) in states.iter().enumerate() {
            let rigid = set.columns().regressor(arm, q, dq, ddq);
            for joint in 0..n {
                for k in 0..set.len() {
                    matrix[(row * n + joint, k)] = rigid[joint * set.len() + k];
                }
            }
        }
        for joint in 0..n {
            let [q, dq, ddq] = [0, 1, 2].map(|pick| columns_of(joint, pick));
            let time: Vec<f64> = (0..states.len()).map(|t| t as f64).collect();
            let motion = JointMotion {
                time_s: &time,
                position: &q,
                velocity: &dq,
                acceleration: &ddq,
                kind: arm.joints[joint].kind,
                direction: &directions_with(&dq, 1e-6),
                rigid_effort: &[],
                temperature_c: &[],
            };
            for (effect, law) in BASELINE.iter().enumerate() {
                for (parameter, column) in law.columns(&[], &motion).iter().enumerate() {
                    let term = Term::Effect { joint, effect, parameter };
                    let Some(k) = all.iter().position(|t| *t == term) else { continue };
                    for (row, value) in column.iter().enumerate() {
                        matrix[(row * n + joint, k)] = *value;
                    }
                }
            }
        }
        let order: Vec<usize> = (0..all.len()).collect();
        let elimination = eliminate_in_order(&matrix, &order, DEPENDENT);
        let mut kept = elimination.kept.clone();
        kept.sort_unstable();
        let place = |k: usize| kept.iter().position(|&x| x == k).unwrap_or(usize::MAX);
        let merged = elimination
            .dropped
            .iter()
            .map(|d| MergedTerm {
                term: all[d.column],
                into: d.combination.iter().map(|&(k, x)| (place(k), x)).collect(),
            })
            .collect();
        let terms: Vec<Term> = kept.iter().map(|&k| all[k]).collect();
        let by_joint = (0..n)
            .map(|joint| {
                (0..terms.len())
                    .filter(|&k| match terms[k] {
                        Term::Constant(c) => set.constants[c].joint >= joint,
                        Term::Effect { joint: on, .. } => on == joint,
                        Term::Shared { coupling, .. } => coupling.joints().contains(&joint),
                        Term::Load { .. } => true,
                    })
                    .collect()
            })
            .collect();
        Self {
            arm: Arc::new(arm.clone()),
            set: Arc::new(set.clone()),
            terms,
            merged,
            by_joint,
            loads: Vec::new(),
            reversals: None,
            has_dead_zone: vec![false; n],
        }
    }

    /// The same with joints whose effort channels have a dead zone. All rows of such a joint together weigh as one
    /// sample, whose error is what the URDF's body would need there, and it shares no transmission.
    #[must_use]
    pub fn with_dead_zones(mut self, has_dead_zone: Vec<bool>) -> Self {
        self.has_dead_zone = has_dead_zone;
        self
    }

    /// The same with the unknown parameters of loads, as unknowns of the recordings that have them.
    #[must_use]
    pub fn with_loads(&self, loads: &[KnownLoad]) -> Self {
        let mut problem = self.clone();
        for load in loads.iter().filter(|load| load.centre_error_m > 0.0) {
            let index = problem.loads.len();
            problem.loads.push(load.clone());
            for number in 1..InertialParameters::COUNT {
                for joint in &mut problem.by_joint {
                    joint.push(problem.terms.len());
                }
                problem.terms.push(Term::Load { load: index, number });
            }
        }
        problem
    }

    /// The same with unknowns of shared transmissions behind its own.
    #[must_use]
    pub fn with_couplings(&self, couplings: &[Coupling]) -> Self {
        let mut problem = self.clone();
        for coupling in couplings {
            for term in coupling.terms() {
                for joint in coupling.joints() {
                    problem.by_joint[joint].push(problem.terms.len());
                }
                problem.terms.push(term);
            }
        }
        problem
    }

    /// The same with sublinear viscous friction of these joints behind its unknowns.
    #[must_use]
    pub fn with_sublinear(&self, joints: &[usize]) -> Self {
        let mut problem = self.clone();
        let Some(effect) =
            LAWS.iter().position(|law| law.law().slug == SublinearViscousFriction.law().slug)
        else {
            return problem;
        };
        for &joint in joints {
            problem.by_joint[joint].push(problem.terms.len());
            problem.terms.push(Term::Effect { joint, effect, parameter: 0 });
        }
        problem
    }

    /// The arm whose efforts are explained.
    pub fn arm(&self) -> &RigidArm {
        &self.arm
    }

    /// The constants among the unknowns.
    pub fn set(&self) -> &MinimalSet {
        &self.set
    }

    /// Terms that appear in the effort of a joint.
    pub fn terms_of_joint(&self, joint: usize) -> &[usize] {
        &self.by_joint[joint]
    }

    /// Label of a term: the constant's, or `effect.parameter(joint)`.
    pub fn label(&self, term: &Term, joint_names: &[&str]) -> String {
        match *term {
            Term::Constant(k) => self.set.constants[k].label(),
            Term::Effect { joint, effect, parameter } => {
                let law = LAWS[effect].law();
                if law.parameters.len() == 1 {
                    format!("{}({})", law.slug, joint_names[joint])
                } else {
                    format!(
                        "{}.{}({})",
                        law.slug, law.parameters[parameter].name, joint_names[joint]
                    )
                }
            }
            Term::Load { load, number } => {
                let source = self.loads[load].sources.join(", ");
                format!("load.{}({source})", NUMBERS[number])
            }
            Term::Shared { coupling, .. } => {
                let name = term.parameter().map_or("", |parameter| parameter.name);
                let [a, b] = coupling.joints().map(|joint| joint_names[joint]);
                format!("{}.{name}({a}, {b})", SHARED.law().slug)
            }
        }
    }

    /// Values of the minimal constants within a vector of all terms.
    pub fn constants(&self, values: &[f64]) -> Vec<f64> {
        let mut constants = vec![0.0; self.set.len()];
        for (term, &value) in self.terms.iter().zip(values) {
            if let Term::Constant(k) = *term {
                constants[k] = value;
            }
        }
        constants
    }

    /// The effects within a vector of all terms; merged parameters are zero.
    pub fn effects(&self, values: &[f64], joint_names: &[&str]) -> Vec<EffectOnJoint> {
        let mut list: Vec<EffectOnJoint> = Vec::new();
        for (term, &value) in self.terms.iter().zip(values) {
            let Term::Effect { joint, effect, parameter } = *term else { continue };
            let law = LAWS[effect].law();
            let name = joint_names[joint];
            let index = match list.iter().position(|e| e.effect == law.slug && e.joint == name) {
                Some(index) => index,
                None => {
                    let zeros = vec![0.0; law.parameters.len()];
                    list.push(EffectOnJoint::new(law.slug, name, zeros));
                    list.len() - 1
                }
            };
            list[index].parameters[parameter] = value;
        }
        list.extend(self.couplings_of(values, joint_names));
        list
    }

    /// The shared transmissions within a vector of all terms.
    fn couplings_of(&self, values: &[f64], joint_names: &[&str]) -> Vec<EffectOnJoint> {
        let mut list: Vec<(Coupling, Vec<f64>)> = Vec::new();
        for (term, &value) in self.terms.iter().zip(values) {
            let Term::Shared { coupling, .. } = *term else { continue };
            match list.iter_mut().find(|(of, _)| *of == coupling) {
                Some((_, coefficients)) => coefficients.push(value),
                None => list.push((coupling, vec![value])),
            }
        }
        list.into_iter()
            .map(|(coupling, coefficients)| {
                let [a, b] = coupling.joints().map(|joint| joint_names[joint]);
                let parameters = SHARED.parameters(&[coupling.ratio], &coefficients);
                EffectOnJoint {
                    other_joint: Some(b.to_owned()),
                    ..EffectOnJoint::new(SHARED.law().slug, a, parameters)
                }
            })
            .collect()
    }

    /// Where the centre of a load was found, in the frame of the last joint \[m\]; where it was given, of a
    /// load without unknowns.
    pub fn centre_of(&self, load: &KnownLoad, values: &[f64]) -> [f64; 3] {
        let mut centre = load.body.com_m();
        for (term, value) in self.terms.iter().zip(values) {
            if let Term::Load { load: index, number: number @ 1..4 } = *term
                && self.loads[index] == *load
            {
                centre[number - 1] += value / load.mass_kg;
            }
        }
        centre.into()
    }
}
