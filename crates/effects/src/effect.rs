//! The trait of a law.

use std::fmt;

use armident_dynamics::RigidArm;

use crate::controller::ControllerVariables;
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::law::{Law, LawRole, Onset, Scope};
use crate::mechanism::{ArmFrames, Mechanism};
use crate::motion::{
    ArmColumns, DryFriction, JointMotion, JointState, MotionScale, WholeArmMotion,
};
use crate::transmission::Transmission;

/// Step in which an estimator refines a constant of a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapeStep {
    /// First step.
    pub first: f64,
    /// Smallest step.
    pub least: f64,
    /// Whether both are relative to the constant.
    pub is_relative: bool,
}

impl ShapeStep {
    /// Steps relative to the constant.
    pub const fn relative(first: f64, least: f64) -> Self {
        Self { first, least, is_relative: true }
    }

    /// Steps in the unit of the constant.
    pub const fn absolute(first: f64, least: f64) -> Self {
        Self { first, least, is_relative: false }
    }
}

/// One physical effect.
///
/// Sign convention: `effort = rigid(q, q̇, q̈) + f`, `f` is what the motor has to supply on top.
///
/// A law is linear in its *coefficients* once its *shape* (the constants it is not linear in) is
/// given: columns are formed for a shape, and shape and coefficients together are the parameters.
pub trait Effect: Sync {
    /// Its metadata.
    fn law(&self) -> &'static Law;

