//! The arm that is moved: rigid body and effects on its joints.

use std::collections::BTreeSet;
use std::fmt;

use armident_dynamics::{RigidArm, Sweep, composite_bodies, inertia_matrix_of};
use armident_effects::{Effect, EffectOnJoint, JointState};
use nalgebra::{DMatrix, DVector};

use crate::error::SimulationError;

/// An effect of the library with its numbers.
#[derive(Clone)]
pub struct EffectWithParameters {
    /// The law.
    pub effect: &'static dyn Effect,
    /// Numbers in the order of the law, finite and of admissible sign.
    pub parameters: Vec<f64>,
}

impl fmt::Debug for EffectWithParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{:?}", self.effect.law().slug, self.parameters)
    }
}

/// A rigid arm with named joints and effects on them.
#[derive(Debug, Clone)]
pub struct SimulatedArm {
    rigid: RigidArm,
    joints: Vec<String>,
    effects: Vec<Vec<EffectWithParameters>>,
}

impl SimulatedArm {
    /// The arm with joints named from base to tip and effects on some of them. Several effects on
    /// one joint add up, also several of one kind.
    ///
    /// # Errors
    /// Names that are not one per joint; an effect that the library does not have, on a joint that
    /// the arm does not have, or with parameters that are not finite or of the wrong sign.
    pub fn new(
        arm: RigidArm,
        joint_names: &[impl AsRef<str>],
        effects: &[EffectOnJoint],
    ) -> Result<Self, SimulationError> {
        let joints: Vec<String> = joint_names.iter().map(|name| name.as_ref().to_owned()).collect();
        let different = joints.iter().collect::<BTreeSet<_>>().len();
        if joints.len() != arm.dof() || different != arm.dof() {
            return Err(SimulationError::JointNames { joints: arm.dof(), names: different });
        }
        let mut on_joint = vec![Vec::new(); arm.dof()];
        for given in effects {
            let effect = given.resolve().map_err(|error| SimulationError::UnknownEffect {
                error,
                joint: given.joint.clone(),
            })?;
            let index = joints.iter().position(|name| *name == given.joint).ok_or_else(|| {
                SimulationError::UnknownJoint {
                    effect: given.effect.clone(),
                    joint: given.joint.clone(),
                    known: joints.clone(),
                }
            })?;
            for (parameter, &value) in effect.law().parameters.iter().zip(&given.parameters) {
                if !parameter.admissible.allows(value) {
                    return Err(SimulationError::Parameter {
                        effect: effect.law().slug,
                        joint: given.joint.clone(),
                        parameter: parameter.name,
                        value,
                        unit: parameter.unit(arm.joints[index].kind),
                    });
                }
            }
            let parameters = given.parameters.clone();
            on_joint[index].push(EffectWithParameters { effect, parameters });
        }
        Ok(Self { rigid: arm, joints, effects: on_joint })
    }

    /// The rigid body alone.
    pub fn rigid(&self) -> &RigidArm {
        &self.rigid
    }

    /// Joint names from base to tip.
    pub fn joints(&self) -> &[String] {
        &self.joints
    }

    /// Effects on joint `joint`, in the order in which they were given.
    pub fn effects(&self, joint: usize) -> &[EffectWithParameters] {
        &self.effects[joint]
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Effort that joint `joint` needs on top of the rigid body at a state, without dry friction
    /// and added inertia \[N m or N\].
    pub fn smooth_effort(&self, joint: usize, position: f64, velocity: f64) -> f64 {
        let state = JointState { position, velocity };
        self.effects[joint].iter().map(|e| e.effect.smooth_effort(&e.parameters, &state)).sum()
    }

    /// Dry friction level of joint `joint` \[N m or N\].
    pub fn dry_friction(&self, joint: usize) -> f64 {
        self.effects[joint].iter().map(|e| e.effect.dry_friction(&e.parameters)).sum()
    }

    /// Inertia that the effects add to the diagonal of `H` at joint `joint` \[kg m2 or kg\].
    pub fn added_inertia(&self, joint: usize) -> f64 {
        self.effects[joint].iter().map(|e| e.effect.added_inertia(&e.parameters)).sum()
    }

    /// `M(q)` and the effort `b(q, q̇)` that everything but `M q̈` and dry friction takes.
    pub(crate) fn equations(
        &self,
        q: &[f64],
        dq: &[f64],
        scratch: &mut EquationsScratch,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let mut bias = DVector::zeros(self.dof());
        let EquationsScratch { sweep, zero } = scratch;
        armident_dynamics::inverse_dynamics_into(
            &self.rigid,
            q,
            dq,
            zero,
            sweep,
            bias.as_mut_slice(),
        );
        let bodies = composite_bodies(&self.rigid, &sweep.poses);
        let mut inertia = inertia_matrix_of(&self.rigid, &sweep.poses, &bodies);
        for j in 0..self.dof() {
            inertia[(j, j)] += self.added_inertia(j);
            bias[j] += self.smooth_effort(j, q[j], dq[j]);
        }
        (inertia, bias)
    }
}

/// Memory that [`SimulatedArm::equations`] uses again and again.
#[derive(Debug, Clone)]
pub(crate) struct EquationsScratch {
    sweep: Sweep<f64>,
    zero: Vec<f64>,
}

impl EquationsScratch {
    pub(crate) fn new(dof: usize) -> Self {
        Self { sweep: Sweep::new(dof), zero: vec![0.0; dof] }
    }
}