    /// Name in files.
    fn slug(&self) -> &'static str {
        self.law().slug
    }

    /// Estimator: whether the column of a coefficient jumps between two samples, at a reversal. All do of a law
    /// of dry friction or of a shared transmission, unless it says otherwise.
    fn coefficient_jumps(&self, _coefficient: usize) -> bool {
        self.law().has_role(LawRole::Dry) || self.law().has_role(LawRole::Shared)
    }

    /// Whether it comes about between two recordings of one arm; by default seldom.
    fn onset(&self) -> Onset {
        Onset::Seldom
    }

    /// Estimator: shapes to try on a motion of this size; one empty shape for a linear law.
    fn shapes(&self, _scale: &MotionScale) -> Vec<Vec<f64>> {
        vec![Vec::new()]
    }

    /// Estimator: how a constant of the shape is refined; nothing where it is no continuous number.
    fn shape_step(&self, _constant: usize) -> Option<ShapeStep> {
        Some(ShapeStep::relative(0.16, 0.005))
    }

    /// Estimator: shapes near one that are tried before its constants are refined, where a refinement from that one
    /// shape may end in a local minimum.
    fn shapes_around(&self, _shape: &[f64]) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Estimator, [`Scan::Simulated`](crate::Scan::Simulated): the transmission of a shape, without the inertia of its
    /// motor; `link_inertia` is what the joint moves \[kg m2 or kg\]. None for other laws and other shapes.
    fn transmission(&self, _shape: &[f64], _link_inertia: f64) -> Option<Transmission> {
        None
    }

    /// Parameters of a transmission, for a law whose [`mechanism`](Self::mechanism) is one; else empty.
    fn parameters_of_transmission(&self, _transmission: &Transmission) -> Vec<f64> {
        Vec::new()
    }

    /// Parameters of a change of the mass \[kg\] and the first moment \[kg m\] of a link, in the frame of the link.
    fn parameters_of_link(&self, change: [f64; 4]) -> Vec<f64> {
        change.to_vec()
    }

    /// Estimator, [`Scope::Joint`]: columns whose combination with the coefficients is `f`.
    fn columns(&self, _shape: &[f64], _motion: &JointMotion<'_>) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Estimator, [`Scope::Neighbours`]: columns on joints a and b.
    fn pair_columns(
        &self,
        _shape: &[f64],
        _a: &JointMotion<'_>,
        _b: &JointMotion<'_>,
    ) -> Vec<[Vec<f64>; 2]> {
        Vec::new()
    }

    /// Estimator, the other scopes: columns on all joints; `joint` is the joint or the link it moves.
    fn arm_columns(&self, _joint: usize, _motion: &WholeArmMotion<'_>) -> ArmColumns {
        Vec::new()
    }

    /// Which of its columns is the one of the law that it contains.
    fn contained_column(&self) -> usize {
        0
    }

    /// Parameters from a shape and the coefficients of its columns.
    fn parameters(&self, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        [coefficients, shape].concat()
    }

    /// Shape and coefficients from the parameters.
    fn shape_and_coefficients(&self, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
        (Vec::new(), parameters.to_vec())
    }

    /// Whether these parameters may carry the name; by default each by its own sign.
    fn admits(&self, parameters: &[f64]) -> bool {
        let each = self.law().parameters.iter().zip(parameters);
        each.into_iter().all(|(parameter, &value)| parameter.admissible.allows(value))
    }

    /// Whether these parameters are those of the physics that the law is named for. Where they are not, the law describes the
    /// recordings and stays in the model, but is no finding.
    fn is_plausible(&self, _parameters: &[f64]) -> bool {
        true
    }

    /// Estimator: whether fitted coefficients may carry the name beside a shape. By default a law of one joint or of two
    /// asks it of its parameters, and others admit any.
    fn admits_fit(&self, shape: &[f64], coefficients: &[f64]) -> bool {
        match self.law().scope {
            Scope::Joint | Scope::Neighbours => self.admits(&self.parameters(shape, coefficients)),
            Scope::ThroughJoint | Scope::Link | Scope::Arm => true,
        }
    }

    /// `f` over a motion, [`Scope::Joint`].
    fn effort(&self, parameters: &[f64], motion: &JointMotion<'_>) -> Vec<f64> {
        let (shape, coefficients) = self.shape_and_coefficients(parameters);
        let mut effort = vec![0.0; motion.velocity.len()];
        for (column, coefficient) in self.columns(&shape, motion).iter().zip(&coefficients) {
            for (effort, x) in effort.iter_mut().zip(column) {
                *effort += coefficient * x;
            }
        }
        effort
    }

    /// Simulator: where the effect acts.
    fn mechanism(&self, _parameters: &[f64]) -> Mechanism {
        Mechanism::Joint
    }

    /// Simulator: the part of `f` that is a smooth function of time, position and velocity.
    fn smooth_effort(&self, _parameters: &[f64], _state: &JointState) -> f64 {
        0.0
    }

    /// Simulator: dry friction at the speed and load of a state.
    fn dry_friction(&self, _parameters: &[f64], _state: &JointState) -> DryFriction {
        DryFriction::default()
    }

    /// Simulator: whether the effect remembers the travel as a deflection.
    fn has_deflection(&self) -> bool {
        false
    }

    /// Simulator: the deflection after a one-way travel of the joint \[rad or m\].
    fn deflection_after(&self, _parameters: &[f64], deflection: f64, _travel: f64) -> f64 {
        deflection
    }

    /// Simulator: the part of `f` that the deflection makes.
    fn deflection_effort(&self, _parameters: &[f64], _deflection: f64, _velocity: f64) -> f64 {
        0.0
    }

    /// Simulator, [`Mechanism::Arm`]: makes the given arm the true one; `joint` is the joint or the link it moves.
    fn change_arm(
        &self,
        _parameters: &[f64],
        _joint: usize,
        _frames: &ArmFrames,
        _arm: &mut RigidArm,
    ) {
    }

    /// Simulator: inertia added to the diagonal of `H` \[kg m2 or kg\].
    fn added_inertia(&self, _parameters: &[f64]) -> f64 {
        0.0
    }

    /// Controller, [`Scope::Joint`]: `f` as a C99 expression of these variables, equal to [`effort`](Self::effort) at every
    /// sample; none where `f` needs more than the state of the joint or is an [added inertia](Self::added_inertia).
    fn c_expression(&self, _parameters: &[f64], _of: &ControllerVariables<'_>) -> Option<String> {
        None
    }

    /// Cases: a random effect of this law up to its size; nothing if it cannot be hidden on what was drawn.
    fn draw(&self, _random: &mut dyn Draw, _context: &DrawContext<'_>) -> Option<DrawnEffect> {
        None
    }
}

/// Laws are the same if their slugs are.
impl PartialEq for dyn Effect {
    fn eq(&self, other: &Self) -> bool {
        self.slug() == other.slug()
    }
}

impl Eq for dyn Effect {}

impl fmt::Debug for dyn Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.slug())
    }
}
